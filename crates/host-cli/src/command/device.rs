//! `device`: find, inspect, configure, measure, calibrate, emulate, program, watch and test a device.

mod calibrate;
pub(crate) mod changes;
pub(crate) mod emulate;
mod flash;
mod info;
mod key_value;
mod measure;
mod monitor;
mod port;
mod selftest;
mod settings;

use crate::command::run_each;
use crate::output::Output;
use clap::Subcommand;
use haptic_experiment::Failure;
use port::PortArguments;

/// `device …`.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// List serial ports, and with --probe their devices
    List(info::List),
    /// Show a device, its limits and its counters
    #[command(after_help = "Example: host-cli device info --device serial:/dev/ttyACM0")]
    Info(PortArguments),
    /// Print the parameters that are set on a device
    #[command(after_help = "Example: host-cli device get --device serial:/dev/ttyACM0 --json")]
    Get(PortArguments),
    /// Set parameters, all or none
    Set(settings::Set),
    /// End the limits that `device set` gave a device from this computer
    ///
    /// Whoever arms a device that was switched off since sets them again, until this command ends them.
    #[command(after_help = "Example: host-cli device forget --device serial:/dev/ttyACM0")]
    Forget(PortArguments),
    Measure(Box<measure::Arguments>),
    Calibrate(Box<calibrate::Arguments>),
    Emulate(emulate::Arguments),
    Flash(flash::Arguments),
    Monitor(monitor::Arguments),
    Selftest(selftest::Arguments),
}

impl Command {
    pub(crate) fn run(self, output: Output) -> Result<(), Failure> {
        run_each!(self, output, [List Set Measure Calibrate Emulate Flash Monitor Selftest]
            Self::Info(port) => info::info(&port, output),
            Self::Get(port) => settings::get(&port, output),
            Self::Forget(port) => settings::forget(&port, output),
        )
    }
}
