//! The same wall for a serial device, and the limits that its safety chain gets.

use super::specification::WallExperiment;
use crate::failure::Failure;
use crate::pushed::force_alone;
use crate::remote::{Kept, RemoteDevice, RemoteLaw, host_limits, no_operator, portable, push};
use crate::safety::GuardedDevice;
use haptic_link::{LoopMode, Simulation, SimulationKind};
use haptic_loop::Limits;
use haptic_loop::plant::MassDamperConfig;
use haptic_loop::units::NewtonsPerSecond;

impl WallExperiment {
    pub(super) fn force_and_rate(&self) -> Limits {
        let limits = force_alone(self.plan.force_limit_n, self.device.sample_time);
        Limits {
            rate: self
                .force_rate_limit_n_per_s
                .map_or(limits.rate, NewtonsPerSecond),
            ..limits
        }
    }

    /// Limits of the chain of a serial device, without its guard.
    fn limits_there(&self) -> Limits {
        let limits = self.safety.on(self.force_and_rate(), true);
        let delay = limits.device_delay_samples;
        self.safety.braked(limits, self.device.mass.0, delay)
    }

    /// Limits of the chain that runs here with a serial device: in a host loop the device does all but force
    /// and rate, and with its own loop this chain runs only to be checked.
    pub(super) fn limits_here(&self) -> Limits {
        match &self.remote {
            Some(remote) if remote.loop_mode == LoopMode::Host => host_limits(&self.limits_there()),
            _ => self.limits_there(),
        }
    }

    /// The same wall and push for a serial device.
    pub(super) fn law(&self, remote: &RemoteDevice, samples: u64) -> Result<RemoteLaw, Failure> {
        let MassDamperConfig {
            mass,
            damping,
            stiffness,
            delay,
            friction,
            lag,
            sample_time: t,
            saturation: _,
        } = self.device;
        if delay.0 > 0.0 || friction.0 > 0.0 || lag.0 > 0.0 {
            return Err(Failure::bad_input(
                "delay_s, friction_n and current_lag_s are of the simulated device: leave them away with a \
                 serial one, which has its own",
            ));
        }
        let operator = match remote.loop_mode {
            LoopMode::Device => {
                let horizon = crate::schedule::horizon(samples);
                let built = self.scheme.build(self.order, t, horizon);
                portable(&built.map_err(Failure::input)?)?
            }
            LoopMode::Host => no_operator(),
        };
        Ok(RemoteLaw {
            stiffness_n_per_m: self.stiffness_n_per_m,
            dissipation_n_s_mu_per_m: self.dissipation_n_s_mu_per_m,
            order: self.order.get(),
            one_sided: self.one_sided,
            operator,
            limits: self.limits_there(),
            kept: Kept {
                rate: self.force_rate_limit_n_per_s.is_none(),
                speed: self.safety.speed_limit_m_per_s.is_none(),
                rise: self.safety.rise_time_s.is_none(),
            },
            guard: (
                self.safety.guard,
                self.safety.guarded(GuardedDevice {
                    mass_kg: Some(mass.0),
                    damping_n_s_per_m: Some(damping.0),
                    ..GuardedDevice::default()
                }),
            ),
            simulation: Simulation {
                kind: SimulationKind::MassDamper,
                mass_kg: mass.0 as f32,
                damping_n_s_per_m: damping.0 as f32,
                hand_stiffness_n_per_m: stiffness.0 as f32,
                ..push(self.plan.push_n)
            },
        })
    }
}
