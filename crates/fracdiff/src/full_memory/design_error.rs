//! Why no design was found.

use crate::ParameterError;
use core::fmt;

/// Why no design was found.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum DesignError {
    /// A parameter outside its range.
    Parameter(ParameterError),
    /// The tolerance takes more modes than there is room for.
    #[non_exhaustive]
    TooManyModes {
        /// Modes that the tolerance takes.
        needed: usize,
        /// Room, the constant MODES.
        room: usize,
    },
    /// The tolerance cannot be reached in double precision.
    #[non_exhaustive]
    Unreachable {
        /// The wish.
        tolerance: f64,
        /// The best that was found.
        reached: f64,
    },
}

impl From<ParameterError> for DesignError {
    fn from(error: ParameterError) -> Self {
        Self::Parameter(error)
    }
}

impl fmt::Display for DesignError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Parameter(error) => error.fmt(f),
            Self::TooManyModes { needed, room } => write!(
                f,
                "the tolerance takes {needed} modes, there is room for {room}: allow a larger \
                 tolerance, a shorter horizon or more modes"
            ),
            Self::Unreachable { tolerance, reached } => write!(
                f,
                "tolerance {tolerance:e} cannot be reached: the best weights are within \
                 {reached:.1e}"
            ),
        }
    }
}

impl core::error::Error for DesignError {}
