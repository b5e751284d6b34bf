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

pub mod parameters;
#[cfg(test)]
mod tests;

use crate::document::error::FileError;
use crate::document::failure::Failure;
use crate::document::parameters::{CONTROLLER, DEVICE, FORCE_UNSTABLE};
use crate::document::parameters::{Parameter, Value};
use crate::document::reader::Table;
use crate::document::{Document, IN_LOG, choice, line};
use crate::experiment::reading::with_devices;
use crate::experiment::{coupler, indentation, teleoperation, touch, wall};
use crate::run::remote::RemoteDevice;
use crate::run::schedule::Pace;
use crate::{
    CouplerExperiment, Indentation, TeleoperationExperiment, TouchExperiment, TrialSetup,
    WallExperiment,
};
use parameters::{
    DEVICE_MODEL, DEVICE_PLANT, DRIVE, DRIVE_TABLE, KINDS, MEASUREMENT, QUESTIONS, of_kind,
    takes_device,
};
use std::collections::BTreeMap;
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
        let words = choice(&KINDS);
        let (kind, table, mut beside) =
            document.one_of(&KINDS, &[DRIVE_TABLE], ("experiment", &words))?;
        let drive = beside.remove(DRIVE_TABLE);
        let table = table.with_keys(&of_kind(kind))?;
        let table = match takes_device(kind) {
            true => with_devices(table)?,
            false => table,
        };
        if let Some(drive) = drive.as_ref().filter(|_| !DRIVEN.contains(&kind)) {
            let reason = format!(
                "[{DRIVE_TABLE}] holds the indenter of [relax] or [creep], which [{kind}] does not have: omit it"
            );
            return Err(drive.fail(reason));
        }
        let drive = drive
            .map(|drive| drive.with_keys(&[(DRIVE_TABLE, DRIVE)]))
            .transpose()?;
        let drive = drive.as_ref();
        match kind {
            "relax" => indentation::relax(&table, drive).map(Self::Relax),
            "creep" => indentation::creep(&table, drive).map(Self::Creep),
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

impl Document {
    /// The kind of the experiment or question: the name of its table.
    ///
    /// # Errors
    /// A file that is not TOML, or has no table of a kind.
    pub fn kind(&self) -> Result<&'static str, FileError> {
        let parsed = self.parse()?;
        let kinds = KINDS.into_iter().chain(QUESTIONS);
        kinds
            .chain([MEASUREMENT])
            .find(|kind| parsed.has(kind))
            .ok_or_else(|| parsed.fail(format!("no experiment: {}", choice(&KINDS))))
    }

    /// The document as one file: what was given, here or in the file, and the other defaults as comments. Paths are absolute, so it may lie anywhere.
    ///
    /// # Errors
    /// As those of [`kind`](Self::kind).
    pub fn to_toml(&self) -> Result<String, FileError> {
        let kind = self.kind()?;
        let parsed = self.parse()?;
        let mut text = String::new();
        for (name, table) in parsed.tables(&[kind, DRIVE_TABLE], "")? {
            text += &format!("[{name}]\n");
            for parameter in known(name) {
                // What a device file above it says is not read.
                let of_device = takes_device(kind) && DEVICE_PLANT.contains(parameter);
                if !(of_device && table.lies_below(parameter, &DEVICE_MODEL)) {
                    text += &line(&table, parameter);
                }
            }
        }
        Ok(text)
    }

    /// Puts the document among the provenance of a log, from which [`read`](Self::read) reads it, and beside it the kind and each
    /// key with its value, given or by default.
    ///
    /// # Errors
    /// As those of [`kind`](Self::kind); a value that is not of its kind.
    pub fn keep_in(&self, provenance: &mut BTreeMap<String, String>) -> Result<(), FileError> {
        let kind = self.kind()?;
        let mut keep = |key: &str, value: String| provenance.insert(key.to_owned(), value);
        keep("experiment", kind.to_owned());
        let parsed = self.parse()?;
        for (name, table) in parsed.tables(&[kind, DRIVE_TABLE], "")? {
            let table = match takes_device(name) {
                true => with_devices(table)?,
                false => table,
            };
            for parameter in known(name) {
                if let Some(value) = in_words(&table, parameter)? {
                    keep(parameter.key, value);
                }
            }
        }
        keep(IN_LOG.1, self.to_toml()?);
        Ok(())
    }
}

/// The parameters of a table of a document.
fn known(table: &str) -> impl Iterator<Item = &'static Parameter> {
    let known = match table {
        DRIVE_TABLE => vec![(DRIVE_TABLE, DRIVE)],
        kind => of_kind(kind),
    };
    known.into_iter().flat_map(|(_, parameters)| parameters)
}

/// The value of a parameter as a log has it: numbers with spaces between them, rows with semicolons.
fn in_words(table: &Table<'_>, parameter: &Parameter) -> Result<Option<String>, FileError> {
    let row = |numbers: Vec<f64>| {
        let numbers: Vec<String> = numbers.iter().map(f64::to_string).collect();
        numbers.join(" ")
    };
    Ok(match parameter.value {
        Value::Number(default, _) => {
            let number = table.number_if(parameter)?.or(default);
            number.map(|number| number.to_string())
        }
        Value::Count(_) => Some(table.count(parameter)?.to_string()),
        Value::Flag(_) => Some(table.flag(parameter)?.to_string()),
        Value::Text(_) => Some(table.text(parameter)?.to_owned()).filter(|text| !text.is_empty()),
        Value::List(_) => match table.numbers_if(parameter) {
            Ok(numbers) => numbers.map(row),
            Err(_) => {
                let rows = table.matrix_if(parameter)?;
                rows.map(|rows| rows.into_iter().map(row).collect::<Vec<_>>().join("; "))
            }
        },
    })
}
