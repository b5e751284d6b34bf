//! A controller that holds the indenter of the rig: the indenter is a mass, the tissue pushes it back, the controller keeps it on its way.
//!
//! ```text
//! relaxation   r the ramp, y the place of the indenter, m        u the force on the indenter, N
//! creep        r the push, y the force between the actuators, N  |u| ≤ the limit of the drive
//! ```
//! The tissue is judged as ever: by the sum over the motion that was really made.

mod preflight;

use crate::document::controller_file::ControllerFile;
use crate::document::error::FileError;
use crate::document::failure::Failure;
use crate::document::parameters::kind::{Parameter, parameters};
use crate::document::parameters::range::FORCE_LIMITS;
use crate::document::parameters::{CONTROLLER, SAMPLE_TIME};
use crate::document::reader::Table;
use crate::judge::decimated::Decimated;
use crate::run::record::Record;
use crate::run::simulate::Instrumented;
use crate::run::tick::KeptSample;
use fracdiff::Real;
use fracdiff::parameter::Shown;
use fractional_control::{ControlError, Controller, ControllerSetup, UseController};
use haptic_log::record::TickMessage;
use haptic_loop::plant::{HeldRig, Holder, IndentationRig, RigDrive};
use haptic_loop::{Device, Reading, SafeForce};
pub(crate) use preflight::TissueLaw;
pub use preflight::{DriveVerdict, LoopVerdict};
use serde::Serialize;
use std::convert::Infallible;
use std::fmt::Debug;
use std::path::Path;

parameters! {
    crate;
    /// Force limit of the drive, N.
    DRIVE_FORCE_LIMIT = number("drive_force_limit_n", 10.0, "10N", FORCE_LIMITS, "Largest force of the drive on the indenter");
}

/// Of `[drive]`, beside `[relax]` or `[creep]`.
pub const DRIVE: &[Parameter] = &[CONTROLLER, DRIVE_FORCE_LIMIT];

/// `[drive]`.
pub(crate) fn drive(table: &Table<'_>) -> Result<Drive, FileError> {
    table.required_text(&CONTROLLER)?;
    let path = table.file(&CONTROLLER)?.unwrap_or_default();
    Ok(Drive {
        force_limit_n: table.number(&DRIVE_FORCE_LIMIT)?,
        ..Drive::read(&path)?
    })
}

/// A controller for the indenter, and the largest force of its motor.
///
/// ```
/// use haptic_experiment::{Drive, Indentation, ModelledTissue, Rendering};
/// use std::ops::ControlFlow;
/// use std::path::Path;
///
/// let text = "
///     [pid]
///     proportional_gain = 900
///     integral_gain_per_s_lambda = 9000
///     integral_order = 0.9
///     derivative_gain_s_mu = 25
///     derivative_order = 0.9
///     [loop]
///     sample_time_s = 0.001";
/// let drive = Drive::parse(Path::new("my-own.toml"), text)?;
/// let tissue = haptic_tissue::Library::load(None)?.find("prostate-cancerous")?;
/// let rendering = Rendering { drive: Some(drive), ..Rendering::new(ModelledTissue::new(tissue)?)? };
/// let relaxation = Indentation { duration_s: 2.0, ..Indentation::relaxation(rendering) };
/// let mut place_m = 0.0;
/// relaxation.simulate(&mut |sample| {
///     place_m = sample.indenter_position_m;
///     ControlFlow::Continue(())
/// })?;
/// assert!((place_m - 1e-3).abs() < 1e-5); // 5 % of 20 mm
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    /// Its name in logs and reports: the path of its file.
    pub name: String,
    /// The controller: from m, or N in a creep test, to N.
    pub controller: ControllerFile,
    /// Largest force on the indenter, N, above 0. The limits of the controller hold beside it.
    pub force_limit_n: f64,
}

impl Drive {
    /// Reads a controller file.
    ///
    /// # Errors
    /// If it cannot be read or is wrong: in one line, with file and line.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        ControllerFile::read(path).map(|controller| Self::of(path, controller))
    }

    /// Reads the text of a controller file; `path` is its name.
    ///
    /// # Errors
    /// If it is wrong: in one line, with file and line.
    pub fn parse(path: &Path, text: &str) -> Result<Self, FileError> {
        ControllerFile::parse(path, text).map(|controller| Self::of(path, controller))
    }

    fn of(path: &Path, controller: ControllerFile) -> Self {
        Self {
            name: path.display().to_string(),
            controller,
            force_limit_n: DRIVE_FORCE_LIMIT.default_number(),
        }
    }

    /// The controller within the limits of its motor, if it is made for this sample time.
    fn limited(&self, sample_time_s: f64) -> Result<ControllerSetup, Failure> {
        let limit = self.force_limit_n;
        if !DRIVE_FORCE_LIMIT.range().contains(limit) {
            return Err(Failure::bad_input(format_args!(
                "drive force limit {} N is not {} N: change {DRIVE_FORCE_LIMIT}",
                Shown(limit),
                DRIVE_FORCE_LIMIT.range()
            )));
        }
        let own = self.controller.setup.sample_time_s;
        if (own / sample_time_s - 1.0).abs() > 1e-9 {
            return Err(Failure::bad_input(format_args!(
                "drive {}: the controller is made for a sample time of {own} s, the experiment has {sample_time_s} s: \
                 change {SAMPLE_TIME}, or take a {CONTROLLER} made for it",
                self.name
            )));
        }
        let within = |own: Option<f64>, end: f64| own.map_or(end, |own| own.clamp(-limit, limit));
        let limited = ControllerSetup {
            output_low: Some(within(self.controller.setup.output_low, -limit)),
            output_high: Some(within(self.controller.setup.output_high, limit)),
            ..self.controller.setup.clone()
        };
        Ok(limited)
    }

    /// The controller at rest, at this sample time.
    pub(crate) fn holder(&self, sample_time_s: f64) -> Result<ControllerHolder, Failure> {
        let limited = self.limited(sample_time_s)?;
        ControllerHolder::new(&limited).map_err(|error| self.refused(&error))
    }

    fn refused(&self, error: &ControlError) -> Failure {
        Failure::bad_input(format_args!("drive {}: {error}", self.name))
    }
}

/// The set point of a tick: m, or N in a creep test.
pub(crate) fn set_point(drive: RigDrive, time_s: f64) -> f64 {
    match drive {
        RigDrive::Position(profile) => profile.position(time_s),
        RigDrive::Force(push) => push.0,
    }
}

/// A controller with its history.
#[derive(Debug)]
pub(crate) struct ControllerHolder {
    running: Box<dyn Running>,
    /// The last command was at a limit.
    pub(crate) limited: bool,
}

/// A controller of any type.
trait Running: Debug {
    /// The command; `true` if it had to be limited.
    fn step(&mut self, r: f64, y: f64) -> (f64, bool);

    fn reset(&mut self);
}

#[derive(Debug)]
struct Own<C: Controller<f64>> {
    controller: C,
    history: C::History,
}

impl<C: Controller<f64> + Debug> Running for Own<C> {
    fn step(&mut self, r: f64, y: f64) -> (f64, bool) {
        let wanted = self.controller.wanted(&self.history, r, y);
        let command = self.controller.output(&self.history, r, y);
        self.controller.advance(&mut self.history, r, y, command);
        (command, wanted.to_bits() != command.to_bits())
    }

    fn reset(&mut self) {
        self.history = self.controller.at_rest();
    }
}

/// Keeps the controller that a setup makes.
#[derive(Default)]
struct Maker(Option<Box<dyn Running>>);

impl UseController for Maker {
    fn have<C: Controller<f64> + Clone + Debug + 'static>(&mut self, controller: &C) {
        self.0 = Some(Box::new(Own {
            controller: controller.clone(),
            history: controller.at_rest(),
        }));
    }
}

impl ControllerHolder {
    /// The controller at rest.
    fn new(setup: &ControllerSetup) -> Result<Self, ControlError> {
        let mut maker = Maker::default();
        setup.with_controller(&mut maker)?;
        let running = maker.0.ok_or(ControlError::Empty { what: "controller" })?;
        Ok(Self {
            running,
            limited: false,
        })
    }
}

impl Holder for ControllerHolder {
    fn force(&mut self, set_point: f64, measured: f64) -> f64 {
        let (command, limited) = self.running.step(set_point, measured);
        self.limited = limited;
        command
    }

    fn restart(&mut self) {
        self.running.reset();
        self.limited = false;
    }
}

/// The rig of a relaxation or creep test.
#[derive(Debug)]
pub(crate) enum SimulatedRig {
    /// Servo or constant push.
    Plain(Box<IndentationRig>),
    /// A controller.
    Held(Box<HeldRig<ControllerHolder>>),
}

impl<F: Real> Device<F, 1> for SimulatedRig {
    type Error = Infallible;

    fn read(&mut self) -> Result<Reading<F, 1>, Infallible> {
        match self {
            Self::Plain(rig) => rig.read(),
            Self::Held(rig) => rig.read(),
        }
    }

    fn write(&mut self, force: SafeForce<F, 1>) -> Result<(), Infallible> {
        match self {
            Self::Plain(rig) => rig.write(force),
            Self::Held(rig) => rig.write(force),
        }
    }
}

impl Instrumented for SimulatedRig {
    type Message = TickMessage;

    fn observe(&self) -> TickMessage {
        match self {
            Self::Plain(rig) => rig.observe(),
            Self::Held(held) => {
                let observed = held.rig().observe();
                TickMessage {
                    reference_m: held.reference().map_or(observed.reference_m, Into::into),
                    ..observed
                }
            }
        }
    }
}

/// The work of a drive.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DriveReport {
    /// The controller.
    pub controller: String,
    /// `position` in a relaxation, `force` in a creep test: what the controller holds, and the unit of the errors, m or N.
    pub quantity: &'static str,
    /// Largest |set point − measurement|, m or N.
    pub tracking_error_max: f64,
    /// Root of the mean square of it, m or N.
    pub tracking_error_rms: f64,
    /// |set point − measurement| of the last sample, m or N.
    pub tracking_error_final: f64,
    /// Largest force on the indenter, N.
    pub drive_force_peak_n: f64,
    /// Its limit, N.
    pub drive_force_limit_n: f64,
    /// Samples in which the limit acted.
    pub saturated_samples: u64,
    /// The verdict before the run.
    pub preflight: DriveVerdict,
}

impl DriveReport {
    /// The drive was at its limit, or runs though the analysis calls it unstable.
    pub(crate) fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        if self.saturated_samples > 0 {
            warnings.push(format!(
                "the drive was at its limit of {} N in {} samples: raise {DRIVE_FORCE_LIMIT}, or take a slower ramp or \
                 another {CONTROLLER}",
                self.drive_force_limit_n, self.saturated_samples
            ));
        }
        if !self.preflight.stable() {
            warnings.push(
                "pre-flight: the loop of the drive is unstable by the analysis; run all the same"
                    .to_owned(),
            );
        }
        warnings
    }
}

/// Tracking error and force of a drive. The slices belong together point by point.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveCurves {
    /// Unit of the error: m, or N in a creep test.
    pub unit: &'static str,
    /// Time, s.
    pub time_s: Vec<f64>,
    /// Set point − measurement.
    pub tracking_error: Vec<f64>,
    /// Force on the indenter, N.
    pub force_n: Vec<f64>,
}

/// Columns that a drive adds to the table of a run.
pub(crate) fn drive_columns(drive: RigDrive) -> [&'static str; 2] {
    match drive {
        RigDrive::Position(_) => ["indenter_position_m", "drive_force_n"],
        RigDrive::Force(_) => ["contact_force_n", "drive_force_n"],
    }
}

/// Judges sample by sample.
pub(crate) struct DriveJudge {
    drive: RigDrive,
    holder: ControllerHolder,
    report: DriveReport,
    samples: u64,
    squares: f64,
    curves: Decimated<2>,
}

impl DriveJudge {
    /// Of no sample yet.
    pub(crate) fn new(
        own: &Drive,
        drive: RigDrive,
        sample_time_s: f64,
        preflight: DriveVerdict,
        record: &Record,
    ) -> Result<Self, Failure> {
        Ok(Self {
            drive,
            holder: own.holder(sample_time_s)?,
            report: DriveReport {
                controller: own.name.clone(),
                quantity: match drive {
                    RigDrive::Position(_) => "position",
                    RigDrive::Force(_) => "force",
                },
                tracking_error_max: 0.0,
                tracking_error_rms: 0.0,
                tracking_error_final: 0.0,
                drive_force_peak_n: 0.0,
                drive_force_limit_n: own.force_limit_n,
                saturated_samples: 0,
                preflight,
            },
            samples: 0,
            squares: 0.0,
            curves: Decimated::of(record),
        })
    }

    /// Takes a sample in; the values of its columns.
    pub(crate) fn add(&mut self, sample: &KeptSample) -> [f64; 2] {
        let set_point = set_point(self.drive, sample.time_s);
        let measured = match self.drive {
            RigDrive::Position(_) => sample.indenter_position_m,
            RigDrive::Force(_) => sample.contact_force_n,
        };
        let force = self.holder.force(set_point, measured);
        let error = set_point - measured;
        let report = &mut self.report;
        report.tracking_error_max = report.tracking_error_max.max(error.abs());
        report.tracking_error_final = error.abs();
        report.drive_force_peak_n = report.drive_force_peak_n.max(force.abs());
        report.saturated_samples += u64::from(self.holder.limited);
        self.samples += 1;
        self.squares += error * error;
        self.curves.add(sample.time_s, [error, force]);
        [measured, force]
    }

    /// The report and the curves.
    pub(crate) fn finish(mut self) -> (DriveReport, DriveCurves) {
        self.curves.finish();
        if self.samples > 0 {
            self.report.tracking_error_rms = (self.squares / self.samples as f64).sqrt();
        }
        let [tracking_error, force_n] = self.curves.curves;
        let curves = DriveCurves {
            unit: match self.drive {
                RigDrive::Position(_) => "m",
                RigDrive::Force(_) => "N",
            },
            time_s: self.curves.time_s,
            tracking_error,
            force_n,
        };
        (self.report, curves)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fracdiff::Seconds;
    use fractional_control::PidParameters;
    use haptic_loop::plant::{RampHold, RigConfig, RigContact};
    use haptic_loop::units::{Metres, Newtons};
    use nalgebra::Vector1;

    #[test]
    fn the_commands_that_are_judged_are_those_that_were_given_bit_for_bit() {
        let t = 1e-3;
        let gains: PidParameters = "900+9000/s^0.9+25s^0.9".parse().expect("a controller");
        let own = Drive {
            name: "own".to_owned(),
            controller: ControllerSetup::new(gains, Seconds(t)).into(),
            force_limit_n: 0.2,
        };
        let stable = LoopVerdict {
            stable_beyond_gain: None,
            stable: true,
            phase_margin_rad: None,
            crossover_rad_s: None,
            gain_margin: None,
            delay_margin_s: None,
        };
        let verdict = DriveVerdict {
            free: None,
            in_contact: stable,
            holding_stiffness_n_per_m: None,
        };
        let record = Record::with_room_for(500).expect("room");
        let ramp = RampHold::new(Metres(1e-3), Seconds(0.05)).expect("a ramp");
        for drive in [RigDrive::Position(ramp), RigDrive::Force(Newtons(0.1))] {
            let config = RigConfig::new(drive, RigContact::COMPLIANT, Seconds(t));
            let holder = own.holder(t).expect("a controller");
            let rig = Box::new(HeldRig::new(config, holder).expect("a rig"));
            let mut rig = super::SimulatedRig::Held(rig);
            let mut judge = DriveJudge::new(&own, drive, t, verdict, &record).expect("a judge");
            let mut peak: f64 = 0.0;
            for tick in 0..500 {
                let seen = rig.observe();
                let reading = Device::<f64, 1>::read(&mut rig).expect("never fails");
                let force_n = -300.0 * reading.position_m[0];
                rig.write(testkit::device::safe(Vector1::new(force_n)))
                    .expect("never fails");
                let [_, judged] = judge.add(&KeptSample {
                    tick,
                    time_s: reading.time_s,
                    position_m: reading.position_m[0],
                    force_n,
                    applied_force_n: force_n,
                    indenter_position_m: seen.indenter_position_m[0],
                    contact_force_n: seen.contact_force_n[0],
                    limiters: 0,
                });
                let super::SimulatedRig::Held(held) = &rig else {
                    unreachable!()
                };
                assert_eq!(judged.to_bits(), held.drive_force().to_bits(), "{tick}");
                peak = peak.max(judged.abs());
            }
            let (report, curves) = judge.finish();
            assert_eq!(report.drive_force_peak_n.to_bits(), peak.to_bits());
            assert_eq!(curves.time_s.len(), 500);
            // The ramp is steep, and the gain is large for a force: the limit acts at first.
            assert!(report.saturated_samples > 0 && report.saturated_samples <= 500);
        }
    }
}
