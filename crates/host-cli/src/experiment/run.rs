//! Runs the loop against the simulated rig, in virtual or real time, and hands every sample on.

use super::recorder::{Recorder, Stopped};
use super::sensed::Sensed;
use crate::record::TickMessage;
use fracdiff::Real;
use haptic_loop::plant::IndentationRig;
use haptic_loop::{Controller, Environment, Fault};
use hdrhistogram::Histogram;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// How time passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// As fast as the machine goes.
    Virtual,
    /// One tick each sample time, by the clock.
    Realtime,
}

/// Who watches a run: may stop it, and hears how far it is.
#[derive(Clone, Copy)]
pub struct Supervisor<'a> {
    /// Set to stop the run: the force ramps to zero, the log is closed.
    pub stop: &'a AtomicBool,
    /// Called now and then with the samples done.
    pub progress: &'a dyn Fn(u64),
}

impl std::fmt::Debug for Supervisor<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Supervisor")
            .field("stop", self.stop)
            .finish_non_exhaustive()
    }
}

/// What a run left in memory, up to where it ended; everything else is in the log.
#[derive(Debug)]
pub struct Record {
    /// Time of each sample, s.
    pub time_s: Vec<f64>,
    /// Position of the renderer as the loop read it, m.
    pub position_m: Vec<f64>,
    /// Force on the device as commanded, N.
    pub force_n: Vec<f64>,
    /// Time that each tick took, ns, the simulated rig included.
    pub tick_ns: Histogram<u64>,
    /// Ticks that began more than one sample time late; 0 in virtual time.
    pub missed_deadlines: u64,
    /// Samples and events that the recorder had to drop.
    pub dropped: u64,
    /// Samples in which a limiter of the safety chain acted.
    pub limited: u64,
    /// Why the run ended before its time, if it did.
    pub ended: Option<Ended>,
}

/// Why a run ended before its time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// Somebody asked for it.
    Interrupted,
    /// The safety chain latched a fault.
    Fault(Fault),
    /// The log could not be written.
    LogStopped,
}

/// How many ticks, how long each, and how they pass.
#[derive(Clone, Copy, Debug)]
pub struct Schedule {
    /// Ticks, the one at time 0 included.
    pub samples: u64,
    /// T, s.
    pub sample_time_s: f64,
    /// How time passes.
    pub pace: Pace,
}

/// Runs a controller for a number of samples. Ends early, with the force ramped to zero, when
/// asked, on a fault, or when the recorder has ended.
///
/// # Errors
/// More samples than the machine can address, or a tick of more than 584 years.
pub fn run<F, E>(
    controller: &mut Controller<F, 1, E>,
    device: &mut Sensed<IndentationRig>,
    schedule: Schedule,
    recorder: &mut Recorder,
    supervisor: Supervisor<'_>,
) -> anyhow::Result<Record>
where
    F: Real,
    E: Environment<F, 1>,
{
    /// How often the supervisor is asked, in ticks.
    const REPORT: u64 = 1024;
    let capacity = usize::try_from(schedule.samples)?;
    let mut record = Record {
        time_s: Vec::with_capacity(capacity),
        position_m: Vec::with_capacity(capacity),
        force_n: Vec::with_capacity(capacity),
        // 1 ns to 10 s, three digits.
        tick_ns: Histogram::new_with_bounds(1, 10_000_000_000, 3)?,
        missed_deadlines: 0,
        dropped: 0,
        limited: 0,
        ended: None,
    };
    let start = Instant::now();
    let mut tick = 0;
    while tick < schedule.samples {
        if schedule.pace == Pace::Realtime {
            let due = Duration::from_secs_f64(tick as f64 * schedule.sample_time_s);
            let late = wait_until(start + due);
            record.missed_deadlines += u64::from(late.as_secs_f64() > schedule.sample_time_s);
        }
        // What the rig's own instruments show at the start of the tick.
        let mut message = observe(device.device());
        let before = Instant::now();
        let sample = match controller.tick(device) {
            Ok(sample) => sample,
            Err(never) => match never {},
        };
        let took = u64::try_from(before.elapsed().as_nanos())?;
        record.tick_ns.saturating_record(took.max(1));

        message.tick = sample.reading.tick;
        message.time_s = sample.reading.time_s;
        message.position_m = sample.reading.position_m[0].to_f64();
        message.environment_force_n = sample.environment_force_n[0].to_f64();
        message.force_n = sample.force.newtons()[0].to_f64();
        message.limiters = sample.limiters.bits();
        let time_s = message.time_s;
        let logged = recorder.tick(message);
        tick += 1;
        if record.ended.is_some() {
            // The force is on its way to zero: in the log, but no part of the result.
            if controller.safety().is_at_rest() {
                break;
            }
            continue;
        }
        if let Err(Stopped) = logged {
            record.ended = Some(Ended::LogStopped);
        } else if let Some(fault) = controller.safety().fault() {
            record.ended = Some(Ended::Fault(fault));
            // A recorder that has ended is seen when it is closed.
            let _ = recorder.event(time_s, "fault", fault.to_string());
        } else {
            record.limited += u64::from(message.limiters != 0);
            record.time_s.push(message.time_s);
            record.position_m.push(message.position_m);
            record.force_n.push(message.force_n);
            if supervisor.stop.load(Ordering::Relaxed) {
                record.ended = Some(Ended::Interrupted);
                let _ = recorder.event(time_s, "interrupted", "stop was asked for".to_owned());
            }
        }
        if record.ended.is_some() {
            controller.stop();
        }
        if tick % REPORT == 0 {
            (supervisor.progress)(tick);
        }
    }
    (supervisor.progress)(tick);
    record.dropped = recorder.dropped();
    Ok(record)
}

fn observe(rig: &IndentationRig) -> TickMessage {
    TickMessage {
        // A force drive has no position to follow.
        reference_m: rig.reference().unwrap_or_else(|| rig.indenter_position()),
        indenter_position_m: rig.indenter_position(),
        contact_force_n: rig.contact_force(),
        ..TickMessage::default()
    }
}

/// Sleeps until the deadline and says how late it is then.
fn wait_until(deadline: Instant) -> Duration {
    let now = Instant::now();
    if deadline > now {
        std::thread::sleep(deadline - now);
    }
    Instant::now().saturating_duration_since(deadline)
}
