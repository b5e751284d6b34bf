//! A coupler experiment: device, coupler, object, trial.

use super::preflight::CouplerPreflight;
use crate::experiment::trial::TrialSetup;
use fracdiff::{Order, Scheme};
use haptic_analysis::CoupledObject;

/// A coupler experiment.
///
/// ```
/// use fracdiff::{Order, Seconds};
/// use haptic_analysis::CoupledObject;
/// use haptic_experiment::{CouplerExperiment, Imperfections, TrialPlan, TrialSetup, dissertation_device};
///
/// let device = dissertation_device(Seconds(1e-3));
/// let setup = TrialSetup::new(device, Imperfections::NONE.sensors, TrialPlan::DEFAULT);
/// let coupler = CouplerExperiment {
///     setup,
///     order: Order::new(1.0)?,
///     scheme: "full".parse()?,
///     coupler_stiffness_n_s_per_m: 2.0,
///     coupler_dissipation_n_s_1_minus_mu_per_m: 3000.0,
///     object: CoupledObject { mass_kg: 0.1, damping_n_s_per_m: 1.0, stiffness_n_per_m: 1000.0 },
/// };
/// let settling = coupler.try_out()?;
/// // 1 N on 3000 N/m and 1000 N/m in series.
/// assert!(settling.stable);
/// assert!(settling.deflection_m.is_some_and(|x| (x / (4.0 / 3000.0) - 1.0).abs() < 1e-3));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct CouplerExperiment {
    /// Device, trial, safety and pace.
    pub setup: TrialSetup,
    /// μ, 0 to 1.
    pub order: Order,
    /// The operator, which is run on the deflection with the order 1 − μ.
    pub scheme: Scheme,
    /// `k_c`, N·s/m, at least 0.
    pub coupler_stiffness_n_s_per_m: f64,
    /// `b_c`, N·s^(1−μ)/m, at least 0.
    pub coupler_dissipation_n_s_1_minus_mu_per_m: f64,
    /// The object behind it.
    pub object: CoupledObject,
}

impl CouplerExperiment {
    /// The loop for the analysis.
    pub(crate) fn preflight(&self, samples: u64) -> CouplerPreflight {
        CouplerPreflight {
            stiffness_n_s_per_m: self.coupler_stiffness_n_s_per_m,
            dissipation_n_s_1_minus_mu_per_m: self.coupler_dissipation_n_s_1_minus_mu_per_m,
            order: self.order,
            scheme: self.scheme,
            sample_time_s: self.setup.device.sample_time.0,
            samples,
            object: self.object,
        }
    }

    /// Stiffness that coupler and object hold a push with for ever, N/m: both springs in series at order 1, none below.
    pub(super) fn holding_stiffness(&self) -> f64 {
        let (spring, ground) = (
            self.coupler_dissipation_n_s_1_minus_mu_per_m,
            self.object.stiffness_n_per_m,
        );
        if self.order.get() < 1.0 || spring <= 0.0 || ground <= 0.0 {
            0.0
        } else {
            1.0 / (1.0 / spring + 1.0 / ground)
        }
    }
}
