//! A calibration from its document to its report.

use super::{
    CALIBRATE_STEP, CALIBRATE_WEIGHT, CALIBRATION, GRAVITY, Person, TABLES, Task, asked,
    conduct::{Bench, Found, done},
    line::{Point, line},
};
use crate::{
    experiment::reading::remote_by,
    question::measurement::serial::{armed, opened},
};
use haptic_document::{
    Document, Failure, FileError, Warn,
    parameters::{DEVICE, DEVICE_MODEL, Parameter},
};
use haptic_log::record::StartTime;
use haptic_measurement::{MEASURE_DEVICE, MeasurePlan, drive::INTERRUPTED};
use haptic_quantity::written;
use haptic_run::{device::at_link, remote::RemoteDevice};
use haptic_trial::{
    DeviceModel,
    device_table::device_model,
    plant_file::calibration::{
        Calibration, MOTOR_FACTOR, MeasuredNumber, SENSOR_FACTOR, SENSOR_LAG, SENSOR_OFFSET,
    },
};
use serde::Serialize;
use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, SystemTime},
};

#[cfg(test)]
mod tests;

const FALLS: &str = "the readings fall while the force grows: put the instrument where the handle presses on it, or pulls it, in its positive direction";
const SENSOR_SIGN: &str = "the force sensor shows the opposite of the force: swap its two signal wires, or the sign where the firmware converts it; then calibrate again";

/// A check of a device's newtons, all of its parameters read.
#[derive(Clone, Debug)]
pub struct Calibrator {
    plan: MeasurePlan,
    remote: RemoteDevice,
    model: DeviceModel,
    weight_n: Option<f64>,
    step_n: f64,
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
        let Some(remote) = remote_by(&table, &MEASURE_DEVICE)? else {
            let reason = format!(
                "the simulated device has no newtons to check: give {}",
                DEVICE.set_to("serial:PATH")
            );
            return Err(table.fail_at(MEASURE_DEVICE.key, reason));
        };
        let model = device_model(&table)?.ok_or_else(|| {
            let file = DEVICE_MODEL.set_to("device.toml");
            table.fail(format_args!(
                "a calibration is kept in a device file: give {file} too, as `device measure` writes it"
            ))
        })?;
        let weight_kg = table.number_if(&CALIBRATE_WEIGHT)?;
        Ok(Self {
            plan: MeasurePlan::read(&table)?,
            remote,
            model,
            weight_n: weight_kg.map(|kg| GRAVITY * kg),
            // A weight has no step.
            step_n: match weight_kg {
                Some(_) => 0.0,
                None => GRAVITY * table.number(&CALIBRATE_STEP)?,
            },
        })
    }

    /// Sets the time to wait for a device at a port.
    #[must_use]
    pub fn with_patience(mut self, patience: Duration) -> Self {
        self.remote.patience = patience;
        self
    }

    /// Checks the newtons of the device; `person` is asked what a person sees. The device is armed only while it moves or is read.
    ///
    /// # Errors
    /// A device that cannot be used, that goes against its force, or that does not follow it; readings that say nothing.
    pub fn run(
        &self,
        person: &Person,
        stop: &Arc<AtomicBool>,
        warn: Warn<'_>,
    ) -> Result<CalibrationReport, Failure> {
        let remote = &self.remote;
        let (mut link, set, plan) = opened(&self.plan, remote, warn, stop)?;
        let bench = Bench {
            plan,
            person,
            step_n: self.step_n,
            stop,
        };
        let mut found = Found::default();
        for (words, task) in self.tasks() {
            asked(person, words, None, || {
                std::thread::sleep(Duration::from_millis(20));
                if stop.load(Ordering::Relaxed) {
                    Err(Failure::run(INTERRUPTED))
                } else {
                    Ok(())
                }
            })?;
            let ended = armed(&plan, remote, &mut link, &set, warn, stop, |axis| {
                done(&bench, axis, task, &mut found)
            });
            ended.map_err(|failure| at_link(&link, failure))?;
        }
        self.report(remote.name.identity(&link).to_string(), found, warn)
    }

    /// Tasks in their order, each with words for a person who prepares it.
    fn tasks(&self) -> [(String, Task); 2] {
        let free = "let the handle stand free and level, with room on both sides, and take your hands off: it will move a little";
        let second = match self.weight_n {
            Some(weight_n) => format!(
                "hang {} on the handle, so that it pulls against its positive direction, and let it rest on its stop, above something soft",
                written("mass_kg", weight_n / GRAVITY)
            ),
            None => "put a kitchen scale or a spring balance where the handle presses on it, or pulls it, in its positive direction: just touching, and set to zero".to_owned(),
        };
        [(free.to_owned(), Some(0.0)), (second, self.weight_n)]
    }

    /// The lines through what was found, over what was known.
    fn report(
        &self,
        device: String,
        found: Found,
        warn: Warn<'_>,
    ) -> Result<CalibrationReport, Failure> {
        let [motor, _] = line(&found.points, self.step_n, FALLS)?;
        // The sensor shows the force on the device, which is against that on the instrument, and has no friction.
        let sensed = found.points.iter().chain([&found.idle]).map(|point| Point {
            commanded_n: -point.sensed_n,
            falling: false,
            ..*point
        });
        let sensed: Vec<Point> = sensed.collect();
        let before = self.model.calibration.clone().unwrap_or_default();
        let was = |factor: &Parameter| MeasuredNumber::about(before.factor(factor).value, 0.0);
        let date = StartTime::at(SystemTime::now()).rfc3339();
        let mut calibration = Calibration {
            date: date.split('T').next().unwrap_or_default().to_owned(),
            device,
            ..Calibration::default()
        };
        let known = &mut calibration.found;
        known.insert(MOTOR_FACTOR.key, motor.times(was(&MOTOR_FACTOR)));
        if found.idle.sensed_n.is_finite() {
            let [slope, offset_n] = line(&sensed, self.step_n, SENSOR_SIGN)?;
            let was = was(&SENSOR_FACTOR);
            known.insert(SENSOR_FACTOR.key, slope.times(was));
            // In newtons of the sensor.
            let own = MeasuredNumber::about(1.0 / (slope.value * was.value), 0.0);
            known.insert(SENSOR_OFFSET.key, offset_n.times(own));
            // No sensor leads its force: an instrument that damps or slips does.
            let lag_s = found.lag_s.filter(|lag_s| lag_s.high >= 0.0);
            known.extend(lag_s.map(|lag_s| (SENSOR_LAG.key, lag_s)));
            if lag_s.is_none() && self.weight_n.is_none() {
                warn(match found.lag_s {
                    None => {
                        "no lag of the force sensor: the handle hardly moved, which a softer instrument, or more force, shows"
                    }
                    Some(_) => {
                        "no lag of the force sensor: the instrument damps the handle more than it springs, as a hand does; a scale or a spring shows it"
                    }
                });
            }
        }
        calibration.factors()?;
        let calibrated = self.model.clone().calibrated(motor, calibration.clone());
        Ok(CalibrationReport {
            device: self.remote.name.to_string(),
            calibration_text: Calibration::in_words(Some(&calibration)),
            readings: found.points,
            calibration,
            calibrated,
            model: None,
        })
    }
}

/// The result. The keys are a contract of the command line.
#[derive(Clone, Debug, Serialize)]
pub struct CalibrationReport {
    device: String,
    #[serde(rename = "calibration")]
    calibration_text: String,
    #[serde(flatten)]
    calibration: Calibration,
    readings: Vec<Point>,
    #[serde(skip)]
    calibrated: DeviceModel,
    /// The device file, once it is written.
    pub model: Option<String>,
}

impl CalibrationReport {
    /// The text of the device file with this calibration.
    #[must_use]
    pub fn device_file(&self, program: &str) -> String {
        self.calibrated.to_toml(program, &self.calibration_text)
    }
}
