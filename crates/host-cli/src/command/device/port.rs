//! The device that a command is about, and how long a command lasts.

use crate::command::stop::stop_on_interrupt;
use crate::output::warn;
use crate::within::within;
use clap::Args;
use fracdiff::parameter::Shown;
use haptic_experiment::Failure;
use haptic_experiment::parameters::range;
use haptic_experiment::run::device::{DeviceName, LinkedName};
use haptic_quantity::Time;
use haptic_remote::serial::SerialLink;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Which device.
#[derive(Debug, Args)]
pub struct PortArguments {
    /// Device: `serial:PATH[@BAUD]`, `serial:auto` for the only one that answers, or one of another maker, as `haply:PATH` or `moteus:PATH`
    #[arg(long, value_name = "DEVICE", default_value = "serial:auto")]
    device: DeviceName,
    /// Go on trying for so long while the device is not there
    #[arg(long, value_parser = within::<Time>(range::WAITS), value_name = "TIME")]
    #[arg(default_value = "0s", allow_hyphen_values = true)]
    wait: Time,
}

impl PortArguments {
    pub(super) fn name(&self) -> Result<&LinkedName, Failure> {
        match &self.device {
            DeviceName::Linked(name) => Ok(name),
            DeviceName::Simulated => Err(Failure::bad_input(
                "device \"sim\" has no port: give --device serial:PATH, for example of host-cli device \
                 emulate",
            )),
        }
    }

    pub(super) fn patience(&self) -> Result<Duration, Failure> {
        Duration::try_from_secs_f64(self.wait.0).map_err(|_| {
            Failure::bad_input(format_args!(
                "waiting time {} s is not in [0, 1e9] s: give --wait, as in 10s",
                Shown(self.wait.0)
            ))
        })
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
        let patience = self.patience()?;
        let stop = match patience {
            Duration::ZERO => None,
            _ => Some(stop_on_interrupt()?),
        };
        Ok((patience, stop))
    }
}

/// Duration of a command, if it ends by itself.
pub(super) fn duration(given: Option<Time>) -> Result<Option<Duration>, Failure> {
    let Some(time) = given else {
        return Ok(None);
    };
    let duration = Duration::try_from_secs_f64(time.0).map_err(|_| {
        Failure::bad_input(format_args!(
            "duration {time} s is not in [0, 1e9] s: give --duration, as in 1min",
            time = Shown(time.0)
        ))
    })?;
    Ok(Some(duration))
}
