//! Conducts a run of any world, in virtual time or by the clock: the order of tick, log, end and stop stands here.
//!
//! ```text
//! tick ─▶ log ─▶ did it end? ─▶ count it, or not ─▶ stop        until the samples are done and the force is zero
//! ```
//! A tick after which the world does not go on, by a fault or a silence, does not count; one in which somebody asked to
//! stop does.

use crate::{
    budget::TickParts,
    fault_recorder::FaultSeen,
    folder::{FolderRequest, OutputFolder},
    ran::Ran,
    realtime::RealtimeSummary,
    record::RunRecord,
    recorder::{Recorded, Recorder, Stopped},
    schedule::{Pace, Schedule},
    supervisor::Supervisor,
};
use haptic_document::{
    Failure,
    parameters::{REALTIME, SAMPLE_TIME},
};
use haptic_log::{live::LiveStreams, record::StartTime};
use haptic_loop::{
    Fault,
    realtime::{Moment, Periodic},
};
use haptic_message::END;
use haptic_trial::{
    ending::{Ending, Lateness},
    simulate::World,
    tick::{KeptSample, TickRecord},
};
use std::{collections::BTreeMap, sync::atomic::Ordering, time::SystemTime};

/// Makes the folder and the log in it, runs a world, and closes the log.
///
/// # Errors
/// If a file cannot be made or written, or the clock cannot keep the sample time.
pub fn run_logged<W: World<D>, const D: usize>(
    world: &mut W,
    schedule: Schedule,
    of_folder: (&FolderRequest, BTreeMap<String, String>),
    supervisor: Supervisor<'_>,
) -> Result<Ran, Failure> {
    run_beside(world, schedule, of_folder, supervisor, |_, _| ())
}

/// Runs a world as [`run_logged`] does; `begins` gets the folder, for what else the world leaves.
///
/// # Errors
/// As [`run_logged`].
pub fn run_beside<W: World<D>, const D: usize>(
    world: &mut W,
    schedule: Schedule,
    (request, metadata): (&FolderRequest, BTreeMap<String, String>),
    supervisor: Supervisor<'_>,
    begins: impl FnOnce(&mut W, &OutputFolder),
) -> Result<Ran, Failure> {
    schedule.clock().map_err(|error| {
        Failure::input_with_advice(
            error,
            format_args!("give a {SAMPLE_TIME} within it, or omit {REALTIME}"),
        )
    })?;
    let folder = request.prepare()?;
    let waits = schedule.pace == Pace::Virtual;
    let mut recorder = recorder(request, &folder, metadata, waits, supervisor)?;
    begins(world, &folder);
    let record = run(world, schedule, &mut recorder, supervisor)?;
    let recorded = close(recorder, &record, world.is_at_rest())?;
    Ok(Ran::of(record, recorded, folder))
}

/// Starts the log of a run; without one no folder is left. With `waits` a full queue waits.
///
/// # Errors
/// If its file cannot be made.
pub fn recorder(
    request: &FolderRequest,
    folder: &OutputFolder,
    of_run: BTreeMap<String, String>,
    waits: bool,
    supervisor: Supervisor<'_>,
) -> Result<Recorder, Failure> {
    // Facts of the run override what its document asked for.
    let mut metadata = request.provenance.clone();
    metadata.extend(of_run);
    let log = folder.file("mcap");
    // Empty for a second run.
    let live = (supervisor.live).map_or_else(Vec::new, LiveStreams::take);
    let (overwrite, roll_bytes) = (folder.overwrite(), folder.roll_bytes());
    Recorder::start(&log, metadata, waits, overwrite, roll_bytes, live)
        .inspect_err(|_| folder.discard())
        .map_err(Failure::from)
}

/// Closes the log of a run. One that could not be written is the first thing to know, and what became of the force.
///
/// # Errors
/// If the log could not be written whole.
pub fn close(recorder: Recorder, record: &RunRecord, at_rest: bool) -> Result<Recorded, Failure> {
    let stopped = record.ended == Some(Ending::LogStopped);
    recorder.finish().map_err(|error| {
        if !stopped {
            return error.into();
        }
        let force = if at_rest {
            "the run was ended, the force fell to zero"
        } else {
            "the run was ended"
        };
        Failure::data_lost(format_args!("{error}; {force}"))
    })
}

/// Ticks from one report of progress to the next, for the supervisor.
const REPORT: u64 = 1024;

/// Runs a world for a number of samples. Ends early, with the force ramped to zero, when asked, when the world
/// does not go on, or when the recorder has ended.
fn run<W: World<D>, const D: usize>(
    world: &mut W,
    schedule: Schedule,
    recorder: &mut Recorder,
    supervisor: Supervisor<'_>,
) -> Result<RunRecord, Failure> {
    let mut record = RunRecord::with_room_for(schedule.samples);
    // Its thread is raised until the end of this function: what others run has been started.
    let clock = schedule.clock().map_err(Failure::run)?;
    let mut periodic = clock.map(Periodic::new).transpose().map_err(Failure::run)?;
    let (mut tick, mut planned) = (0, schedule.samples);
    // A run that was ended continues until the force is zero, past its last sample if need be.
    while tick < planned || record.ended.is_some() {
        let cycle = periodic.as_mut().map(Periodic::wait);
        if tick == 0 {
            // A recorder that has ended is seen at the tick.
            let _ = recorder.starts_at(StartTime::at(SystemTime::now()));
        }
        let before = Moment::now();
        let mut message = world.tick();
        record.sensor.take_off(message.logged_mut());
        let compute_ns = before.elapsed().as_nanos() as u64;
        record.tick_ns.record(compute_ns);
        let parts = cycle.map(|cycle| TickParts {
            lateness_ns: cycle.lateness.as_nanos() as u64,
            compute_ns,
        });
        let mut logged = recorder.ticked(message.logged(), parts);
        if let Some(event) = world.event() {
            logged = logged.and(recorder.tell(event));
        }
        tick += 1;
        if world.is_over() {
            planned = tick;
        }
        if record.ended.is_some() {
            record.push_after(&message);
            if world.is_at_rest() && recorder.has_aftermath() {
                break;
            }
            continue;
        }
        let asked = || supervisor.stop.load(Ordering::Relaxed);
        let ended = match logged {
            Err(Stopped) => Some(Ending::LogStopped),
            Ok(()) => (world.ended()).or_else(|| asked().then_some(Ending::Interrupted)),
        };
        if matches!(ended, None | Some(Ending::Interrupted)) {
            record.push(&message);
            world.counted();
        } else {
            record.push_after(&message);
        }
        if let Some(ended) = ended {
            let KeptSample { tick, time_s, .. } = message.kept();
            tell_end(recorder, ended, None, (tick, time_s), time_s);
            record.ended = Some(ended);
            world.stop();
        }
        if tick % REPORT == 0 {
            (supervisor.progress)(tick);
        }
    }
    if let Some(periodic) = periodic {
        note_periodic(periodic, &mut record, recorder);
    }
    (supervisor.progress)(tick);
    record.dropped = recorder.dropped();
    recorder.metadata(END, record.end(planned, tick).metadata());
    Ok(record)
}

/// Records in the log and the fault recorder why a run ends: `at` is the tick of the fault and its time, s, `event_s` that of the
/// event, which is never before what is logged.
pub fn tell_end(
    recorder: &mut Recorder,
    ended: Ending,
    lateness: Option<Lateness>,
    at: (u64, f64),
    event_s: f64,
) {
    let (tick, time_s) = at;
    if let Some(code) = ended.fault_code() {
        let known = Fault::from_code(code).map(|fault| fault.to_string());
        recorder.fault(FaultSeen {
            code,
            text: known.unwrap_or_else(|| format!("fault {code}")),
            tick,
            time_s,
        });
    }
    // A recorder that has ended is seen when it is closed.
    let _ = recorder.event(event_s, ended.kind(), ended.reason(lateness));
}

/// Writes what the clock says of the run into record and log.
pub fn note_periodic(periodic: Periodic, record: &mut RunRecord, recorder: &mut Recorder) {
    let margin = periodic.spin_margin();
    record.raised(periodic.thread());
    let (timing, thread) = periodic.finish();
    let summary = RealtimeSummary::of(&timing, &thread, margin);
    drop(thread);
    record.missed_deadlines = timing.overruns.cycles();
    recorder.metadata("realtime", summary.metadata(&timing));
    record.realtime = Some(summary);
}
