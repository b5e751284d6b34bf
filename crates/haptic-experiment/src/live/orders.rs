//! The end of a loop that gives it orders, and waits for its threads.

use super::ticking::{FromLoop, LoopCounts, LoopEnds, LoopOrder, rings};
use haptic_document::Failure;
use rtrb::{Consumer, Producer, RingBuffer};
use std::{
    sync::{Arc, Mutex, MutexGuard, PoisonError, atomic::Ordering},
    thread::JoinHandle,
};

/// A lock that a panic elsewhere does not close: the numbers behind it are whole at any time.
pub fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Whoever gives a loop its orders.
#[derive(Debug)]
pub struct Orders {
    ring: Mutex<Producer<LoopOrder>>,
    /// Counts of the loop, which may be read at any time.
    pub counts: Arc<LoopCounts>,
    threads: Mutex<Vec<JoinHandle<()>>>,
}

impl Orders {
    /// Both rings of a loop: this end, that of the loop, and that of its keeper.
    #[must_use]
    pub fn new() -> (Self, LoopEnds, Consumer<FromLoop>) {
        let (ring, ends, from_loop) = rings();
        let orders_end = Self {
            ring: Mutex::new(ring),
            counts: Arc::default(),
            threads: Mutex::default(),
        };
        (orders_end, ends, from_loop)
    }

    /// Has this work done in a thread that [`end`](Self::end) waits for.
    pub fn spawn(&self, work: impl FnOnce() + Send + 'static) {
        locked(&self.threads).push(std::thread::spawn(work));
    }

    /// Gives an order.
    ///
    /// # Errors
    /// A loop that has not read a thousand of them.
    pub fn give(&self, order: LoopOrder) -> Result<(), Failure> {
        locked(&self.ring).push(order).map_err(|_| {
            Failure::bad_input(
                "the loop does not respond: this machine is overloaded; stop, and start again",
            )
        })
    }

    /// The force falls to zero, the hand lets go. Nothing can keep it from the loop.
    pub fn stop(&self) {
        self.counts.stops.fetch_add(1, Ordering::Relaxed);
    }

    /// Stops, and waits until the force is zero and all is kept.
    pub fn end(&self) {
        self.stop();
        self.leave();
        self.join();
    }

    /// Waits until the loop has ended and all is kept.
    pub fn join(&self) {
        for thread in locked(&self.threads).drain(..) {
            // A panic in it is a defect that its own message has reported.
            let _ = thread.join();
        }
    }

    /// A loop without anybody to give orders ends when its force is zero.
    pub fn leave(&self) {
        let (nobody, _) = RingBuffer::new(1);
        drop(std::mem::replace(&mut *locked(&self.ring), nobody));
    }
}

impl Drop for Orders {
    fn drop(&mut self) {
        self.end();
    }
}
