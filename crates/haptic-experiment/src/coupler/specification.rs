//! A coupler experiment: device, coupler, object, trial.

use crate::preflight::{CouplerPreflight, Dynamics};
use crate::pushed::{Setup, TrialPlan, dynamics};
use crate::remote::RemoteDevice;
use crate::safety::Safety;
use crate::schedule::Pace;
use crate::sensed::Sensors;
use fracdiff::{Order, Scheme};
use haptic_analysis::CoupledObject;
use haptic_loop::plant::MassDamperConfig;

/// A coupler experiment.
///
/// ```
/// use fracdiff::{Order, Seconds};
/// use haptic_analysis::CoupledObject;
/// use haptic_experiment::{
///     CouplerExperiment, Imperfections, Pace, Safety, TrialPlan, dissertation_device,
/// };
///
/// let coupler = CouplerExperiment {
///     device: dissertation_device(Seconds(1e-3)),
///     sensors: Imperfections::NONE.sensors,
///     order: Order::new(1.0)?,
///     scheme: "full".parse()?,
///     coupler_stiffness_n_s_per_m: 2.0,
///     coupler_dissipation_n_s_1_minus_mu_per_m: 3000.0,
///     object: CoupledObject { mass_kg: 0.1, damping_n_s_per_m: 1.0, stiffness_n_per_m: 1000.0 },
///     plan: TrialPlan::DEFAULT,
///     must_be_stable: false,
///     force_rate_limit_n_per_s: None,
///     safety: Safety::default(),
///     pace: Pace::Virtual,
///     remote: None,
///     force_unstable: false,
/// };
/// let settling = coupler.try_out()?;
/// // 1 N on 3000 N/m and 1000 N/m in series.
/// assert!(settling.stable);
/// assert!(settling.deflection_m.is_some_and(|x| (x / (4.0 / 3000.0) - 1.0).abs() < 1e-3));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct CouplerExperiment {
    /// The device, the hand that holds it, and what makes it less than ideal.
    pub device: MassDamperConfig,
    /// Its sensors.
    pub sensors: Sensors,
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
    /// Plan of the trial.
    pub plan: TrialPlan,
    /// A coupler that is not stable by trial and analysis, or that Llewellyn refuses, is a failure.
    pub must_be_stable: bool,
    /// Largest rate of the force, N/s; `None` for that of a serial device, and none on the simulated one.
    pub force_rate_limit_n_per_s: Option<f64>,
    /// Further settings of the safety chain.
    pub safety: Safety,
    /// Pace of time.
    pub pace: Pace,
    /// The serial device; `None` for the simulated one.
    pub remote: Option<RemoteDevice>,
    /// Run on a serial device what the analysis refuses.
    pub force_unstable: bool,
}

impl CouplerExperiment {
    /// The loop for the analysis.
    pub(crate) fn preflight(&self, samples: u64) -> CouplerPreflight {
        CouplerPreflight {
            stiffness_n_s_per_m: self.coupler_stiffness_n_s_per_m,
            dissipation_n_s_1_minus_mu_per_m: self.coupler_dissipation_n_s_1_minus_mu_per_m,
            order: self.order,
            scheme: self.scheme,
            sample_time_s: self.device.sample_time.0,
            samples,
            object: self.object,
        }
    }

    /// Device and hand.
    pub(crate) fn dynamics(&self) -> Dynamics {
        dynamics(&self.device)
    }

    /// All but coupler and object.
    pub(super) fn setup(&self) -> Setup<'_> {
        Setup {
            device: &self.device,
            sensors: self.sensors,
            plan: self.plan,
            force_rate_limit_n_per_s: self.force_rate_limit_n_per_s,
            safety: &self.safety,
            pace: self.pace,
            remote: self.remote.as_ref(),
            force_unstable: self.force_unstable,
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
