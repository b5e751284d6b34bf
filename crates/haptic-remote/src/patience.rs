//! Patience with a device that says nothing: only time in which this machine listened counts against it.
//!
//! ```text
//! a wait      asked: the time after which it was to be back,  took: by the clock
//! listened    Σ min(took, asked)           a thread that woke 300 ms late has not listened for these 300 ms
//! a round     from the end of one read to the end of the next: its wait, and the work on what came before
//! silent      listened now − listened when the device was heard last
//! over        silent ≥ most
//! ```
//! - *A device that answers in time is never given up*: it sends at most `most` after it was heard last, and whatever has come is
//!   taken before a wait counts. Between the two this machine cannot have listened for `most`.
//! - *A silent one is given up after* `most` of listening, that is after ⌈most/asked⌉ waits, however late each of them ends. On a
//!   machine that runs its threads in time this is `most` by the clock.
//! - *One that floods is silent, too*: no read of it waits, so whoever reads counts rounds. Only a good frame is a sign of the device.
//!
//! *Cost*: some additions per wait. No clock is read here: time is an argument.

use core::time::Duration;

/// The time for which a device may be silent, by the time in which this machine listened.
///
/// ```
/// use core::time::Duration;
/// use haptic_remote::Patience;
///
/// let mut patience = Patience::new(Duration::from_millis(100));
/// // A thread that was to wait for 20 ms, and was stopped for 5 s.
/// patience.waited(Duration::from_millis(20), Duration::from_secs(5));
/// assert_eq!(patience.left(), Duration::from_millis(80));
/// patience.heard();
/// assert_eq!(patience.left(), Duration::from_millis(100));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Patience {
    most: Duration,
    heard: Duration,
    listened: Duration,
    /// Looks that found it over.
    looks: usize,
}

impl Patience {
    /// Patience with a device that was heard just now.
    #[must_use]
    pub const fn new(most: Duration) -> Self {
        Self::since(most, Duration::ZERO)
    }

    /// Patience with a device that was heard just now, by the count of a thread that has listened for `listened`.
    #[must_use]
    pub const fn since(most: Duration, listened: Duration) -> Self {
        Self {
            most,
            heard: listened,
            listened,
            looks: 0,
        }
    }

    /// The device gave a sign: its time begins anew.
    pub const fn heard(&mut self) {
        (self.heard, self.looks) = (self.listened, 0);
    }

    /// Looks that have found it over, with this one.
    #[cfg(feature = "std")]
    pub(crate) const fn looks_when_over(&mut self) -> usize {
        self.looks += 1;
        self.looks
    }

    /// A wait for the device has ended; what came meanwhile was taken.
    pub fn waited(&mut self, asked: Duration, took: Duration) {
        self.listened = self.listened.saturating_add(asked.min(took));
    }

    /// Another thread has listened for this long now. Read its count first, then take what has come, then pass the count here: what
    /// comes between the two is not missed.
    pub fn listened_for(&mut self, listened: Duration) {
        self.listened = self.listened.max(listened);
    }

    /// Time that was listened, since the count began.
    #[must_use]
    pub const fn listened(&self) -> Duration {
        self.listened
    }

    /// Time of listening without a sign of the device.
    #[must_use]
    pub const fn silent(&self) -> Duration {
        self.listened.saturating_sub(self.heard)
    }

    /// Time of listening until it is over: no wait needs to take longer.
    #[must_use]
    pub const fn left(&self) -> Duration {
        self.most.saturating_sub(self.silent())
    }

    /// The device has been silent for too long.
    #[must_use]
    pub const fn is_over(&self) -> bool {
        self.left().is_zero()
    }
}
