//! Keeps the log and those who watch off the tick: a thread that owns them, behind a ring.
//!
//! The ring is lock-free, so whoever ticks never waits for the writer, nor wakes it: the writer looks for itself,
//! each millisecond when the ring is empty.

use super::{
    budget::{Budget, TickParts},
    fault_recorder::{FaultRecorder, FaultSeen, RunOfFault},
};
use crate::folder::fault_log_of;
use haptic_log::{
    live::Live,
    record::{BUDGET, FinishedLog, RecordError, RollingLog, StartTime, remove_earlier},
};
use haptic_message::{EventMessage, TickMessage};
use rtrb::{Consumer, Producer, PushError, RingBuffer};
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    thread::JoinHandle,
    time::Duration,
};

/// Samples that wait in the queue at most: at 1 kHz, 8 s of a stalled disk.
const QUEUE: usize = 8192;

/// Sleep of the writer when the ring is empty.
const IDLE: Duration = Duration::from_millis(1);
/// Sleep of a loop in virtual time when the ring is full.
const FULL: Duration = Duration::from_micros(200);

/// Writes a log from another thread, as the run goes.
#[derive(Debug)]
pub struct Recorder {
    queue: Producer<Entry>,
    /// `None` beside another, whose writer it shares.
    writer: Option<JoinHandle<Result<Recorded, RecordError>>>,
    /// A full queue waits (virtual time) or drops and counts (real time).
    waits: bool,
    dropped: u64,
    flight: FaultRecorder,
    path: PathBuf,
    fault_log: PathBuf,
    overwrite: bool,
    /// Metadata of the run, for the log of a fault.
    experiment: BTreeMap<String, String>,
    started: Option<StartTime>,
}

#[derive(Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "nearly all are ticks, and whoever ticks allocates nothing"
)]
enum Entry {
    Started(StartTime),
    Tick(TickMessage, Option<TickParts>),
    Event(EventMessage),
    Metadata(String, BTreeMap<String, String>),
    /// Those of a second device, from now on.
    Drive(Consumer<Entry>),
}

/// Results of [`Recorder::finish`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recorded {
    /// Files of the log, closed.
    pub log: FinishedLog,
    /// The log of a fault, if one latched.
    pub fault_log: Option<PathBuf>,
    /// One sentence for each loss of a live stream, and one if the log of a fault is missing.
    pub warnings: Vec<String>,
}

/// The writer has ended early; [`Recorder::finish`] says why.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stopped;

impl Recorder {
    /// Starts the log with its metadata. With `waits` a full queue waits, else it drops and counts;
    /// with `overwrite` the finished log may replace another. A file of `roll_bytes` is followed by another.
    /// Samples and events go to `live` too.
    ///
    /// # Errors
    /// If the file exists or cannot be made.
    pub fn start(
        path: &Path,
        metadata: BTreeMap<String, String>,
        waits: bool,
        overwrite: bool,
        roll_bytes: Option<u64>,
        live: Vec<Box<dyn Live>>,
    ) -> Result<Self, RecordError> {
        let mut log = RollingLog::create(path, metadata.clone(), overwrite)?;
        roll_bytes.into_iter().for_each(|full| log.roll_at(full));
        let (queue, entries) = RingBuffer::new(QUEUE);
        let writer = std::thread::spawn(move || write(log, live, entries));
        Ok(Self {
            queue,
            writer: Some(writer),
            waits,
            dropped: 0,
            flight: FaultRecorder::default(),
            path: path.to_owned(),
            fault_log: fault_log_of(path),
            overwrite,
            experiment: metadata,
            started: None,
        })
    }

    /// A recorder for a second device, the drive of the first, that writes into the same log; it has a log of its faults of its own.
    /// Its [`finish`](Self::finish) comes first, and knows of no log.
    pub(crate) fn second(&mut self) -> Self {
        let (queue, entries) = RingBuffer::new(QUEUE);
        // A writer that has ended is seen by whoever pushes.
        let _ = self.push_waiting(Entry::Drive(entries));
        let drive = self.path.with_extension("drive");
        let drive = drive.to_string_lossy().replace('.', "-");
        Self {
            queue,
            writer: None,
            waits: self.waits,
            dropped: 0,
            flight: FaultRecorder::default(),
            path: self.path.clone(),
            fault_log: fault_log_of(Path::new(&drive)),
            overwrite: self.overwrite,
            experiment: self.experiment.clone(),
            started: None,
        }
    }

    /// Sets the start time of the log: call it when the first tick is due. Without it the log has
    /// device times only.
    ///
    /// # Errors
    /// If the writer has ended.
    pub fn starts_at(&mut self, start: StartTime) -> Result<(), Stopped> {
        self.started = Some(start);
        self.push_waiting(Entry::Started(start))
    }

    /// Hands over a sample.
    ///
    /// # Errors
    /// If the writer has ended, as on a full disk.
    pub fn tick(&mut self, tick: &TickMessage) -> Result<(), Stopped> {
        self.ticked(tick, None)
    }

    /// Hands over a sample with the durations of the tick's parts.
    pub(crate) fn ticked(
        &mut self,
        tick: &TickMessage,
        parts: Option<TickParts>,
    ) -> Result<(), Stopped> {
        self.flight.tick(tick);
        self.send(Entry::Tick(*tick, parts))
    }

    /// Hands over an event.
    ///
    /// # Errors
    /// If the writer has ended.
    pub fn event(&mut self, time_s: f64, kind: &str, text: String) -> Result<(), Stopped> {
        self.tell(EventMessage {
            time_s,
            kind: kind.to_owned(),
            text,
        })
    }

    /// Hands over an event that is written already.
    pub(crate) fn tell(&mut self, event: EventMessage) -> Result<(), Stopped> {
        self.send(Entry::Event(event))
    }

    /// A fault has latched: from here on the flight recorder takes what follows it.
    pub(crate) fn fault(&mut self, fault: FaultSeen) {
        self.flight.latch(fault);
    }

    /// Recorder of the ticks around a fault.
    pub(crate) const fn flight(&self) -> &FaultRecorder {
        &self.flight
    }

    /// True if what follows a fault has been kept too, or there was no fault.
    pub fn has_aftermath(&self) -> bool {
        self.flight.fault().is_none() || self.flight.is_full()
    }

    /// Adds to it what a device's own recorder kept.
    pub(crate) fn fill_fault_recorder(&mut self, kept: impl IntoIterator<Item = TickMessage>) {
        self.flight.fill(kept);
    }

    /// Hands over metadata; a failure to write the log is reported when it is closed.
    pub fn metadata(&mut self, name: &str, values: BTreeMap<String, String>) {
        let _ = self.push_waiting(Entry::Metadata(name.to_owned(), values));
    }

    fn send(&mut self, entry: Entry) -> Result<(), Stopped> {
        if self.waits {
            return self.push_waiting(entry);
        }
        if self.queue.is_abandoned() {
            return Err(Stopped);
        }
        if self.queue.push(entry).is_err() {
            self.dropped += 1;
        }
        Ok(())
    }

    fn push_waiting(&mut self, mut entry: Entry) -> Result<(), Stopped> {
        loop {
            if self.queue.is_abandoned() {
                return Err(Stopped);
            }
            match self.queue.push(entry) {
                Ok(()) => return Ok(()),
                Err(PushError::Full(back)) => entry = back,
            }
            std::thread::sleep(FULL);
        }
    }

    /// Samples and events that found the queue full and are not in the log.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Waits until all is written, the log is closed and the live streams have ended. After a fault
    /// it writes the flight recorder too, even if the log failed.
    ///
    /// # Errors
    /// The error that stopped the writer, such as a full disk.
    pub fn finish(self) -> Result<Recorded, RecordError> {
        drop(self.queue);
        let result = match self.writer.map(JoinHandle::join) {
            Some(Ok(result)) => result,
            // A panic in the writer is a defect; let it be seen as one.
            Some(Err(panic)) => std::panic::resume_unwind(panic),
            None => Ok(Recorded {
                log: FinishedLog {
                    path: self.path.clone(),
                    paths: Vec::new(),
                    samples: 0,
                    bytes: 0,
                },
                fault_log: None,
                warnings: Vec::new(),
            }),
        };
        let path = self.fault_log;
        let (mut fault_log, mut unwritten) = (None, None);
        if self.flight.fault().is_some() {
            let run = RunOfFault {
                log: &self.path,
                experiment: self.experiment,
                started: self.started,
            };
            let written = self.flight.write(&path, self.overwrite, run);
            match written {
                Ok(()) => fault_log = Some(path),
                Err(error) => {
                    unwritten = Some(format!("the log of the fault was not written: {error}"));
                }
            }
        } else if self.overwrite {
            // That of an earlier run would pass for one of this.
            remove_earlier(&path);
        }
        let mut recorded = result?;
        recorded.fault_log = fault_log;
        recorded.warnings.extend(unwritten);
        Ok(recorded)
    }
}

/// Writes what comes of both devices, or of the only one, in turn.
fn write(
    mut log: RollingLog,
    mut live: Vec<Box<dyn Live>>,
    mut entries: Consumer<Entry>,
) -> Result<Recorded, RecordError> {
    let mut budget = Budget::new();
    let mut drive: Option<Consumer<Entry>> = None;
    loop {
        // Asked before the rings are: what is pushed until they are abandoned is popped.
        let abandoned = entries.is_abandoned() && drive.as_ref().is_none_or(Consumer::is_abandoned);
        let driven = drive.as_mut().and_then(|drive| drive.pop().ok());
        let is_idle = driven.is_none();
        match driven {
            Some(Entry::Tick(tick, _)) => log.drive_tick(&tick)?,
            Some(Entry::Event(message)) => log.event(&EventMessage {
                text: format!("drive: {}", message.text),
                ..message
            })?,
            Some(Entry::Metadata(name, values)) => log.metadata(&name, values)?,
            // Dated by the first.
            Some(Entry::Started(_) | Entry::Drive(_)) | None => {}
        }
        let Ok(entry) = entries.pop() else {
            if abandoned && is_idle {
                break;
            }
            if is_idle {
                std::thread::sleep(IDLE);
            }
            continue;
        };
        match entry {
            Entry::Started(start) => log.starts_at(start)?,
            Entry::Metadata(name, values) => log.metadata(&name, values)?,
            Entry::Drive(entries) => drive = Some(entries),
            Entry::Tick(tick, parts) => {
                log.tick(&tick)?;
                if let Some(parts) = parts
                    && let Some(values) = budget.take(parts, tick.time_s)
                {
                    log.metadata(BUDGET, values)?;
                }
                live.iter_mut().for_each(|live| live.tick(&tick));
            }
            Entry::Event(message) => {
                log.event(&message)?;
                live.iter_mut().for_each(|live| live.event(&message));
            }
        }
    }
    let log = log.finish()?;
    let warnings = live.into_iter().filter_map(|live| live.finish()).collect();
    Ok(Recorded {
        log,
        fault_log: None,
        warnings,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::{
        path::Path,
        sync::mpsc::{Receiver, Sender, channel},
    };
    use testkit::Folder;

    /// A viewer that holds the writer up: it says when it has the first sample, and goes on when it is told to.
    #[derive(Debug)]
    struct Gate {
        arrived: Sender<()>,
        open: Receiver<()>,
    }

    impl Live for Gate {
        fn tick(&mut self, message: &TickMessage) {
            if message.tick == 0 {
                self.arrived.send(()).expect("somebody waits");
                // Goes on, too, when nobody holds the gate any more.
                let _ = self.open.recv();
            }
        }

        fn event(&mut self, _: &EventMessage) {}

        fn finish(self: Box<Self>) -> Option<String> {
            None
        }
    }

    fn sample(tick: u64) -> TickMessage {
        TickMessage {
            tick,
            time_s: 1e-3 * tick as f64,
            ..TickMessage::at_rest(1)
        }
    }

    /// A recorder that stands still at the first sample, which `Receiver` tells, until the `Sender` is dropped.
    fn gated(folder: &Path, waits: bool) -> (Recorder, Receiver<()>, Sender<()>) {
        let ((arrived, arrival), (open, gate)) = (channel(), channel());
        let gate = Gate {
            arrived,
            open: gate,
        };
        let log = folder.join("log.mcap");
        let live: Vec<Box<dyn Live>> = vec![Box::new(gate)];
        let recorder = Recorder::start(&log, BTreeMap::new(), waits, false, None, live);
        (recorder.expect("starts"), arrival, open)
    }

    #[test]
    fn a_full_ring_drops_and_counts_in_real_time_and_never_waits() {
        let folder = Folder::empty();
        let (mut recorder, arrival, open) = gated(&folder, false);
        recorder.tick(&sample(0)).expect("records");
        arrival.recv().expect("arrives");
        // The writer takes nothing now: the ring holds its size, the rest is dropped.
        for tick in 1..=QUEUE as u64 + 5 {
            recorder.tick(&sample(tick)).expect("records");
        }
        assert_eq!(recorder.dropped(), 5);
        drop(open);
        let recorded = recorder.finish().expect("finishes");
        assert_eq!(recorded.log.samples, 1 + QUEUE as u64);
    }

    #[test]
    fn a_full_ring_waits_in_virtual_time_and_keeps_everything() {
        let folder = Folder::empty();
        let (mut recorder, arrival, open) = gated(&folder, true);
        let opener = std::thread::spawn(move || {
            arrival.recv().expect("arrives");
            // Long enough for the ring to fill.
            std::thread::sleep(Duration::from_millis(50));
            drop(open);
        });
        let samples = 3 * QUEUE as u64;
        for tick in 0..samples {
            recorder.tick(&sample(tick)).expect("records");
        }
        assert_eq!(recorder.dropped(), 0);
        let recorded = recorder.finish().expect("finishes");
        assert_eq!(recorded.log.samples, samples);
        opener.join().expect("no panic");
    }
}
