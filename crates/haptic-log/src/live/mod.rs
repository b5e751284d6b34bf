//! Live streams: the samples of a run, for other programs, while it goes.
//!
//! ```text
//! loop ──▶ queue ──▶ writer thread ──┬──▶ log, whole
//!                                    ├──▶ Foxglove WebSocket ──▶ Foxglove, PlotJuggler
//!                                    └──▶ Teleplot UDP
//! ```
//!
//! A live stream is a courtesy: it cannot fail a run, and never waits for a viewer. What a slow or
//! vanished viewer misses is in the log.
//!
//! Streams are stamped with the time of day: that of the first message, plus device time since.
//! So the spacing is the device's, runs do not overlap in a viewer that stays open, and in virtual
//! time, where a run passes in a burst, the stamps run ahead of the clock.

#[cfg(feature = "foxglove")]
mod foxglove;
mod teleplot;

#[cfg(feature = "foxglove")]
pub use self::foxglove::Foxglove;
pub use self::teleplot::{DATAGRAM_BYTES, Teleplot};

use crate::record::{EventMessage, TickMessage, VectorTick};
use std::fmt::Debug;
use std::net::SocketAddr;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// Somebody who watches a run. Called from the thread that writes the log, in the order of the log.
pub trait Live: Debug + Send {
    /// A sample of one axis; must not wait.
    fn tick(&mut self, message: &TickMessage);

    /// A sample of two or three axes; must not wait.
    fn vector_tick(&mut self, message: &VectorTick);

    /// An event; must not wait.
    fn event(&mut self, message: &EventMessage);

    /// The run has ended: sends what is left, in less than a second, and says what was lost, if
    /// anything was: a sentence for the user.
    fn finish(self: Box<Self>) -> Option<String>;
}

/// A live stream that could not be opened.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LiveError {
    /// The address is taken, not ours, or not reachable.
    #[error("live stream at {address}: {source}")]
    Open {
        /// The address.
        address: SocketAddr,
        /// Why.
        source: std::io::Error,
    },
    /// The WebSocket server could not be started.
    #[error("live stream at {address}: {reason}")]
    Server {
        /// The address.
        address: SocketAddr,
        /// Why.
        reason: String,
    },
}

/// Opened streams, waiting for the one run that they are for.
#[derive(Debug, Default)]
pub struct LiveStreams(Mutex<Vec<Box<dyn Live>>>);

impl LiveStreams {
    /// Gathers streams.
    #[must_use]
    pub fn new(streams: Vec<Box<dyn Live>>) -> Self {
        Self(Mutex::new(streams))
    }

    /// Hands them to the run; a second one gets none.
    #[must_use]
    pub fn take(&self) -> Vec<Box<dyn Live>> {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// Turns device time into time of day.
#[derive(Clone, Copy, Debug, Default)]
struct TimeOfDay {
    /// Time of day at device time 0, in whole ms since 1970, so that stamps stay short in decimal.
    start_ms: Option<f64>,
}

impl TimeOfDay {
    /// Time of day, ms since 1970, to the µs.
    fn milliseconds(&mut self, time_s: f64) -> f64 {
        let time_ms = 1e3 * time_s;
        let start_ms = *self.start_ms.get_or_insert_with(|| {
            let now = SystemTime::now().duration_since(UNIX_EPOCH);
            (1e3 * now.unwrap_or(Duration::ZERO).as_secs_f64() - time_ms).round()
        });
        ((start_ms + time_ms) * 1e3).round() / 1e3
    }

    /// Time of day, ns since 1970.
    #[cfg(feature = "foxglove")]
    fn nanoseconds(&mut self, time_s: f64) -> u64 {
        self.milliseconds(time_s);
        // The sum would lose digits in f64. Casts saturate.
        let start_ms = self.start_ms.unwrap_or(0.0) as u64;
        start_ms
            .saturating_mul(1_000_000)
            .saturating_add((1e9 * time_s).round() as u64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_are_the_time_of_day_with_the_spacing_of_the_device() {
        let mut stamp = TimeOfDay::default();
        let now = SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .expect("after 1970");
        let first = stamp.milliseconds(100.0);
        assert!(
            (first - 1e3 * now.as_secs_f64()).abs() < 10e3,
            "{first} at {now:?}"
        );
        let next = stamp.milliseconds(100.0001);
        assert!((next - first - 0.1).abs() < 1e-3, "{first} to {next}");
        // No digits but those of the time.
        assert!(next.to_string().ends_with(".1"), "{next}");
    }

    #[test]
    #[cfg(feature = "foxglove")]
    fn nanoseconds_are_exact() {
        let mut stamp = TimeOfDay::default();
        let first = stamp.nanoseconds(0.0);
        assert_eq!(stamp.nanoseconds(1.000_000_001) - first, 1_000_000_001);
        assert_eq!(first % 1_000_000, 0);
    }
}
