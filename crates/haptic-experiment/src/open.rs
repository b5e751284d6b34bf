//! Experiment files: TOML with one table, `[relax]`, `[creep]`, `[wall]`, `[coupler]`, `[teleoperation]`, `[touch]` or `[press]`, units in the
//! names of keys; `[drive]` beside all but `[teleoperation]` and `[touch]`.
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

use crate::{
    experiment,
    experiment::{
        indentation::Indentation,
        kind::Experiment,
        press::{Press, PressRecord},
        teleoperation::{End, FarReport, TeleoperationExperiment, Terms},
    },
    judge::{Published, Report},
};
use haptic_document::{
    Document, Failure, FileError, IN_LOG, Table, bad_input, choice, parameters as p,
    parameters::{
        CONTROLLER, DEVICE, DEVICE_MODEL, DRIVE_DEVICE_MODEL, FORCE_UNSTABLE, Parameter, Value,
    },
};
use haptic_judge::{modelled_tissue::TissuePiece, setup::Beside, tissue_table::piece};
use haptic_log::record::add_verdict;
use haptic_message::TickMessage;
use haptic_run::{Supervisor, Watched, folder::FolderRequest, schedule::Pace};
use haptic_trial::{
    device_table::{device_text, with_devices},
    tick::KeptSample,
};
use parameters::{
    ADMITTANCE_TABLE, AT_A_DEVICE, BESIDE, DEVICE_PLANT, DRIVE_TABLE, KINDS, QUESTIONS, of_kind,
    takes_device,
};
use std::{
    any::Any,
    collections::BTreeMap,
    net::SocketAddr,
    path::{Path, absolute},
    time::Duration,
};

/// The experiment that a file describes, all of its parameters checked.
///
/// ```
/// use haptic_experiment::ExperimentFile;
/// use std::path::{Path, absolute};
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
#[derive(Debug)]
pub struct ExperimentFile(pub(crate) Box<dyn Experiment>);

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
        let (name, table, mut tables) = document.one_of(&KINDS, &BESIDE, "experiment", &words)?;
        let drive = tables.remove(DRIVE_TABLE);
        let kind = experiment::find(name).ok_or_else(|| table.fail(format!("no kind {name}")))?;
        let table = table.with_keys(kind.keys)?;
        let table = above_device(name, table)?;
        if let Some(drive) = drive.as_ref().filter(|_| !kind.companion.has_drive()) {
            return Err(drive.fail(format_args!(
                "[{DRIVE_TABLE}] stands beside [relax], [creep], [press], [wall] or [coupler], not [{name}]: omit it"
            )));
        }
        let drive = drive
            .map(|drive| drive.with_keys(&of_kind(DRIVE_TABLE)))
            .transpose()?;
        let admittance = tables.remove(ADMITTANCE_TABLE);
        if let Some(admittance) = admittance.as_ref().filter(|_| name != "wall") {
            let why = match name {
                "touch" => "touches along one axis only",
                "relax" | "creep" | "press" => "is pushed by a hand, and does not press by itself",
                _ => "takes a velocity, and not the force of this law",
            };
            return Err(admittance.fail(format_args!(
                "[{ADMITTANCE_TABLE}] stands beside [wall], not [{name}], as its robot {why}: omit it"
            )));
        }
        let admittance = admittance
            .map(|admittance| admittance.with_keys(&of_kind(ADMITTANCE_TABLE)))
            .transpose()?;
        let beside = Beside {
            drive: drive.as_ref(),
            admittance: admittance.as_ref(),
        };
        (kind.read)(&table, beside).map(Self)
    }

    /// The number of samples.
    ///
    /// # Errors
    /// A parameter outside its range; reading the document has excluded that.
    pub fn samples(&self) -> Result<u64, Failure> {
        self.0.check()
    }

    /// Checks that a simulated hand begins outside the shape that it touches.
    ///
    /// # Errors
    /// A start inside, which would be a blow.
    pub fn check_start(&self) -> Result<(), Failure> {
        self.0.check_start()
    }

    /// Time from one tick of its loop to the next, s.
    #[must_use]
    pub fn sample_time_s(&self) -> f64 {
        self.0.sample_time_s()
    }

    /// The number of axes along which its device moves.
    #[must_use]
    pub fn axes(&self) -> usize {
        self.0.axes()
    }

    /// The piece of tissue that an indenter presses.
    #[must_use]
    pub fn piece(&self) -> Option<&TissuePiece> {
        let press = || self.of().map(|press: &Press| &press.piece);
        (self.indentation().map(|pressed| &pressed.piece)).or_else(press)
    }

    /// The record of a press by the ticks of its log; `None` of another experiment.
    #[must_use]
    pub fn press_record(&self, ticks: &[TickMessage]) -> Option<PressRecord> {
        let samples: Vec<KeptSample> = ticks.iter().map(KeptSample::of).collect();
        self.of().map(|press: &Press| press.record(&samples))
    }

    /// Metadata that the log of its run has, which overrides its document.
    #[must_use]
    pub fn metadata(&self) -> BTreeMap<String, String> {
        self.0.metadata()
    }

    /// Runs the experiment; log and CSV go into the folder. The log keeps the verdict.
    ///
    /// # Errors
    /// Bad parameters, before any file is made; a log or CSV that cannot be written; a device that cannot be used.
    pub fn run(
        &self,
        request: &FolderRequest,
        supervisor: Supervisor<'_>,
    ) -> Result<Published<Report>, Failure> {
        self.run_for(request, supervisor, || true)
    }

    /// Runs the experiment as [`run`](Self::run) does, but once all else is done the log gets no verdict if nobody waits for it any more.
    ///
    /// # Errors
    /// As for [`run`](Self::run).
    pub fn run_for(
        &self,
        request: &FolderRequest,
        supervisor: Supervisor<'_>,
        is_awaited: impl FnOnce() -> bool,
    ) -> Result<Published<Report>, Failure> {
        let mut published = self.0.run(Watched {
            request,
            supervisor,
        })?;
        let Report { run, verdict, .. } = &mut published.report;
        if let (Some(verdict), Some(log)) = (verdict, run.logs.last())
            && is_awaited()
            && let Err(error) = add_verdict(Path::new(log), verdict)
        {
            let lost = format!("the log is whole, but lacks its verdict: {error}");
            run.warnings.push(lost);
        }
        Ok(published)
    }

    /// True if it runs on the simulated device.
    #[must_use]
    pub fn is_simulated(&self) -> bool {
        self.0.conduct().remote.is_none()
    }

    /// The experiment, if it is of this type.
    pub(crate) fn of<T: Experiment>(&self) -> Option<&T> {
        let experiment: &dyn Any = &*self.0;
        experiment.downcast_ref()
    }

    /// The relaxation or creep test that it is.
    #[must_use]
    pub fn indentation(&self) -> Option<&Indentation> {
        self.of()
    }

    /// Runs a side of a teleoperation for `duration_s` of its device, once the other is there; log
    /// and table go into the folder. `opened` receives the address of this side.
    ///
    /// # Errors
    /// Another experiment; a parameter outside its range; an address that is not
    /// available; no other side, or one that does not match; a log that cannot be written.
    pub fn run_side(
        &self,
        end: End,
        terms: Terms,
        opened: &dyn Fn(SocketAddr),
        request: &FolderRequest,
        supervisor: Supervisor<'_>,
    ) -> Result<Published<FarReport>, Failure> {
        let teleoperation: Option<&TeleoperationExperiment> = self.of();
        let teleoperation = teleoperation.ok_or_else(|| {
            Failure::bad_input(
                "the file describes another experiment: give one with a table [teleoperation]",
            )
        })?;
        teleoperation.run_side(end, terms, opened, request, supervisor)
    }

    /// Sets the time to wait for a device at a port.
    #[must_use]
    pub fn with_patience(mut self, patience: Duration) -> Self {
        if let Some(remote) = &mut self.0.conduct_mut().remote {
            remote.patience = patience;
        }
        self
    }

    /// Allows the run even if the pre-flight finds it unstable.
    ///
    /// # Errors
    /// An experiment that no pre-flight refuses.
    pub fn though_unstable(mut self) -> Result<Self, Failure> {
        if self.is_simulated() && !self.0.may_be_refused() {
            return Err(bad_input!(
                "{FORCE_UNSTABLE} is for serial devices, drives and teleoperations: give {} or {} too",
                DEVICE.set_to("serial:PATH"),
                CONTROLLER.set_to("FILE.toml")
            ));
        }
        self.0.conduct_mut().force_unstable = true;
        Ok(self)
    }

    /// Sets the pace: as fast as the machine goes, or by the clock.
    #[must_use]
    pub fn in_pace(mut self, pace: Pace) -> Self {
        self.0.conduct_mut().pace = pace;
        self
    }
}

/// The kind of a document, and what is kept of it, by the tables of all kinds.
pub trait DocumentOfKind {
    /// The kind of the experiment or question: the name of its table.
    ///
    /// # Errors
    /// A file that is not TOML, or has no table of a kind.
    fn kind(&self) -> Result<&'static str, FileError>;

    /// The document as one file: what was given, here or in the file, and the other defaults as comments. Paths are absolute, so it may lie anywhere.
    ///
    /// # Errors
    /// As for [`kind`](Self::kind).
    fn to_toml(&self) -> Result<String, FileError>;

    /// Puts the document among the provenance of a log, from which [`read_document`](haptic_run::document::read_document) reads it, and beside it the kind and each
    /// key with its value, given or by default.
    ///
    /// # Errors
    /// As for [`kind`](Self::kind); a value that is not of its kind.
    fn keep_in(&self, provenance: &mut BTreeMap<String, String>) -> Result<(), FileError>;

    /// A note if files named in a log's document have changed since: the run is then repeated with
    /// the log's versions.
    #[must_use]
    fn changed_since_log(&self) -> Option<String>;
}

impl DocumentOfKind for Document {
    fn kind(&self) -> Result<&'static str, FileError> {
        let parsed = self.parse()?;
        let kinds = KINDS.into_iter().chain(QUESTIONS);
        kinds
            .chain(AT_A_DEVICE)
            .find(|kind| parsed.has(kind))
            .ok_or_else(|| parsed.fail(format!("no experiment: {}", choice(&KINDS))))
    }

    fn to_toml(&self) -> Result<String, FileError> {
        let kind = self.kind()?;
        let parsed = self.parse()?;
        let mut text = String::new();
        for (name, table) in parsed.tables(&[kind, DRIVE_TABLE, ADMITTANCE_TABLE], "")? {
            text += &format!("[{name}]\n");
            for parameter in known(name) {
                // A device file overrides these keys, which are then not read.
                let of_device = takes_device(kind) && DEVICE_PLANT.contains(parameter);
                if !(of_device && table.lies_below(parameter, &DEVICE_MODEL)) {
                    text += &line(&table, parameter);
                }
            }
        }
        Ok(text)
    }

    fn keep_in(&self, provenance: &mut BTreeMap<String, String>) -> Result<(), FileError> {
        let kind = self.kind()?;
        let mut keep = |key: &str, value: String| provenance.insert(key.to_owned(), value);
        keep("experiment", kind.to_owned());
        let parsed = self.parse()?;
        for (name, table) in parsed.tables(&[kind, DRIVE_TABLE, ADMITTANCE_TABLE], "")? {
            let table = above_device(name, table)?;
            for parameter in known(name) {
                if let Some(value) = in_words(&table, parameter)? {
                    keep(parameter.key, value);
                }
            }
            for file in [DEVICE_MODEL, DRIVE_DEVICE_MODEL] {
                if let (Some(entry), Some(text)) = (file.in_log, device_text(&table, &file)?) {
                    keep(entry, text);
                }
            }
        }
        keep(IN_LOG.1, self.to_toml()?);
        Ok(())
    }

    fn changed_since_log(&self) -> Option<String> {
        let read = |document: &Self| -> Result<BTreeMap<String, String>, FileError> {
            let mut metadata = ExperimentFile::open(document)?.metadata();
            document.keep_in(&mut metadata)?;
            Ok(metadata)
        };
        let today = self.clone().without_log();
        let then = read(self).ok().filter(|_| !self.logged().is_empty())?;
        // Of files that cannot be read any more there is nothing.
        let today = read(&today).unwrap_or_default();
        let mut known = [self.kind().ok()?, DRIVE_TABLE, ADMITTANCE_TABLE]
            .into_iter()
            .flat_map(known);
        let changed = |entry| then.get(entry) != today.get(entry);
        let Parameter { key, .. } = known.find(|known| known.in_log.is_some_and(changed))?;
        Some(format!(
            "the file of {key} has changed since the log was made: the run takes it from the log; give {key} for today's"
        ))
    }
}

/// The piece of the tissue that a document names; `None` where it names none.
///
/// # Errors
/// Keys that say nothing of a piece, a tissue that there is not, sizes that its loading does not
/// have.
pub fn pressed(document: &Document) -> Result<Option<TissuePiece>, FileError> {
    let parsed = document.parse()?;
    let mut tables = parsed.tables(&[document.kind()?], "")?.into_iter();
    let table = tables
        .next()
        .map(|(_, table)| table.with_keys(&[("", p::PIECE)]));
    let named = table.transpose()?.filter(|table| table.has(&p::TISSUE));
    named.as_ref().map(piece).transpose()
}

/// A line of a file for a parameter: a comment for a default.
fn line(table: &Table<'_>, parameter: &Parameter) -> String {
    let Parameter { key, shown, .. } = parameter;
    let default = match (table.written(parameter), parameter.value) {
        (Some(text), _) => {
            let path = table.path(parameter);
            let path = path.map(|path| absolute(&path).unwrap_or(path));
            return match path {
                Some(path) => format!(
                    "{key} = {}\n",
                    toml::Value::from(path.to_string_lossy().as_ref())
                ),
                None => format!("{key} = {text}\n"),
            };
        }
        (None, Value::Number(Some(default), _)) => format!("{default:?}"),
        (None, Value::Count(default)) => default.to_string(),
        (None, Value::Flag(default)) => default.to_string(),
        (None, Value::List(_)) if !shown.is_empty() => format!("[{shown}]"),
        (None, Value::Text(default)) if !default.is_empty() => format!("\"{default}\""),
        _ => return String::new(),
    };
    format!("# {key} = {default}\n")
}

/// The table above the values of its device file, if its kind takes one.
fn above_device<'a>(name: &str, table: Table<'a>) -> Result<Table<'a>, FileError> {
    if takes_device(name) {
        with_devices(table)
    } else {
        Ok(table)
    }
}

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
