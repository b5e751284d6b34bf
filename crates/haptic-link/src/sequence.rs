//! Numbers on frames: what was lost, came twice or late. Reports count modulo 2¹⁶, and a host believes a device that
//! has begun anew ([`SequenceTracker`]); requests count modulo 2³², and a device believes nobody
//! ([`RequestTracker`]): a captured one would look new after 24 days at 1000 a second.

/// Frames that did not arrive exactly once and in order, so far; each count is modulo 2³².
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OutOfOrder {
    /// Numbers that a newer frame skipped; frames that came late are among them.
    pub lost: u32,
    /// Frames that repeated the newest number.
    pub duplicate: u32,
    /// Frames that arrived after a later one.
    pub late: u32,
}

impl OutOfOrder {
    const NONE: Self = Self {
        lost: 0,
        duplicate: 0,
        late: 0,
    };
}

const fn count(of: &mut u32, more: u32) {
    *of = of.wrapping_add(more);
}

/// Follows the numbers of a device's reports, modulo 2¹⁶.
///
/// A number up to 32 767 ahead of the last is new, others are late. A sender that restarts its
/// count announces it (a hello); then call [`restart`](Self::restart);
/// [`RESTART_AFTER`](Self::RESTART_AFTER) late frames in a row, each following the one before, mean
/// that the sender restarted and its announcement was lost.
///
/// ```
/// use haptic_link::SequenceTracker;
///
/// let mut tracker = SequenceTracker::default();
/// assert!(tracker.is_new(65_535));
/// assert!(tracker.is_new(1)); // 0 did not come
/// assert_eq!(tracker.out_of_order().lost, 1);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SequenceTracker {
    last: Option<u16>,
    /// The last late number, and how many late ones in a row were successors.
    late_run: (u16, u8),
    out_of_order: OutOfOrder,
}

impl SequenceTracker {
    /// Number of late frames in a row and in order after which the tracker accepts their numbers.
    pub const RESTART_AFTER: u8 = 8;

    /// A tracker to which nothing has arrived: any first number is new.
    pub const NEW: Self = Self {
        last: None,
        late_run: (0, 0),
        out_of_order: OutOfOrder::NONE,
    };

    /// True if a frame with this number may be acted on.
    pub fn is_new(&mut self, sequence: u16) -> bool {
        let Some(last) = self.last else {
            self.last = Some(sequence);
            return true;
        };
        let ahead = sequence.wrapping_sub(last);
        if ahead == 0 {
            count(&mut self.out_of_order.duplicate, 1);
            return false;
        }
        let mut is_new = ahead < 0x8000;
        if is_new {
            count(&mut self.out_of_order.lost, u32::from(ahead - 1));
        } else {
            count(&mut self.out_of_order.late, 1);
            let (before, run) = self.late_run;
            let follows = run > 0 && sequence == before.wrapping_add(1);
            let run = if follows { run + 1 } else { 1 };
            self.late_run = (sequence, run);
            is_new = run >= Self::RESTART_AFTER;
        }
        if is_new {
            self.last = Some(sequence);
            self.late_run = (0, 0);
        }
        is_new
    }

    /// Call this when the sender restarts its count: any next number is accepted.
    pub fn restart(&mut self) {
        self.last = None;
        self.late_run = (0, 0);
    }

    /// Frames that did not come once and in order, so far.
    #[must_use]
    pub const fn out_of_order(&self) -> OutOfOrder {
        self.out_of_order
    }
}

/// Follows the numbers of a host's requests within one connection, modulo 2³². A number up to 2³¹ −
/// 1 ahead of the last is new, any other is late, so every frame of a replayed capture is late. A
/// new connection may begin with any number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RequestTracker {
    last: Option<u32>,
    out_of_order: OutOfOrder,
}

impl RequestTracker {
    /// A tracker to which nothing has arrived: any first number is new.
    pub const NEW: Self = Self {
        last: None,
        out_of_order: OutOfOrder::NONE,
    };

    /// True if a request with this number may be acted on.
    pub fn is_new(&mut self, sequence: u32) -> bool {
        let ahead = self.last.map_or(1, |last| sequence.wrapping_sub(last));
        match ahead {
            0 => count(&mut self.out_of_order.duplicate, 1),
            1..0x8000_0000 => {
                self.last = Some(sequence);
                count(&mut self.out_of_order.lost, ahead - 1);
                return true;
            }
            _ => count(&mut self.out_of_order.late, 1),
        }
        false
    }

    /// Call this when a new connection begins: any next number is accepted.
    pub const fn restart(&mut self) {
        self.last = None;
    }

    /// Requests that did not come once and in order, so far.
    #[must_use]
    pub const fn out_of_order(&self) -> OutOfOrder {
        self.out_of_order
    }
}
