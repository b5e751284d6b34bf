//! `[calibration]` of a device file: how many newtons a newton of the device is, and the day on which that was found.
//!
//! ```toml
//! [calibration]
//! date = "2026-11-29"
//! device = "rp2040 E6605838"                # its identity; of a file without it any device takes the factors
//! motor_factor = [0.505, 0.511, 0.517]      # lowest, likeliest, highest
//! sensor_factor = [0.981, 0.990, 0.999]     # of a device with a force sensor
//! sensor_offset_n = [-0.02, -0.01, 0.0]
//! sensor_lag_s = [0.0008, 0.001, 0.0012]
//! ```

use crate::document::error::FileError;
use crate::document::failure::Failure;
use crate::document::parameters::kind::{Parameter, parameters};
use crate::document::parameters::range::{Range, either_sign};
use crate::document::reader::Table;
use haptic_quantity::{label, written};
use haptic_remote::serial::ForceFactors;
use serde::Serialize;

const FACTORS: Range = Range::Within(ForceFactors::ENDS[0], ForceFactors::ENDS[1]);

parameters! {
    all CALIBRATION_KEYS;
    CALIBRATED_ON = text("date", "", "Day of the calibration");
    CALIBRATED_DEVICE = text("device", "", "The device; another is refused");
    MOTOR_FACTOR = list("motor_factor", FACTORS, "Force per newton commanded: lowest, likeliest, highest");
    SENSOR_FACTOR = list("sensor_factor", FACTORS, "Force per newton shown");
    SENSOR_OFFSET = list("sensor_offset_n", either_sign(1e3), "Reading without force");
    SENSOR_LAG = list("sensor_lag_s", Range::Within(-0.05, 0.2), "Time by which it follows");
}

/// A number and the interval in which it lies in 95 of 100 cases, if the model is right.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Estimate {
    pub value: f64,
    pub low: f64,
    pub high: f64,
}

impl Estimate {
    /// A number and half the width of its interval.
    pub(crate) const fn about(value: f64, half: f64) -> Self {
        Self {
            value,
            low: value - half,
            high: value + half,
        }
    }

    /// Half the width of the interval over the value.
    pub(crate) fn relative(&self) -> f64 {
        0.5 * (self.high - self.low) / self.value.abs()
    }

    /// The product with a factor above 0; the interval has all that both intervals allow.
    pub(crate) fn times(&self, factor: Self) -> Self {
        let end =
            |end: f64, toward_0: f64, away: f64| end * if end < 0.0 { away } else { toward_0 };
        Self {
            value: self.value * factor.value,
            low: end(self.low, factor.low, factor.high),
            high: end(self.high, factor.high, factor.low),
        }
    }
}

/// Newtons of a device, checked against an instrument.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(crate) struct Calibration {
    /// Day.
    pub date: String,
    /// Identity of the device; empty where readings were given.
    pub device: String,
    /// True force for each newton commanded.
    pub motor_factor: Option<Estimate>,
    /// True force for each newton that the force sensor shows.
    pub sensor_factor: Option<Estimate>,
    /// Reading of the force sensor without force, in its own newtons.
    pub sensor_offset_n: Option<Estimate>,
    /// Time by which the force sensor follows the force.
    pub sensor_lag_s: Option<Estimate>,
}

type Field = fn(&mut Calibration) -> &mut Option<Estimate>;

impl Calibration {
    const FIELDS: [(Parameter, Field); 4] = [
        (MOTOR_FACTOR, |known| &mut known.motor_factor),
        (SENSOR_FACTOR, |known| &mut known.sensor_factor),
        (SENSOR_OFFSET, |known| &mut known.sensor_offset_n),
        (SENSOR_LAG, |known| &mut known.sensor_lag_s),
    ];

    pub(super) fn read(table: &Table<'_>) -> Result<Self, FileError> {
        let mut known = Self {
            date: table.required_text(&CALIBRATED_ON)?.to_owned(),
            device: table.text(&CALIBRATED_DEVICE)?.to_owned(),
            ..Self::default()
        };
        for (parameter, field) in Self::FIELDS {
            *field(&mut known) = match table.numbers_if(&parameter)?.as_deref() {
                None => None,
                Some(&[low, value, high]) if low <= value && value <= high => {
                    Some(Estimate { value, low, high })
                }
                Some(_) => {
                    return Err(table.fail_at(parameter.key, format_args!(
                        "{} is not three numbers, the lowest, the likeliest and the highest: write them in that order, or omit it", parameter.key
                    )));
                }
            };
        }
        Ok(known)
    }

    /// The text of its table.
    pub(super) fn to_toml(&self) -> String {
        let mut known = self.clone();
        let [date, device] =
            [&self.date, &self.device].map(|text| toml::Value::from(text.as_str()));
        let mut text = format!(
            "\n[calibration]\ndate = {date}\ndevice = {device}\n# Lowest, likeliest and highest value.\n"
        );
        for (Parameter { key, .. }, field) in Self::FIELDS {
            if let Some(Estimate { value, low, high }) = *field(&mut known) {
                text += &format!("{key} = [{low:?}, {value:?}, {high:?}]\n");
            }
        }
        text
    }

    /// The likeliest motor factor with its interval; 1 of one that was not found.
    pub(crate) fn motor(&self) -> Estimate {
        self.motor_factor.unwrap_or(Estimate::about(1.0, 0.0))
    }

    /// Its factors, for the link of the device.
    ///
    /// # Errors
    /// A factor that no device has.
    pub(crate) fn factors(&self) -> Result<ForceFactors, Failure> {
        let (motor, sensor) = (
            self.motor(),
            self.sensor_factor.map_or(1.0, |sensor| sensor.value),
        );
        ForceFactors::new(motor.value, motor.high, sensor).map_err(Failure::input)
    }

    /// One line for a report.
    pub(crate) fn in_words(known: Option<&Self>) -> String {
        let Some(known) = known else {
            return "never calibrated: a newton here is what the device takes for one".to_owned();
        };
        let mut of = known.clone();
        let numbers = Self::FIELDS.iter().filter_map(|(parameter, field)| {
            let Estimate { value, low, high } = (*field(&mut of))?;
            let [value, low, high] = [value, low, high].map(|end| written(parameter.key, end));
            Some(format!(
                "{} {value} ({low} to {high})",
                label(parameter.key)
            ))
        });
        let numbers: Vec<String> = numbers.collect();
        format!("calibrated on {}: {}", known.date, numbers.join(", "))
    }
}
