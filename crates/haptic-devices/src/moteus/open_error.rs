//! Why a servo cannot be opened.

use super::trouble::Trouble;
use haptic_loop::ParameterError;
use haptic_remote::serial::SerialError;
use thiserror::Error;

/// A servo that cannot be opened.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MoteusOpenError {
    /// The port.
    #[error(transparent)]
    Port(#[from] SerialError),
    /// A setting outside its range.
    #[error(transparent)]
    Settings(#[from] ParameterError),
    /// The servo or its adapter.
    #[error(transparent)]
    Trouble(#[from] Trouble),
    /// Reads of the port cannot be made not to wait.
    #[error("{path}: the port cannot be read without waiting: {error}")]
    Patience {
        /// The port.
        path: String,
        /// Words of the system.
        error: std::io::Error,
    },
}
