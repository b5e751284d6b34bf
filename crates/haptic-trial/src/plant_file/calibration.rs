//! `[calibration]` of a device file: how many newtons a newton of the device is, and the day on which that was found.
//!
//! ```toml
//! [calibration]
//! date = "2026-11-29"
//! device = "rp2040 E6605838"                # its identity; of a file without it any device takes the factors
//! motor_factor = [0.505, 0.511, 0.517]      # lowest, likeliest, highest
//! sensor_factor = [0.981, 0.990, 0.999]     # of a device with a force sensor
//! sensor_offset_n = [-0.02, -0.01, 0.0]
//! sensed_lag_s = [0.0008, 0.001, 0.0012]
//! ```

use haptic_document::{
    Failure, FileError, Table, parameters,
    parameters::{
        Parameter,
        range::{Range, either_sign},
    },
};
use haptic_quantity::{label, written};
use haptic_remote::ForceFactors;
use serde::Serialize;
use std::collections::BTreeMap;

const FACTORS: Range = Range::Within(ForceFactors::ENDS[0], ForceFactors::ENDS[1]);

parameters! {
    CALIBRATED_ON = text("date", "", "Day of the calibration");
    CALIBRATED_DEVICE = text("device", "", "The device; another is refused");
    MOTOR_FACTOR = list("motor_factor", FACTORS, "Force per newton commanded: lowest, likeliest, highest");
    SENSOR_FACTOR = list("sensor_factor", FACTORS, "Force per newton shown");
    SENSOR_OFFSET = list("sensor_offset_n", either_sign(1e3), "Reading without force");
    SENSOR_LAG = list("sensed_lag_s", either_sign(0.2), "Time by which it follows");
}

/// The keys of a calibration.
pub const CALIBRATION_KEYS: &[Parameter] = &[
    CALIBRATED_ON,
    CALIBRATED_DEVICE,
    MOTOR_FACTOR,
    SENSOR_FACTOR,
    SENSOR_OFFSET,
    SENSOR_LAG,
];

/// A number and the interval in which it lies in 95 of 100 cases, if the model is right.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MeasuredNumber {
    /// The likeliest number.
    pub value: f64,
    /// Low end of the interval.
    pub low: f64,
    /// High end of the interval.
    pub high: f64,
}

impl MeasuredNumber {
    /// A number and half the width of its interval.
    pub const fn about(value: f64, half: f64) -> Self {
        Self {
            value,
            low: value - half,
            high: value + half,
        }
    }

    /// Half the width of the interval over the value.
    pub fn relative(&self) -> f64 {
        0.5 * (self.high - self.low) / self.value.abs()
    }

    /// The product with a factor above 0; the interval has all that both intervals allow.
    pub fn times(&self, factor: Self) -> Self {
        Self {
            value: self.value * factor.value,
            low: f64::min(self.low * factor.low, self.low * factor.high),
            high: f64::max(self.high * factor.low, self.high * factor.high),
        }
    }
}

/// Newtons of a device, checked against an instrument.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Calibration {
    /// Day of the calibration, as 2026-11-29.
    pub date: String,
    /// The device that was calibrated: another is refused. Empty if the file names none.
    #[serde(skip)]
    pub device: String,
    /// Numbers by their keys: true force for each newton commanded, and for each that the force sensor shows; its reading without force, in its own
    /// newtons; the time by which it follows, s.
    #[serde(flatten)]
    pub found: BTreeMap<&'static str, MeasuredNumber>,
}

impl MeasuredNumber {
    /// True of a number in the interval.
    #[must_use]
    pub fn covers(&self, number: f64) -> bool {
        (self.low..=self.high).contains(&number)
    }
}

impl Calibration {
    /// Reads the table of a calibration.
    ///
    /// # Errors
    /// A key that is missing, or a number outside its range.
    pub fn read(table: &Table<'_>) -> Result<Self, FileError> {
        let mut known = Self {
            date: table.required_text(&CALIBRATED_ON)?.to_owned(),
            device: table.text(&CALIBRATED_DEVICE)?.to_owned(),
            ..Self::default()
        };
        for parameter in &CALIBRATION_KEYS[2..] {
            let key = parameter.key;
            match table.numbers_if(parameter)?.as_deref() {
                None => {}
                Some(&[low, value, high]) if low <= value && value <= high => {
                    known.found.insert(key, MeasuredNumber { value, low, high });
                }
                Some(_) => {
                    return Err(table.fail_at(key, format_args!(
                        "{key} is not three numbers, the lowest, the likeliest and the highest: write them in that order, or omit it"
                    )));
                }
            }
        }
        Ok(known)
    }

    /// The text of its table.
    pub fn to_toml(&self) -> String {
        let [date, device] =
            [&self.date, &self.device].map(|text| toml::Value::from(text.as_str()));
        let mut text = format!(
            "\n# Lowest, likeliest and highest value.\n[calibration]\ndate = {date}\ndevice = {device}\n"
        );
        for (key, MeasuredNumber { value, low, high }) in &self.found {
            text += &format!("{key} = [{low:?}, {value:?}, {high:?}]\n");
        }
        text
    }

    /// A factor; 1 of one that was not found.
    pub fn factor(&self, parameter: &Parameter) -> MeasuredNumber {
        let found = self.found.get(parameter.key).copied();
        found.unwrap_or(MeasuredNumber::about(1.0, 0.0))
    }

    /// Its factors, for the link of the device.
    ///
    /// # Errors
    /// A factor that no device has.
    pub fn factors(&self) -> Result<ForceFactors, Failure> {
        let [motor, sensor] = [MOTOR_FACTOR, SENSOR_FACTOR].map(|factor| self.factor(&factor));
        ForceFactors::new(motor.value, motor.high, sensor.value).map_err(Failure::input)
    }

    /// One line for a report.
    pub fn in_words(known: Option<&Self>) -> String {
        let Some(known) = known else {
            return "never calibrated: a newton here is what the device takes for one".to_owned();
        };
        let numbers = known
            .found
            .iter()
            .map(|(key, MeasuredNumber { value, low, high })| {
                let [value, low, high] = [value, low, high].map(|end| written(key, *end));
                format!("{} {value} ({low} to {high})", label(key))
            });
        let numbers: Vec<String> = numbers.collect();
        format!("calibrated on {}: {}", known.date, numbers.join(", "))
    }
}
