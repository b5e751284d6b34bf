//! Live streams: the samples of a run, for other programs, while it goes.
//!
//! ```text
//! loop ──▶ queue ──▶ writer thread ──┬──▶ log, whole
//!                                    └──▶ Foxglove WebSocket ──▶ Foxglove, PlotJuggler
//! ```
//!
//! A live stream cannot fail a run and never waits for a viewer. What a slow viewer misses is in the log.
//!
//! Streams are stamped with the time of day of the first message, plus device time since: so the spacing is the
//! device's, and runs do not overlap in a viewer that stays open.

#[cfg(feature = "foxglove")]
mod foxglove;

#[cfg(feature = "foxglove")]
pub use self::foxglove::Foxglove;

use haptic_message::{EventMessage, TickMessage};
use std::{
    fmt::Debug,
    net::SocketAddr,
    sync::{Mutex, PoisonError},
};

/// A viewer of a run. Called from the thread that writes the log, in the order of the log.
pub trait Live: Debug + Send {
    /// A sample; must not wait.
    fn tick(&mut self, message: &TickMessage);

    /// An event; must not wait.
    fn event(&mut self, message: &EventMessage);

    /// The run has ended: sends the rest, in less than a second, and reports a loss, if
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
        /// Address to listen at, which failed.
        address: SocketAddr,
        /// The error of the system, as of a port that is taken.
        source: std::io::Error,
    },
    /// The WebSocket server could not be started.
    #[error("live stream at {address}: {reason}")]
    Server {
        /// Address of the WebSocket server.
        address: SocketAddr,
        /// The reason in the words of the server.
        reason: String,
    },
}

/// Opened streams, waiting for their one run.
#[derive(Debug, Default)]
pub struct LiveStreams(Mutex<Vec<Box<dyn Live>>>);

impl LiveStreams {
    /// Streams for one run; the thread that writes the log takes them.
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
