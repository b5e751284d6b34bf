//! Impossible samples of a device.

use thiserror::Error;

/// A sample that cannot be.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Impossible {
    /// A position that is not a finite number.
    #[error("a position of {position_m} m in tick {tick}")]
    Position {
        /// Number of the tick that it is said to be of.
        tick: u32,
        /// The reported position, m, which is NaN or infinite.
        position_m: f32,
    },
    /// A position outside the workspace of the run, in which the device latched no fault.
    #[error(
        "a position of {position_m:?} m in tick {tick}, outside {low_m} to {high_m} m, and no fault"
    )]
    Outside {
        /// Number of the tick that reported it.
        tick: u32,
        /// The reported position, m, outside the range that follows.
        position_m: f32,
        /// Lowest position that is no fault, m.
        low_m: f32,
        /// Highest position that is no fault, m.
        high_m: f32,
    },
    /// A motion in which the device latched no fault, though it is beyond its limits of speed and of a jump.
    #[error("a motion by {moved_m:?} m up to tick {tick}, of at most {most_m} m, and no fault")]
    Moved {
        /// Number of the tick at the end of the motion.
        tick: u32,
        /// Motion since the sample before, m.
        moved_m: f32,
        /// Largest that is no fault, m.
        most_m: f32,
    },
    /// A force that is not a finite number, or beyond the largest that the device makes.
    #[error("a force of {force_n} N in tick {tick}, of at most {most_n} N")]
    Force {
        /// Number of the tick that it is said to be of.
        tick: u32,
        /// Force on the axis of the largest, N.
        force_n: f32,
        /// The largest that it makes, N.
        most_n: f32,
    },
    /// A force sensor at the end of its range, where it no longer follows the force.
    #[error("a sensed force of {force_n} N in tick {tick}, at the end of the range of ±{most_n} N")]
    Saturated {
        /// Number of the tick of the reading.
        tick: u32,
        /// Reading of the sensor, N.
        force_n: f32,
        /// Range of the sensor on either side of 0, N.
        most_n: f32,
    },
    /// A force sensor that no longer follows the force.
    #[error(
        "a sensed force of {force_n} N to the last bit for {still_ms} ms until tick {tick}, while the command changed by {changed_n} N, \
         of which {most_n} N must show"
    )]
    Stuck {
        /// Number of the tick that was too many.
        tick: u32,
        /// Reading of the sensor, N; NaN of one that gives nothing.
        force_n: f32,
        /// Time without a change, ms.
        still_ms: u32,
        /// Change of the commanded force in that time, N.
        changed_n: f32,
        /// Largest such change that may leave it as it is, N.
        most_n: f32,
    },
    /// A tick before the one that came before it.
    #[error("tick {tick} after tick {before}")]
    Tick {
        /// Number of the tick that it is said to be of.
        tick: u32,
        /// That of the sample before.
        before: u32,
    },
    /// A time before that of the tick before it.
    #[error("a time in tick {tick} that is {back_us} µs before that of the tick before")]
    Time {
        /// Number of the tick that it is said to be of.
        tick: u32,
        /// Time by which it goes back, µs.
        back_us: u32,
    },
}

impl Impossible {
    /// The tick of the sample.
    #[must_use]
    pub const fn tick(self) -> u32 {
        match self {
            Self::Position { tick, .. }
            | Self::Outside { tick, .. }
            | Self::Moved { tick, .. }
            | Self::Force { tick, .. }
            | Self::Saturated { tick, .. }
            | Self::Stuck { tick, .. }
            | Self::Tick { tick, .. }
            | Self::Time { tick, .. } => tick,
        }
    }

    /// Advice to a person, in a few words.
    #[must_use]
    pub const fn remedy(self) -> &'static str {
        match self {
            Self::Position { .. }
            | Self::Outside { .. }
            | Self::Moved { .. }
            | Self::Force { .. }
            | Self::Tick { .. }
            | Self::Time { .. } => "check its sensor and firmware",
            Self::Saturated { .. } => {
                "ask for less force, or let the board state the range of a larger sensor"
            }
            Self::Stuck { .. } => "check the supply and the wires of its force sensor",
        }
    }
}
