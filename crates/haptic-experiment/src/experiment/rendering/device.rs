//! The same tissue and drive for a device.

use super::specification::{Contact, Rendering};
use crate::document::failure::Failure;
use crate::run::remote::{
    RemoteDevice, RemoteLaw, UnchangedLimits, indentation, no_operator, portable, push,
};
use crate::run::safety::GuardedDevice;
use haptic_link::{LoopMode, Simulation};
use haptic_loop::plant::RigDrive;

impl Rendering {
    /// The same tissue and drive for a device.
    pub(super) fn law(
        &self,
        drive: RigDrive,
        device: &RemoteDevice,
        samples: u64,
    ) -> Result<RemoteLaw, Failure> {
        let (stiffness, dissipation) = self.spring_and_damper();
        let simulation = match drive {
            RigDrive::Position(profile) => indentation(
                self.contact == Contact::Compliant,
                profile.depth().0,
                profile.ramp_time().0,
            ),
            RigDrive::Force(force) => push(force.0),
        };
        Ok(RemoteLaw {
            stiffness_n_per_m: stiffness,
            dissipation_n_s_mu_per_m: dissipation,
            order: self.material.order().get(),
            one_sided: true,
            operator: match device.loop_mode {
                LoopMode::Device => portable(&self.operator(samples)?)?,
                LoopMode::Host => no_operator(),
            },
            limits: self.limits(true),
            unchanged: UnchangedLimits {
                speed: self.safety.speed_limit_m_per_s.is_none(),
                ..UnchangedLimits::default()
            },
            guard: (
                self.safety.guard,
                self.safety.guarded(GuardedDevice::default()),
            ),
            // The device of which the pre-flight speaks, if it knows one.
            simulation: match self.preflight.dynamics {
                Some(known) => Simulation {
                    mass_kg: known.mass_kg as f32,
                    damping_n_s_per_m: known.damping_n_s_per_m as f32,
                    ..simulation
                },
                None => simulation,
            },
            after_rise: true,
        })
    }
}
