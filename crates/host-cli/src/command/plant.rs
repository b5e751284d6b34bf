//! The simulated device, as every command that simulates one asks for it.

use crate::parameter::{help_with_default, seed_for};
use crate::quantity::{Damping, Force, Length, Mass, Stiffness, Time};
use clap::Args;
use fracdiff::Seconds;
use haptic_experiment::parameters;
use haptic_experiment::{Failure, Imperfections, Sensors, TrialPlan, dissertation_device};
use haptic_loop::plant::MassDamperConfig;
use haptic_loop::units::{Kilograms, NewtonSecondsPerMetre, NewtonsPerMetre};

/// The simulated device; by default that of the dissertation's section 4.4.
#[derive(Debug, Args)]
#[command(next_help_heading = "Device")]
pub struct PlantArguments {
    #[arg(long, help = parameters::MASS.help, default_value = parameters::MASS.shown, allow_hyphen_values = true)]
    mass: Mass,
    #[arg(long, help = parameters::DAMPING.help, default_value = parameters::DAMPING.shown, allow_hyphen_values = true)]
    damping: Damping,
    #[arg(long, help = parameters::HAND_STIFFNESS.help, default_value = parameters::HAND_STIFFNESS.shown, allow_hyphen_values = true)]
    hand_stiffness: Stiffness,
    #[arg(long, help = parameters::WALL_SAMPLE_TIME.help, default_value = parameters::WALL_SAMPLE_TIME.shown, allow_hyphen_values = true)]
    sample_time: Time,
    /// What real devices have: 1 um encoder, 0.05 N friction, half a sample of delay, 1 ms current lag
    /// (each can be set by itself)
    #[arg(long)]
    realistic: bool,
    #[arg(long, help = parameters::FRICTION.help, value_name = "FORCE", allow_hyphen_values = true)]
    friction: Option<Force>,
    #[arg(long, help = parameters::DELAY.help, value_name = "TIME", allow_hyphen_values = true)]
    delay: Option<Time>,
    #[arg(long, help = parameters::CURRENT_LAG.help, value_name = "TIME", allow_hyphen_values = true)]
    current_lag: Option<Time>,
    #[arg(long, help = parameters::ENCODER_RESOLUTION.help, value_name = "LENGTH", allow_hyphen_values = true)]
    encoder_resolution: Option<Length>,
    #[arg(long, help = parameters::SENSOR_NOISE.help, value_name = "LENGTH", default_value = parameters::SENSOR_NOISE.shown, allow_hyphen_values = true)]
    sensor_noise: Length,
    #[arg(long, help = help_with_default(&parameters::SEED), allow_hyphen_values = true)]
    seed: Option<u64>,
    /// Largest force of the actuator [default: 100 N]
    #[arg(long, value_name = "FORCE", allow_hyphen_values = true)]
    force_limit: Option<Force>,
}

impl PlantArguments {
    /// True if the simulated device is to have any imperfection of a real one.
    pub(super) fn is_less_than_ideal(&self) -> bool {
        self.realistic
            || self.friction.is_some()
            || self.delay.is_some()
            || self.current_lag.is_some()
            || self.encoder_resolution.is_some()
            || self.sensor_noise.0 > 0.0
    }

    /// Mass, damping, hand and sample time, the rest ideal.
    pub(super) fn ideal(&self) -> MassDamperConfig {
        MassDamperConfig {
            mass: Kilograms(self.mass.0),
            damping: NewtonSecondsPerMetre(self.damping.0),
            stiffness: NewtonsPerMetre(self.hand_stiffness.0),
            ..dissertation_device(Seconds(self.sample_time.0))
        }
    }

    /// Imperfections of the simulated device. `--realistic` sets each one that is not given by its own option.
    ///
    /// # Errors
    /// A seed without noise.
    pub(super) fn imperfections(&self) -> Result<Imperfections, Failure> {
        let usual = if self.realistic {
            Imperfections::realistic(self.sample_time.0)
        } else {
            Imperfections::NONE
        };
        let steps = usual.sensors.encoder_resolution_m;
        Ok(Imperfections {
            friction_n: self.friction.map_or(usual.friction_n, |force| force.0),
            delay_s: self.delay.map_or(usual.delay_s, |delay| delay.0),
            current_lag_s: self.current_lag.map_or(usual.current_lag_s, |lag| lag.0),
            sensors: Sensors {
                encoder_resolution_m: self.encoder_resolution.map_or(steps, |step| step.0),
                noise_m: self.sensor_noise.0,
                seed: seed_for(self.seed, self.sensor_noise.0)?,
            },
        })
    }

    /// True if a force limit was given.
    pub(super) fn limits_the_force(&self) -> bool {
        self.force_limit.is_some()
    }

    /// Largest force, N.
    pub(super) fn force_limit_n(&self) -> f64 {
        self.force_limit
            .map_or(TrialPlan::DEFAULT.force_limit_n, |limit| limit.0)
    }
}
