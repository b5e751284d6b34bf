//! State that the threads of a link share with the thread that ticks.

use crate::{Conversation, LinkError};
use haptic_link::{Event, FaultReport, Request, Sample, Status};
use hdrhistogram::Histogram;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// Message that a device sends unasked.
#[derive(Clone, Debug, PartialEq)]
pub enum Heard {
    /// A tick.
    Sample(Sample),
    /// Something happened.
    Event(Event),
    /// A fault latched.
    Fault(FaultReport),
    /// The session is over.
    Over(LinkError),
}

#[derive(Debug)]
pub(super) enum Command {
    Ask(Request),
    Tell(Request),
}

#[derive(Debug)]
pub(super) struct Shared {
    pub(super) conversation: Mutex<Conversation>,
    pub(super) began: Instant,
    pub(super) over: AtomicBool,
    pub(super) samples_dropped: AtomicU64,
    pub(super) forces_dropped: AtomicU64,
    pub(super) round_trip_us: Mutex<Histogram<u64>>,
    pub(super) status: Mutex<Status>,
    /// Answers to keep-alives so far: each brings the status of its moment.
    pub(super) alives: AtomicU64,
    /// Faults of the device when it was armed last; more than there can be before.
    pub(super) armed_after: AtomicU32,
    /// Energy that the guard observed, J, as bits of an `f32`.
    pub(super) energy_bits: AtomicU32,
    pub(super) period_us: AtomicU32,
}

impl Shared {
    pub(super) fn now_us(&self) -> u64 {
        self.began.elapsed().as_micros() as u64
    }

    pub(super) fn conversation(&self) -> MutexGuard<'_, Conversation> {
        lock(&self.conversation)
    }
}

/// Whoever panicked with it has been seen; what is inside are counters.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
