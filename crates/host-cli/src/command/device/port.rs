//! The device that a command speaks with.

use crate::command::conduct::stop_on_interrupt;
use crate::output::warn;
use crate::parse::{WAITS, quantity};
use clap::Args;
use haptic_experiment::Failure;
use haptic_remote::serial::SerialLink;
use haptic_run::DeviceName;
use std::time::Duration;

#[derive(Debug, Args)]
pub(crate) struct PortArguments {
    /// `serial:PATH[@BAUD]`, `serial:auto`, `tcp:HOST:PORT`, `haply:PATH`, `moteus:PATH` or `inverse3:`
    #[arg(long, value_name = "DEVICE", default_value = "serial:auto")]
    pub(super) device: DeviceName,
    /// Keep trying for this long if the device is absent
    #[arg(long, value_name = "TIME", value_parser = quantity("_s", WAITS))]
    #[arg(default_value = "0s")]
    wait: f64,
}

impl PortArguments {
    pub(super) fn patience(&self) -> Duration {
        Duration::from_secs_f64(self.wait)
    }

    /// One attempt, at a device of one axis.
    pub(super) fn connect_once(&self) -> Result<SerialLink, Failure> {
        let stop = stop_on_interrupt()?;
        (self.device).connect(Some(1), Duration::ZERO, &warn, Some(stop))
    }

    /// Attempts at a device of one axis until the patience is over; Ctrl-C ends them in words.
    pub(super) fn connect(&self) -> Result<SerialLink, Failure> {
        let stop = stop_on_interrupt()?;
        (self.device).connect(Some(1), self.patience(), &warn, Some(stop))
    }

    /// Attempts at a device of any number of axes.
    pub(super) fn connect_any(&self) -> Result<SerialLink, Failure> {
        let stop = stop_on_interrupt()?;
        (self.device).connect(None, self.patience(), &warn, Some(stop))
    }

    /// Connects for all axes of a device, or this many of one of another maker.
    pub(super) fn connect_all(&self, axes: Option<u8>) -> Result<SerialLink, Failure> {
        let (axes, stop) = (axes.map(usize::from), stop_on_interrupt()?);
        (self.device).connect_all(axes, self.patience(), &warn, Some(stop))
    }
}
