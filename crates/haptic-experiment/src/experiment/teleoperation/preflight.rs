//! Pre-flight of a teleoperation: the slave in its remote place, before anything moves.

use super::specification::TeleoperationExperiment;
use crate::document::failure::Failure;
use crate::judge::preflight::Preflight;
use crate::run::preflight::PreflightVerdict;
use haptic_analysis::Dynamics;
use haptic_loop::plant::SUB_STEPS;

impl TeleoperationExperiment {
    /// The loop of the slave and its remote place as they are simulated, several steps a sample, without coupler, hand and
    /// line. `None` for a place without spring and damper, which is no loop.
    ///
    /// # Errors
    /// A number that the analysis does not take.
    pub(crate) fn preflight(&self) -> Result<Option<PreflightVerdict>, Failure> {
        let law = self.place.constants();
        if law.stiffness_n_per_m <= 0.0 && law.dissipation_n_s_mu_per_m <= 0.0 {
            return Ok(None);
        }
        let loops = Preflight {
            stiffness_n_per_m: law.stiffness_n_per_m,
            dissipation_n_s_mu_per_m: law.dissipation_n_s_mu_per_m,
            order: law.order,
            model: law.model,
            scheme: self.scheme,
            sample_time_s: self.sample_time().0 / SUB_STEPS as f64,
            samples: self.samples() * SUB_STEPS as u64,
        };
        let slave = Dynamics::ideal(self.slave.mass.0, self.slave.damping.0);
        loops.verdict(slave, 0).map(Some)
    }

    /// The same; refuses what is unstable, unless `force_unstable` is set.
    ///
    /// # Errors
    /// Bad input, with the numbers and what to change.
    pub(super) fn require_stable(&self) -> Result<Option<PreflightVerdict>, Failure> {
        let verdict = self.preflight()?;
        if let Some(verdict) = &verdict {
            verdict
                .require_stable(self.force_unstable)
                .map_err(|refusal| {
                    Failure::bad_input(format_args!("the slave in its remote place: {refusal}"))
                })?;
        }
        Ok(verdict)
    }
}
