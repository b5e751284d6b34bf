//! A device whose values are in a file: measured, or written down by somebody who knows them.

use super::model::{DeviceValues, Interval, PlantFile, PlantModel};
use crate::document::Parsed;
use crate::document::error::{FileError, text_of};
use crate::document::parameters as p;
use crate::document::parameters::Parameter;
use crate::run::imperfections::Imperfections;
use crate::run::safety::GuardedDevice;
use crate::run::sensors::Sensors;
use haptic_analysis::Dynamics;
use std::path::Path;

/// The device of a plant file with `[device]`, to be simulated, analysed or guarded.
///
/// ```
/// use haptic_experiment::run::DeviceModel;
/// use std::path::Path;
///
/// let text = "[device]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\nfriction_n = 0.05\ndelay_s = 0.0013\n\
///             [intervals]\ndelay_s = [0.00128, 0.00132]";
/// let device = DeviceModel::parse(Path::new("lab/device.toml"), text)?;
/// assert_eq!(device.values.friction_n, 0.05);
/// // A guard is made for what is certain.
/// assert_eq!(device.guarded().delay_s, Some((0.00128, 0.00132)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct DeviceModel {
    /// Its values.
    pub values: DeviceValues,
    /// Between which numbers they lie, where that is known.
    pub intervals: Vec<Interval>,
    /// The program that made the file.
    pub program: String,
    /// Conditions under which it was measured.
    pub note: String,
}

impl DeviceValues {
    /// Parameters with the values.
    #[must_use]
    pub(crate) fn named(&self) -> [(&'static Parameter, f64); 8] {
        [
            (&p::MASS, self.mass_kg),
            (&p::DAMPING, self.damping_n_s_per_m),
            (&p::HAND_STIFFNESS, self.hand_stiffness_n_per_m),
            (&p::DELAY, self.delay_s),
            (&p::CURRENT_LAG, self.current_lag_s),
            (&p::FRICTION, self.friction_n),
            (&p::ENCODER_RESOLUTION, self.encoder_resolution_m),
            (&p::SENSOR_NOISE, self.sensor_noise_m),
        ]
    }
}

impl DeviceModel {
    /// The device `laboratory`, which is shipped, or that of a file.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn find(name: &Path) -> Result<Self, FileError> {
        match name.to_str() {
            Some(p::LABORATORY) => {
                Self::parse(name, include_str!("../../../devices/laboratory.toml"))
            }
            _ => Self::read(name),
        }
    }

    /// Reads and checks a file.
    ///
    /// # Errors
    /// If it cannot be read, is wrong, or has another plant than a device: in one line, with file and line.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        Self::parse(path, &text_of(path, "device")?)
    }

    /// Reads and checks the text of a file; `path` is for messages.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn parse(path: &Path, text: &str) -> Result<Self, FileError> {
        let file = PlantFile::parse(path, text)?;
        let document = Parsed::of(path, text)?;
        let PlantModel::Device(values) = file.model else {
            let reason = "no [device] in it: `device measure` writes such a file";
            return Err(document.fail(reason.to_owned()));
        };
        Ok(Self {
            values,
            intervals: file.intervals,
            program: file.program,
            note: file.note,
        })
    }

    /// The text of its file.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let file = PlantFile {
            model: PlantModel::Device(self.values),
            intervals: self.intervals.clone(),
            program: self.program.clone(),
            note: self.note.clone(),
        };
        file.to_toml().unwrap_or_default()
    }

    /// Friction, delay, lag and sensors, for a simulation.
    #[must_use]
    pub const fn imperfections(&self) -> Imperfections {
        Imperfections {
            friction_n: self.values.friction_n,
            delay_s: self.values.delay_s,
            current_lag_s: self.values.current_lag_s,
            sensors: Sensors {
                encoder_resolution_m: self.values.encoder_resolution_m,
                noise_m: self.values.sensor_noise_m,
                ..Imperfections::NONE.sensors
            },
        }
    }

    /// Mass, damping, hand, delay and lag, for an analysis.
    #[must_use]
    pub const fn dynamics(&self) -> Dynamics {
        Dynamics {
            mass_kg: self.values.mass_kg,
            damping_n_s_per_m: self.values.damping_n_s_per_m,
            hand_stiffness_n_per_m: self.values.hand_stiffness_n_per_m,
            delay_s: self.values.delay_s,
            current_lag_s: self.values.current_lag_s,
        }
    }

    /// The least of mass and damping and the whole interval of the delay, for a guard, which must hold for what is certain.
    #[must_use]
    pub fn guarded(&self) -> GuardedDevice {
        let values = &self.values;
        let ends = |key: &str, value: f64| {
            let found = self.intervals.iter().find(|interval| interval.key == key);
            found.map_or((value, value), |interval| (interval.low, interval.high))
        };
        GuardedDevice {
            mass_kg: Some(ends(p::MASS.key, values.mass_kg).0),
            damping_n_s_per_m: Some(ends(p::DAMPING.key, values.damping_n_s_per_m).0),
            delay_s: Some(ends(p::DELAY.key, values.delay_s)),
            lag_s: Some(values.current_lag_s),
            noise_m: Some(self.imperfections().sensors.deviation_m()),
        }
    }
}

/// `[device]` and, if there are any, `[intervals]`.
pub(super) fn tables(values: &DeviceValues, intervals: &[Interval]) -> String {
    let mut text = "[device]\n".to_owned();
    for (parameter, value) in values.named() {
        text += &format!("{} = {value:?}\n", parameter.key);
    }
    if !intervals.is_empty() {
        text += "\n# 95 of 100 such intervals have the true value in them.\n[intervals]\n";
        for Interval { key, low, high } in intervals {
            text += &format!("{key} = [{low:?}, {high:?}]\n");
        }
    }
    text
}
