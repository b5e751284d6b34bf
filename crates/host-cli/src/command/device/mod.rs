//! `device`: find, inspect, configure, imitate, program and watch a device.

pub mod emulate;
pub mod flash;
pub mod info;
pub mod list;
mod loosened;
pub mod monitor;
pub mod number;
pub mod parameters;
pub mod safety;
pub mod set;

use crate::output::Output;
use crate::output::warn;
use clap::{Args, Subcommand};
use haptic_experiment::device::{DeviceName, SerialName};
use haptic_experiment::failure::Failure;
use haptic_remote::serial::SerialLink;
use std::time::Duration;

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
    /// Imitate a device behind a pseudo-terminal
    Emulate(emulate::Arguments),
    /// Program a device over a debug probe
    Flash(flash::Arguments),
    /// Watch a device: its position and state on the terminal, every sample in a log
    Monitor(monitor::Arguments),
}

impl Command {
    /// Does what was asked.
    ///
    /// # Errors
    /// What went wrong, with its exit code.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        match self {
            Self::List(arguments) => arguments.run(output),
            Self::Info(arguments) => arguments.run(output),
            Self::Get(arguments) => arguments.run(output),
            Self::Set(arguments) => arguments.run(output),
            Self::Emulate(arguments) => arguments.run(output),
            Self::Flash(arguments) => arguments.run(output),
            Self::Monitor(arguments) => arguments.run(output),
        }
    }
}

/// Which device.
#[derive(Debug, Args)]
pub struct PortArguments {
    /// Device: `serial:PATH[@BAUD]`, or `serial:auto` for the only one that answers
    #[arg(long, value_name = "DEVICE", default_value = "serial:auto")]
    device: DeviceName,
    /// Go on trying for so long while the device is not there
    #[arg(
        long,
        value_name = "TIME",
        default_value = "0s",
        allow_hyphen_values = true
    )]
    wait: crate::quantity::Time,
}

impl PortArguments {
    fn name(&self) -> Result<&SerialName, Failure> {
        match &self.device {
            DeviceName::Serial(name) => Ok(name),
            DeviceName::Simulated => Err(Failure::bad_input(
                "device \"sim\" has no port: give --device serial:PATH, for example of host-cli device \
                 emulate",
            )),
        }
    }

    fn patience(&self) -> Result<Duration, Failure> {
        Duration::try_from_secs_f64(self.wait.0).map_err(|_| {
            Failure::bad_input(format_args!(
                "waiting time {} is not in [0, 1e9] s: give --wait, as in 10s",
                self.wait
            ))
        })
    }

    /// One attempt.
    fn connect_once(&self) -> Result<SerialLink, Failure> {
        self.name()?.connect(Duration::ZERO, &warn)
    }

    fn connect(&self) -> Result<SerialLink, Failure> {
        self.name()?.connect(self.patience()?, &warn)
    }
}
