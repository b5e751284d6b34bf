//! A wall experiment: device, wall, trial.

use crate::experiment::trial::TrialSetup;
use crate::judge::preflight::Preflight;
use fracdiff::{Order, Scheme};
use haptic_tissue::Model;

/// A wall experiment.
///
/// ```
/// use fracdiff::{Order, Seconds};
/// use haptic_experiment::{Imperfections, TrialPlan, TrialSetup, WallExperiment, dissertation_device};
///
/// let device = dissertation_device(Seconds(2e-3));
/// let setup = TrialSetup::new(device, Imperfections::NONE.sensors, TrialPlan::DEFAULT);
/// let wall = WallExperiment {
///     setup,
///     order: Order::new(0.5)?,
///     model: None,
///     scheme: "full".parse()?,
///     stiffness_n_per_m: 1000.0,
///     dissipation_n_s_mu_per_m: 20.0,
///     one_sided: false,
/// };
/// let settling = wall.try_out()?;
/// assert!(settling.stable);
/// // 1 N into 1000 N/m, and B·D^0.5 of a wall at rest is small.
/// assert!(settling.deflection_m.is_some_and(|x| x > 0.5e-3 && x < 1.1e-3));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct WallExperiment {
    /// Device, trial, safety and pace.
    pub setup: TrialSetup,
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
            sample_time_s: self.setup.device.sample_time.0,
            samples,
        }
    }
}
