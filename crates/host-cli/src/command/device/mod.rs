//! `device`: find, inspect, configure, measure, emulate, program, watch and test a device.

pub mod changes;
pub mod emulate;
pub mod emulate_haply;
pub mod emulate_moteus;
pub mod flash;
pub mod info;
mod key_value;
pub mod list;
mod loosened;
pub mod measure;
pub mod monitor;
pub mod parameters;
pub mod port;
pub mod selftest;
pub mod set;

use crate::output::Output;
use clap::Subcommand;
use haptic_experiment::Failure;

/// `device …`.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// List serial ports, with --probe their devices
    List(list::Arguments),
    /// What a device is, its limits and its counters
    Info(info::Arguments),
    /// Print parameters
    Get(set::GetArguments),
    /// Set parameters, all or none
    Set(Box<set::SetArguments>),
    /// Measure mass, damping, friction, delay, lag and sensor with small, safe forces
    Measure(Box<measure::Arguments>),
    /// Emulate a device behind a pseudo-terminal
    #[command(long_about = emulate::LONG_ABOUT)]
    Emulate(emulate::Arguments),
    /// Program a board over a debug probe
    #[command(long_about = flash::LONG_ABOUT)]
    Flash(flash::Arguments),
    /// Show position and state, log every sample
    #[command(long_about = monitor::LONG_ABOUT)]
    Monitor(monitor::Arguments),
    /// Test arm, limits, watchdog, recorder, reconnect and emergency stop
    Selftest(selftest::Arguments),
}

impl Command {
    /// Does what was asked.
    ///
    /// # Errors
    /// The error of the command, with its exit code.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        match self {
            Self::List(arguments) => arguments.run(output),
            Self::Info(arguments) => arguments.run(output),
            Self::Get(arguments) => arguments.run(output),
            Self::Set(arguments) => arguments.run(output),
            Self::Measure(arguments) => arguments.run(output),
            Self::Emulate(arguments) => arguments.run(output),
            Self::Flash(arguments) => arguments.run(output),
            Self::Monitor(arguments) => arguments.run(output),
            Self::Selftest(arguments) => arguments.run(output),
        }
    }
}
