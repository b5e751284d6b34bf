//! A measurement from its document to its report.

use crate::{
    experiment::reading::remote_by,
    question::measurement::serial::{Moved, on_serial},
};
use haptic_document::{
    Document, Failure, FileError, Warn,
    parameters::{DEVICE, DEVICE_MODEL, SIMULATED},
};
use haptic_log::record::StartTime;
use haptic_loop::plant::MassDamperConfig;
use haptic_measurement::{
    MEASURE_DEVICE, MEASUREMENT, MeasurePlan, TABLES,
    drive::on_simulated,
    estimate::{Measured, device_model, estimate},
    response::{ResponseLine, coherent, response, table},
    robot::{MeasuredRobot, estimate_robot},
};
use haptic_quantity::{digits, written};
use haptic_run::remote::RemoteDevice;
use haptic_trial::{
    DeviceModel, Sensors,
    device_table::{device, with_devices, without},
    plant_file::calibration::{Calibration, MOTOR_FACTOR},
};
use serde::Serialize;
use std::{
    sync::{Arc, atomic::AtomicBool},
    time::{Duration, SystemTime},
};

/// A measurement of a device, all of its parameters checked.
#[derive(Clone, Debug)]
pub struct Measurement {
    plan: MeasurePlan,
    /// The device at a port; `None` for the simulated one.
    remote: Option<RemoteDevice>,
    device: MassDamperConfig,
    sensors: Sensors,
}

impl Measurement {
    /// Reads and checks a document.
    ///
    /// # Errors
    /// If it is wrong: in one line, with its place.
    pub fn open(document: &Document) -> Result<Self, FileError> {
        let document = document.parse()?;
        let (_, table, _) =
            document.one_of(&[MEASUREMENT], &[], "measurement", "give [measure]")?;
        let table = with_devices(table.with_keys(&TABLES)?)?;
        let remote = remote_by(&table, &MEASURE_DEVICE)?;
        if remote.is_some() {
            let why = format!(
                "on a real device, which is measured: give {}",
                DEVICE.set_to("sim")
            );
            // Of a device file its calibration counts.
            let others = SIMULATED.iter().filter(|key| **key != DEVICE_MODEL);
            without(&table, others, &why)?;
        }
        let plan = MeasurePlan::read(&table)?;
        let (device, sensors) = device(&table, plan.sample_time_s)?;
        Ok(Self {
            plan,
            remote,
            device,
            sensors,
        })
    }

    /// Sets the time to wait for a device at a port.
    #[must_use]
    pub fn with_patience(mut self, patience: Duration) -> Self {
        if let Some(remote) = &mut self.remote {
            remote.patience = patience;
        }
        self
    }

    /// Number of steps in the reported progress.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.plan.ticks_at_most()
    }

    /// Moves the device and identifies its model.
    ///
    /// # Errors
    /// A device that cannot be used; a motion that was cut short, or that does not
    /// determine the model.
    pub fn run(
        &self,
        progress: &dyn Fn(u64),
        stop: &Arc<AtomicBool>,
        warn: Warn<'_>,
    ) -> Result<MeasureReport, Failure> {
        let plan = &self.plan;
        let (record, device, board, plan, is_robot) = match &self.remote {
            Some(remote) => {
                let Moved {
                    record,
                    is_robot,
                    board,
                    plan,
                } = on_serial(plan, remote, warn, progress, stop)?;
                let name = remote.name.to_string();
                (record, name, Some(board), plan, is_robot)
            }
            None => {
                let record = on_simulated(plan, self.device, self.sensors, progress, stop)?;
                (record, "sim".to_owned(), None, *plan, false)
            }
        };
        let mut found = if is_robot {
            Found::Robot(estimate_robot(&record)?)
        } else {
            let found = estimate(&record, plan.hand).map_err(|error| {
                plan.held_back(&record)
                    .unwrap_or_else(|| Failure::input(error))
            })?;
            Found::Device(Box::new(found))
        };
        let calibration = self
            .remote
            .as_ref()
            .and_then(|remote| remote.calibration.clone());
        if let (Some(calibration), Found::Device(found)) = (&calibration, &mut found) {
            found.by_newtons_of(calibration.factor(&MOTOR_FACTOR));
        }
        let date = StartTime::at(SystemTime::now()).rfc3339();
        let at = board.as_ref();
        let conditions = format!(
            "{device}{}, {}, {} of {} at {}, up to {} in a box of {}, hand {}, model off by {} rms",
            at.map_or(String::new(), |board| format!(", {board}")),
            date.split('T').next().unwrap_or_default(),
            written("duration_s", plan.duration_s),
            if is_robot { "steps" } else { "multi-sine" },
            written("sample_time_s", plan.sample_time_s),
            if is_robot {
                written("speed_m_per_s", plan.speed_m_per_s)
            } else {
                format!("{} N", digits(record.largest_force_n(), 4))
            },
            written("box_m", plan.box_m),
            if plan.hand { "on" } else { "off" },
            written("residual_m", found.residual_rms_m())
        );
        let (reach_low_m, reach_high_m) = record.reach_m();
        let lines = if is_robot {
            Vec::new()
        } else {
            response(&record, &plan)
        };
        Ok(MeasureReport {
            device,
            // A robot is measured in metres and seconds.
            calibration_text: (self.remote.as_ref().filter(|_| !is_robot))
                .map(RemoteDevice::calibration_in_words),
            calibration,
            board,
            encoder_resolution_reason: (found.has_no_steps()).then_some("no steps seen"),
            found,
            largest_force_n: (!is_robot).then(|| record.largest_force_n()),
            reach_low_m,
            reach_high_m,
            coherent_lines: (!is_robot).then(|| coherent(&lines).count()),
            lines,
            model: None,
            frequency_response: None,
            figure: None,
            conditions,
        })
    }
}

/// Numbers of a device that takes a force, or of a robot.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
enum Found {
    Device(Box<Measured>),
    Robot(MeasuredRobot),
}

impl Found {
    const fn residual_rms_m(&self) -> f64 {
        match self {
            Self::Device(found) => found.residual_rms_m,
            Self::Robot(found) => found.residual_rms_m,
        }
    }

    fn has_no_steps(&self) -> bool {
        matches!(self, Self::Device(found) if found.encoder_resolution_m == 0.0)
    }
}

/// The result. The keys are a contract of the command line.
#[derive(Clone, Debug, Serialize)]
pub struct MeasureReport {
    device: String,
    /// Its newtons were checked on this day, or never; none of the simulated one.
    #[serde(rename = "calibration")]
    calibration_text: Option<String>,
    #[serde(skip)]
    calibration: Option<Calibration>,
    /// Name of the board, and its firmware.
    board: Option<String>,
    #[serde(flatten)]
    found: Found,
    encoder_resolution_reason: Option<&'static str>,
    largest_force_n: Option<f64>,
    reach_low_m: f64,
    reach_high_m: f64,
    /// Coherent lines of the frequency response, of 20; 0 if the record is too short, none of a robot.
    coherent_lines: Option<usize>,
    #[serde(skip)]
    lines: Vec<ResponseLine>,
    /// The device file, once it is written.
    pub model: Option<String>,
    /// The table of the frequency response, once it is written.
    pub frequency_response: Option<String>,
    /// The file of the picture, if one was written.
    pub figure: Option<String>,
    /// Device, day and excitation, in words.
    #[serde(skip)]
    pub conditions: String,
}

impl MeasureReport {
    /// Facts that a user should know, a sentence each.
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        match &self.found {
            Found::Device(found) => &found.warnings,
            Found::Robot(found) => &found.warnings,
        }
    }

    /// Time since the start, s, position read and position of the model, m, of each fitted tick.
    #[must_use]
    pub fn curve(&self) -> &[[f64; 3]] {
        match &self.found {
            Found::Device(found) => &found.curve,
            Found::Robot(found) => &found.curve,
        }
    }

    /// True of a robot that takes a velocity.
    #[must_use]
    pub const fn is_robot(&self) -> bool {
        matches!(self.found, Found::Robot(_))
    }

    /// The frequency response as a table that a plant file takes; `None` if the record is too short for one, or too few lines are coherent.
    #[must_use]
    pub fn response_table(&self) -> Option<String> {
        table(&self.lines)
    }

    /// ω, rad/s, |G|, m/N, and coherence of each line of the frequency response.
    pub fn response(&self) -> impl Iterator<Item = [f64; 3]> {
        let line = |line: &ResponseLine| [line.omega_rad_s, line.gain, line.coherence];
        self.lines.iter().map(line)
    }

    /// The text of the device file, made by this program.
    #[must_use]
    pub fn device_file(&self, program: &str) -> String {
        match &self.found {
            Found::Robot(found) => found.device_file(program, &self.conditions),
            Found::Device(found) => {
                let model = DeviceModel {
                    calibration: self.calibration.clone(),
                    ..device_model(found)
                };
                model.to_toml(program, &self.conditions)
            }
        }
    }
}
