//! A wall experiment: device, wall, trial.

use crate::preflight::{Dynamics, Preflight};
use crate::pushed::{Setup, TrialPlan, dynamics};
use crate::remote::RemoteDevice;
use crate::safety::Safety;
use crate::schedule::Pace;
use crate::sensed::Sensors;
use fracdiff::{Order, Scheme};
use haptic_loop::plant::MassDamperConfig;
use haptic_tissue::Model;

/// A wall experiment.
///
/// ```
/// use fracdiff::{Order, Seconds};
/// use haptic_experiment::{
///     Imperfections, Pace, Safety, TrialPlan, WallExperiment, dissertation_device,
/// };
///
/// let wall = WallExperiment {
///     device: dissertation_device(Seconds(2e-3)),
///     sensors: Imperfections::NONE.sensors,
///     order: Order::new(0.5)?,
///     model: None,
///     scheme: "full".parse()?,
///     stiffness_n_per_m: 1000.0,
///     dissipation_n_s_mu_per_m: 20.0,
///     one_sided: false,
///     plan: TrialPlan::DEFAULT,
///     must_be_stable: false,
///     force_rate_limit_n_per_s: None,
///     safety: Safety::default(),
///     pace: Pace::Virtual,
///     remote: None,
///     force_unstable: false,
/// };
/// let settling = wall.try_out()?;
/// assert!(settling.stable);
/// // 1 N into 1000 N/m, and B·D^0.5 of a wall at rest is small.
/// assert!(settling.deflection_m.is_some_and(|x| x > 0.5e-3 && x < 1.1e-3));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct WallExperiment {
    /// The device, the hand that holds it, and what makes it less than ideal.
    pub device: MassDamperConfig,
    /// Its sensors.
    pub sensors: Sensors,
    /// μ, 0 to 2.
    pub order: Order,
    /// The model whose memory the operator is, for slow motion of the order μ; `None` for D^μ.
    pub model: Option<Model>,
    /// The operator.
    pub scheme: Scheme,
    /// K, N/m, at least 0.
    pub stiffness_n_per_m: f64,
    /// B, N·s^μ/m, at least 0.
    pub dissipation_n_s_mu_per_m: f64,
    /// A wall that pushes but never pulls.
    pub one_sided: bool,
    /// Plan of the trial.
    pub plan: TrialPlan,
    /// A wall that is not stable by trial and analysis is a failure.
    pub must_be_stable: bool,
    /// Largest rate of the force, N/s; `None` for that of a serial device, and none on the simulated one.
    pub force_rate_limit_n_per_s: Option<f64>,
    /// Further settings of the safety chain.
    pub safety: Safety,
    /// Pace of time.
    pub pace: Pace,
    /// The serial device; `None` for the simulated one.
    pub remote: Option<RemoteDevice>,
    /// Run on a serial device what the analysis calls unstable.
    pub force_unstable: bool,
}

impl WallExperiment {
    /// The loop for the analysis.
    pub(super) fn preflight(&self, samples: u64) -> Preflight<'_> {
        Preflight {
            stiffness_n_per_m: self.stiffness_n_per_m,
            dissipation_n_s_mu_per_m: self.dissipation_n_s_mu_per_m,
            order: self.order,
            model: self.model.as_ref(),
            scheme: self.scheme,
            sample_time_s: self.device.sample_time.0,
            samples,
        }
    }

    /// Device and hand.
    pub(super) fn dynamics(&self) -> Dynamics {
        dynamics(&self.device)
    }

    /// All but the wall.
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

    /// As it is really tried.
    pub(super) fn plan(&self) -> TrialPlan {
        self.setup().plan()
    }
}
