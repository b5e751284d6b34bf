//! A device as its program describes it, checked.

use haptic_document::{FileError, text_of};
use haptic_link::{Capabilities, Conduct, Limits, SerialNumber};
use haptic_loop::RangeError;
use haptic_remote::abilities;
use haptic_trial::robot::OwnRobot;
use std::path::PathBuf;
use thiserror::Error;

/// Abilities and limits of a device. No host can loosen these limits; it sets its own within them.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// Name in `device info` and in logs, 1 to 16 bytes.
    pub name: String,
    /// Number of axes, 1 to 3.
    pub axes: u32,
    /// T, the time from one tick to the next, µs, 100 to 10 000; 0 takes the mean time between the calls of the first second, which
    /// has no force. Calls in between hold the last force.
    pub sample_time_us: u32,
    /// Largest force on an axis, and of several axes the largest magnitude, N, above 0.
    pub force_max_n: f64,
    /// Largest rate of the force, N/s, above 0.
    pub force_rate_max_n_per_s: f64,
    /// Distance of one count of the sensor, m; 0 if it is not known.
    pub position_resolution_m: f64,
    /// Largest force that the force sensor shows either way, N; 0 without one.
    pub sensed_force_max_n: f64,
    /// Low ends of the workspace, m. Outside of it there is no force. Two ends of 0 mean no workspace limit.
    pub workspace_low_m: [f64; 3],
    /// High ends of the workspace, m.
    pub workspace_high_m: [f64; 3],
    /// Longest silence of a host while the device is armed, ms, 5 to 1000; a host may ask for less, which counts. 0 leaves it
    /// to the host.
    pub watchdog_ms: u32,
    /// Serial number of the device, 6 to 32 letters, digits and any of `-_.:+`, by which a host remembers its limits; empty if it is not known.
    pub serial_number: String,
    /// A force, or a velocity.
    pub takes: Takes,
}

/// Kind of command that a device takes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Takes {
    /// A force, N, by [`BridgeTicker::tick`](crate::BridgeTicker::tick).
    #[default]
    Force,
    /// A velocity, m/s, by [`BridgeTicker::tick_motion`](crate::BridgeTicker::tick_motion): of a robot with a force sensor under its handle,
    /// whose range and sample time are then declared.
    Velocity {
        /// Its device file, with `[admittance]`: body, loop, limits and hands. Without bandwidth and dead time it is to be measured.
        robot: PathBuf,
    },
}

/// Sample times that a device can have, µs.
pub(crate) const PERIODS_US: [u32; 2] = [100, 10_000];

/// A device that cannot be.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum DescriptionError {
    /// A number outside its range.
    #[error("{0}: give another")]
    Range(#[from] RangeError),
    /// A name that is empty, longer than a frame can say, or has a zero byte in it.
    #[error("name = \"{0}\" is not 1 to 16 bytes long: give a short name, such as \"Falcon\"")]
    Name(String),
    /// A serial number that could be that of another device.
    #[error(
        "serial_number = \"{0}\" is not {least} to {most} letters, digits and any of -_.:+, or is one that counts up: give that of the device, or none",
        least = SerialNumber::LEAST,
        most = SerialNumber::MOST
    )]
    SerialNumber(String),
    /// A workspace whose ends are the wrong way round, or are no numbers.
    #[error(
        "workspace_low_m = {low} m on axis {axis} is not below workspace_high_m = {high} m: exchange them, or give 0 and 0 for no ends"
    )]
    Workspace {
        /// Number of the axis, from 0.
        axis: usize,
        /// Its low end as it was given, m.
        low: f64,
        /// Its high end as it was given, m.
        high: f64,
    },
}

impl Description {
    /// Checks it, and says it as the wire does.
    ///
    /// # Errors
    /// The first thing that cannot be, with its range.
    pub fn capabilities(&self) -> Result<Capabilities, DescriptionError> {
        if self.name.is_empty() || self.name.len() > 16 || self.name.contains('\0') {
            return Err(DescriptionError::Name(self.name.clone()));
        }
        let (period_us, watchdog_ms) = (self.sample_time_us, self.watchdog_ms);
        let silences = u32::from(Limits::WATCHDOG_MIN_MS)..=u32::from(Limits::WATCHDOG_MAX_MS);
        let watched = watchdog_ms == 0 || silences.contains(&watchdog_ms);
        let (axes, period, watchdog) = (self.axes.into(), period_us.into(), watchdog_ms.into());
        let (force_n, rate) = (self.force_max_n, self.force_rate_max_n_per_s);
        let (count_m, sensed_n) = (self.position_resolution_m, self.sensed_force_max_n);
        // In single precision, in which the loop computes.
        let positive = |value: f64| value as f32 > 0.0 && (value as f32).is_finite();
        let (above, silence) = ("above 0 and finite", "5 to 1000, or 0 for the host's alone");
        let [least_us, most_us] = PERIODS_US;
        let (few, short) = (
            (1..=3).contains(&self.axes),
            period_us == 0 || (least_us..=most_us).contains(&period_us),
        );
        let fine = (0.0..=0.1).contains(&count_m);
        let moves = matches!(self.takes, Takes::Velocity { .. });
        let declared = "declared for a device that takes a velocity: 100 to 10000";
        let sensor = "above 0 and at most 1e6 for a device that takes a velocity";
        for (good, what, value, allowed, unit) in [
            (few, "axes", axes, "1, 2 or 3", ""),
            (
                short,
                "sample_time_us",
                period,
                "100 to 10000, or 0 to have it measured",
                "µs",
            ),
            (watched, "watchdog_ms", watchdog, silence, "ms"),
            (positive(force_n), "force_max_n", force_n, above, "N"),
            (positive(rate), "force_rate_max_n_per_s", rate, above, "N/s"),
            (fine, "position_resolution_m", count_m, "0 to 0.1", "m"),
            (
                (0.0..=1e6).contains(&sensed_n),
                "sensed_force_max_n",
                sensed_n,
                "0 to 1e6, 0 without a force sensor",
                "N",
            ),
            (
                !moves || period_us > 0,
                "sample_time_us",
                period,
                declared,
                "µs",
            ),
            (
                !moves || sensed_n > 0.0,
                "sensed_force_max_n",
                sensed_n,
                sensor,
                "N",
            ),
        ] {
            if !good {
                return Err(RangeError::new(what, value, allowed, unit).into());
            }
        }
        for axis in 0..self.axes as usize {
            let (low, high) = (self.workspace_low_m[axis], self.workspace_high_m[axis]);
            let none = low.abs() + high.abs() <= 0.0;
            if !(none || low < high) {
                return Err(DescriptionError::Workspace { axis, low, high });
            }
        }
        Ok(Capabilities {
            tick_period_min_us: period_us.max(least_us),
            tick_period_max_us: period_us.max(least_us),
            force_max_n: force_n as f32,
            force_rate_max_n_per_s: rate as f32,
            position_resolution_m: count_m as f32,
            sensed_force_max_n: sensed_n as f32,
            // The program may stand still, and its driver hold the last force.
            lets_go_alone: Conduct::default(),
            ..abilities(&self.name, self.axes as u8)
        })
    }

    /// The robot of its device file, if it takes a velocity.
    pub(crate) fn robot(&self) -> Result<Option<OwnRobot>, FileError> {
        let Takes::Velocity { robot } = &self.takes else {
            return Ok(None);
        };
        let (text, t) = (
            text_of(robot, "device")?,
            f64::from(self.sample_time_us) * 1e-6,
        );
        OwnRobot::parse(robot, &text, t).map(Some)
    }

    pub(crate) fn serial_number(&self) -> Result<SerialNumber, DescriptionError> {
        let text = &self.serial_number;
        if text.is_empty() {
            return Ok(SerialNumber::NONE);
        }
        SerialNumber::named(text).ok_or_else(|| DescriptionError::SerialNumber(text.clone()))
    }

    /// The ends of an axis, m; infinite without a limit.
    pub(crate) fn workspace(&self, axis: usize) -> [f32; 2] {
        match [self.workspace_low_m[axis], self.workspace_high_m[axis]] {
            [low, high] if low < high => [low as f32, high as f32],
            _ => [f32::NEG_INFINITY, f32::INFINITY],
        }
    }
}
