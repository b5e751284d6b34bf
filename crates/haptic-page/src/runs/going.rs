//! The run in progress: its thread, its samples for those who watch, its end.

use super::opened::push;
use crate::Announce;
use haptic_answer::channels::Channels;
use haptic_answer::pyramid::Pyramid;
use haptic_experiment::Failure;
use haptic_experiment::live::locked;
use haptic_log::live::{Live, LiveStreams};
use haptic_loop::realtime::Moment;
use haptic_message::{EventMessage, TickMessage};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::Duration;

/// Progress of a piece of work, in its steps; called in any thread.
pub(super) type Progress<'a> = &'a (dyn Fn(u64) + Sync);

/// Callbacks of a piece of work.
#[derive(Clone, Copy)]
pub(super) struct Attendant<'a> {
    pub(super) stop: &'a Arc<AtomicBool>,
    pub(super) progress: Progress<'a>,
    /// Hears a sentence for people.
    pub(super) warn: &'a (dyn Fn(&str) + Sync),
    /// See the samples of an experiment.
    pub(super) live: &'a LiveStreams,
}

/// Channels drawn of a run while it goes.
#[derive(Clone, Debug)]
pub(super) struct Drawn {
    pub(super) channels: Channels,
    pub(super) sample_time_s: f64,
    /// The record `experiment` of its log, as far as it is known before.
    pub(super) metadata: BTreeMap<String, String>,
}

pub(super) struct Finished {
    pub(super) report: Value,
    pub(super) curves: Value,
    pub(super) verdict: Option<String>,
    pub(super) ended_early: Option<String>,
}

/// Closure that does a piece of work.
type Run = dyn FnOnce(Attendant<'_>) -> Result<Finished, Failure> + Send;

/// An experiment, which is drawn while it goes, or a question, which is answered at its end.
pub(super) struct Work {
    pub(super) kind: String,
    /// Name as in the list of runs.
    pub(super) name: String,
    /// Samples of an experiment, steps of a question.
    pub(super) steps: u64,
    /// `None` for a question.
    pub(super) drawn: Option<Drawn>,
    pub(super) run: Box<Run>,
}

/// Time between two words on how far a run is.
const PROGRESS: Duration = Duration::from_millis(100);

/// A run or question in a thread.
#[derive(Debug)]
pub(super) struct Going {
    name: String,
    kind: String,
    steps: u64,
    /// Its samples so far; `None` for a question.
    pub(super) watched: Option<Watched>,
    stop: Arc<AtomicBool>,
    over: AtomicBool,
    thread: Mutex<Option<JoinHandle<()>>>,
}

/// The samples of a run so far, and what is known of it before its end.
#[derive(Debug)]
pub(super) struct Watched {
    pub(super) drawn: Drawn,
    pub(super) pyramid: Arc<Mutex<Pyramid>>,
}

/// A watcher that puts the samples where views find them.
#[derive(Debug)]
struct Watcher {
    channels: Channels,
    pyramid: Arc<Mutex<Pyramid>>,
}

impl Live for Watcher {
    fn tick(&mut self, message: &TickMessage) {
        // A gap that cannot be drawn is not drawn; the log has it.
        let _ = push(&mut locked(&self.pyramid), &self.channels, message);
    }

    fn event(&mut self, _: &EventMessage) {}

    fn finish(self: Box<Self>) -> Option<String> {
        None
    }
}

impl Watched {
    fn of(drawn: Drawn, samples: u64) -> Self {
        Self {
            pyramid: Arc::new(Mutex::new(drawn.channels.pyramid(samples))),
            drawn,
        }
    }

    fn watcher(&self) -> Box<dyn Live> {
        Box::new(Watcher {
            channels: self.drawn.channels.clone(),
            pyramid: Arc::clone(&self.pyramid),
        })
    }
}

impl Going {
    /// Starts it. `keep` takes its curves.
    pub(super) fn start(
        work: Work,
        announce: Announce,
        keep: impl FnOnce(&str, Value) + Send + 'static,
    ) -> Arc<Self> {
        let (drawn, run) = (work.drawn, work.run);
        let going = Arc::new(Self {
            name: work.name,
            kind: work.kind,
            steps: work.steps,
            watched: drawn.map(|drawn| Watched::of(drawn, work.steps)),
            stop: Arc::default(),
            over: AtomicBool::new(false),
            thread: Mutex::default(),
        });
        let running = Arc::clone(&going);
        let thread = std::thread::spawn(move || running.run(run, &announce, keep));
        *locked(&going.thread) = Some(thread);
        going
    }

    fn run(
        &self,
        work: impl FnOnce(Attendant<'_>) -> Result<Finished, Failure>,
        announce: &Announce,
        keep: impl FnOnce(&str, Value),
    ) {
        let say = |state: &str, more: Value| {
            let mut run = json!({
                "name": self.name,
                "kind": self.kind,
                "state": state,
                "samples": self.steps,
            });
            if let (Some(all), Value::Object(more)) = (run.as_object_mut(), more) {
                all.extend(more);
            }
            announce.say(&json!({"run": run}));
        };
        let latest = Mutex::new(None::<Moment>);
        let progress = |done: u64| {
            let mut latest = locked(&latest);
            if latest.is_none_or(|then| then.elapsed() >= PROGRESS) {
                *latest = Some(Moment::now());
                say("running", json!({"samples_done": done}));
            }
        };
        let warn = |text: &str| announce.notice(text.to_owned());
        let watcher = self.watched.as_ref().map(Watched::watcher);
        let live = LiveStreams::new(watcher.into_iter().collect());
        let result = work(Attendant {
            stop: &self.stop,
            progress: &progress,
            warn: &warn,
            live: &live,
        });
        self.over.store(true, Ordering::Relaxed);
        match result {
            Ok(finished) => {
                let (state, more) = self.end_of(finished, keep);
                say(state, more);
            }
            // Work that was stopped before it had a result has not failed.
            Err(error) if self.is_stopped() => {
                say("stopped", json!({"error": error.to_string()}));
            }
            Err(error) => {
                announce.notice(format!("{}: {error}", self.name));
                say("failed", json!({"error": error.to_string()}));
            }
        }
    }

    fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// The last word of a run.
    fn end_of(&self, finished: Finished, keep: impl FnOnce(&str, Value)) -> (&'static str, Value) {
        keep(&self.name, finished.curves);
        let state = match &finished.ended_early {
            None => "done",
            Some(_) if self.is_stopped() => "stopped",
            Some(_) => "failed",
        };
        let more = json!({
            // A question has steps, not samples.
            "samples_done": finished.report.get("samples").cloned().unwrap_or(self.steps.into()),
            "verdict": finished.verdict,
            "error": finished.ended_early,
            "report": finished.report,
        });
        (state, more)
    }

    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// The answer to `runs.open` while it goes: its samples are those that are planned.
    pub(super) fn answer(&self) -> Value {
        let Some(Watched { drawn, .. }) = &self.watched else {
            return json!({"name": self.name, "kind": self.kind, "running": true});
        };
        json!({
            "name": self.name,
            "channels": drawn.channels.names(),
            "axes": drawn.channels.axes,
            "samples": self.steps,
            "sample_time_s": drawn.sample_time_s,
            "first_s": 0.0,
            "last_s": self.steps.saturating_sub(1) as f64 * drawn.sample_time_s,
            "complete": false,
            "running": true,
            "damage": [],
            "missing_samples": 0,
            "metadata": {"experiment": drawn.metadata},
            "events": [],
        })
    }

    /// True if its log is whole, or it has no log.
    pub(super) fn is_over(&self) -> bool {
        self.over.load(Ordering::Relaxed)
    }

    /// The force ramps to zero, the log is closed.
    pub(super) fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// Stops, and waits for the end.
    pub(super) fn end(&self) {
        self.stop();
        let thread = locked(&self.thread).take();
        if let Some(thread) = thread {
            // A panic in it is a defect that its own message has reported.
            let _ = thread.join();
        }
    }
}
