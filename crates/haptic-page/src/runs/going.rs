//! The run that goes on: its thread, its samples for those who watch, its end.

use super::experiment::{Finished, Job};
use super::opened::{push, pyramid};
use crate::Announce;
use crate::feel::locked;
use crate::pyramid::Pyramid;
use haptic_experiment::{Failure, Supervisor};
use haptic_log::live::{Live, LiveStreams};
use haptic_log::record::{EventMessage, TickMessage, VectorTick};
use serde_json::{Value, json};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Time between two words on how far a run is.
const PROGRESS: Duration = Duration::from_millis(100);

/// A run in a thread.
#[derive(Debug)]
pub(super) struct Going {
    name: String,
    sample_time_s: f64,
    pyramid: Arc<Mutex<Pyramid>>,
    stop: AtomicBool,
    over: AtomicBool,
    thread: Mutex<Option<JoinHandle<()>>>,
}

/// A watcher that puts the samples where views find them.
#[derive(Debug)]
struct Watcher(Arc<Mutex<Pyramid>>);

impl Live for Watcher {
    fn tick(&mut self, message: &TickMessage) {
        // A gap that cannot be drawn is not drawn; the log has it.
        let _ = push(&mut locked(&self.0), message);
    }

    // The page draws one axis; the log has them all.
    fn vector_tick(&mut self, _: &VectorTick) {}

    fn event(&mut self, _: &EventMessage) {}

    fn finish(self: Box<Self>) -> Option<String> {
        None
    }
}

impl Going {
    /// Starts it. `keep` takes its curves.
    pub(super) fn start(
        job: Job,
        announce: Announce,
        keep: impl FnOnce(&str, Value) + Send + 'static,
    ) -> Arc<Self> {
        let going = Arc::new(Self {
            name: job.name().to_owned(),
            sample_time_s: job.sample_time_s(),
            pyramid: Arc::new(Mutex::new(pyramid(job.samples()))),
            stop: AtomicBool::new(false),
            over: AtomicBool::new(false),
            thread: Mutex::default(),
        });
        let own = Arc::clone(&going);
        let thread = std::thread::spawn(move || own.run(&job, &announce, keep));
        *locked(&going.thread) = Some(thread);
        going
    }

    fn run(&self, job: &Job, announce: &Announce, keep: impl FnOnce(&str, Value)) {
        let say = |state: &str, more: Value| {
            let mut run = json!({
                "name": job.name(),
                "kind": job.kind(),
                "state": state,
                "samples": job.samples(),
            });
            if let (Some(all), Value::Object(more)) = (run.as_object_mut(), more) {
                all.extend(more);
            }
            announce.say(&json!({"run": run}));
        };
        let said = Mutex::new(None::<Instant>);
        let progress = |done: u64| {
            let mut said = locked(&said);
            if said.is_none_or(|then| then.elapsed() >= PROGRESS) {
                *said = Some(Instant::now());
                say("running", json!({"samples_done": done}));
            }
        };
        let warn = |text: &str| announce.notice(text.to_owned());
        let live = LiveStreams::new(vec![Box::new(Watcher(Arc::clone(&self.pyramid)))]);
        let supervisor = Supervisor {
            stop: &self.stop,
            progress: &progress,
            live: None,
            warn: &warn,
        };
        let result = job.run(supervisor.watched(&live));
        self.over.store(true, Ordering::Relaxed);
        match result {
            Ok(result) => {
                let Finished {
                    report,
                    curves,
                    verdict,
                    ended_early,
                } = result;
                keep(job.name(), curves);
                let state = match &ended_early {
                    None => "done",
                    Some(_) if self.stop.load(Ordering::Relaxed) => "stopped",
                    Some(_) => "failed",
                };
                let more = json!({
                    "samples_done": report["samples"],
                    "verdict": verdict,
                    "error": ended_early,
                    "report": report,
                });
                say(state, more);
            }
            Err(error) => self.failed(&error, announce, say),
        }
    }

    fn failed(&self, error: &Failure, announce: &Announce, say: impl Fn(&str, Value)) {
        announce.notice(format!("{}: {error}", self.name));
        say("failed", json!({"error": error.to_string()}));
    }

    pub(super) fn name(&self) -> &str {
        &self.name
    }

    pub(super) const fn sample_time_s(&self) -> f64 {
        self.sample_time_s
    }

    pub(super) fn pyramid(&self) -> &Mutex<Pyramid> {
        &self.pyramid
    }

    /// True if its log is whole, or there is none.
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
            // A panic in it is a defect that its own message has told.
            let _ = thread.join();
        }
    }
}
