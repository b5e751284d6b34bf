//! Device of an experiment, and the way in which the loop with it is closed.

use super::device::number::watchdog_ms;
use crate::choice::choice;
use crate::whole::whole;
use crate::within::within;
use clap::Args;
use fracdiff::parameter::Shown;
use haptic_experiment::device::{DeviceName, LinkedName, Loop};
use haptic_experiment::failure::Failure;
use haptic_experiment::parameters;
use haptic_experiment::parameters::range;
use haptic_experiment::remote::RemoteDevice;
use haptic_quantity::Time;
use std::time::Duration;

/// Arguments of every experiment that can run on a device.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Device")]
pub struct RemoteArguments {
    /// Device: `sim`, `serial:PATH[@BAUD]`, `serial:auto`, or one of another maker, as `haply:PATH` or `moteus:PATH` [default: sim]
    #[arg(long, value_name = "DEVICE")]
    pub device: Option<DeviceName>,
    /// Where the loop with a serial device is closed [default: device]
    #[arg(long = "loop", value_parser = choice::<Loop>())]
    pub loop_mode: Option<Loop>,
    /// See [`parameters::WATCHDOG`].
    #[arg(long, value_parser = within::<Time>(parameters::WATCHDOG.range()), help = parameters::WATCHDOG.help, value_name = "TIME", allow_hyphen_values = true)]
    pub watchdog: Option<Time>,
    /// Late ticks in a row after which a serial device lets go; 0 for never [default: 20]
    #[arg(long, value_name = "COUNT", value_parser = whole::<u16>(0..=u16::MAX))]
    pub late_ticks: Option<u16>,
    /// See [`parameters::MAX_AGE_TICKS`].
    #[arg(long, help = parameters::MAX_AGE_TICKS.help, value_name = "COUNT", value_parser = whole::<u16>(1..=1000))]
    pub max_age_ticks: Option<u16>,
    /// Go on trying for so long while a serial device is not there [default: 0s]
    #[arg(long, value_parser = within::<Time>(range::WAITS), value_name = "TIME", allow_hyphen_values = true)]
    pub wait: Option<Time>,
}

impl RemoteArguments {
    /// True if a device at a port was named.
    #[must_use]
    pub fn is_serial(&self) -> bool {
        self.named().is_some()
    }

    /// The device at a port that was named.
    #[must_use]
    pub const fn named(&self) -> Option<&LinkedName> {
        match &self.device {
            Some(DeviceName::Linked(name)) => Some(name),
            Some(DeviceName::Simulated) | None => None,
        }
    }

    /// The serial device; `None` for the simulated one. What is not given is as in `file`.
    ///
    /// # Errors
    /// A time outside its range; options of a serial device without one.
    pub fn remote(&self, file: Option<&RemoteDevice>) -> Result<Option<RemoteDevice>, Failure> {
        let name = match &self.device {
            Some(DeviceName::Linked(name)) => Some(name.clone()),
            Some(DeviceName::Simulated) => None,
            None => file.map(|file| file.name.clone()),
        };
        let Some(name) = name else {
            let given = self.loop_mode.is_some()
                || self.watchdog.is_some()
                || self.late_ticks.is_some()
                || self.max_age_ticks.is_some()
                || self.wait.is_some();
            if given {
                return Err(Failure::bad_input(
                    "--loop, --watchdog, --late-ticks, --max-age-ticks and --wait are for serial devices: add \
                     --device serial:PATH",
                ));
            }
            return Ok(None);
        };
        let mut remote = file
            .cloned()
            .unwrap_or_else(|| RemoteDevice::new(name.clone()));
        remote.name = name;
        if let Some(chosen) = self.loop_mode {
            remote.loop_mode = chosen.into();
        }
        if let Some(watchdog) = self.watchdog {
            remote.watchdog_ms = Some(watchdog_ms(watchdog)?);
        }
        if let Some(late_ticks) = self.late_ticks {
            remote.late_ticks = late_ticks;
        }
        if let Some(max_age_ticks) = self.max_age_ticks {
            remote.max_age_ticks = max_age_ticks;
        }
        if let Some(wait) = self.wait {
            remote.patience = Duration::try_from_secs_f64(wait.0).map_err(|_| {
                Failure::bad_input(format_args!(
                    "waiting time {wait} s is not in [0, 1e9] s: give --wait, as in 10s",
                    wait = Shown(wait.0)
                ))
            })?;
        }
        Ok(Some(remote))
    }
}
