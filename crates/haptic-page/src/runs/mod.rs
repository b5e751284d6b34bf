//! Runs: logs in a folder, and experiments started from the page.
//! ```text
//! folder ─▶ list ─▶ open ─▶ pyramid ─▶ views             form ─▶ experiment file ─▶ run in a thread ─▶ log in the folder
//!                     └─▶ answer                                                      └─▶ pyramid, while it goes
//!                                                       form ─▶ question ─▶ thread ─▶ answer in the folder
//! ```
//! A log is named by its path in the folder, without `.mcap`; only what the folder holds has a name.

mod experiment;
mod form;
mod going;
mod list;
mod opened;
mod question;

pub(crate) use form::{FILES, forms};
pub(crate) use opened::Table;

use crate::Announce;
use going::{Going, Watched, Work};
use haptic_answer::channels::Channels;
use haptic_answer::pyramid::{Pyramid, ViewColumns, ViewSpan};
use haptic_answer::request::TableRequest;
use haptic_document::Document;
use haptic_experiment::Failure;
use haptic_experiment::live::locked;
use haptic_run::RealtimeOptions;
use haptic_run::read_document;
use list::{Listing, is_answer, is_being_written, read_answer};
use opened::Opened;
use serde_json::{Map, Value, json};
use std::collections::{BTreeMap, VecDeque};
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

/// Logs that are kept open; each is some tens of megabytes.
const OPEN: usize = 2;
/// Runs whose curves are remembered.
const OUTCOMES: usize = 8;

/// The runs of a folder.
#[derive(Debug)]
pub(crate) struct Runs {
    folder: PathBuf,
    provenance: BTreeMap<String, String>,
    realtime: RealtimeOptions,
    announce: Announce,
    listing: Mutex<Listing>,
    open: Mutex<VecDeque<Arc<Opened>>>,
    going: Mutex<Option<Arc<Going>>>,
    /// Outcomes of those that were run here; newest last.
    outcomes: Arc<Mutex<VecDeque<Outcome>>>,
}

/// Curves that a run gave at its end, which its log does not hold.
#[derive(Debug)]
struct Outcome {
    name: String,
    curves: Value,
}

pub(crate) struct ShownRun {
    pub(crate) channels: Vec<String>,
    pub(crate) columns: ViewColumns,
    pub(crate) sample_time_s: f64,
}

impl Runs {
    pub(crate) fn new(
        folder: PathBuf,
        provenance: BTreeMap<String, String>,
        realtime: RealtimeOptions,
        announce: Announce,
    ) -> Self {
        Self {
            folder,
            provenance,
            realtime,
            announce,
            listing: Mutex::default(),
            open: Mutex::default(),
            going: Mutex::default(),
            outcomes: Arc::default(),
        }
    }

    fn going(&self) -> Option<Arc<Going>> {
        locked(&self.going).clone().filter(|going| !going.is_over())
    }

    pub(crate) fn list(&self) -> Result<Value, Failure> {
        let going = self.going();
        let name = going.as_ref().map(|going| going.name());
        let runs = locked(&self.listing).list(&self.folder, name)?;
        Ok(json!({"runs": runs}))
    }

    /// Metadata and events of a log, or of the run in progress as far as they are known; or an answer.
    pub(crate) fn open(&self, name: &str) -> Result<Value, Failure> {
        if let Some(going) = self.going().filter(|going| going.name() == name) {
            return Ok(going.answer());
        }
        let (path, _) = locked(&self.listing).find(&self.folder, name)?;
        if is_answer(&path) {
            let mut answer = read_answer(&path)?;
            answer["name"] = name.into();
            return Ok(answer);
        }
        let opened = self.opened(name)?;
        let mut answer = opened.answer();
        answer["running"] = is_being_written(&path).into();
        let outcomes = locked(&self.outcomes);
        let found = outcomes.iter().find(|outcome| outcome.name == name);
        answer["curves"] = found.map_or(Value::Null, |outcome| outcome.curves.clone());
        Ok(answer)
    }

    fn opened(&self, name: &str) -> Result<Arc<Opened>, Failure> {
        let (path, seen) = locked(&self.listing).find(&self.folder, name)?;
        if is_answer(&path) {
            return Err(Failure::bad_input(format_args!(
                "{name} is an answer, not a log, and has no curves: open it with `runs.open`"
            )));
        }
        let known = |opened: &&Arc<Opened>| opened.name == name && opened.seen == seen;
        if let Some(opened) = locked(&self.open).iter().find(known) {
            return Ok(Arc::clone(opened));
        }
        let opened = Arc::new(Opened::read(name, &path, seen)?);
        let mut open = locked(&self.open);
        open.retain(|other| other.name != name);
        open.push_back(Arc::clone(&opened));
        while open.len() > OPEN {
            open.pop_front();
        }
        Ok(opened)
    }

    /// Columns of a log, or of the run in progress; `span` gives their ticks, from the number of samples and the sample time.
    pub(crate) fn columns(
        &self,
        name: &str,
        span: impl Fn(u64, f64) -> Result<ViewSpan, Failure>,
    ) -> Result<ShownRun, Failure> {
        let going = self.going().filter(|going| going.name() == name);
        let shown = |channels: &Channels, pyramid: &Pyramid, sample_time_s| {
            let span = span(pyramid.made().max(1), sample_time_s)?;
            Ok(ShownRun {
                channels: channels.drawn(),
                columns: pyramid.columns(span),
                sample_time_s,
            })
        };
        if let Some(Watched { drawn, pyramid }) =
            going.as_ref().and_then(|going| going.watched.as_ref())
        {
            return shown(&drawn.channels, &locked(pyramid), drawn.sample_time_s);
        }
        let opened = self.opened(name)?;
        shown(&opened.channels, &opened.pyramid, opened.sample_time_s)
    }

    /// The experiment of a log.
    pub(crate) fn document(&self, name: &str) -> Result<Document, Failure> {
        let (path, _) = locked(&self.listing).find(&self.folder, name)?;
        Ok(read_document(&path)?)
    }

    /// The samples of a log as a table.
    pub(crate) fn table(&self, request: &TableRequest) -> Result<Table, Failure> {
        let name = &request.name;
        if self.going().is_some_and(|going| going.name() == name) {
            return Err(Failure::bad_input(format_args!(
                "{name} is still running: ask for its samples when it is done"
            )));
        }
        let opened = self.opened(name)?;
        let (path, _) = locked(&self.listing).find(&self.folder, name)?;
        Table::new(path, opened.channels.clone(), request)
    }

    /// Starts an experiment or a question in a thread.
    pub(crate) fn start(
        &self,
        kind: &str,
        parameters: &Map<String, Value>,
        realtime: bool,
    ) -> Result<Value, Failure> {
        let work = self.work(kind, parameters, realtime)?;
        let mut slot = locked(&self.going);
        if let Some(going) = slot.as_ref().filter(|going| !going.is_over()) {
            return Err(Failure::bad_input(format_args!(
                "{} is still running: wait for its end, or stop it",
                going.name()
            )));
        }
        let (name, samples) = (work.name.clone(), work.steps);
        let outcomes = Arc::clone(&self.outcomes);
        let keep = move |name: &str, curves: Value| {
            let mut outcomes = locked(&outcomes);
            outcomes.push_back(Outcome {
                name: name.to_owned(),
                curves,
            });
            while outcomes.len() > OUTCOMES {
                outcomes.pop_front();
            }
        };
        *slot = Some(Going::start(work, self.announce.clone(), keep));
        Ok(json!({"name": name, "samples": samples}))
    }

    /// Work of a form: an experiment or a question.
    fn work(
        &self,
        kind: &str,
        parameters: &Map<String, Value>,
        realtime: bool,
    ) -> Result<Work, Failure> {
        let (folder, provenance) = (&self.folder, &self.provenance);
        if haptic_experiment::parameters::QUESTIONS.contains(&kind) {
            if realtime {
                return Err(Failure::bad_input(format_args!(
                    "{kind} is a question, which does not run by the clock: omit `realtime`"
                )));
            }
            return question::work(kind, parameters, folder, provenance);
        }
        let realtime = realtime.then_some(self.realtime);
        experiment::work(kind, parameters, realtime, folder, provenance)
    }

    /// Ends the run in progress, force ramped to zero.
    pub(crate) fn stop(&self) {
        if let Some(going) = self.going() {
            going.stop();
        }
    }

    /// Ends the run in progress, and waits for it.
    pub(crate) fn end(&self) {
        let going = locked(&self.going).take();
        if let Some(going) = going {
            going.end();
        }
    }
}
