//! `device`: find, inspect, configure, measure, emulate, program, watch and test a device.

pub(crate) mod changes;
pub(crate) mod emulate;
mod flash;
mod info;
mod key_value;
mod measure;
mod monitor;
mod selftest;
mod settings;

use super::conduct::stop_on_interrupt;
use crate::output::{Output, warn};
use crate::parse::within;
use clap::{Args, Subcommand};
use haptic_experiment::Failure;
use haptic_experiment::parameters::range;
use haptic_experiment::run::device::{DeviceName, LinkedName};
use haptic_quantity::Time;
use haptic_remote::serial::SerialLink;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// `device …`.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// List serial ports, with --probe their devices
    List(info::List),
    /// What a device is, its limits and its counters
    #[command(after_help = "Example: host-cli device info --device serial:/dev/ttyACM0")]
    Info(PortArguments),
    /// Print parameters
    #[command(after_help = "Example: host-cli device get --device serial:/dev/ttyACM0 --json")]
    Get(PortArguments),
    /// Set parameters, all or none
    Set(settings::Set),
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
    pub(crate) fn run(self, output: Output) -> Result<(), Failure> {
        match self {
            Self::List(arguments) => arguments.run(output),
            Self::Info(port) => info::info(&port, output),
            Self::Get(port) => settings::get(&port, output),
            Self::Set(arguments) => arguments.run(output),
            Self::Measure(arguments) => arguments.run(output),
            Self::Emulate(arguments) => arguments.run(output),
            Self::Flash(arguments) => arguments.run(output),
            Self::Monitor(arguments) => arguments.run(output),
            Self::Selftest(arguments) => arguments.run(output),
        }
    }
}

/// Which device.
#[derive(Debug, Args)]
pub(crate) struct PortArguments {
    /// `serial:PATH[@BAUD]`, `serial:auto`, `haply:PATH` or `moteus:PATH`
    #[arg(long, value_name = "DEVICE", default_value = "serial:auto")]
    device: DeviceName,
    /// Keep trying for this long if the device is absent
    #[arg(long, value_parser = within::<Time>(range::WAITS))]
    #[arg(default_value = "0s")]
    wait: Time,
}

impl PortArguments {
    pub(super) fn name(&self) -> Result<&LinkedName, Failure> {
        match &self.device {
            DeviceName::Linked(name) => Ok(name),
            DeviceName::Simulated => Err(Failure::bad_input(
                "device \"sim\" has no port: give --device serial:PATH, as of host-cli device emulate",
            )),
        }
    }

    pub(super) fn patience(&self) -> Duration {
        Duration::from_secs_f64(self.wait.0)
    }

    /// One attempt, at a device of one axis.
    pub(super) fn connect_once(&self) -> Result<SerialLink, Failure> {
        self.name()?.connect_with(1, Duration::ZERO, &warn, None)
    }

    /// Attempts at a device of one axis until the patience is over; Ctrl-C ends them in words.
    pub(super) fn connect(&self) -> Result<SerialLink, Failure> {
        let (patience, stop) = self.attempts()?;
        self.name()?.connect_with(1, patience, &warn, stop)
    }

    /// The same at a device of any number of axes.
    pub(super) fn connect_any(&self) -> Result<SerialLink, Failure> {
        let (patience, stop) = self.attempts()?;
        self.name()?.connect(patience, &warn, stop)
    }

    /// For how long to try, and what ends it before.
    fn attempts(&self) -> Result<(Duration, Option<&'static AtomicBool>), Failure> {
        let patience = self.patience();
        let stop = match patience {
            Duration::ZERO => None,
            _ => Some(stop_on_interrupt()?),
        };
        Ok((patience, stop))
    }
}
