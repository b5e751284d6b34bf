//! The services that a loop asks of a system, and the reasons for a refusal.

use core::fmt;

/// Why the system did not do what was asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Refusal {
    /// This user may not.
    NotPermitted,
    /// More than this user's limit.
    Limit,
    /// This system cannot.
    Unsupported,
    /// Its error code.
    Other(i32),
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotPermitted => f.write_str("not permitted"),
            Self::Limit => f.write_str("above this user's limit"),
            Self::Unsupported => f.write_str("not on this system"),
            Self::Other(code) => write!(f, "error {code} of the system"),
        }
    }
}

impl core::error::Error for Refusal {}

/// The services of a system for the calling thread.
pub(super) trait System {
    fn raise(&mut self, priority: u8) -> Result<(), Refusal>;
    fn pin(&mut self, core: usize) -> Result<(), Refusal>;
    fn lock_memory(&mut self) -> Result<(), Refusal>;
    fn restore(&mut self);
}
