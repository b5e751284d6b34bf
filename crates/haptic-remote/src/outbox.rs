//! Messages that a device sends unasked: samples, events and faults, in the order in which they leave.

use crate::tick::Tick;
use haptic_link::{BATCH_MAX, Batch, Event, EventKind, FaultReport, Field, Refusal, Report};
use heapless::Deque;

/// Samples that wait to be sent at most: 32 ms at 1 kHz, and two batches.
pub const QUEUE_SAMPLES: usize = 32;
/// Notices that wait to be sent at most.
const QUEUE_NOTICES: usize = 8;

/// Choice of the samples to send, and their number in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stream {
    /// Sends every n-th tick; 0 for no ticks.
    pub(super) every: u16,
    /// Samples in a frame.
    pub(super) batch: u8,
}

impl Stream {
    pub(super) const OFF: Self = Self { every: 0, batch: 1 };

    /// As a host asks for it.
    pub(super) fn new(every: u16, batch: u8) -> Result<Self, Refusal> {
        if (1..=BATCH_MAX).contains(&usize::from(batch)) {
            Ok(Self { every, batch })
        } else {
            Err(Refusal::Range {
                field: Field::BatchLength,
                value: f32::from(batch),
                least: 1.0,
                most: BATCH_MAX as f32,
            })
        }
    }

    pub(super) fn takes(self, tick: u32) -> bool {
        self.every > 0 && tick.is_multiple_of(u32::from(self.every))
    }
}

/// A notice: an event or a fault.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Notice {
    Event(Event),
    Fault(FaultReport),
}

/// Samples and notices that wait for the line.
#[derive(Debug)]
pub(super) struct Outbox<const D: usize> {
    samples: Deque<Tick<D>, QUEUE_SAMPLES>,
    notices: Deque<Notice, QUEUE_NOTICES>,
}

impl<const D: usize> Outbox<D> {
    /// Empty.
    pub(super) const fn new() -> Self {
        Self {
            samples: Deque::new(),
            notices: Deque::new(),
        }
    }

    /// Takes a sample; false if there is no room.
    pub(super) fn take(&mut self, sample: Tick<D>) -> bool {
        self.samples.push_back(sample).is_ok()
    }

    pub(super) fn forget_samples(&mut self) {
        self.samples.clear();
    }

    /// Takes a notice. Without room the oldest goes: the newest say what the state is now.
    #[inline(never)]
    pub(super) fn notify(&mut self, notice: Notice) {
        if self.notices.is_full() {
            self.notices.pop_front();
        }
        // There is room now.
        let _ = self.notices.push_back(notice);
    }

    /// The next thing to say: faults, then samples, then what happened after them. `more` says that
    /// samples of the stream are still to come, so that a batch waits until it is full.
    pub(super) fn next(&mut self, stream: Stream, more: bool) -> Option<Report> {
        match self.notices.front() {
            // The samples of a run go out before the event of its end.
            Some(Notice::Event(event)) if self.samples.is_empty() || begins(event.kind) => {
                let report = Report::Event(*event);
                self.notices.pop_front();
                Some(report)
            }
            Some(Notice::Fault(fault)) => {
                let report = Report::Fault(*fault);
                self.notices.pop_front();
                Some(report)
            }
            _ => self.next_samples(stream, more),
        }
    }

    #[inline(never)]
    fn next_samples(&mut self, stream: Stream, more: bool) -> Option<Report> {
        let every = stream.every.max(1);
        let most = usize::from(stream.batch).min(Batch::ticks_most(D));
        if most <= 1 {
            return (self.samples.pop_front()).map(|tick| Report::Sample(tick.sample()));
        }
        if self.samples.len() < most && more {
            return None;
        }
        let first = self.samples.pop_front()?;
        let mut batch = Batch {
            tick: first.tick,
            time_us: first.time_us,
            every,
            axes: D as u8,
            items: heapless::Vec::new(),
        };
        let mut next = Some(first);
        let mut tick = first.tick;
        while let Some(sample) = next {
            sample.add_to(&mut batch.items);
            tick = tick.wrapping_add(u32::from(every));
            next = match self.samples.front() {
                // A gap, where samples were dropped, ends a batch.
                Some(sample) if batch.items.len() < most * D && sample.tick == tick => {
                    self.samples.pop_front()
                }
                _ => None,
            };
        }
        Some(Report::Batch(batch))
    }
}

/// An event that comes before the samples in the queue.
const fn begins(kind: EventKind) -> bool {
    matches!(kind, EventKind::Started)
}
