//! A controller that holds the indenter of the rig: the indenter is a mass, the tissue pushes it back, the controller keeps it on its way.
//!
//! ```text
//! relaxation   r the ramp, y the place of the indenter, m        u the force on the indenter, N
//! creep        r the push, y the force between the actuators, N  |u| ≤ the limit of the drive
//! ```
//! The tissue is judged as ever: by the sum over the motion that was really made.

mod holder;
mod judge;
pub(crate) mod keys;
mod port;
mod preflight;
mod rig;

use crate::document::controller_file::ControllerFile;
use crate::document::error::FileError;
use crate::document::failure::Failure;
use crate::document::parameters::{CONTROLLER, SAMPLE_TIME};
use crate::experiment::drive::keys::DRIVE_FORCE_LIMIT;
use fracdiff::parameter::Shown;
use fractional_control::{ControlError, ControllerSetup};
use haptic_loop::plant::RigDrive;
pub(crate) use holder::ControllerHolder;
pub use judge::{DriveCurves, DriveReport};
pub(crate) use judge::{DriveJudge, drive_columns};
pub(crate) use preflight::TissueLaw;
pub use preflight::{DriveVerdict, LoopVerdict};
pub(crate) use rig::SimulatedRig;
use std::collections::BTreeMap;
use std::path::Path;

/// A controller for the indenter, and the largest force of its motor.
///
/// ```
/// use haptic_experiment::{Drive, ModelledTissue, Relaxation, Rendering};
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
/// let relaxation = Relaxation { duration_s: 2.0, ..Relaxation::of(rendering) };
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
    ///
    /// # Errors
    /// A force limit that is not above 0, a controller that cannot be made or is made for another sample time.
    pub(crate) fn holder(&self, sample_time_s: f64) -> Result<ControllerHolder, Failure> {
        let limited = self.limited(sample_time_s)?;
        ControllerHolder::new(&limited).map_err(|error| self.refused(&error))
    }

    fn refused(&self, error: &ControlError) -> Failure {
        Failure::bad_input(format_args!("drive {}: {error}", self.name))
    }

    /// Adds the drive to the metadata of a log.
    pub(crate) fn describe(&self, metadata: &mut BTreeMap<String, String>) {
        for (key, value) in [
            ("controller", self.name.clone()),
            ("law", self.controller.setup.law.to_string()),
            ("file", self.controller.to_toml()),
            ("force_limit_n", self.force_limit_n.to_string()),
        ] {
            metadata.insert(format!("drive.{key}"), value);
        }
    }
}

/// The set point of a tick: m, or N in a creep test.
pub(crate) fn set_point(drive: RigDrive, time_s: f64) -> f64 {
    match drive {
        RigDrive::Position(profile) => profile.position(time_s),
        RigDrive::Force(push) => push.0,
    }
}
