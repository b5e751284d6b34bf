//! Runs: logs in a folder, and experiments started from the page.
//!
//! ```text
//! folder ─▶ list ─▶ open ─▶ pyramid ─▶ views             form ─▶ experiment file ─▶ run in a thread ─▶ log in the folder
//!                                                                                     └─▶ pyramid, while it goes
//! ```
//! A log is named by its path in the folder, without `.mcap`; only what the folder holds has a name.

mod experiment;
mod forms;
mod going;
mod list;
mod opened;

use crate::Announce;
use crate::feel::locked;
use crate::pyramid::{Columns, Span};
use going::Going;
use haptic_experiment::{Failure, RealtimeOptions};
use list::Listing;
use opened::{CHANNELS, Opened};
use serde_json::{Map, Value, json};
use std::collections::{BTreeMap, VecDeque};
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

/// Logs that are kept open; each is some tens of megabytes.
const OPEN: usize = 2;
/// Runs whose curves are remembered.
const CURVES: usize = 8;

/// The runs of a folder.
#[derive(Debug)]
pub(crate) struct Runs {
    folder: PathBuf,
    provenance: BTreeMap<String, String>,
    realtime: RealtimeOptions,
    announce: Announce,
    listing: Mutex<Listing>,
    /// Newest last.
    open: Mutex<VecDeque<Arc<Opened>>>,
    going: Mutex<Option<Arc<Going>>>,
    /// Theory and run of those that were run here, by name; newest last.
    curves: Arc<Mutex<VecDeque<(String, Value)>>>,
}

/// Columns of a log.
pub(crate) struct ShownRun {
    pub(crate) channels: &'static [&'static str],
    pub(crate) columns: Columns,
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
            curves: Arc::default(),
        }
    }

    fn going(&self) -> Option<Arc<Going>> {
        locked(&self.going).clone().filter(|going| !going.is_over())
    }

    /// The runs, newest first.
    ///
    /// # Errors
    /// A folder that cannot be read; one that there is not is empty.
    pub(crate) fn list(&self) -> Result<Value, Failure> {
        let going = self.going();
        let name = going.as_ref().map(|going| going.name());
        let runs = locked(&self.listing).list(&self.folder, name)?;
        Ok(json!({"runs": runs}))
    }

    /// Metadata and events of a log.
    ///
    /// # Errors
    /// A log that there is not, or that cannot be read.
    pub(crate) fn open(&self, name: &str) -> Result<Value, Failure> {
        let opened = self.opened(name)?;
        let mut answer = opened.answer();
        let curves = locked(&self.curves);
        let found = curves.iter().find(|(of, _)| of == name);
        answer["curves"] = found.map_or(Value::Null, |(_, curves)| curves.clone());
        Ok(answer)
    }

    fn opened(&self, name: &str) -> Result<Arc<Opened>, Failure> {
        let (path, seen) = locked(&self.listing).find(&self.folder, name)?;
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

    /// Columns of a log, or of the run that goes on; `span` says of which ticks, of so many at this sample time.
    ///
    /// # Errors
    /// A log that there is not, or that cannot be read; those of the span.
    pub(crate) fn columns(
        &self,
        name: &str,
        span: impl Fn(u64, f64) -> Result<Span, Failure>,
    ) -> Result<ShownRun, Failure> {
        if let Some(going) = self.going().filter(|going| going.name() == name) {
            let pyramid = locked(going.pyramid());
            let sample_time_s = going.sample_time_s();
            let span = span(pyramid.made().max(1), sample_time_s)?;
            return Ok(ShownRun {
                channels: &CHANNELS,
                columns: pyramid.columns(span),
                sample_time_s,
            });
        }
        let opened = self.opened(name)?;
        let span = span(opened.pyramid.made().max(1), opened.sample_time_s)?;
        Ok(ShownRun {
            channels: &CHANNELS,
            columns: opened.pyramid.columns(span),
            sample_time_s: opened.sample_time_s,
        })
    }

    /// The forms of the experiments.
    pub(crate) fn forms(&self) -> Value {
        forms::forms()
    }

    /// Starts an experiment in a thread.
    ///
    /// # Errors
    /// Parameters that are refused, with the reason; a run that goes on; a folder that cannot be made.
    pub(crate) fn start(
        &self,
        kind: &str,
        parameters: &Map<String, Value>,
        realtime: bool,
    ) -> Result<Value, Failure> {
        let experiment = experiment::parse(kind, parameters)?;
        let mut slot = locked(&self.going);
        if let Some(going) = slot.as_ref().filter(|going| !going.is_over()) {
            return Err(Failure::bad_input(format_args!(
                "{} goes on: wait for its end, or stop it",
                going.name()
            )));
        }
        let realtime = realtime.then_some(self.realtime);
        let job = experiment::Job::new(kind, experiment, realtime, &self.folder, &self.provenance)?;
        let (name, samples) = (job.name().to_owned(), job.samples());
        let curves = Arc::clone(&self.curves);
        let keep = move |name: &str, value: Value| {
            let mut curves = locked(&curves);
            curves.push_back((name.to_owned(), value));
            while curves.len() > CURVES {
                curves.pop_front();
            }
        };
        *slot = Some(Going::start(job, self.announce.clone(), keep));
        Ok(json!({"name": name, "samples": samples}))
    }

    /// Ends the run that goes on, force ramped to zero.
    pub(crate) fn stop(&self) {
        if let Some(going) = self.going() {
            going.stop();
        }
    }

    /// Ends the run that goes on, and waits for it.
    pub(crate) fn end(&self) {
        let going = locked(&self.going).take();
        if let Some(going) = going {
            going.end();
        }
    }
}
