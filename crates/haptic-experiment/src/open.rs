//! Experiment files: TOML with one table, `[relax]`, `[creep]`, `[wall]`, `[coupler]`, `[teleoperation]` or `[touch]`, units in the names
//! of keys; `[drive]` beside the first two.
//!
//! ```toml
//! [wall]
//! mass_kg = 0.065
//! damping_n_s_per_m = 3.5
//! sample_time_s = 0.002
//! order = 0.5
//! stiffness_n_per_m = 3000
//! dissipation_n_s_mu_per_m = 60
//! ```
//! Defaults are those of the commands. Whatever is wrong is refused in one line, `FILE:LINE: reason`;
//! so are keys that are not known. Paths in a file start from the folder of the file.

mod document;
pub mod parameters;
#[cfg(test)]
mod tests;

use crate::document::Document;
use crate::document::error::FileError;
use crate::document::failure::Failure;
use crate::document::parameters::{CONTROLLER, DEVICE, FORCE_UNSTABLE};
use crate::experiment::DRIVE_TABLE as DRIVE;
use crate::experiment::reading::with_devices;
use crate::experiment::{coupler, drive, rendering, teleoperation, touch, wall};
use crate::run::remote::RemoteDevice;
use crate::run::schedule::Pace;
use crate::{
    CouplerExperiment, Indentation, TeleoperationExperiment, TouchExperiment, TrialSetup,
    WallExperiment,
};
use std::path::Path;
use std::time::Duration;

/// The experiment that a file describes, all of its parameters checked.
///
/// ```
/// use haptic_experiment::ExperimentFile;
/// use std::path::Path;
///
/// let text = "[relax]\nstrain = 0.05\nduration_s = 2";
/// let experiment = ExperimentFile::parse(Path::new("lab/relax.toml"), text)?;
/// assert_eq!(experiment.samples()?, 2001);
/// let wrong = ExperimentFile::parse(Path::new("lab/relax.toml"), "[relax]\nstrain = 5");
/// assert_eq!(
///     wrong.expect_err("five times the thickness").to_string(),
///     "lab/relax.toml:2: strain = 5 is not above 0 and at most 1: change it, or omit it for 0.05"
/// );
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub enum ExperimentFile {
    /// `[relax]`.
    Relax(Indentation),
    /// `[creep]`.
    Creep(Indentation),
    /// `[wall]`.
    Wall(WallExperiment),
    /// `[coupler]`.
    Coupler(CouplerExperiment),
    /// `[teleoperation]`.
    Teleoperation(Box<TeleoperationExperiment>),
    /// `[touch]`.
    Touch(Box<TouchExperiment>),
}

/// The kinds that may have a drive.
const DRIVEN: [&str; 2] = ["relax", "creep"];

impl ExperimentFile {
    /// Reads and checks a file.
    ///
    /// # Errors
    /// If it cannot be read or is wrong: in one line, with file and line.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        Self::open(&Document::read(path)?)
    }

    /// Reads and checks the text of a file; `path` is for messages and for the paths in it.
    ///
    /// # Errors
    /// If it is wrong: in one line, with file and line.
    pub fn parse(path: &Path, text: &str) -> Result<Self, FileError> {
        Self::open(&Document::of_text(path, text))
    }

    /// Reads and checks a document.
    ///
    /// # Errors
    /// If it is wrong: in one line, with its place.
    pub fn open(document: &Document) -> Result<Self, FileError> {
        let document = document.parse()?;
        let (kind, table, drive) = document.experiment(&parameters::KINDS, DRIVE)?;
        let table = table.with_keys(&parameters::of_kind(kind))?;
        let table = match parameters::takes_device(kind) {
            true => with_devices(table)?,
            false => table,
        };
        if let Some(drive) = drive.as_ref().filter(|_| !DRIVEN.contains(&kind)) {
            let reason = format!(
                "[{DRIVE}] holds the indenter of [relax] or [creep], which [{kind}] does not have: omit it"
            );
            return Err(drive.fail(reason));
        }
        let drive = drive
            .map(|drive| drive.with_keys(&[(DRIVE, drive::DRIVE)]))
            .transpose()?;
        let drive = drive.as_ref();
        match kind {
            "relax" => rendering::relax(&table, drive).map(Self::Relax),
            "creep" => rendering::creep(&table, drive).map(Self::Creep),
            "coupler" => coupler::coupler(&table).map(Self::Coupler),
            "teleoperation" => {
                let read = teleoperation::teleoperation(&table)?;
                Ok(Self::Teleoperation(Box::new(read)))
            }
            "touch" => Ok(Self::Touch(Box::new(touch::touch(&table)?))),
            _ => wall::wall(&table).map(Self::Wall),
        }
    }

    /// The number of samples.
    ///
    /// # Errors
    /// A parameter outside its range, which reading has ruled out.
    pub fn samples(&self) -> Result<u64, Failure> {
        match self {
            Self::Relax(experiment) | Self::Creep(experiment) => experiment.check(),
            Self::Wall(experiment) => experiment.check(),
            Self::Coupler(experiment) => experiment.check(),
            Self::Teleoperation(experiment) => experiment.check(),
            Self::Touch(experiment) => experiment.check(),
        }
    }

    /// The serial device of the file; `None` for the simulated one.
    #[must_use]
    pub fn remote(&self) -> Option<&RemoteDevice> {
        match self {
            Self::Relax(own) | Self::Creep(own) => own.rendering.remote.as_ref(),
            Self::Wall(wall) => wall.setup.remote.as_ref(),
            Self::Coupler(coupler) => coupler.setup.remote.as_ref(),
            Self::Touch(touch) => touch.remote.as_ref(),
            Self::Teleoperation(_) => None,
        }
    }

    /// Pace, whether it is run though it is unstable, and the serial device.
    fn conducted(&mut self) -> (&mut Pace, &mut bool, Option<&mut RemoteDevice>) {
        fn of(setup: &mut TrialSetup) -> (&mut Pace, &mut bool, Option<&mut RemoteDevice>) {
            let remote = setup.remote.as_mut();
            (&mut setup.pace, &mut setup.force_unstable, remote)
        }
        match self {
            Self::Relax(own) | Self::Creep(own) => {
                let own = &mut own.rendering;
                let force_unstable = &mut own.preflight.force_unstable;
                (&mut own.pace, force_unstable, own.remote.as_mut())
            }
            Self::Wall(wall) => of(&mut wall.setup),
            Self::Coupler(coupler) => of(&mut coupler.setup),
            Self::Touch(own) => (&mut own.pace, &mut own.force_unstable, own.remote.as_mut()),
            Self::Teleoperation(own) => (&mut own.pace, &mut own.force_unstable, None),
        }
    }

    /// The same, for a program that waits so long for a device at a port.
    #[must_use]
    pub fn with_patience(mut self, patience: Duration) -> Self {
        if let (.., Some(remote)) = self.conducted() {
            remote.patience = patience;
        }
        self
    }

    /// The same, to be run though the pre-flight calls it unstable.
    ///
    /// # Errors
    /// An experiment that no pre-flight refuses.
    pub fn though_unstable(mut self) -> Result<Self, Failure> {
        let is_looked_at = match &self {
            Self::Relax(own) | Self::Creep(own) => own.rendering.drive.is_some(),
            Self::Teleoperation(_) => true,
            _ => false,
        };
        if self.remote().is_none() && !is_looked_at {
            return Err(Failure::bad_input(format_args!(
                "{FORCE_UNSTABLE} is for serial devices, drives and teleoperations: give {} or {} too",
                DEVICE.set_to("serial:PATH"),
                CONTROLLER.set_to("FILE.toml")
            )));
        }
        *self.conducted().1 = true;
        Ok(self)
    }

    /// The same, in another pace.
    #[must_use]
    pub fn in_pace(mut self, pace: Pace) -> Self {
        *self.conducted().0 = pace;
        self
    }
}
