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
use crate::document::parameters::{CONTROLLER, DEVICE, FORCE_UNSTABLE, TISSUE};
use crate::document::parameters::{Parameter, Value};
use crate::document::reader::Table;
use crate::document::{
    CONTROLLER_IN_LOG, DEVICE_IN_LOG, Document, IN_LOG, TISSUE_IN_LOG, choice, line,
};
use crate::experiment::coupler::{self, CouplerExperiment, CouplerReport};
use crate::experiment::indentation::{self, Indentation, IndentationReport};
use crate::experiment::reading::{device_text, with_devices};
use crate::experiment::teleoperation::{
    self, End, FarReport, MUST_BE_PASSIVE, TeleoperationExperiment, TeleoperationReport,
    TeleoperationVerdict, Terms,
};
use crate::experiment::touch::{self, TouchExperiment, TouchReport, TouchVerdict};
use crate::experiment::trial::{Trial as _, TrialSetup};
use crate::experiment::wall::{self, MUST_BE_STABLE, WallExperiment, WallReport};
use crate::judge::Published;
use crate::judge::modelled_tissue::TissuePiece;
use crate::judge::report::RunReport;
use crate::run::Supervisor;
use crate::run::folder::FolderRequest;
use crate::run::remote::RemoteDevice;
use crate::run::schedule::Pace;
use parameters::{
    DEVICE_MODEL, DEVICE_PLANT, DRIVE_TABLE, KINDS, MEASUREMENT, QUESTIONS, of_kind, takes_device,
};
use serde::Serialize;
use std::collections::BTreeMap;
use std::net::SocketAddr;
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
pub struct ExperimentFile(pub(crate) Experiment);

/// An experiment of any kind.
#[derive(Clone, Debug)]
pub(crate) enum Experiment {
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
            .map(|drive| drive.with_keys(&of_kind(DRIVE_TABLE)))
            .transpose()?;
        let drive = drive.as_ref();
        let experiment = match kind {
            "relax" => indentation::relax(&table, drive).map(Experiment::Relax),
            "creep" => indentation::creep(&table, drive).map(Experiment::Creep),
            "coupler" => coupler::coupler(&table).map(Experiment::Coupler),
            "teleoperation" => {
                let read = teleoperation::teleoperation(&table)?;
                Ok(Experiment::Teleoperation(Box::new(read)))
            }
            "touch" => Ok(Experiment::Touch(Box::new(touch::touch(&table)?))),
            _ => wall::wall(&table).map(Experiment::Wall),
        };
        experiment.map(Self)
    }

    /// The number of samples.
    ///
    /// # Errors
    /// A parameter outside its range, which reading has ruled out.
    pub fn samples(&self) -> Result<u64, Failure> {
        match &self.0 {
            Experiment::Relax(experiment) | Experiment::Creep(experiment) => experiment.check(),
            Experiment::Wall(experiment) => experiment.check(),
            Experiment::Coupler(experiment) => experiment.check(),
            Experiment::Teleoperation(experiment) => experiment.check(),
            Experiment::Touch(experiment) => experiment.check(),
        }
    }

    /// Checks that a simulated hand begins outside the shape that it touches.
    ///
    /// # Errors
    /// A start inside, which would be a blow.
    pub fn check_start(&self) -> Result<(), Failure> {
        match &self.0 {
            Experiment::Touch(own) => own.check_start(),
            _ => Ok(()),
        }
    }

    /// T, s.
    #[must_use]
    pub fn sample_time_s(&self) -> f64 {
        match &self.0 {
            Experiment::Relax(own) | Experiment::Creep(own) => own.rendering.sample_time_s,
            Experiment::Wall(own) => own.setup.device.sample_time.0,
            Experiment::Coupler(own) => own.setup.device.sample_time.0,
            Experiment::Teleoperation(own) => own.sample_time().0,
            Experiment::Touch(own) => own.sample_time().0,
        }
    }

    /// Number of axes.
    #[must_use]
    pub fn axes(&self) -> usize {
        match &self.0 {
            Experiment::Touch(own) => own.axes,
            _ => 1,
        }
    }

    /// The piece of tissue that an indenter presses.
    #[must_use]
    pub const fn piece(&self) -> Option<&TissuePiece> {
        match &self.0 {
            Experiment::Relax(own) | Experiment::Creep(own) => Some(&own.rendering.piece),
            _ => None,
        }
    }

    /// What the log of its run says of it, over what its document says.
    #[must_use]
    pub fn metadata(&self) -> BTreeMap<String, String> {
        match &self.0 {
            Experiment::Relax(own) | Experiment::Creep(own) => own.metadata(),
            Experiment::Wall(own) => own.metadata(),
            Experiment::Coupler(own) => own.metadata(),
            Experiment::Teleoperation(own) => own.metadata(own.pace),
            Experiment::Touch(own) => own.metadata(),
        }
    }

    /// Runs the experiment; log and CSV go into the folder.
    ///
    /// # Errors
    /// Bad parameters, before any file is made; a log or CSV that cannot be written; a device that cannot be used.
    pub fn run(
        &self,
        request: &FolderRequest,
        supervisor: Supervisor<'_>,
    ) -> Result<Published<Report>, Failure> {
        Ok(match &self.0 {
            Experiment::Relax(own) | Experiment::Creep(own) => own
                .run(request, supervisor)?
                .map(|report| Report::Indentation(Box::new(report))),
            Experiment::Wall(own) => own.published(request, supervisor)?.map(Report::Wall),
            Experiment::Coupler(own) => own.run(request, supervisor)?.map(Report::Coupler),
            Experiment::Teleoperation(own) => {
                own.run(request, supervisor)?.map(Report::Teleoperation)
            }
            Experiment::Touch(own) => own.run(request, supervisor)?.map(Report::Touch),
        })
    }

    /// Refuses a run that does not keep what its document asks for by `must_be_stable` or `must_be_passive`.
    ///
    /// # Errors
    /// Exit code 1.
    pub fn require(&self, report: &Report) -> Result<(), Failure> {
        let stable = (MUST_BE_STABLE.key, "design a weaker one");
        let ((key, remedy), what) = match (&self.0, report) {
            (Experiment::Wall(own), Report::Wall(wall))
                if own.setup.must_be_stable && !wall.trial.stable_by_both() =>
            {
                let words = wall.trial.settling.verdict.words();
                let what = format!("trial ({words}) and analysis do not both call the wall stable");
                (stable, what)
            }
            (Experiment::Coupler(own), Report::Coupler(coupler))
                if own.setup.must_be_stable && !coupler.stable_by_all() =>
            {
                let words = coupler.trial.settling.verdict.words();
                let what = format!(
                    "trial ({words}), analysis and Llewellyn's criterion do not all accept the coupler"
                );
                (stable, what)
            }
            (Experiment::Teleoperation(own), Report::Teleoperation(far))
                if own.must_be_passive && far.verdict != TeleoperationVerdict::Passive =>
            {
                let remedy = "take a passive architecture, a softer coupler or a smaller motion";
                (
                    (MUST_BE_PASSIVE.key, remedy),
                    far.verdict.words().to_owned(),
                )
            }
            (Experiment::Touch(own), Report::Touch(touch))
                if own.must_be_passive && touch.verdict != TouchVerdict::Passive =>
            {
                let remedy = "take a softer shape, a shorter sample time or a guard";
                (
                    (MUST_BE_PASSIVE.key, remedy),
                    touch.verdict.words().to_owned(),
                )
            }
            _ => return Ok(()),
        };
        Err(Failure::Run(anyhow::anyhow!(
            "{key}: {what}: {remedy}, or remove {key} from the file to run it anyway"
        )))
    }

    /// True if it runs on the simulated device.
    #[must_use]
    pub fn is_simulated(&self) -> bool {
        self.remote().is_none()
    }

    /// The relaxation or creep test that it is.
    #[must_use]
    pub const fn indentation(&self) -> Option<&Indentation> {
        match &self.0 {
            Experiment::Relax(own) | Experiment::Creep(own) => Some(own),
            _ => None,
        }
    }

    /// The serial device of the file; `None` for the simulated one.
    pub(crate) fn remote(&self) -> Option<&RemoteDevice> {
        match &self.0 {
            Experiment::Relax(own) | Experiment::Creep(own) => own.rendering.remote.as_ref(),
            Experiment::Wall(wall) => wall.setup.remote.as_ref(),
            Experiment::Coupler(coupler) => coupler.setup.remote.as_ref(),
            Experiment::Touch(touch) => touch.remote.as_ref(),
            Experiment::Teleoperation(_) => None,
        }
    }

    /// Runs a side of a teleoperation for `duration_s` of its device, once the other is there; log and table go into the folder. `opened` hears
    /// the address of this side.
    ///
    /// # Errors
    /// Another experiment; a parameter outside its range; an address that cannot be had; nobody at the other end, or somebody who does not
    /// fit; a log that cannot be written.
    pub fn run_side(
        &self,
        end: End,
        terms: Terms,
        opened: &dyn Fn(SocketAddr),
        conduct: (&FolderRequest, Supervisor<'_>),
    ) -> Result<Published<FarReport>, Failure> {
        self.teleoperation()?.run_side(end, terms, opened, conduct)
    }

    /// Refuses a side that did not reach its end, skipped too many ticks, or does not keep what its document asks for.
    ///
    /// # Errors
    /// Exit code 1.
    pub fn require_side(&self, report: &FarReport, terms: Terms) -> Result<(), Failure> {
        report.require(self.teleoperation()?, terms)
    }

    fn teleoperation(&self) -> Result<&TeleoperationExperiment, Failure> {
        match &self.0 {
            Experiment::Teleoperation(own) => Ok(own),
            _ => Err(Failure::bad_input(
                "the file describes another experiment: give one with a table [teleoperation]",
            )),
        }
    }

    /// Pace, whether it is run though it is unstable, and the serial device.
    fn conducted(&mut self) -> (&mut Pace, &mut bool, Option<&mut RemoteDevice>) {
        fn of(setup: &mut TrialSetup) -> (&mut Pace, &mut bool, Option<&mut RemoteDevice>) {
            let remote = setup.remote.as_mut();
            (&mut setup.pace, &mut setup.force_unstable, remote)
        }
        match &mut self.0 {
            Experiment::Relax(own) | Experiment::Creep(own) => {
                let own = &mut own.rendering;
                let force_unstable = &mut own.preflight.force_unstable;
                (&mut own.pace, force_unstable, own.remote.as_mut())
            }
            Experiment::Wall(wall) => of(&mut wall.setup),
            Experiment::Coupler(coupler) => of(&mut coupler.setup),
            Experiment::Touch(own) => (&mut own.pace, &mut own.force_unstable, own.remote.as_mut()),
            Experiment::Teleoperation(own) => (&mut own.pace, &mut own.force_unstable, None),
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

    /// Runs even if the pre-flight finds it unstable.
    ///
    /// # Errors
    /// An experiment that no pre-flight refuses.
    pub fn though_unstable(mut self) -> Result<Self, Failure> {
        let is_looked_at = match &self.0 {
            Experiment::Relax(own) | Experiment::Creep(own) => own.rendering.drive.is_some(),
            Experiment::Teleoperation(_) => true,
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

/// The report of an experiment: as JSON and as rows that of its kind.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub enum Report {
    /// Of a relaxation or creep test.
    Indentation(Box<IndentationReport>),
    /// Of a wall.
    Wall(WallReport),
    /// Of a coupler.
    Coupler(CouplerReport),
    /// Of a teleoperation.
    Teleoperation(TeleoperationReport),
    /// Of a touch.
    Touch(TouchReport),
}

impl Report {
    /// Of the run.
    #[must_use]
    pub const fn run(&self) -> &RunReport {
        match self {
            Self::Indentation(own) => &own.run,
            Self::Wall(own) => &own.trial.run,
            Self::Coupler(own) => &own.trial.run,
            Self::Teleoperation(own) => &own.run,
            Self::Touch(own) => &own.run,
        }
    }

    /// The same, to name a picture in it.
    pub const fn run_mut(&mut self) -> &mut RunReport {
        match self {
            Self::Indentation(own) => &mut own.run,
            Self::Wall(own) => &mut own.trial.run,
            Self::Coupler(own) => &mut own.trial.run,
            Self::Teleoperation(own) => &mut own.run,
            Self::Touch(own) => &mut own.run,
        }
    }

    /// The verdict in words; none of a relaxation or creep test whose error has no meaning.
    #[must_use]
    pub fn verdict(&self) -> Option<String> {
        let words = match self {
            Self::Indentation(own) => {
                let error = own.errors.closed_form.largest?;
                return Some(format!("{:.2} % from the closed form", 1e2 * error));
            }
            Self::Wall(own) => own.trial.settling.verdict.words(),
            Self::Coupler(own) => own.trial.settling.verdict.words(),
            Self::Teleoperation(own) => own.verdict.words(),
            Self::Touch(own) => own.verdict.words(),
        };
        Some(words.to_owned())
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
            if let Some(text) = device_text(&table)? {
                keep(DEVICE_IN_LOG, text);
            }
        }
        keep(IN_LOG.1, self.to_toml()?);
        Ok(())
    }

    /// That files which a log's document names are not as the log has them, if so: its run is repeated with what the log has.
    #[must_use]
    pub fn changed_since_log(&self) -> Option<String> {
        let read = |document: &Self| -> Result<BTreeMap<String, String>, FileError> {
            let mut said = ExperimentFile::open(document)?.metadata();
            document.keep_in(&mut said)?;
            Ok(said)
        };
        let mut today = self.clone();
        today.logged.clear();
        let then = read(self).ok().filter(|_| !self.logged.is_empty())?;
        // Of files that cannot be read any more there is nothing.
        let today = read(&today).unwrap_or_default();
        let changed = |(_, entry): &(&str, &str)| then.get(*entry) != today.get(*entry);
        let (key, _) = FILES_IN_LOG.into_iter().find(changed)?;
        Some(format!(
            "the file of {key} has changed since the log was made: the run takes it from the log; give {key} for today's"
        ))
    }
}

/// Files that a document names: the key, and where a log has the text.
const FILES_IN_LOG: [(&str, &str); 3] = [
    (TISSUE.key, TISSUE_IN_LOG),
    (CONTROLLER.key, CONTROLLER_IN_LOG),
    (DEVICE_MODEL.key, DEVICE_IN_LOG),
];

/// The parameters of a table of a document.
fn known(table: &str) -> impl Iterator<Item = &'static Parameter> {
    let known = of_kind(table).into_iter();
    known.flat_map(|(_, parameters)| parameters)
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
