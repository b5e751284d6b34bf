//! Ticks as a device reports them: one, several in a frame, or those around a fault.

use heapless::Vec;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Most axes of a device: three, or one without the feature `several-axes`. The wire format is the
/// same.
pub const AXES_MAX: usize = if cfg!(feature = "several-axes") { 3 } else { 1 };

/// Most items in a [`SampleBatch`].
pub const BATCH_MAX: usize = 16;
/// Most items in a [`SampleBatch`] with sensed forces.
pub const SENSED_MAX: usize = 12;

/// Flaw of a tick: the board did not answer, so the position is from an earlier tick.
pub const UNANSWERED: u8 = 1;
/// Flaw of a tick: the board did not confirm the previous tick's force, so an older one may still
/// act.
pub const NOT_TAKEN: u8 = 2;
/// Flaw of a tick that only a host sets: its sample was impossible.
pub const IMPOSSIBLE: u8 = 8;

/// One tick. With one axis a frame of 34 bytes, or 38 with a force sensor.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, Schema)]
pub struct Sample {
    /// Number of the tick, from the start of the run, or from power-up before the first.
    #[serde(with = "postcard::fixint::le")]
    pub tick: u32,
    /// The device's own time, µs, modulo 2³².
    #[serde(with = "postcard::fixint::le")]
    pub time_us: u32,
    /// One item per axis; limiters and flaws belong to the tick and are the same in each.
    #[serde(serialize_with = "list")]
    pub axes: Vec<BatchItem, AXES_MAX>,
    /// Force of the hand or indenter on the device as its sensor shows it, N, positive along the position: one number per axis, or none
    /// from a device without a sensor, which costs it a byte.
    #[serde(serialize_with = "list")]
    pub sensed_force_n: Vec<f32, AXES_MAX>,
}

impl Sample {
    /// True if each axis has a sensed force, or none has.
    #[must_use]
    pub fn is_even(&self) -> bool {
        [0, self.axes.len()].contains(&self.sensed_force_n.len())
    }
}

/// Samples of at least one tick, consecutive among those sent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct SampleBatch {
    /// Number of the tick of the first item.
    #[serde(with = "postcard::fixint::le")]
    pub tick: u32,
    /// Device time of the first item, µs, modulo 2³².
    #[serde(with = "postcard::fixint::le")]
    pub time_us: u32,
    /// Number of ticks from one item to the next.
    #[serde(with = "postcard::fixint::le")]
    pub every: u16,
    /// Number of items that belong to one tick.
    pub axes: u8,
    /// The items, tick by tick, with the axes of each tick in order.
    #[serde(serialize_with = "list")]
    pub items: Vec<BatchItem, BATCH_MAX>,
    /// Sensed forces in the order of the items, see [`Sample::sensed_force_n`]; empty without a sensor.
    #[serde(serialize_with = "list")]
    pub sensed_force_n: Vec<f32, BATCH_MAX>,
}

impl SampleBatch {
    /// Most ticks in a batch for this many axes, which fit into a frame with or without sensed forces.
    #[must_use]
    pub const fn ticks_most(axes: usize, sensed: bool) -> usize {
        let items = if sensed { SENSED_MAX } else { BATCH_MAX };
        match axes {
            0 => 0,
            axes => items / axes,
        }
    }

    /// The samples, for ticks of this period. Left-over items that do not make a whole tick are
    /// dropped.
    pub fn samples(&self, tick_period_us: u32) -> impl Iterator<Item = Sample> + '_ {
        let every = u32::from(self.every);
        let axes = usize::from(self.axes).clamp(1, AXES_MAX);
        let ticks = self.items.chunks_exact(axes).zip(0_u32..);
        let mut sensed = self.sensed_force_n.chunks_exact(axes);
        ticks.map(move |(items, n)| {
            let ticks = n.wrapping_mul(every);
            Sample {
                tick: self.tick.wrapping_add(ticks),
                time_us: (self.time_us).wrapping_add(ticks.wrapping_mul(tick_period_us)),
                axes: items.iter().copied().collect(),
                sensed_force_n: sensed.next().into_iter().flatten().copied().collect(),
            }
        })
    }
}

/// Record of an axis in a tick: 14 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, Schema)]
pub struct BatchItem {
    /// Position that was measured at the start of the tick, m.
    pub position_m: f32,
    /// The force that the environment, or the host, wanted, N.
    pub environment_force_n: f32,
    /// The force that was applied, N.
    pub force_n: f32,
    /// Limiters that acted, bits: 1 magnitude, 2 rate, 4 fault, 8 stopping, 16 start-up, 32 workspace,
    /// 64 velocity, 128 passivity guard.
    pub limiters: u8,
    /// Flaws of the exchange with a board on a separate line, bits: [`UNANSWERED`], [`NOT_TAKEN`].
    pub flaws: u8,
}

/// A sample of the flight recorder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Flight {
    /// Index of the sample; 0 is the oldest.
    #[serde(with = "postcard::fixint::le")]
    pub index: u16,
    /// Number of samples kept, which end a while after the latched fault; 0 while there is no
    /// fault, and then the sample is all zero.
    #[serde(with = "postcard::fixint::le")]
    pub count: u16,
    /// Record of the tick with that index.
    pub sample: Sample,
}

fn list<T: Serialize, S: serde::Serializer>(items: &[T], to: S) -> Result<S::Ok, S::Error> {
    items.serialize(to)
}
