//! Why a device cannot be emulated.

use haptic_loop::ParameterError;
use std::fmt;
use std::path::PathBuf;
use std::string::String;

/// A device that could not be emulated.
#[derive(Debug)]
#[non_exhaustive]
pub enum EmulatorError {
    /// A fault of the line outside its range.
    Faults(ParameterError),
    /// The symbolic link could not be made.
    Link {
        /// Its name.
        link: PathBuf,
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
            Self::Faults(error) => error.fmt(f),
            Self::Link { link, error } => {
                write!(f, "cannot make the link `{}`: ", link.display())?;
                match error.kind() {
                    std::io::ErrorKind::AlreadyExists => f.write_str(
                        "it is there already; remove it if no emulator uses it, or choose another",
                    ),
                    _ => write!(f, "{error}; choose another"),
                }
            }
            Self::Terminal(reason) => f.write_str(reason),
            Self::Axes(axes) => write!(f, "axes = {axes} is not in [1, 3]: give 1, 2 or 3"),
            Self::Device(refusal) => write!(f, "the emulated device: {refusal:?}"),
        }
    }
}

impl core::error::Error for EmulatorError {}
