//! The counters of a device.

use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// All counters since power-up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Statistics {
    /// Ticks.
    #[serde(with = "postcard::fixint::le")]
    pub ticks: u32,
    /// Ticks that began a whole period late or took longer than one.
    #[serde(with = "postcard::fixint::le")]
    pub overruns: u32,
    /// Longest tick, processor cycles; 0 where there is no counter.
    #[serde(with = "postcard::fixint::le")]
    pub tick_cycles_max: u32,
    /// Last tick, processor cycles.
    #[serde(with = "postcard::fixint::le")]
    pub tick_cycles_last: u32,
    /// Ticks of a host loop without a new force.
    #[serde(with = "postcard::fixint::le")]
    pub stale_forces: u32,
    /// Samples that found the queue full and were not sent.
    #[serde(with = "postcard::fixint::le")]
    pub samples_dropped: u32,
    /// Frames sent.
    #[serde(with = "postcard::fixint::le")]
    pub sent: u32,
    /// Frames received whole.
    #[serde(with = "postcard::fixint::le")]
    pub received: u32,
    /// Frames damaged, cut, of no known kind, or not in their one form.
    #[serde(with = "postcard::fixint::le")]
    pub corrupt: u32,
    /// Frames longer than the buffer.
    #[serde(with = "postcard::fixint::le")]
    pub oversize: u32,
    /// Frames of another protocol version.
    #[serde(with = "postcard::fixint::le")]
    pub foreign: u32,
    /// Frames that did not come.
    #[serde(with = "postcard::fixint::le")]
    pub lost: u32,
    /// Frames that came twice.
    #[serde(with = "postcard::fixint::le")]
    pub duplicate: u32,
    /// Frames that came after a later one.
    #[serde(with = "postcard::fixint::le")]
    pub late: u32,
    /// Bytes that the hardware received but nobody fetched in time.
    #[serde(with = "postcard::fixint::le")]
    pub bytes_overrun: u32,
    /// Frames of a connection that the device does not know.
    #[serde(with = "postcard::fixint::le")]
    pub strangers: u32,
    /// Ticks in which a board behind a line of its own did not answer.
    #[serde(with = "postcard::fixint::le")]
    pub unanswered: u32,
    /// Forces of which nothing says that such a board took them.
    #[serde(with = "postcard::fixint::le")]
    pub forces_not_taken: u32,
}

impl Statistics {
    /// The counts since `before`. Counters go round at 2³², so a device that was reset in between gives
    /// large numbers, never a failure. Longest and last tick are those of `self`.
    #[must_use]
    pub const fn since(&self, before: &Self) -> Self {
        Self {
            ticks: self.ticks.wrapping_sub(before.ticks),
            overruns: self.overruns.wrapping_sub(before.overruns),
            tick_cycles_max: self.tick_cycles_max,
            tick_cycles_last: self.tick_cycles_last,
            stale_forces: self.stale_forces.wrapping_sub(before.stale_forces),
            samples_dropped: self.samples_dropped.wrapping_sub(before.samples_dropped),
            sent: self.sent.wrapping_sub(before.sent),
            received: self.received.wrapping_sub(before.received),
            corrupt: self.corrupt.wrapping_sub(before.corrupt),
            oversize: self.oversize.wrapping_sub(before.oversize),
            foreign: self.foreign.wrapping_sub(before.foreign),
            lost: self.lost.wrapping_sub(before.lost),
            duplicate: self.duplicate.wrapping_sub(before.duplicate),
            late: self.late.wrapping_sub(before.late),
            bytes_overrun: self.bytes_overrun.wrapping_sub(before.bytes_overrun),
            strangers: self.strangers.wrapping_sub(before.strangers),
            unanswered: self.unanswered.wrapping_sub(before.unanswered),
            forces_not_taken: self.forces_not_taken.wrapping_sub(before.forces_not_taken),
        }
    }
}
