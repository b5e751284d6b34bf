//! Messages of a device of two or three axes: vectors in place of numbers.
//!
//! A vector has as many elements as the device has axes, in their order. The messages of one axis stay as they are, and a
//! device of one axis neither sends nor takes these.

use crate::sample::{BatchItem, Sample, later};
use heapless::Vec;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Most axes of a device.
pub const AXES_MAX: usize = 3;

/// The force on the device from the next tick on, in [`LoopMode::Host`](crate::LoopMode::Host).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Forces {
    /// The tick whose sample it answers.
    #[serde(with = "postcard::fixint::le")]
    pub tick: u32,
    /// N, an element an axis; one that is not finite latches a fault, another number of them is no force.
    pub force_n: Vec<f32, AXES_MAX>,
}

/// The range in which a device may move on an axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct AxisWorkspace {
    /// Lowest position, m, −100 to 100.
    pub low_m: f32,
    /// Highest position, m, above the lowest, at most 100. Beyond either a fault latches.
    pub high_m: f32,
    /// Width of the zones at both ends in which an outward motion is braked, m, 0 or 1e-6 to half the range.
    pub soft_m: f32,
}

/// A workspace of its own for each axis of a device of several, in a run. Where [`Limits`](crate::Limits) has a workspace for
/// all axes, this one lies in it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct WorkspaceBox {
    /// An element an axis.
    pub axes: Vec<AxisWorkspace, AXES_MAX>,
}

/// One tick.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, Schema)]
pub struct VectorSample {
    /// As in [`Sample`](crate::Sample).
    #[serde(with = "postcard::fixint::le")]
    pub tick: u32,
    /// The device's own time, µs, modulo 2³².
    #[serde(with = "postcard::fixint::le")]
    pub time_us: u32,
    /// An item an axis; the limiters are those of the tick, the same in each.
    pub axes: Vec<BatchItem, AXES_MAX>,
}

impl From<Sample> for VectorSample {
    /// That of the only axis.
    fn from(sample: Sample) -> Self {
        Self {
            tick: sample.tick,
            time_us: sample.time_us,
            axes: [BatchItem::from(sample)].into_iter().collect(),
        }
    }
}

/// Consecutive sent ticks, at least one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct VectorBatch {
    /// Tick of the first.
    #[serde(with = "postcard::fixint::le")]
    pub tick: u32,
    /// Device time of the first, µs, modulo 2³².
    #[serde(with = "postcard::fixint::le")]
    pub time_us: u32,
    /// Ticks from one to the next.
    #[serde(with = "postcard::fixint::le")]
    pub every: u16,
    /// Items of a tick.
    pub axes: u8,
    /// Tick after tick, the axes of each in their order.
    pub items: Vec<BatchItem, { crate::BATCH_MAX }>,
}

impl VectorBatch {
    /// Most ticks in a batch of so many axes.
    #[must_use]
    pub const fn ticks_most(axes: usize) -> usize {
        match axes {
            0 => 0,
            axes => crate::BATCH_MAX / axes,
        }
    }

    /// The samples, for ticks of this period. Items at the end that are no whole tick are none.
    pub fn samples(&self, tick_period_us: u32) -> impl Iterator<Item = VectorSample> + '_ {
        let every = u32::from(self.every);
        let axes = usize::from(self.axes).clamp(1, AXES_MAX);
        let ticks = self.items.chunks_exact(axes).zip(0_u32..);
        ticks.map(move |(items, n)| {
            let (tick, time_us) = later(
                (self.tick, self.time_us),
                n.wrapping_mul(every),
                tick_period_us,
            );
            VectorSample {
                tick,
                time_us,
                axes: items.iter().copied().collect(),
            }
        })
    }
}

/// A sample of the flight recorder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct VectorFlight {
    /// From 0, the oldest.
    #[serde(with = "postcard::fixint::le")]
    pub index: u16,
    /// As in [`Flight`](crate::Flight).
    #[serde(with = "postcard::fixint::le")]
    pub count: u16,
    /// The sample.
    pub sample: VectorSample,
}
