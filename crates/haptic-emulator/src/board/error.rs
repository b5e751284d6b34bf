//! Why a device cannot be emulated.

use haptic_loop::ParameterError;
use std::fmt;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// A device that could not be emulated.
#[derive(Debug)]
#[non_exhaustive]
pub enum EmulatorError {
    /// A fault of the line outside its range.
    Faults(ParameterError),
    /// A sensor outside its range.
    Body(ParameterError),
    /// The symbolic link could not be made.
    Link {
        /// Its name.
        link: PathBuf,
        /// Why.
        error: std::io::Error,
    },
    /// The socket could not be made.
    Socket {
        /// Its name.
        path: PathBuf,
        /// Why.
        error: std::io::Error,
    },
    /// The system gives no pseudo-terminal, or it cannot be shared.
    Terminal(String),
    /// A number of axes that no device has.
    Axes(u8),
    /// The emulated device refused its own start-up configuration.
    Device(haptic_link::Refusal),
}

impl fmt::Display for EmulatorError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Faults(error) | Self::Body(error) => error.fmt(f),
            Self::Link { link, error } => not_made(f, "link", link, error),
            Self::Socket { path, error } => not_made(f, "socket", path, error),
            Self::Terminal(reason) => f.write_str(reason),
            Self::Axes(axes) => write!(f, "axes = {axes} is not in [1, 3]: give 1, 2 or 3"),
            Self::Device(refusal) => write!(f, "the emulated device: {refusal:?}"),
        }
    }
}

/// A file of this kind that cannot be made.
fn not_made(
    f: &mut fmt::Formatter<'_>,
    kind: &str,
    path: &Path,
    error: &std::io::Error,
) -> fmt::Result {
    write!(f, "cannot make the {kind} `{}`: ", path.display())?;
    match error.kind() {
        ErrorKind::AlreadyExists => {
            f.write_str("it is there already; remove it if no emulator uses it, or choose another")
        }
        _ => write!(f, "{error}; choose another"),
    }
}

impl core::error::Error for EmulatorError {}
