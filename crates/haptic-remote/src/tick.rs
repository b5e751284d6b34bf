//! A tick as the device's loop keeps it, and the messages that tell of it: those of one axis, or vectors.

use haptic_link::{BATCH_MAX, Batch, BatchItem, Flight, Report, Sample};
#[cfg(feature = "several-axes")]
use haptic_link::{VectorBatch, VectorFlight, VectorSample};

/// A tick of a device of D axes: see [`Sample`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tick<const D: usize = 1> {
    /// Number of the tick, from the start of the run, or from power-up before the first.
    pub tick: u32,
    /// The device's own time, µs, modulo 2³².
    pub time_us: u32,
    /// Position, m.
    pub position_m: [f32; D],
    /// The force that the environment, or the host, wanted, N.
    pub environment_force_n: [f32; D],
    /// The force that was applied, N.
    pub force_n: [f32; D],
    /// Limiters that acted, bits as in [`Sample`].
    pub limiters: u8,
    /// Flaws of the exchange with a board, bits as in [`Sample`].
    pub flaws: u8,
}

impl<const D: usize> Tick<D> {
    /// All zero.
    pub(crate) const NONE: Self = Self {
        tick: 0,
        time_us: 0,
        position_m: [0.0; D],
        environment_force_n: [0.0; D],
        force_n: [0.0; D],
        limiters: 0,
        flaws: 0,
    };

    /// What an axis did in it.
    fn item(&self, axis: usize) -> BatchItem {
        BatchItem {
            position_m: self.position_m[axis],
            environment_force_n: self.environment_force_n[axis],
            force_n: self.force_n[axis],
            limiters: self.limiters,
            flaws: self.flaws,
        }
    }

    /// As a device of one axis tells it.
    fn sample(&self) -> Sample {
        Sample {
            tick: self.tick,
            time_us: self.time_us,
            position_m: self.position_m[0],
            environment_force_n: self.environment_force_n[0],
            force_n: self.force_n[0],
            limiters: self.limiters,
            flaws: self.flaws,
        }
    }

    /// As a device of several tells it.
    #[cfg(feature = "several-axes")]
    fn vectors(&self) -> VectorSample {
        VectorSample {
            tick: self.tick,
            time_us: self.time_us,
            axes: (0..D).map(|axis| self.item(axis)).collect(),
        }
    }

    /// One tick in a frame.
    pub(crate) fn report(self) -> Report {
        #[cfg(feature = "several-axes")]
        if D > 1 {
            return Report::VectorSample(self.vectors());
        }
        Report::Sample(self.sample())
    }

    /// As a sample of the flight recorder.
    pub(crate) fn flight(&self, index: u16, count: u16) -> Report {
        #[cfg(feature = "several-axes")]
        if D > 1 {
            return Report::VectorFlight(VectorFlight {
                index,
                count,
                sample: self.vectors(),
            });
        }
        Report::Flight(Flight {
            index,
            count,
            sample: self.sample(),
        })
    }
}

/// Ticks that go into one frame.
pub(crate) struct Ticks<const D: usize> {
    tick: u32,
    time_us: u32,
    every: u16,
    items: heapless::Vec<BatchItem, BATCH_MAX>,
}

impl<const D: usize> Ticks<D> {
    /// Most of them.
    pub(crate) const MOST: usize = BATCH_MAX / D;

    /// None yet; this one comes first.
    pub(crate) const fn from(first: Tick<D>, every: u16) -> Self {
        Self {
            tick: first.tick,
            time_us: first.time_us,
            every,
            items: heapless::Vec::new(),
        }
    }

    /// Takes the next. There is room: at most [`MOST`](Self::MOST) are taken.
    pub(crate) fn take(&mut self, tick: Tick<D>) {
        for axis in 0..D {
            let _ = self.items.push(tick.item(axis));
        }
    }

    pub(crate) fn count(&self) -> usize {
        self.items.len() / D
    }

    /// The frame.
    pub(crate) fn report(self) -> Report {
        let Self {
            tick,
            time_us,
            every,
            items,
        } = self;
        #[cfg(feature = "several-axes")]
        if D > 1 {
            return Report::VectorBatch(VectorBatch {
                tick,
                time_us,
                every,
                axes: D as u8,
                items,
            });
        }
        Report::Batch(Batch {
            tick,
            time_us,
            every,
            items,
        })
    }
}
