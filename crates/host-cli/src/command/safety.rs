//! Options of the safety chain that every experiment has.

use super::device_model::DeviceModelArguments;
use crate::choice::choice;
use crate::pair::{Delay, Workspace};
use crate::within::within;
use clap::Args;
use haptic_experiment::failure::Failure;
use haptic_experiment::parameters;
use haptic_experiment::plant_file::DeviceModel;
use haptic_experiment::{GuardChoice, Safety};
use haptic_quantity::{Damping, Force, Length, Mass, Speed, Time};

/// An option that is not given is as in the file, else off.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Safety")]
pub struct SafetyArguments {
    #[command(flatten)]
    device_model: DeviceModelArguments,
    /// Keep the loop from feeding the device energy [default: off]
    #[arg(long, value_parser = choice::<GuardChoice>())]
    guard: Option<GuardChoice>,
    /// Range that the device may move in, as in -10mm:20mm; beyond it a fault ends the run
    #[arg(long, value_name = "LOW:HIGH", allow_hyphen_values = true)]
    workspace: Option<Workspace>,
    #[arg(long, value_parser = within::<Speed>(parameters::SPEED_LIMIT.range()), help = parameters::SPEED_LIMIT.help, value_name = "SPEED", allow_hyphen_values = true)]
    speed_limit: Option<Speed>,
    #[arg(long, value_parser = within::<Time>(parameters::RISE_TIME.range()), help = parameters::RISE_TIME.help, value_name = "TIME", allow_hyphen_values = true)]
    rise_time: Option<Time>,
    #[arg(long, value_parser = within::<Damping>(parameters::BRAKING.range()), help = parameters::BRAKING.help, value_name = "DAMPING", allow_hyphen_values = true)]
    braking: Option<Damping>,
    #[arg(long, value_parser = within::<Time>(parameters::STOP_TIME.range()), help = parameters::STOP_TIME.help, value_name = "TIME", allow_hyphen_values = true)]
    stop_time: Option<Time>,
    #[arg(long, value_parser = within::<Force>(parameters::BRAKE_FORCE.range()), help = parameters::BRAKE_FORCE.help, value_name = "FORCE", allow_hyphen_values = true)]
    brake_force: Option<Force>,
    #[arg(long, value_parser = within::<Force>(parameters::STUCK_FORCE.range()), help = parameters::STUCK_FORCE.help, value_name = "FORCE", allow_hyphen_values = true)]
    stuck_force: Option<Force>,
    #[arg(long, value_parser = within::<Time>(parameters::STUCK_TIME.range()), help = parameters::STUCK_TIME.help, value_name = "TIME", allow_hyphen_values = true)]
    stuck_time: Option<Time>,
    #[arg(long, value_parser = within::<Length>(parameters::JUMP.range()), help = parameters::JUMP.help, value_name = "LENGTH", allow_hyphen_values = true)]
    jump: Option<Length>,
    #[arg(long, value_parser = within::<Mass>(parameters::DEVICE_MASS.range()), help = parameters::DEVICE_MASS.help, value_name = "MASS", allow_hyphen_values = true)]
    device_mass: Option<Mass>,
    #[arg(long, value_parser = within::<Damping>(parameters::DEVICE_DAMPING.range()), help = parameters::DEVICE_DAMPING.help, value_name = "DAMPING", allow_hyphen_values = true)]
    device_damping: Option<Damping>,
    /// Delay of a real device from a measurement to the effect of its force, or the interval in which it lies, as in
    /// 0.2ms:1ms, for --guard energy-bounding
    #[arg(long, value_name = "TIME|LEAST:MOST", allow_hyphen_values = true)]
    device_delay: Option<Delay>,
    #[arg(long, value_parser = within::<Time>(parameters::DEVICE_LAG.range()), help = parameters::DEVICE_LAG.help, value_name = "TIME", allow_hyphen_values = true)]
    device_lag: Option<Time>,
    #[arg(long, value_parser = within::<Length>(parameters::DEVICE_NOISE.range()), help = parameters::DEVICE_NOISE.help, value_name = "LENGTH", allow_hyphen_values = true)]
    device_noise: Option<Length>,
}

impl SafetyArguments {
    /// The device file, if one was named.
    ///
    /// # Errors
    /// A file that cannot be read or is wrong.
    pub fn device_model(&self) -> Result<Option<DeviceModel>, Failure> {
        self.device_model.read()
    }

    /// The settings of the file, replaced by those given here.
    #[must_use]
    pub fn over(&self, file: Safety) -> Safety {
        let damping = self.device_damping.map(|damping| damping.0);
        Safety {
            guard: self.guard.unwrap_or(file.guard),
            workspace_m: self
                .workspace
                .map(|ends| (ends.low_m, ends.high_m))
                .or(file.workspace_m),
            speed_limit_m_per_s: self
                .speed_limit
                .map(|speed| speed.0)
                .or(file.speed_limit_m_per_s),
            rise_time_s: self.rise_time.map(|time| time.0).or(file.rise_time_s),
            braking_n_s_per_m: self
                .braking
                .map(|damping| damping.0)
                .or(file.braking_n_s_per_m),
            stop_time_s: self.stop_time.map(|time| time.0).or(file.stop_time_s),
            brake_force_n: self.brake_force.map(|f| f.0).or(file.brake_force_n),
            stuck_force_n: self.stuck_force.map(|f| f.0).or(file.stuck_force_n),
            stuck_time_s: self.stuck_time.map(|time| time.0).or(file.stuck_time_s),
            jump_m: self.jump.map(|jump| jump.0).or(file.jump_m),
            device_mass_kg: self.device_mass.map(|mass| mass.0).or(file.device_mass_kg),
            device_damping_n_s_per_m: damping.or(file.device_damping_n_s_per_m),
            device_delay_s: self
                .device_delay
                .map(|delay| (delay.least_s, delay.most_s))
                .or(file.device_delay_s),
            device_lag_s: self.device_lag.map(|lag| lag.0).or(file.device_lag_s),
            device_noise_m: self
                .device_noise
                .map(|noise| noise.0)
                .or(file.device_noise_m),
        }
    }
}
