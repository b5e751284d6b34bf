//! Numbers on frames: what was lost, what came twice, what came late.
//!
//! A device numbers its reports modulo 2¹⁶, and a host believes one that has begun anew ([`SequenceTracker`]). A host
//! numbers its requests modulo 2³², and a device believes nobody ([`RequestTracker`]): at 1000 requests a second a
//! captured one would look new again after 24 days.

/// The arrival of a frame, by its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arrival {
    /// To be acted on; this many frames before it are missing.
    New {
        /// Frames that did not come.
        lost: u16,
    },
    /// The same frame once more: not to be acted on.
    Duplicate,
    /// After a later one: not to be acted on.
    Late,
}

impl Arrival {
    /// True if the frame may be acted on.
    #[must_use]
    pub const fn is_new(self) -> bool {
        matches!(self, Self::New { .. })
    }
}

/// What did not come once and in order, so far; each count modulo 2³².
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OutOfOrder {
    /// Did not come.
    pub lost: u32,
    /// Came twice.
    pub duplicate: u32,
    /// Came after a later one.
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
/// A number up to 32 767 ahead of the last is new, others are late. Whoever starts to count anew says so
/// (a hello) and calls [`restart`](Self::restart); [`RESTART_AFTER`](Self::RESTART_AFTER) late frames in a
/// row, each the successor of the one before, are taken for a sender that has done so unheard.
///
/// ```
/// use haptic_link::{Arrival, SequenceTracker};
///
/// let mut tracker = SequenceTracker::default();
/// tracker.arrive(65_535);
/// assert_eq!(tracker.arrive(1), Arrival::New { lost: 1 }); // 0 did not come
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
    /// Late frames in a row, in order, after which their numbers are believed.
    pub const RESTART_AFTER: u8 = 8;

    /// Nothing has arrived yet.
    pub const NEW: Self = Self {
        last: None,
        late_run: (0, 0),
        out_of_order: OutOfOrder::NONE,
    };

    /// Judges a frame by its number.
    pub fn arrive(&mut self, sequence: u16) -> Arrival {
        let Some(last) = self.last else {
            self.last = Some(sequence);
            return Arrival::New { lost: 0 };
        };
        let ahead = sequence.wrapping_sub(last);
        match ahead {
            0 => {
                count(&mut self.out_of_order.duplicate, 1);
                Arrival::Duplicate
            }
            1..0x8000 => {
                self.last = Some(sequence);
                self.late_run = (0, 0);
                count(&mut self.out_of_order.lost, u32::from(ahead - 1));
                Arrival::New { lost: ahead - 1 }
            }
            _ => {
                count(&mut self.out_of_order.late, 1);
                let (before, run) = self.late_run;
                let run = if run > 0 && sequence == before.wrapping_add(1) {
                    run + 1
                } else {
                    1
                };
                self.late_run = (sequence, run);
                if run >= Self::RESTART_AFTER {
                    self.last = Some(sequence);
                    self.late_run = (0, 0);
                    return Arrival::New { lost: 0 };
                }
                Arrival::Late
            }
        }
    }

    /// The sender counts anew: the next number is right, whatever it is.
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

/// Follows the numbers of a host's requests within one connection, modulo 2³².
///
/// A number up to 2³¹ − 1 ahead of the last is new, others are late, however many of them come: a capture that is
/// played again is nothing but late. A new connection may begin with any number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RequestTracker {
    last: Option<u32>,
    out_of_order: OutOfOrder,
}

impl RequestTracker {
    /// Nothing has arrived yet.
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

    /// A new connection begins.
    pub const fn restart(&mut self) {
        self.last = None;
    }

    /// Requests that did not come once and in order, so far.
    #[must_use]
    pub const fn out_of_order(&self) -> OutOfOrder {
        self.out_of_order
    }
}
