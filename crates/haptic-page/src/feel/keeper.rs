//! The page's part of a loop: it computes the ghosts, and puts all into the pyramid and the log.

use super::compare::Comparison;
use crate::Announce;
use crate::folder::next_folder;
use crate::pyramid::Pyramid;
use haptic_experiment::Failure;
use haptic_experiment::live::{
    FadingFelt, FadingHistory, Felt, Finished, Law, Recording, Ticked, Watch, fading, locked,
};
use haptic_loop::realtime::Durations;
use haptic_loop::realtime::Moment;
use haptic_loop::units::Seconds;
use haptic_loop::{Environment, Fault};
use haptic_run::RealtimeOptions;
use nalgebra::Vector1;
use serde::Serialize;
use serde_json::json;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex};
use std::time::Duration;

pub(crate) const CHANNELS: [&str; 7] = [
    "position_m",
    "hand_m",
    "force_n",
    "ghost_short_n",
    "ghost_a3_n",
    "energy_j",
    "limiter",
];
/// Place of the position among them.
pub(super) const POSITION: usize = 0;

/// Time between looks at the ring: four a frame.
pub(super) const LOOK: Duration = Duration::from_millis(4);
/// Time between two counts of percentiles.
const COUNTED: Duration = Duration::from_millis(100);

#[derive(Debug)]
pub(super) enum KeeperTask {
    Ghosts(Box<[Option<Law<Felt>>; 2]>),
    /// Begin a log with these metadata; the answer is its name.
    Record(BTreeMap<String, String>, Sender<Result<String, Failure>>),
    EndRecord(Sender<Result<Finished, Failure>>),
    Mark(String),
}

/// The newest of the loop, as `status` reports it.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(crate) struct FeelState {
    pub(crate) sample_time_s: f64,
    tick: u64,
    time_s: f64,
    position_m: f64,
    force_n: f64,
    energy_j: f64,
    pub(crate) limiter: u8,
    #[serde(skip)]
    pub(crate) fault: Option<Fault>,
    #[serde(rename = "stopped")]
    pub(crate) stopping: bool,
    late: u64,
    skipped: u64,
    tick_p50_us: f64,
    tick_p999_us: f64,
    tick_max_us: f64,
    late_p50_us: f64,
    late_p999_us: f64,
    recording: Option<String>,
    recorded: u64,
}

impl FeelState {
    /// State of a loop before its first tick.
    pub(crate) fn of(sample_time: Seconds) -> Self {
        Self {
            sample_time_s: sample_time.0,
            ..Self::default()
        }
    }
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

/// The force that another operator would have made of the same motion. It acts on nothing.
#[derive(Debug)]
struct Ghosting {
    law: FadingFelt,
    history: FadingHistory<<Felt as Environment<f64, 1>>::History>,
    /// Comes when the last change is over.
    pending: Option<Law<Felt>>,
}

impl Ghosting {
    /// Ghost of a law, after what it has missed.
    fn new(mut ready: Law<Felt>, pyramid: &Pyramid, sample_time_s: f64) -> Self {
        let mut law = fading(&ready.environment, Seconds(sample_time_s));
        let mut history = law.at_rest();
        hear_missed(&mut ready, pyramid);
        law.replace(&mut history, &mut ready);
        Self {
            law,
            history,
            pending: None,
        }
    }

    fn forget(&mut self) {
        self.history = self.law.at_rest();
        self.pending = None;
    }

    fn settle(&mut self, pyramid: &Pyramid) {
        if self.history.is_settled()
            && let Some(mut ready) = self.pending.take()
        {
            hear_missed(&mut ready, pyramid);
            self.law.change(&mut self.history, &mut ready);
        }
    }

    /// Force at a position, N, which it then has heard.
    fn force(&mut self, position_m: f64) -> f64 {
        let x = Vector1::new(position_m);
        let force = self.law.wanted(&self.history, &x);
        self.law.advance(&mut self.history, &x);
        force
    }
}

fn hear_missed(law: &mut Law<Felt>, pyramid: &Pyramid) {
    let mut missed = Vec::new();
    let first = pyramid.samples_from(law.next, POSITION, &mut missed);
    law.hear_from(first, missed.into_iter().map(f64::from));
}

/// The page's part of a loop.
pub(super) struct Watching {
    pub(super) place: FeelPlace,
    pub(super) work: Work,
    /// Rows for the pyramid since the last look.
    rows: Vec<[f32; CHANNELS.len()]>,
}

pub(super) struct Work {
    ghosts: [Option<Ghosting>; 2],
    recording: Option<Recording>,
    state: FeelState,
    before: Option<(f64, f64)>,
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
            KeeperTask::Ghosts(ready) => {
                let pyramid = locked(&self.place.kept.pyramid);
                for (ghost, ready) in work.ghosts.iter_mut().zip(*ready) {
                    match (ghost.as_mut(), ready) {
                        (Some(ghost), Some(ready)) => ghost.pending = Some(ready),
                        (_, ready) => {
                            *ghost = ready.map(|ready| {
                                Ghosting::new(ready, &pyramid, work.state.sample_time_s)
                            });
                        }
                    }
                }
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
                let (tick, time_s) = (work.state.tick, work.state.time_s);
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
        let (tick, time_s) = (sample.reading.tick, sample.reading.time_s);
        let (position_m, force_n) = (sample.reading.position_m[0], sample.force.newtons()[0]);
        let limiters = sample.limiters.bits();
        if ticked.fresh {
            work.ghosts.iter_mut().flatten().for_each(Ghosting::forget);
            work.before = None;
            work.state.energy_j = 0.0;
        }
        if let Some((before_m, before_n)) = work.before {
            work.state.energy_j += before_n * (position_m - before_m);
        }
        work.before = Some((position_m, force_n));
        let ghosts = work.ghosts.each_mut().map(|ghost| {
            let force = ghost.as_mut().map(|ghost| ghost.force(position_m));
            force.unwrap_or(f64::NAN)
        });
        if work.state.fault.is_none()
            && let Some(fault) = sample.fault
        {
            self.place.announce.notice(format!("stopped: {fault}"));
            if let Some(recording) = &mut work.recording {
                recording.event(time_s, "fault", fault.to_string());
            }
        }
        if ticked.around.skipped > 0 {
            work.state.late += 1;
            work.state.skipped += ticked.around.skipped;
        }
        work.took_ns.record(ticked.around.took_ns);
        work.late_ns.record(ticked.around.late_ns);
        let state = &mut work.state;
        (state.tick, state.time_s) = (tick, time_s);
        (state.position_m, state.force_n) = (position_m, force_n);
        (state.limiter, state.fault) = (limiters, sample.fault);
        state.stopping = ticked.stopping;
        if let Some(recording) = &mut work.recording
            && !recording.tick(ticked, work.state.energy_j)
            && let Some(recording) = work.recording.take()
        {
            closed(&self.place, &recording.finish());
        }
        let mut comparison = locked(&self.place.kept.comparison);
        let ended = comparison
            .as_mut()
            .and_then(|comparison| comparison.tick(ticked, work.state.energy_j));
        drop(comparison);
        if let Some(ended) = ended {
            closed(&self.place, &ended);
        }
        let row = [
            position_m,
            ticked.around.hand_m,
            force_n,
            ghosts[0],
            ghosts[1],
            work.state.energy_j,
            f64::from(limiters),
        ];
        self.rows.push(row.map(|number| number as f32));
    }

    fn keep(&mut self) {
        let work = &mut self.work;
        {
            let mut pyramid = locked(&self.place.kept.pyramid);
            for row in self.rows.drain(..) {
                pyramid.push(&row);
            }
            for ghost in work.ghosts.iter_mut().flatten() {
                ghost.settle(&pyramid);
            }
        }
        let recording = work.recording.as_ref();
        work.state.recording = recording.map(|recording| recording.name.clone());
        work.state.recorded = recording.map_or(0, |recording| recording.samples);
        if work.counted.elapsed() >= COUNTED {
            work.count();
        }
        locked(&self.place.kept.state).clone_from(&work.state);
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
    pub(super) fn new(sample_time: Seconds) -> Result<Self, Failure> {
        Ok(Self {
            ghosts: [None, None],
            recording: None,
            state: FeelState::of(sample_time),
            before: None,
            took_ns: Durations::default(),
            late_ns: Durations::default(),
            counted: Moment::now(),
        })
    }

    fn count(&mut self) {
        self.counted = Moment::now();
        let us = |times: &Durations, share| times.quantile(share) as f64 * 1e-3;
        self.state.tick_p50_us = us(&self.took_ns, 0.5);
        self.state.tick_p999_us = us(&self.took_ns, 0.999);
        self.state.tick_max_us = self.took_ns.max() as f64 * 1e-3;
        self.state.late_p50_us = us(&self.late_ns, 0.5);
        self.state.late_p999_us = us(&self.late_ns, 0.999);
    }
}
