//! Records of a device apart from its loop: the samples around a fault, and reports that wait to be sent.

use haptic_link::{
    BATCH_MAX, BatchItem, DeviceReport, Event, EventKind, FaultReport, Field, Flight, Refusal,
    Sample, SampleBatch,
};
use heapless::{Deque, HistoryBuf, Vec};

/// Flight recorder, and reports that wait to be sent: 3.8 KiB with one axis. A [`TickSide`](crate::TickSide) holds or
/// borrows them.
#[derive(Debug, Default)]
pub struct Records<const D: usize = 1> {
    pub(crate) outbox: Outbox<D>,
    pub(crate) flight: FlightRecorder<D>,
}

impl<const D: usize> Records<D> {
    /// Records without samples and notices, for a static.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            outbox: Outbox::new(),
            flight: FlightRecorder::new(),
        }
    }
}

/// Samples that the flight recorder keeps.
pub const FLIGHT_SAMPLES: usize = 96;
/// Number of these that come after the fault.
const AFTER: u16 = 24;

/// Keeps the newest samples until a fault latches and some more have come, then stands still until cleared.
#[derive(Debug, Default)]
pub(super) struct FlightRecorder<const D: usize> {
    samples: HistoryBuf<Tick<D>, FLIGHT_SAMPLES>,
    /// Samples still to be taken: all until a fault latches.
    left: Option<u16>,
}

impl<const D: usize> FlightRecorder<D> {
    pub(super) const fn new() -> Self {
        Self {
            samples: HistoryBuf::new(),
            left: None,
        }
    }

    pub(super) fn take(&mut self, sample: Tick<D>) {
        match &mut self.left {
            None => self.samples.write(sample),
            Some(0) => {}
            Some(left) => {
                *left -= 1;
                self.samples.write(sample);
            }
        }
    }

    pub(super) fn fault(&mut self) {
        self.left = Some(AFTER);
    }

    /// Begins anew: what led to the last fault is no part of what comes.
    pub(super) fn clear(&mut self) {
        self.left = None;
        self.samples.clear();
    }

    /// A sample, 0 the oldest. Samples exist only after a fault has latched.
    pub(super) fn read(&self, index: u16) -> Result<DeviceReport, Refusal> {
        let count = match self.left {
            Some(_) => self.samples.len() as u16,
            None => 0,
        };
        let mut kept = self.samples.oldest_ordered().take(usize::from(count));
        let sample = match kept.nth(usize::from(index)) {
            Some(sample) => *sample,
            None if index == 0 => Tick::NONE,
            None => {
                return Err(Refusal::range(
                    Field::FlightIndex,
                    f32::from(index),
                    0.0,
                    f32::from(count.saturating_sub(1)),
                ));
            }
        };
        Ok(DeviceReport::Flight(Flight {
            index,
            count,
            sample: sample.sample(),
        }))
    }
}

/// Samples that wait to be sent at most: 32 ms at 1 kHz, and two batches.
pub const QUEUE_SAMPLES: usize = 32;
/// Notices that wait to be sent at most.
const QUEUE_NOTICES: usize = 8;

/// Choice of the samples to send, and their number in a frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stream {
    /// Sends every n-th tick; 0 for no ticks.
    pub every: u16,
    pub batch: u8,
}

impl Stream {
    pub(super) const OFF: Self = Self { every: 0, batch: 1 };

    /// Stream that a host asks for.
    pub(super) fn new(every: u16, batch: u8) -> Result<Self, Refusal> {
        if (1..=BATCH_MAX).contains(&usize::from(batch)) {
            Ok(Self { every, batch })
        } else {
            Err(Refusal::range(
                Field::BatchLength,
                f32::from(batch),
                1.0,
                BATCH_MAX as f32,
            ))
        }
    }

    pub(super) fn takes(self, tick: u32) -> bool {
        self.every > 0 && tick.is_multiple_of(u32::from(self.every))
    }
}

#[derive(Debug)]
pub(super) enum Notice {
    Event(Event),
    Fault(FaultReport),
}

#[derive(Debug, Default)]
pub(super) struct Outbox<const D: usize> {
    samples: Deque<Tick<D>, QUEUE_SAMPLES>,
    notices: Deque<Notice, QUEUE_NOTICES>,
}

impl<const D: usize> Outbox<D> {
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

    /// The next thing to say: faults, samples, other events. `more`: samples are still to come, so a batch waits
    /// until it is full.
    pub(super) fn next(&mut self, stream: Stream, more: bool) -> Option<DeviceReport> {
        match self.notices.front() {
            // The samples of a run go out before the event of its end.
            Some(Notice::Event(event)) if self.samples.is_empty() || begins(event.kind) => {
                let report = DeviceReport::Event(*event);
                self.notices.pop_front();
                Some(report)
            }
            Some(Notice::Fault(fault)) => {
                let report = DeviceReport::Fault(*fault);
                self.notices.pop_front();
                Some(report)
            }
            _ => self.next_samples(stream, more),
        }
    }

    #[inline(never)]
    fn next_samples(&mut self, stream: Stream, more: bool) -> Option<DeviceReport> {
        let every = stream.every.max(1);
        let sensed = self.samples.front().is_some_and(Tick::senses);
        let most = usize::from(stream.batch).min(SampleBatch::ticks_most(D, sensed));
        if most <= 1 {
            return (self.samples.pop_front()).map(|tick| DeviceReport::Sample(tick.sample()));
        }
        if self.samples.len() < most && more {
            return None;
        }
        let first = self.samples.pop_front()?;
        let mut batch = SampleBatch {
            tick: first.tick,
            time_us: first.time_us,
            every,
            axes: D as u8,
            items: Vec::new(),
            sensed_force_n: Vec::new(),
        };
        let mut next = Some(first);
        let mut tick = first.tick;
        while let Some(sample) = next {
            sample.add_to(&mut batch.items);
            sample.add_sensed_to(&mut batch.sensed_force_n);
            tick = tick.wrapping_add(u32::from(every));
            next = match self.samples.front() {
                // A gap, where samples were dropped or nothing was sensed, ends a batch.
                Some(sample)
                    if batch.items.len() < most * D
                        && sample.tick == tick
                        && sample.senses() == sensed =>
                {
                    self.samples.pop_front()
                }
                _ => None,
            };
        }
        Some(DeviceReport::Batch(batch))
    }
}

/// An event that comes before the samples in the queue.
const fn begins(kind: EventKind) -> bool {
    matches!(kind, EventKind::Started)
}

/// A tick of a device of D axes: see [`Sample`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tick<const D: usize = 1> {
    /// Number of the tick, from the start of the run, or from power-up before the first.
    pub tick: u32,
    /// The device's own time, µs, modulo 2³².
    pub time_us: u32,
    /// Position on each axis at the start of the tick, m.
    pub position_m: [f32; D],
    /// The force that the environment, or the host, wanted, N.
    pub environment_force_n: [f32; D],
    /// The force that was applied, N.
    pub force_n: [f32; D],
    /// Limiters that acted, bits as in a [`BatchItem`].
    pub limiters: u8,
    /// Flaws of the exchange with a board, bits as in a [`BatchItem`].
    pub flaws: u8,
    /// Force at the sensor of each axis, N; NaN without a sensor.
    pub sensed_force_n: [f32; D],
}

impl<const D: usize> Tick<D> {
    /// All zero, and nothing sensed.
    pub const NONE: Self = Self {
        tick: 0,
        time_us: 0,
        position_m: [0.0; D],
        environment_force_n: [0.0; D],
        force_n: [0.0; D],
        limiters: 0,
        flaws: 0,
        sensed_force_n: [f32::NAN; D],
    };

    /// True if a sensor gave a force on an axis.
    fn senses(&self) -> bool {
        !self.sensed_force_n.iter().all(|force_n| force_n.is_nan())
    }

    /// Sample of a loop, by the device's own number and time.
    #[inline]
    pub(crate) fn of(
        sample: &haptic_loop::LoopSample<f32, D>,
        tick: u32,
        time_us: u32,
        flaws: u8,
        sensed_force_n: [f32; D],
    ) -> Self {
        Self {
            tick,
            time_us,
            position_m: sample.reading.position_m.into(),
            environment_force_n: sample.environment_force_n.into(),
            force_n: (*sample.force.newtons()).into(),
            limiters: sample.limiters.bits(),
            flaws,
            sensed_force_n,
        }
    }

    /// Adds what each axis did in it, as far as there is room.
    fn add_to<const N: usize>(&self, items: &mut Vec<BatchItem, N>) {
        for axis in 0..D {
            let _ = items.push(BatchItem {
                position_m: self.position_m[axis],
                environment_force_n: self.environment_force_n[axis],
                force_n: self.force_n[axis],
                limiters: self.limiters,
                flaws: self.flaws,
            });
        }
    }

    /// Adds what the sensors showed, of which there is nothing without one.
    fn add_sensed_to<const N: usize>(&self, forces: &mut Vec<f32, N>) {
        if self.senses() {
            // Batches and samples have room for all axes.
            let _ = forces.extend_from_slice(&self.sensed_force_n);
        }
    }

    pub(crate) fn sample(&self) -> Sample {
        let mut sample = Sample {
            tick: self.tick,
            time_us: self.time_us,
            axes: Vec::new(),
            sensed_force_n: Vec::new(),
        };
        self.add_to(&mut sample.axes);
        self.add_sensed_to(&mut sample.sensed_force_n);
        sample
    }

    /// Tick as a device reported it; `None` for another number of axes.
    #[must_use]
    pub fn reported(sample: &Sample) -> Option<Self> {
        let axes: &[BatchItem; D] = sample.axes[..].try_into().ok()?;
        let first = axes.first()?;
        Some(Self {
            tick: sample.tick,
            time_us: sample.time_us,
            position_m: axes.map(|axis| axis.position_m),
            environment_force_n: axes.map(|axis| axis.environment_force_n),
            force_n: axes.map(|axis| axis.force_n),
            limiters: first.limiters,
            flaws: first.flaws,
            sensed_force_n: (sample.sensed_force_n[..].try_into()).unwrap_or([f32::NAN; D]),
        })
    }
}
