//! The device that a command speaks with.

use crate::command::conduct::stop_on_interrupt;
use crate::output::warn;
use crate::parse::{WAITS, within};
use clap::Args;
use haptic_experiment::Failure;
use haptic_experiment::run::device::{DeviceName, LinkedName};
use haptic_quantity::Time;
use haptic_remote::serial::SerialLink;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Which device.
#[derive(Debug, Args)]
pub(crate) struct PortArguments {
    /// `serial:PATH[@BAUD]`, `serial:auto`, `haply:PATH` or `moteus:PATH`
    #[arg(long, value_name = "DEVICE", default_value = "serial:auto")]
    device: DeviceName,
    /// Keep trying for this long if the device is absent
    #[arg(long, value_parser = within::<Time>(WAITS))]
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
