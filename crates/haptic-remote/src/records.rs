//! What a device remembers of its ticks, apart from its loop.

use crate::flight::FlightRecorder;
use crate::outbox::Outbox;

/// Flight recorder, and what waits to be sent: 3.3 KiB. A [`TickSide`](crate::TickSide) holds them itself, or borrows them
/// from a static where it is made on a stack without room for both.
#[derive(Debug)]
pub struct Records {
    pub(crate) outbox: Outbox,
    pub(crate) flight: FlightRecorder,
}

impl Records {
    /// Empty.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            outbox: Outbox::new(),
            flight: FlightRecorder::new(),
        }
    }
}

impl Default for Records {
    fn default() -> Self {
        Self::new()
    }
}
