//! What a hand feels, live: a loop whose law changes while it is held. The page and Python's sessions use it.
//!
//! ```text
//! orders ─ring─▶ loop, by the clock, in virtual time or by a device ─ring─▶ keeper ─▶ whoever watches
//!                  └─ old law ─fades─▶ new law that has heard the same positions
//! ```
//! - *Force*: between those of both laws while one fades into the other; a touch in which the law changed gives no more than it took, see
//!   [`Fading`]. Safety chain and limits are those of any run.
//! - *The thread that ticks* never waits for anybody and wakes nobody: what it needs comes through a ring, what it is done with goes
//!   through another to be freed.

mod by_clock;
mod fading;
mod hand;
mod keeper;
mod place;
mod recording;
mod ticking;

pub use by_clock::run;
pub use fading::{Fading, FadingHistory, Law};
pub use hand::{HAND_DAMPING, HAND_M, HAND_STIFFNESS, HeldDevice};
pub use keeper::{Keeper, Watch};
pub use place::Placed;
pub use recording::{Finished, Recording};
pub use ticking::{
    Around, FadingFelt, FromLoop, HandPath, LoopCounts, LoopEnds, LoopOrder, Stimulus, Ticked,
};

use crate::document::failure::Failure;
use fracdiff::{Operator, Seconds};
use haptic_loop::{Pushing, Wall};
use rtrb::{Producer, RingBuffer};
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

/// A tissue or wall behind its surface: the law of `[wall]`.
pub type Felt = Placed<Pushing<Wall<f64, Operator<f64>>>>;

/// Samples for which the memory of a law is made: 2.8 hours at 1 kHz.
pub const HORIZON: u64 = 10_000_000;
/// Time in which one law goes over into the next, s.
const FADE_S: f64 = 0.2;
const ORDERS: usize = 1024;
/// Samples that wait for the keeper at most: 8 s.
const SAMPLES: usize = 8192;

/// Ticks of a time, rounded.
#[must_use]
pub fn ticks(time_s: f64, sample_time: Seconds) -> usize {
    (time_s / sample_time.0).round() as usize
}

/// Two laws that become one another: the first is felt alone.
#[must_use]
pub fn fading(law: &Felt, sample_time: Seconds) -> FadingFelt {
    Fading::new(law.clone(), ticks(FADE_S, sample_time) as u32)
}

/// A lock that a panic elsewhere does not close: the numbers behind it are whole at any time.
pub fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Whoever gives a loop its orders.
#[derive(Debug)]
pub struct Orders {
    ring: Mutex<Producer<LoopOrder>>,
    /// What the loop counts.
    pub counts: Arc<LoopCounts>,
    threads: Mutex<Vec<JoinHandle<()>>>,
}

impl Orders {
    /// Both rings of a loop: this end, that of the loop, and that of its keeper.
    #[must_use]
    pub fn new() -> (Self, LoopEnds, rtrb::Consumer<FromLoop>) {
        let (ring, orders) = RingBuffer::new(ORDERS);
        let (out, from_loop) = RingBuffer::new(SAMPLES);
        let orders_end = Self {
            ring: Mutex::new(ring),
            counts: Arc::default(),
            threads: Mutex::default(),
        };
        (orders_end, LoopEnds { orders, out }, from_loop)
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
