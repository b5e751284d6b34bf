//! The page's part of a loop: it computes the ghosts, and puts all into the pyramid and the log.

use super::compare::Comparison;
use crate::Announce;
use crate::folder::next_folder;
use haptic_answer::feel::ghost::{Company, GhostLaws};
use haptic_answer::feel::{CHANNELS, FeelState};
use haptic_answer::pyramid::Pyramid;
use haptic_experiment::Failure;
use haptic_experiment::live::{Finished, Recording, Ticked, Watch, locked};
use haptic_loop::realtime::Durations;
use haptic_loop::realtime::Moment;
use haptic_loop::units::Seconds;
use haptic_run::RealtimeOptions;
use serde_json::json;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// Time between looks at the ring: four a frame.
pub(super) const LOOK: Duration = Duration::from_millis(4);
/// Time between two counts of percentiles.
const COUNTED: Duration = Duration::from_millis(100);

#[derive(Debug)]
pub(super) enum KeeperTask {
    Ghosts(Box<GhostLaws>),
    /// Begin a log with these metadata; the answer is its name.
    Record(BTreeMap<String, String>, Sender<Result<String, Failure>>),
    EndRecord(Sender<Result<Finished, Failure>>),
    Mark(String),
}

/// Data that the keeper shares with those who watch.
#[derive(Debug)]
pub(crate) struct Kept {
    pub(crate) pyramid: Mutex<Pyramid>,
    pub(crate) state: Mutex<FeelState>,
    /// The comparison that goes on, or the last one.
    pub(crate) comparison: Mutex<Option<Comparison>>,
}

/// Services of the server that a loop needs.
#[derive(Clone, Debug)]
pub(crate) struct FeelPlace {
    pub(crate) kept: Arc<Kept>,
    pub(crate) runs: PathBuf,
    pub(crate) provenance: Arc<BTreeMap<String, String>>,
    pub(crate) announce: Announce,
    pub(crate) realtime: RealtimeOptions,
}

/// The page's part of a loop.
pub(super) struct Watching {
    pub(super) place: FeelPlace,
    pub(super) work: Work,
    /// Rows for the pyramid since the last look.
    rows: Vec<[f32; CHANNELS.len()]>,
}

pub(super) struct Work {
    company: Company,
    recording: Option<Recording>,
    took_ns: Durations,
    late_ns: Durations,
    counted: Moment,
}

impl Watching {
    pub(super) const fn new(place: FeelPlace, work: Work) -> Self {
        Self {
            place,
            work,
            rows: Vec::new(),
        }
    }
}

impl Watch for Watching {
    type Task = KeeperTask;

    /// Lost ticks become NaN, so that rows and ticks go together.
    fn lost(&mut self, ticks: u64) {
        let rows = self.rows.len() + ticks as usize;
        self.rows.resize(rows, [f32::NAN; CHANNELS.len()]);
    }

    fn end(&mut self) {
        if let Some(recording) = self.work.recording.take() {
            closed(&self.place, &recording.finish());
        }
        if let Some(comparison) = locked(&self.place.kept.comparison).as_mut()
            && let Some(result) = comparison.end()
        {
            closed(&self.place, &result);
        }
        locked(&self.place.kept.state).recording = None;
    }

    fn task(&mut self, task: KeeperTask) {
        let work = &mut self.work;
        match task {
            KeeperTask::Ghosts(laws) => {
                let pyramid = locked(&self.place.kept.pyramid);
                work.company.draw(*laws, &pyramid);
            }
            KeeperTask::Record(metadata, answer) => {
                let result = match &work.recording {
                    Some(recording) => Ok(recording.name.clone()),
                    None => next_folder(&self.place.runs, "feel", &self.place.provenance)
                        .and_then(|(request, name)| Recording::start(&request, name, metadata))
                        .map(|new| work.recording.insert(new).name.clone()),
                };
                // The page that asked may have gone.
                let _ = answer.send(result);
            }
            KeeperTask::EndRecord(answer) => {
                let result = match work.recording.take() {
                    Some(recording) => recording.finish(),
                    None => Err(Failure::bad_input("nothing is being recorded")),
                };
                let _ = answer.send(result);
            }
            KeeperTask::Mark(text) => {
                let (tick, time_s) = (work.company.state.tick, work.company.state.time_s);
                if let Some(recording) = &mut work.recording {
                    recording.event(time_s, "mark", text.clone());
                }
                let mark = json!({"tick": tick, "time_s": time_s, "text": text});
                self.place.announce.say(&json!({"mark": mark}));
            }
        }
    }

    fn take(&mut self, ticked: &Ticked) {
        let work = &mut self.work;
        let sample = &ticked.sample;
        let was_well = work.company.state.fault.is_none();
        let row = work.company.take(ticked);
        let time_s = sample.reading.time_s;
        if was_well && let Some(fault) = sample.fault {
            self.place.announce.notice(format!("stopped: {fault}"));
            if let Some(recording) = &mut work.recording {
                recording.event(time_s, "fault", fault.to_string());
            }
        }
        work.took_ns.record(ticked.around.took_ns);
        work.late_ns.record(ticked.around.late_ns);
        if let Some(recording) = &mut work.recording
            && !recording.tick(ticked, work.company.state.energy_j)
            && let Some(recording) = work.recording.take()
        {
            closed(&self.place, &recording.finish());
        }
        let mut comparison = locked(&self.place.kept.comparison);
        let ended = comparison
            .as_mut()
            .and_then(|comparison| comparison.tick(ticked, work.company.state.energy_j));
        drop(comparison);
        if let Some(ended) = ended {
            closed(&self.place, &ended);
        }
        self.rows.push(row);
    }

    fn keep(&mut self) {
        let work = &mut self.work;
        {
            let mut pyramid = locked(&self.place.kept.pyramid);
            for row in self.rows.drain(..) {
                pyramid.push(&row);
            }
            work.company.settle(&pyramid);
        }
        let recording = work.recording.as_ref();
        work.company.state.recording = recording.map(|recording| recording.name.clone());
        work.company.state.recorded = recording.map_or(0, |recording| recording.samples);
        if work.counted.elapsed() >= COUNTED {
            work.count();
        }
        locked(&self.place.kept.state).clone_from(&work.company.state);
    }
}

/// Reports a recording that ended without a request.
fn closed(place: &FeelPlace, result: &Result<Finished, Failure>) {
    let text = match result {
        Ok(finished) => format!("recorded {}: {} samples", finished.name, finished.samples),
        Err(error) => format!("the recording has ended: {error}"),
    };
    place.announce.notice(text);
}

impl Work {
    pub(super) fn new(sample_time: Seconds) -> Self {
        Self {
            company: Company::new(sample_time),
            recording: None,
            took_ns: Durations::default(),
            late_ns: Durations::default(),
            counted: Moment::now(),
        }
    }

    fn count(&mut self) {
        self.counted = Moment::now();
        let us = |times: &Durations, share| times.quantile(share) as f64 * 1e-3;
        self.company.state.tick_p50_us = us(&self.took_ns, 0.5);
        self.company.state.tick_p999_us = us(&self.took_ns, 0.999);
        self.company.state.tick_max_us = self.took_ns.max() as f64 * 1e-3;
        self.company.state.late_p50_us = us(&self.late_ns, 0.5);
        self.company.state.late_p999_us = us(&self.late_ns, 0.999);
    }
}
