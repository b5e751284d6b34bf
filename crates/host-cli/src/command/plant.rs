//! The simulated device, as every command that simulates one asks for it.

use super::device_model::DeviceModelArguments;
use crate::parameter::{help_with_default, seed_for};
use crate::whole::whole;
use crate::within::within;
use clap::Args;
use fracdiff::Seconds;
use haptic_experiment::parameters;
use haptic_experiment::{Failure, Imperfections, Sensors, dissertation_device};
use haptic_loop::plant::MassDamperConfig;
use haptic_loop::units::{Kilograms, NewtonSecondsPerMetre, NewtonsPerMetre};
use haptic_quantity::{Damping, Force, Length, Mass, Stiffness, Time};

/// Values of the simulated device; those that are not given are of the device file, else the defaults.
#[derive(Debug, Args)]
#[command(next_help_heading = "Device")]
pub struct SimulatedArguments {
    #[command(flatten)]
    file: DeviceModelArguments,
    #[arg(long, value_parser = within::<Mass>(parameters::MASS.range()), help = help_with_default(&parameters::MASS), value_name = "MASS", allow_hyphen_values = true)]
    mass: Option<Mass>,
    #[arg(long, value_parser = within::<Damping>(parameters::DAMPING.range()), help = help_with_default(&parameters::DAMPING), value_name = "DAMPING", allow_hyphen_values = true)]
    damping: Option<Damping>,
    #[arg(long, value_parser = within::<Stiffness>(parameters::HAND_STIFFNESS.range()), help = help_with_default(&parameters::HAND_STIFFNESS), value_name = "STIFFNESS", allow_hyphen_values = true)]
    hand_stiffness: Option<Stiffness>,
    #[arg(long, value_parser = within::<Force>(parameters::FRICTION.range()), help = parameters::FRICTION.help, value_name = "FORCE", allow_hyphen_values = true)]
    friction: Option<Force>,
    #[arg(long, value_parser = within::<Time>(parameters::DELAY.range()), help = parameters::DELAY.help, value_name = "TIME", allow_hyphen_values = true)]
    delay: Option<Time>,
    #[arg(long, value_parser = within::<Time>(parameters::CURRENT_LAG.range()), help = parameters::CURRENT_LAG.help, value_name = "TIME", allow_hyphen_values = true)]
    current_lag: Option<Time>,
    #[arg(long, value_parser = within::<Length>(parameters::ENCODER_RESOLUTION.range()), help = parameters::ENCODER_RESOLUTION.help, value_name = "LENGTH", allow_hyphen_values = true)]
    encoder_resolution: Option<Length>,
    #[arg(long, value_parser = within::<Length>(parameters::SENSOR_NOISE.range()), help = help_with_default(&parameters::SENSOR_NOISE), value_name = "LENGTH", allow_hyphen_values = true)]
    sensor_noise: Option<Length>,
    #[arg(long, help = help_with_default(&parameters::SEED), value_parser = whole::<u64>(0..=u64::MAX), allow_hyphen_values = true)]
    seed: Option<u64>,
}

impl SimulatedArguments {
    /// True if the simulated device is to have any imperfection of a real one by an option of its own.
    pub(super) fn is_less_than_ideal(&self) -> bool {
        self.friction.is_some()
            || self.delay.is_some()
            || self.current_lag.is_some()
            || self.encoder_resolution.is_some()
            || self.sensor_noise.is_some_and(|noise| noise.0 > 0.0)
    }

    /// True if anything at all is said of the simulated device.
    pub(super) fn is_described(&self) -> bool {
        self.is_less_than_ideal()
            || self.file.is_given()
            || self.mass.is_some()
            || self.damping.is_some()
            || self.hand_stiffness.is_some()
            || self.seed.is_some()
    }

    /// Mass, damping and hand, the rest ideal.
    ///
    /// # Errors
    /// A device file that is wrong.
    pub(super) fn ideal(&self, sample_time_s: f64) -> Result<MassDamperConfig, Failure> {
        let device = dissertation_device(Seconds(sample_time_s));
        let file = self.file.read()?.map(|file| file.values);
        let or = |given: Option<f64>, of_file: Option<f64>, default: f64| {
            given.or(of_file).unwrap_or(default)
        };
        let mass = or(
            self.mass.map(|m| m.0),
            file.map(|f| f.mass_kg),
            device.mass.0,
        );
        let damping = or(
            self.damping.map(|b| b.0),
            file.map(|f| f.damping_n_s_per_m),
            device.damping.0,
        );
        let stiffness = or(
            self.hand_stiffness.map(|k| k.0),
            file.map(|f| f.hand_stiffness_n_per_m),
            device.stiffness.0,
        );
        Ok(MassDamperConfig {
            mass: Kilograms(mass),
            damping: NewtonSecondsPerMetre(damping),
            stiffness: NewtonsPerMetre(stiffness),
            ..device
        })
    }

    /// Imperfections of the simulated device. A device file sets each one that is not given by its own option.
    ///
    /// # Errors
    /// A device file that is wrong, a seed without noise.
    pub(super) fn imperfections(&self) -> Result<Imperfections, Failure> {
        let file = self.file.read()?;
        let usual = file.map_or(Imperfections::NONE, |file| file.imperfections());
        let steps = usual.sensors.encoder_resolution_m;
        let noise_m = (self.sensor_noise).map_or(usual.sensors.noise_m, |noise| noise.0);
        Ok(Imperfections {
            friction_n: self.friction.map_or(usual.friction_n, |force| force.0),
            delay_s: self.delay.map_or(usual.delay_s, |delay| delay.0),
            current_lag_s: self.current_lag.map_or(usual.current_lag_s, |lag| lag.0),
            sensors: Sensors {
                encoder_resolution_m: self.encoder_resolution.map_or(steps, |step| step.0),
                noise_m,
                seed: seed_for(self.seed, noise_m)?,
            },
        })
    }
}
