//! Options of the safety chain that every experiment has.

use crate::choice::choice;
use crate::quantity::{Damping, Delay, Force, Length, Mass, Speed, Time, Workspace};
use clap::Args;
use haptic_experiment::{GuardChoice, Safety};

/// What is not given is as in the file, else off.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Safety")]
pub struct SafetyArguments {
    /// Keep the loop from feeding the device energy [default: off]
    #[arg(long, value_parser = choice::<GuardChoice>())]
    guard: Option<GuardChoice>,
    /// Where the device may be, as in -10mm:20mm; beyond it a fault ends the run
    #[arg(long, value_name = "LOW:HIGH", allow_hyphen_values = true)]
    workspace: Option<Workspace>,
    /// How fast the device may move; beyond it a fault ends the run
    #[arg(long, value_name = "SPEED", allow_hyphen_values = true)]
    speed_limit: Option<Speed>,
    /// Let the force rise in this time from the start on
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    rise_time: Option<Time>,
    /// Brake with this damping near workspace and speed limit, and after a fault or stop
    #[arg(long, value_name = "DAMPING", allow_hyphen_values = true)]
    braking: Option<Damping>,
    /// Time in which the force falls to zero after a fault, a stop or the end, 1ms to 1s [default: 0.1s]
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    stop_time: Option<Time>,
    /// Largest force of the braking meanwhile, 0N to 10N [default: 2N]
    #[arg(long, value_name = "FORCE", allow_hyphen_values = true)]
    brake_force: Option<Force>,
    /// A force that grows by this on a position that stands still is a fault; 0 for never [default: 3N on a serial
    /// device, else never]
    #[arg(long, value_name = "FORCE", allow_hyphen_values = true)]
    stuck_force: Option<Force>,
    /// Time for which the position has to have stood still for that [default: 0.1s]
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    stuck_time: Option<Time>,
    /// A position that moves in a sample by this more than the speed limit allows is a fault; 0 for never [default:
    /// 1mm on a serial device, else never]
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    jump: Option<Length>,
    /// Mass of a real device, for --guard observer, --braking and the pre-flight
    #[arg(long, value_name = "MASS", allow_hyphen_values = true)]
    device_mass: Option<Mass>,
    /// Damping of a real device, for --guard energy-bounding and the pre-flight
    #[arg(long, value_name = "DAMPING", allow_hyphen_values = true)]
    device_damping: Option<Damping>,
    /// Delay of a real device from a measurement to the effect of its force, or the interval in which it lies, as in
    /// 0.2ms:1ms, for --guard energy-bounding
    #[arg(long, value_name = "TIME|LEAST:MOST", allow_hyphen_values = true)]
    device_delay: Option<Delay>,
    /// Time constant with which the force of a real device follows, for --guard energy-bounding
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    device_lag: Option<Time>,
    /// Standard deviation of the noise of a real device's position, for --guard energy-bounding [default: 0.29 of its
    /// resolution]
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    device_noise: Option<Length>,
}

impl SafetyArguments {
    /// What is given in place of what is in the file.
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
