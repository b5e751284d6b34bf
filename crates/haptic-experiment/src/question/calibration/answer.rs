//! A calibration from its document to its report.

use super::conduct::{WRONG_SIGN, held};
use super::line::{Point, line};
use super::{
    Answer, Answers, CALIBRATE_BOX, CALIBRATE_FORCE, CALIBRATE_READINGS, CALIBRATE_STEP,
    CALIBRATE_WEIGHT, CALIBRATION, GRAVITY, TABLES,
};
use crate::document::Document;
use crate::document::error::FileError;
use crate::document::failure::Failure;
use crate::document::parameters::DEVICE;
use crate::experiment::reading::{device_model, remote_by};
use crate::question::measurement::drive::{armed, board_words, opened};
use crate::question::measurement::{
    MEASURE_AXIS, MEASURE_DEVICE, MEASURE_SAMPLE_TIME, MeasurePlan, OwnLimits,
};
use crate::run::device::{Warn, at_link};
use crate::run::plant_file::calibration::{Calibration, Estimate};
use crate::run::plant_file::{DeviceModel, DeviceValues};
use crate::run::remote::RemoteDevice;
use haptic_log::record::StartTime;
use haptic_quantity::{digits, written};
use serde::Serialize;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, SystemTime};

#[cfg(test)]
mod tests;

const SENSOR_SIGN: &str = "the force sensor shows the opposite of the force: swap its two signal wires, or the sign where the firmware converts it; then calibrate again";

/// A check of a device's newtons, all of its parameters read.
#[derive(Clone, Debug)]
pub struct Calibrator {
    plan: MeasurePlan,
    /// The device; `None` where the readings are given.
    remote: Option<RemoteDevice>,
    model: Option<DeviceModel>,
    weight_n: Option<f64>,
    step_n: f64,
    readings: Vec<Point>,
}

impl Calibrator {
    /// Reads and checks a document.
    ///
    /// # Errors
    /// If it is wrong: in one line, with its place.
    pub fn open(document: &Document) -> Result<Self, FileError> {
        let document = document.parse()?;
        let (_, table, _) =
            document.one_of(&[CALIBRATION], &[], "calibration", "give [calibrate]")?;
        let table = table.with_keys(&TABLES)?;
        let wrong = |reason: &str| {
            table.fail_at(
                CALIBRATE_READINGS.key,
                format_args!("{} {reason}", CALIBRATE_READINGS.key),
            )
        };
        let mut readings = Vec::new();
        for pair in table.matrix_if(&CALIBRATE_READINGS)?.unwrap_or_default() {
            let [commanded_n, force_n] = pair[..] else {
                return Err(wrong(
                    "is not a list of pairs: write [[COMMANDED, SHOWN], …]",
                ));
            };
            // By hand: each was approached from zero, as far as is known.
            readings.push(Point::rising(commanded_n, force_n));
        }
        let remote = match readings.len() {
            0 => remote_by(&table, &MEASURE_DEVICE)?,
            1 => return Err(wrong("has one pair: give two at least, far apart")),
            _ => None,
        };
        if remote.is_none() && readings.is_empty() {
            return Err(table.fail_at(MEASURE_DEVICE.key, format_args!(
                "the simulated device has no newtons to check: give {}, or {CALIBRATE_READINGS}", DEVICE.set_to("serial:PATH")
            )));
        }
        let weight_kg = table.number_if(&CALIBRATE_WEIGHT)?;
        Ok(Self {
            plan: MeasurePlan {
                sample_time_s: table.number(&MEASURE_SAMPLE_TIME)?,
                // The plan of a measurement uses a share of it.
                force_limit_n: table.number(&CALIBRATE_FORCE)? / MeasurePlan::SHARE,
                box_m: table.number(&CALIBRATE_BOX)?,
                duration_s: 600.0,
                hand: false,
                axis: table.choice(&MEASURE_AXIS)?,
                own: OwnLimits::NONE,
            },
            // Whatever it was calibrated to: its own newtons are checked.
            remote: remote.map(|remote| RemoteDevice {
                calibration: None,
                ..remote
            }),
            model: device_model(&table)?,
            weight_n: weight_kg.map(|kg| GRAVITY * kg),
            // A weight has none.
            step_n: match weight_kg.is_some() && !table.has(&CALIBRATE_STEP) {
                true => 0.0,
                false => GRAVITY * table.number(&CALIBRATE_STEP)?,
            },
            readings,
        })
    }

    /// True if there is a device file to keep the calibration in.
    #[must_use]
    pub const fn has_device_file(&self) -> bool {
        self.model.is_some()
    }

    /// Sets the time to wait for a device at a port.
    #[must_use]
    pub fn with_patience(mut self, patience: Duration) -> Self {
        if let Some(remote) = &mut self.remote {
            remote.patience = patience;
        }
        self
    }

    /// Checks the newtons of the device; `answer` is asked what a person sees. The device is armed only while it moves or is read.
    ///
    /// # Errors
    /// A device that cannot be used, that goes against its force, or that does not follow it; readings that say nothing.
    pub fn run(
        &self,
        answer: Answer<'_>,
        stop: &AtomicBool,
        warn: Warn<'_>,
    ) -> Result<CalibrationReport, Failure> {
        let found = match &self.remote {
            Some(remote) => self.found(remote, answer, stop, warn)?,
            None => Found {
                points: self.readings.clone(),
                ..Found::default()
            },
        };
        self.report(found, warn)
    }

    /// The lines through what was found.
    fn report(&self, found: Found, warn: Warn<'_>) -> Result<CalibrationReport, Failure> {
        let known = (self.model.as_ref()).map_or(DeviceValues::default(), |model| model.values);
        let motor = line(&found.points, self.step_n, known.friction_n, WRONG_SIGN)?;
        // The sensor shows the force on the device, which is against that on the instrument.
        let sensed = found.points.iter().chain([&found.idle]);
        let sensed = sensed.map(|point| Point::rising(0.0 - point.sensed_n, point.force_n));
        let sensed: Vec<Point> = sensed
            .filter(|point| point.commanded_n.is_finite())
            .collect();
        let sensor = (!sensed.is_empty()).then(|| line(&sensed, self.step_n, 0.0, SENSOR_SIGN));
        let sensor = sensor.transpose()?;
        let date = StartTime::at(SystemTime::now()).rfc3339();
        let calibration = Calibration {
            device: found.device,
            date: date.split('T').next().unwrap_or_default().to_owned(),
            motor_factor: Some(motor.slope),
            sensor_factor: sensor.map(|sensor| sensor.slope),
            sensor_offset_n: sensor.map(|sensor| sensor.zero),
            sensor_lag_s: found.lag_s,
        };
        calibration.factors()?;
        if let Some(model) = self
            .model
            .as_ref()
            .filter(|model| model.calibration.is_none())
        {
            let mass = model.clone().calibrated(calibration.clone()).values.mass_kg;
            warn(&format!(
                "mass, damping and friction of the device file were in newtons of the device: a mass of {} there is {}",
                written("mass_kg", model.values.mass_kg),
                written("mass_kg", mass)
            ));
        }
        Ok(CalibrationReport {
            device: self.remote.as_ref().map(|remote| remote.name.to_string()),
            board: found.board,
            calibration_text: Calibration::in_words(Some(&calibration)),
            friction_n: motor.friction_n,
            readings: found.points,
            sensor_lag_reason: (sensor.is_some() && found.lag_s.is_none()).then_some(
                "the handle hardly moves on the instrument: a softer one, or more force, shows it",
            ),
            model_before: self.model.clone(),
            calibration,
            model: None,
        })
    }

    /// Findings of a device and a person.
    fn found(
        &self,
        remote: &RemoteDevice,
        answer: Answer<'_>,
        stop: &AtomicBool,
        warn: Warn<'_>,
    ) -> Result<Found, Failure> {
        let mut answers = Answers(answer, stop);
        let (mut link, set, plan) = opened(&self.plan, remote, warn, stop)?;
        let plan = &plan;
        let mut found = Found {
            board: Some(board_words(&link)),
            device: remote.name.identity(&link).to_string(),
            ..Found::default()
        };
        answers.prepare("let the handle stand free and level, with room on both sides, and take your hands off: it will move a little")?;
        let sign = armed(plan, remote, &mut link, &set, warn, stop, |axis| {
            held(plan, axis, stop, |handle| handle.goes_with_its_force())
        });
        found.idle = sign.map_err(|failure| at_link(&link, failure))?;
        let Some(weight_n) = self.weight_n else {
            answers.prepare("put a kitchen scale or a spring balance where the handle presses on it, or pulls it, in its positive direction: just touching, and set to zero")?;
            let read = armed(plan, remote, &mut link, &set, warn, stop, |axis| {
                held(plan, axis, stop, |handle| {
                    handle.reads(&mut answers, self.step_n)
                })
            });
            (found.points, found.lag_s) = read.map_err(|failure| at_link(&link, failure))?;
            return Ok(found);
        };
        let mass = written("mass_kg", weight_n / GRAVITY);
        let hang = format!(
            "hang {mass} on the handle, so that it pulls against its positive direction, and let it rest on its stop, above something soft"
        );
        for (words, hung_n) in [
            ("leave the handle free, without a weight", 0.0),
            (hang.as_str(), weight_n),
        ] {
            answers.prepare(words)?;
            let lifted = armed(plan, remote, &mut link, &set, warn, stop, |axis| {
                held(plan, axis, stop, |handle| handle.lifts(hung_n))
            });
            (found.points).extend(lifted.map_err(|failure| at_link(&link, failure))?);
        }
        Ok(found)
    }
}

/// Findings of a calibration.
#[derive(Debug, Default)]
struct Found {
    board: Option<String>,
    device: String,
    points: Vec<Point>,
    /// The free handle.
    idle: Point,
    /// Time by which the sensor follows, s.
    lag_s: Option<Estimate>,
}

/// The result. The keys are a contract of the command line.
#[derive(Clone, Debug, Serialize)]
pub struct CalibrationReport {
    device: Option<String>,
    board: Option<String>,
    #[serde(rename = "calibration")]
    calibration_text: String,
    #[serde(flatten)]
    calibration: Calibration,
    /// Half of what lies between the ways up and down, N: friction, of a weight that is lifted an upper bound.
    friction_n: f64,
    sensor_lag_reason: Option<&'static str>,
    readings: Vec<Point>,
    #[serde(skip)]
    model_before: Option<DeviceModel>,
    /// The device file, once it is written.
    pub model: Option<String>,
}

impl CalibrationReport {
    /// The text of the device file with this calibration; `None` without a device file to put it into.
    #[must_use]
    pub fn device_file(&self, program: &str) -> Option<String> {
        let model = self
            .model_before
            .clone()?
            .calibrated(self.calibration.clone());
        let factor = digits(self.calibration.motor().value, 4);
        Some(model.to_toml(
            program,
            &format!(
                "calibrated on {}, motor factor {factor}",
                self.calibration.date
            ),
        ))
    }
}
