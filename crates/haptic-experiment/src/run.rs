//! Runs the loop against a simulated device, in virtual or real time, and hands every sample on.

use super::budget::TickParts;
use super::ended::Ended;
use super::flight::FaultSeen;
use super::kept::{KeptSample, Record, TickRecord as _};
use super::preflight::PreflightVerdict;
use super::realtime::RealtimeSummary;
use super::recorder::{Recorded, Recorder, Stopped};
use super::schedule::{Pace, Schedule};
use super::simulate::Instrumented;
use crate::device::Warn;
use crate::failure::Failure;
use crate::folder::{FolderRequest, OutputFolder};
use crate::parameters::{REALTIME, SAMPLE_TIME};
use fracdiff::Real;
use haptic_log::live::{Live, LiveStreams};
use haptic_log::record::{AnyTick, END, FinishedLog, StartTime};
use haptic_loop::plant::Sensed;
use haptic_loop::realtime::{Cycle, Periodic};
use haptic_loop::{Controller, Device, Engaged, Environment, SafetyState};
use std::collections::BTreeMap;
use std::convert::Infallible;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Instant, SystemTime};

/// Watcher of a run: may stop it, hears how far it is, and sees the samples.
#[derive(Clone, Copy)]
pub struct Supervisor<'a> {
    /// Set to stop the run: the force ramps to zero, the log is closed.
    pub stop: &'a AtomicBool,
    /// Called now and then with the samples done.
    pub progress: &'a dyn Fn(u64),
    /// Streams that show the run while it goes; the first run takes them.
    pub live: Option<&'a LiveStreams>,
    /// Hears what a user should know before the run is over.
    pub warn: Warn<'a>,
}

impl<'a> Supervisor<'a> {
    /// With streams that show the run.
    #[must_use]
    pub const fn watched(mut self, live: &'a LiveStreams) -> Self {
        self.live = Some(live);
        self
    }

    /// The streams; none for a second run.
    pub(super) fn live_streams(&self) -> Vec<Box<dyn Live>> {
        self.live.map(LiveStreams::take).unwrap_or_default()
    }
}

impl std::fmt::Debug for Supervisor<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Supervisor")
            .field("stop", self.stop)
            .finish_non_exhaustive()
    }
}

/// Results of a run.
#[derive(Debug)]
pub struct Ran {
    /// The samples.
    pub record: Record,
    /// The log.
    pub log: FinishedLog,
    /// Folder of the log.
    pub folder: OutputFolder,
    /// The log of a fault, if one latched.
    pub fault_log: Option<PathBuf>,
    /// Findings of the pre-flight; `None` if it was skipped.
    pub preflight: Option<PreflightVerdict>,
    /// Losses of live streams, a sentence each.
    pub live_warnings: Vec<String>,
}

/// Makes the folder and the log in it, runs a controller, and closes the log.
///
/// # Errors
/// A folder or log that cannot be written; what [`run`] refuses.
pub(crate) fn run_logged<F, E, V, const D: usize>(
    controller: &mut Controller<F, D, E>,
    device: &mut Sensed<V>,
    schedule: Schedule,
    (request, mut metadata): (&FolderRequest, BTreeMap<String, String>),
    supervisor: Supervisor<'_>,
) -> Result<Ran, Failure>
where
    F: Real,
    E: Environment<F, D>,
    V: Device<F, D, Error = Infallible> + Instrumented<D>,
{
    schedule.clock().map_err(|error| {
        Failure::input_with_advice(
            error,
            format_args!("give a {SAMPLE_TIME} within it, or leave {REALTIME} away"),
        )
    })?;
    metadata.extend(request.provenance.clone());
    let folder = request.prepare()?;
    let waits = schedule.pace == Pace::Virtual;
    let log = folder.file("mcap");
    let live = supervisor.live_streams();
    let started = Recorder::start(&log, metadata, waits, folder.overwrite(), live);
    let mut recorder = started.inspect_err(|_| folder.discard())?;
    recorder.roll_at(folder.roll_bytes());
    let record =
        run(controller, device, schedule, &mut recorder, supervisor).map_err(Failure::Run)?;
    let at_rest = controller.safety().is_at_rest();
    let Recorded {
        log,
        fault_log,
        warnings,
    } = close(recorder, &record, at_rest)?;
    Ok(Ran {
        record,
        log,
        folder,
        fault_log,
        preflight: None,
        live_warnings: warnings,
    })
}

/// Closes the log of a run. One that could not be written is the first thing to know, and what became of the force.
pub(super) fn close(
    recorder: Recorder,
    record: &Record,
    at_rest: bool,
) -> Result<Recorded, Failure> {
    let stopped = record.ended == Some(Ended::LogStopped);
    recorder.finish().map_err(|error| {
        if !stopped {
            return error.into();
        }
        let force = if at_rest {
            "the run was ended, the force fell to zero"
        } else {
            "the run was ended"
        };
        Failure::DataLost(anyhow::anyhow!("{error}; {force}"))
    })
}

/// Fewest and most samples of an experiment: at 1 kHz, eleven days. The disk is full before.
pub(super) const SAMPLES: std::ops::RangeInclusive<f64> = 10.0..=1e9;

/// Ticks from one report of progress to the next, for the supervisor.
pub(crate) const REPORT: u64 = 1024;

/// Runs a controller for a number of samples. Ends early, with the force ramped to zero, when
/// asked, on a fault, or when the recorder has ended.
///
/// # Errors
/// More samples than the machine can address, a tick of more than 584 years, a sample time that no clock keeps.
pub(crate) fn run<F, E, V, const D: usize>(
    controller: &mut Controller<F, D, E>,
    device: &mut Sensed<V>,
    schedule: Schedule,
    recorder: &mut Recorder,
    supervisor: Supervisor<'_>,
) -> anyhow::Result<Record>
where
    F: Real,
    E: Environment<F, D>,
    V: Device<F, D, Error = Infallible> + Instrumented<D>,
{
    let mut record = Record::with_room_for(schedule.samples)?;
    // Its thread is raised until the end of this function: what others run has been started.
    let mut periodic = schedule.clock()?.map(Periodic::new).transpose()?;
    let mut tick = 0;
    // Whatever ends this function, no force stays.
    let mut engaged = controller.engage(device);
    // A run that was ended goes on until the force is zero, past its last sample if need be.
    while tick < schedule.samples || record.ended.is_some() {
        let cycle = periodic.as_mut().map(Periodic::wait);
        if tick == 0 {
            // A recorder that has ended is seen at the tick.
            let _ = recorder.starts_at(StartTime::at(SystemTime::now()));
        }
        let (message, compute_ns) = timed_tick(&mut engaged, &mut record)?;
        let logged = log_tick(recorder, message.logged(), cycle, compute_ns)?;
        tick += 1;
        if record.ended.is_some() {
            record.push_after(&message);
            if engaged.controller().safety().is_at_rest() && recorder.has_aftermath() {
                break;
            }
            continue;
        }
        let safety = engaged.controller().safety();
        record.ended = ended(&message.kept(), logged, safety, recorder, supervisor.stop);
        if matches!(record.ended, None | Some(Ended::Interrupted)) {
            record.push(&message);
        } else {
            record.push_after(&message);
        }
        if record.ended.is_some() {
            engaged.controller_mut().stop();
        }
        if tick % REPORT == 0 {
            (supervisor.progress)(tick);
        }
    }
    if let Some(periodic) = periodic {
        told(periodic, &mut record, recorder);
    }
    (supervisor.progress)(tick);
    record.dropped = recorder.dropped();
    recorder.metadata(END, record.end(schedule.samples, tick).metadata());
    Ok(record)
}

/// Runs a tick, and keeps how long it took, ns.
fn timed_tick<F, E, V, const D: usize>(
    engaged: &mut Engaged<F, D, E, &mut Sensed<V>, &mut Controller<F, D, E>>,
    record: &mut Record,
) -> anyhow::Result<(V::Message, u64)>
where
    F: Real,
    E: Environment<F, D>,
    V: Device<F, D, Error = Infallible> + Instrumented<D>,
{
    let observed = engaged.device().device().observe();
    let before = Instant::now();
    let sample = match engaged.tick() {
        Ok(sample) => sample,
        Err(never) => match never {},
    };
    let took = u64::try_from(before.elapsed().as_nanos())?;
    record.tick_ns.saturating_record(took.max(1));
    let energy_j = engaged.controller().guarded_energy_j();
    Ok((observed.of_loop(&sample, energy_j), took))
}

/// Hands a tick to the recorder; with a clock, with where its time went.
fn log_tick(
    recorder: &mut Recorder,
    tick: AnyTick,
    cycle: Option<Cycle>,
    compute_ns: u64,
) -> anyhow::Result<Result<(), Stopped>> {
    let Some(cycle) = cycle else {
        return Ok(recorder.tick(tick));
    };
    let parts = TickParts {
        lateness_ns: u64::try_from(cycle.lateness.as_nanos())?,
        compute_ns,
    };
    Ok(recorder.timed_tick(tick, parts))
}

/// Why a run is to end with this sample; fault and interruption go into the log.
fn ended<F: Real, const D: usize>(
    sample: &KeptSample,
    logged: Result<(), Stopped>,
    safety: &SafetyState<F, D>,
    recorder: &mut Recorder,
    stop: &AtomicBool,
) -> Option<Ended> {
    let time_s = sample.time_s;
    if let Err(Stopped) = logged {
        return Some(Ended::LogStopped);
    }
    // A recorder that has ended is seen when it is closed.
    if let Some(fault) = safety.fault() {
        recorder.fault(FaultSeen {
            code: fault.code(),
            text: fault.to_string(),
            tick: sample.tick,
            time_s,
        });
        let _ = recorder.event(time_s, "fault", fault.to_string());
        return Some(Ended::Fault(fault));
    }
    stop.load(Ordering::Relaxed).then(|| {
        let _ = recorder.event(time_s, "interrupted", "stop was asked for".to_owned());
        Ended::Interrupted
    })
}

/// Writes what the clock says of the run into record and log.
pub(crate) fn told(periodic: Periodic, record: &mut Record, recorder: &mut Recorder) {
    let margin = periodic.spin_margin();
    record.raised(periodic.thread());
    let (timing, thread) = periodic.finish();
    let summary = RealtimeSummary::of(&timing, &thread, margin);
    drop(thread);
    record.missed_deadlines = timing.overruns().cycles();
    recorder.metadata("realtime", summary.metadata(&timing));
    record.realtime = Some(summary);
}
