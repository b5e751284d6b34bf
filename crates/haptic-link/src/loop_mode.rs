//! The side on which the loop runs.

use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// The side on which the loop runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum LoopMode {
    /// On the device; the host sets parameters and records.
    #[default]
    Device,
    /// On the host; the device reports its position and applies the force it is sent.
    Host,
}

impl LoopMode {
    /// The watchdog time unless given, ms: 20 in a host loop, whose force is as old as the silence, and 500 in a
    /// device loop, whose force does not come from the host.
    #[must_use]
    pub const fn watchdog_ms(self) -> u16 {
        match self {
            Self::Device => 500,
            Self::Host => 20,
        }
    }
}
