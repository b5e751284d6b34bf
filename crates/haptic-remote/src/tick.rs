//! A tick as the device's loop keeps it, and the messages that tell of it.

use haptic_link::{BatchItem, Sample};
use heapless::Vec;

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
    /// Limiters that acted, bits as in a [`BatchItem`].
    pub limiters: u8,
    /// Flaws of the exchange with a board, bits as in a [`BatchItem`].
    pub flaws: u8,
}

impl<const D: usize> Tick<D> {
    /// All zero.
    pub const NONE: Self = Self {
        tick: 0,
        time_us: 0,
        position_m: [0.0; D],
        environment_force_n: [0.0; D],
        force_n: [0.0; D],
        limiters: 0,
        flaws: 0,
    };

    /// Adds what each axis did in it, as far as there is room.
    pub(crate) fn add_to<const N: usize>(&self, items: &mut Vec<BatchItem, N>) {
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

    /// As the device tells it.
    pub(crate) fn sample(&self) -> Sample {
        let mut sample = Sample {
            tick: self.tick,
            time_us: self.time_us,
            axes: Vec::new(),
        };
        self.add_to(&mut sample.axes);
        sample
    }

    /// As a device has told it; `None` for another number of axes.
    #[must_use]
    pub fn told(sample: &Sample) -> Option<Self> {
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
        })
    }
}
