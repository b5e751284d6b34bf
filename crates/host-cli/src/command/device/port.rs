//! The device that a command is about, and how long a command lasts.

use crate::output::warn;
use crate::quantity::Time;
use clap::Args;
use haptic_experiment::device::{DeviceName, LinkedName};
use haptic_experiment::failure::Failure;
use haptic_remote::serial::SerialLink;
use std::time::Duration;

/// Which device.
#[derive(Debug, Args)]
pub struct PortArguments {
    /// Device: `serial:PATH[@BAUD]`, `serial:auto` for the only one that answers, or one of another maker, as `haply:PATH` or `moteus:PATH`
    #[arg(long, value_name = "DEVICE", default_value = "serial:auto")]
    device: DeviceName,
    /// Go on trying for so long while the device is not there
    #[arg(
        long,
        value_name = "TIME",
        default_value = "0s",
        allow_hyphen_values = true
    )]
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

    /// The device at a port; `None` for the simulated one.
    pub(super) const fn linked(&self) -> Option<&LinkedName> {
        match &self.device {
            DeviceName::Linked(name) => Some(name),
            DeviceName::Simulated => None,
        }
    }

    pub(super) fn patience(&self) -> Result<Duration, Failure> {
        Duration::try_from_secs_f64(self.wait.0).map_err(|_| {
            Failure::bad_input(format_args!(
                "waiting time {} is not in [0, 1e9] s: give --wait, as in 10s",
                self.wait
            ))
        })
    }

    /// One attempt, at a device of one axis.
    pub(super) fn connect_once(&self) -> Result<SerialLink, Failure> {
        self.name()?.connect_with(1, Duration::ZERO, &warn, None)
    }

    /// A device of one axis.
    pub(super) fn connect(&self) -> Result<SerialLink, Failure> {
        self.name()?.connect_with(1, self.patience()?, &warn, None)
    }

    /// A device of any number of axes.
    pub(super) fn connect_any(&self) -> Result<SerialLink, Failure> {
        self.name()?.connect(self.patience()?, &warn, None)
    }
}

/// Duration of a command, if it ends by itself.
pub(super) fn duration(given: Option<Time>) -> Result<Option<Duration>, Failure> {
    let Some(time) = given else {
        return Ok(None);
    };
    let duration = Duration::try_from_secs_f64(time.0).map_err(|_| {
        Failure::bad_input(format_args!(
            "duration {time} is not in [0, 1e9] s: give --duration, as in 1min"
        ))
    })?;
    Ok(Some(duration))
}
