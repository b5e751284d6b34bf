//! What a device remembers of its ticks, apart from its loop.

use crate::flight::FlightRecorder;
use crate::outbox::Outbox;

/// Flight recorder, and what waits to be sent: 3.3 KiB with one axis. A [`TickSide`](crate::TickSide) holds them itself, or borrows them
/// from a static where it is made on a stack without room for both.
#[derive(Debug)]
pub struct Records<const D: usize = 1> {
    pub(crate) outbox: Outbox<D>,
    pub(crate) flight: FlightRecorder<D>,
}

impl<const D: usize> Records<D> {
    /// Empty.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            outbox: Outbox::new(),
            flight: FlightRecorder::new(),
        }
    }
}

impl<const D: usize> Default for Records<D> {
    fn default() -> Self {
        Self::new()
    }
}
