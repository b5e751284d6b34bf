//! `device`: find, inspect, configure, measure, imitate, program, watch and test a device.

pub mod emulate;
pub mod emulate_haply;
pub mod emulate_moteus;
pub mod flash;
pub mod info;
pub mod list;
mod loosened;
pub mod measure;
pub mod monitor;
pub mod number;
pub mod parameters;
pub mod port;
pub mod safety;
pub mod selftest;
pub mod set;

use crate::output::Output;
use clap::Subcommand;
use haptic_experiment::Failure;

/// `device …`.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// List the serial ports, and with --probe the devices at them
    List(list::Arguments),
    /// What a device is, can do, and has counted
    Info(info::Arguments),
    /// Print the parameters of a device
    Get(set::GetArguments),
    /// Set parameters of a device, all of them or none
    Set(Box<set::SetArguments>),
    /// Find mass, damping, friction, delay, lag and sensor of a device by small safe forces
    Measure(Box<measure::Arguments>),
    /// Imitate a device behind a pseudo-terminal
    #[command(long_about = emulate::LONG_ABOUT)]
    Emulate(emulate::Arguments),
    /// Program a device over a debug probe
    #[command(long_about = flash::LONG_ABOUT)]
    Flash(flash::Arguments),
    /// Watch a device: its position and state on the terminal, every sample in a log
    #[command(long_about = monitor::LONG_ABOUT)]
    Monitor(monitor::Arguments),
    /// Try what a device promises: arm, limits, watchdog, recorder, reconnect, emergency stop
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
