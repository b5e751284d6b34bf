//! A device that has answered, on an open port: what it is, what both ends have counted.

use super::served::Served;
use super::shared::{Command, Heard, Shared, lock};
use super::trouble::{BoardTrouble, TroubleCause};
use crate::impossible::Plausible;
use crate::{HostCounters, LinkError};
use haptic_link::{AXES_MAX, Capabilities, Hello, Report, Sample, Status};
use haptic_loop::Fault;
use haptic_loop::realtime::{self, raise_thread};
use hdrhistogram::Histogram;
use std::collections::VecDeque;
use std::string::String;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, SyncSender};
use std::thread::JoinHandle;
use std::vec::Vec;

/// Counters of a link.
#[derive(Clone, Debug)]
pub struct LinkReport {
    /// Of the host's end.
    pub host: HostCounters,
    /// Samples that found the queue full.
    pub samples_dropped: u64,
    /// Forces that found the queue full.
    pub forces_dropped: u64,
    /// Forces that were not sent because a newer sample had come already.
    pub forces_skipped: u64,
    /// From sending a keep-alive to hearing the answer, µs; empty if none was heard.
    pub round_trip_us: Histogram<u64>,
}

/// A device that has answered, on an open port.
///
/// ```no_run
/// use haptic_link::{EventKind, Start};
/// use haptic_remote::serial::{ConnectOptions, Heard, SerialLink};
/// use std::time::Duration;
///
/// let mut link = SerialLink::connect("/dev/ttyACM0", ConnectOptions::default())?;
/// println!("{}", link.capabilities().board());
/// link.arm(Duration::from_millis(100))?;
/// link.start(Start { ticks: 1000, ..Start::ENDLESS })?;
/// while let Some(heard) = link.hear(Duration::from_secs(1)) {
///     match heard {
///         Heard::Sample(sample) => println!("{:?}", sample.axes),
///         Heard::Event(event) if event.kind == EventKind::Finished => break,
///         Heard::Fault(_) | Heard::Over(_) => break,
///         Heard::Event(_) => {}
///     }
/// }
/// link.disarm()?;
/// # Ok::<(), haptic_remote::serial::SerialError>(())
/// ```
#[derive(Debug)]
pub struct SerialLink {
    pub(super) shared: Arc<Shared>,
    pub(super) commands: Option<SyncSender<Command>>,
    pub(super) answers: Receiver<Result<Report, LinkError>>,
    pub(super) heard: Receiver<Heard>,
    pub(super) threads: Vec<JoinHandle<()>>,
    pub(super) hello: Hello,
    pub(super) capabilities: Capabilities,
    pub(super) latency_ms: Option<u32>,
    pub(super) path: String,
    pub(super) baud: u32,
    /// Heard before its turn, to see whether a newer sample waits.
    pub(super) ahead: Option<Heard>,
    /// A run that was started and whose end was not heard yet, as of the alive of this number.
    pub(super) running: Option<u64>,
    /// The sample that a host loop read last.
    pub(super) newest: Sample,
    /// Looks at each sample of a run.
    pub(super) plausible: Plausible,
    /// The one that cannot be, which ended the run.
    pub(super) impossible: Option<Sample>,
    /// The bits of the last forces of a host loop, as many as a device lets pass for one in time.
    pub(super) newest_answers: VecDeque<[u32; AXES_MAX]>,
    /// The device had one of them when it made the newest sample.
    pub(super) follows: bool,
    /// Tick of the last sample heard.
    pub(super) heard_tick: u32,
    /// Tick of the first sample of this run that a fault has shaped before its own frame was heard.
    pub(super) fault_tick: Option<u32>,
    pub(super) forces_skipped: u64,
    /// The other end, if this process serves it. Last, so that it goes when nobody speaks to it any more.
    pub(super) served: Option<Served>,
}

impl SerialLink {
    /// T, s.
    #[must_use]
    pub fn period_s(&self) -> f64 {
        f64::from(self.period_us()) * 1e-6
    }

    pub(super) fn period_us(&self) -> u32 {
        self.shared.period_us.load(Ordering::Relaxed)
    }

    pub(super) fn ticks_every(&self, period_us: u32) {
        self.shared.period_us.store(period_us, Ordering::Relaxed);
    }

    /// Raises the threads that read and write to a real-time priority, so that keep-alives are sent on a busy machine.
    ///
    /// # Errors
    /// The system does not allow the priority. A thread that was not raised goes on as it was.
    pub fn raise(&self, priority: u8) -> Result<(), realtime::Refusal> {
        self.threads
            .iter()
            .chain(self.served.iter().filter_map(Served::thread))
            .try_for_each(|thread| raise_thread(thread, priority))
    }

    /// True for a device that this process [serves](Served): its board has no watchdog that hears this link.
    #[must_use]
    pub const fn is_served(&self) -> bool {
        self.served.is_some()
    }

    /// Words of a served device about its last fault: a code says less than the board that failed knows.
    #[must_use]
    pub fn trouble(&self) -> Option<BoardTrouble> {
        self.served.as_ref().and_then(Served::trouble)
    }

    /// Words of a served device that failed because nothing comes from its board any more. Its own line, to the thread that
    /// serves it, works as before.
    #[must_use]
    pub fn lost_board(&self) -> Option<String> {
        if self.status().fault != Fault::BoardFailed.code() {
            return None;
        }
        let lost = (self.trouble()).filter(|trouble| trouble.cause == TroubleCause::Gone)?;
        Some(lost.words)
    }

    /// Answer of the device to the first greeting.
    #[must_use]
    pub const fn hello(&self) -> &Hello {
        &self.hello
    }

    /// Name and abilities of the device.
    #[must_use]
    pub const fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    /// State and fault, as of the last keep-alive, event or fault.
    #[must_use]
    pub fn status(&self) -> Status {
        *lock(&self.shared.status)
    }

    /// Energy that the device's passivity guard has observed up to the last keep-alive, J; 0 without a guard.
    #[must_use]
    pub fn observed_energy_j(&self) -> f32 {
        f32::from_bits(self.shared.energy_bits.load(Ordering::Relaxed))
    }

    /// The sample that a host loop read last; one without axes before the first.
    #[must_use]
    pub const fn newest(&self) -> &Sample {
        &self.newest
    }

    /// The sample that cannot be, with its flaw, if there was one.
    #[must_use]
    pub const fn impossible(&self) -> Option<&Sample> {
        self.impossible.as_ref()
    }

    /// True if the device had one of the last ten forces of a host loop ([`max_age_ticks`](haptic_link::Limits::max_age_ticks) by default)
    /// when it made the newest sample. Where it is false they came later than that or were lost, and the device went on with an older one.
    #[must_use]
    pub const fn follows(&self) -> bool {
        self.follows
    }

    /// Tick of the first sample of this run that a fault of the device has shaped whose own frame was lost: that comes before the sample.
    /// `None` in any other run.
    #[must_use]
    pub const fn fault_tick(&self) -> Option<u32> {
        self.fault_tick
    }

    /// The speed at which the device answered, bits per second.
    #[must_use]
    pub const fn baud(&self) -> u32 {
        self.baud
    }

    /// The device, as on the command line.
    #[must_use]
    pub fn name(&self) -> String {
        match &self.served {
            Some(_) => self.path.clone(),
            None => std::format!("serial:{}", self.path),
        }
    }

    /// The port; of a device that this process serves, its name.
    #[must_use]
    pub fn path(&self) -> &str {
        &self.path
    }

    /// Time for which the USB adapter holds bytes back, ms; `None` if it is not known.
    #[must_use]
    pub const fn latency_ms(&self) -> Option<u32> {
        self.latency_ms
    }

    pub(super) fn alives(&self) -> u64 {
        self.shared.alives.load(Ordering::Acquire)
    }

    /// All counters of this end.
    #[must_use]
    pub fn report(&self) -> LinkReport {
        LinkReport {
            host: self.shared.conversation().counters(),
            samples_dropped: self.shared.samples_dropped.load(Ordering::Relaxed),
            forces_dropped: self.shared.forces_dropped.load(Ordering::Relaxed),
            forces_skipped: self.forces_skipped,
            round_trip_us: lock(&self.shared.round_trip_us).clone(),
        }
    }
}

impl Drop for SerialLink {
    fn drop(&mut self) {
        // Best effort: a device that does not hear it trips its own watchdog.
        if !self.shared.over.load(Ordering::Relaxed) {
            let _ = self.disarm();
        }
        self.shared.over.store(true, Ordering::Relaxed);
        self.commands = None;
        for thread in self.threads.drain(..) {
            // A panic in there has been printed; there is nothing left to save.
            let _ = thread.join();
        }
    }
}
