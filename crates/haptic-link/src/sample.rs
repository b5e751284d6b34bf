//! Ticks as a device reports them: one, several in a frame, or those around a fault.

use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Most samples in a [`Batch`].
pub const BATCH_MAX: usize = 16;

/// Flaw of a tick: the board did not answer, so the position is that of an earlier tick.
pub const UNANSWERED: u8 = 1;
/// Flaw of a tick: nothing says that the board took the force of the tick before, so an older one may act.
pub const NOT_TAKEN: u8 = 2;
/// Flaw of a tick that no device tells: a host saw that its sample cannot be.
pub const IMPOSSIBLE: u8 = 8;

/// One tick. A frame of 32 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, Schema)]
pub struct Sample {
    /// Number of the tick, from the start of the run, or from power-up before the first.
    #[serde(with = "postcard::fixint::le")]
    pub tick: u32,
    /// The device's own time, µs, modulo 2³².
    #[serde(with = "postcard::fixint::le")]
    pub time_us: u32,
    /// Position, m.
    pub position_m: f32,
    /// The force that the environment, or the host, wanted, N.
    pub environment_force_n: f32,
    /// The force that was applied, N.
    pub force_n: f32,
    /// Limiters that acted, bits: 1 magnitude, 2 rate, 4 fault, 8 stopping, 16 start-up, 32 workspace,
    /// 64 velocity, 128 passivity guard.
    pub limiters: u8,
    /// Flaws of the exchange with a board behind a line of its own, bits: [`UNANSWERED`], [`NOT_TAKEN`].
    pub flaws: u8,
}

/// Consecutive sent ticks, at least one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Batch {
    /// Tick of the first.
    #[serde(with = "postcard::fixint::le")]
    pub tick: u32,
    /// Device time of the first, µs, modulo 2³².
    #[serde(with = "postcard::fixint::le")]
    pub time_us: u32,
    /// Ticks from one to the next.
    #[serde(with = "postcard::fixint::le")]
    pub every: u16,
    /// The samples.
    pub items: heapless::Vec<BatchItem, BATCH_MAX>,
}

impl Batch {
    /// The samples, for ticks of this period.
    pub fn samples(&self, tick_period_us: u32) -> impl Iterator<Item = Sample> + '_ {
        let every = u32::from(self.every);
        self.items.iter().zip(0_u32..).map(move |(item, n)| {
            let (tick, time_us) = later(
                (self.tick, self.time_us),
                n.wrapping_mul(every),
                tick_period_us,
            );
            Sample {
                tick,
                time_us,
                position_m: item.position_m,
                environment_force_n: item.environment_force_n,
                force_n: item.force_n,
                limiters: item.limiters,
                flaws: item.flaws,
            }
        })
    }
}

/// Number and device time of a tick so many ticks after another.
pub(crate) const fn later(
    (tick, time_us): (u32, u32),
    ticks: u32,
    tick_period_us: u32,
) -> (u32, u32) {
    (
        tick.wrapping_add(ticks),
        time_us.wrapping_add(ticks.wrapping_mul(tick_period_us)),
    )
}

/// A tick in a [`Batch`]: 14 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct BatchItem {
    /// Position, m.
    pub position_m: f32,
    /// The force that the environment, or the host, wanted, N.
    pub environment_force_n: f32,
    /// The force that was applied, N.
    pub force_n: f32,
    /// As in [`Sample`].
    pub limiters: u8,
    /// As in [`Sample`].
    pub flaws: u8,
}

impl From<Sample> for BatchItem {
    /// What its axis did.
    fn from(sample: Sample) -> Self {
        Self {
            position_m: sample.position_m,
            environment_force_n: sample.environment_force_n,
            force_n: sample.force_n,
            limiters: sample.limiters,
            flaws: sample.flaws,
        }
    }
}

/// A sample of the flight recorder.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Flight {
    /// From 0, the oldest.
    #[serde(with = "postcard::fixint::le")]
    pub index: u16,
    /// Samples kept, of ticks up to a while after the latched fault; 0 while there is none, and then the
    /// sample is all zero.
    #[serde(with = "postcard::fixint::le")]
    pub count: u16,
    /// The sample.
    pub sample: Sample,
}
