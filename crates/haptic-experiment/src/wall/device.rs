//! The same wall for a serial device.

use super::specification::WallExperiment;
use crate::failure::Failure;
use crate::remote::{RemoteDevice, RemoteLaw, portable};
use haptic_link::LoopMode;

impl WallExperiment {
    /// The same wall and push for a serial device.
    pub(super) fn law(&self, remote: &RemoteDevice, samples: u64) -> Result<RemoteLaw, Failure> {
        let law = self.setup.law()?;
        let operator = match remote.loop_mode {
            LoopMode::Device => portable(&self.operator(samples)?)?,
            LoopMode::Host => law.operator,
        };
        Ok(RemoteLaw {
            stiffness_n_per_m: self.stiffness_n_per_m,
            dissipation_n_s_mu_per_m: self.dissipation_n_s_mu_per_m,
            order: self.order.get(),
            one_sided: self.one_sided,
            operator,
            ..law
        })
    }
}
