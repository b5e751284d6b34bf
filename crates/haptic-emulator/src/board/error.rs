//! Why a device cannot be emulated.

use haptic_loop::LoopParameterError;
use std::{
    io::{Error, ErrorKind},
    path::PathBuf,
};

/// A device that could not be emulated.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EmulatorError {
    /// A fault of the line or a sensor outside its range.
    #[error(transparent)]
    Parameter(#[from] LoopParameterError),
    /// The symbolic link could not be made.
    #[error("cannot make the link `{}`: {}", .path.display(), why(.error))]
    Path {
        /// Path that the link should have.
        path: PathBuf,
        /// Error of the operating system.
        error: Error,
    },
    /// The address cannot be listened at.
    #[error(transparent)]
    Address(#[from] haptic_remote::serial::SerialError),
    /// The system gives no pseudo-terminal, or it cannot be shared.
    #[error("{0}")]
    Terminal(String),
    /// A number of axes that no device has.
    #[error("axes = {0} is not in [1, 3]: give 1, 2 or 3")]
    Axes(u8),
    /// A specimen or a scripted hand at a handle of so many axes.
    #[error("a specimen or a scripted hand has one axis, not {0}: give axes = 1")]
    AtHandle(u8),
    /// The emulated device refused its own start-up configuration.
    #[error("the emulated device: {0:?}")]
    Device(haptic_link::Refusal),
}

fn why(error: &Error) -> String {
    if error.kind() == ErrorKind::AlreadyExists {
        "it is there already; remove it if no emulator uses it, or choose another".to_owned()
    } else {
        format!("{error}; choose another")
    }
}
