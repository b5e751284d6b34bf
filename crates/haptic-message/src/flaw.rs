//! Flaws of a tick: bits of its field `flaws`.

use serde::Serialize;

use super::TickMessage;

/// The board did not answer: the position is from an earlier tick.
pub const UNANSWERED: u8 = 1;
/// The board did not confirm the previous tick's force.
pub const NOT_TAKEN: u8 = 2;
/// The device had not received the last forces of a loop on the host, so an older one acts.
pub const LATE_FORCE: u8 = 4;
/// The device reported something impossible for the tick.
pub const IMPOSSIBLE: u8 = 8;

/// A log with a larger share of stale ticks does not show what the loop did.
const STALE_MOST: f64 = 0.01;

/// Ticks of a log with flaws.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct FlawCounts {
    /// Ticks with an earlier tick's position, or in which an older force may have acted.
    pub stale: u64,
    /// Those of the stale ticks in which the board did not answer.
    pub unanswered: u64,
    /// Those whose board may not have taken the force of the tick before.
    pub forces_not_taken: u64,
    /// Those of the stale ticks in which the device had not received the last forces of a loop on the host.
    pub late_forces: u64,
    /// Ticks for which the device reported something impossible.
    pub impossible: u64,
}

impl FlawCounts {
    /// Counts the flaws of a tick.
    pub fn add(&mut self, tick: &TickMessage) {
        let has = |bits: u8| u64::from(tick.flaws & bits != 0);
        self.stale += has(UNANSWERED | NOT_TAKEN | LATE_FORCE);
        self.unanswered += has(UNANSWERED);
        self.forces_not_taken += has(NOT_TAKEN);
        self.late_forces += has(LATE_FORCE);
        let has_place = tick.position_m.iter().all(|axis| axis.is_finite());
        self.impossible += u64::from(tick.flaws & IMPOSSIBLE != 0 || !has_place);
    }

    /// True if too large a share of this many ticks is stale.
    #[must_use]
    pub fn is_stale(&self, samples: u64) -> bool {
        self.stale as f64 > STALE_MOST * samples as f64
    }
}
