//! State of a device, and what happens to it.

use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// State of a device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum State {
    /// Zero force; parameters can be set.
    #[default]
    Idle,
    /// Zero force, ready to run; needs the host to be there.
    Armed,
    /// The loop is closed; needs the host to be there.
    Running,
    /// The force falls to zero within the stop time.
    Stopping,
    /// A fault is latched: the force falls to zero, or is.
    Fault,
}

impl core::fmt::Display for State {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Idle => "idle",
            Self::Armed => "armed",
            Self::Running => "running",
            Self::Stopping => "stopping",
            Self::Fault => "in a fault",
        })
    }
}

/// State and fault of a device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Status {
    /// The state.
    pub state: State,
    /// Code of the latched fault; 0 for none.
    pub fault: u8,
    /// Faults since power-up, modulo 2¹⁶.
    #[serde(with = "postcard::fixint::le")]
    pub faults: u16,
}

/// Something happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Event {
    /// The kind of event.
    pub kind: EventKind,
    /// At this tick.
    #[serde(with = "postcard::fixint::le")]
    pub tick: u32,
    /// Device time, µs.
    #[serde(with = "postcard::fixint::le")]
    pub time_us: u64,
}

/// The kind of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum EventKind {
    /// A configuration took effect.
    Configured,
    /// Armed.
    Armed,
    /// A run began.
    Started,
    /// A run had all its ticks and its force has fallen to zero.
    Finished,
    /// A run was stopped and its force has fallen to zero.
    Stopped,
    /// Disarmed, and the force has fallen to zero.
    Disarmed,
}

/// A fault latched.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct FaultReport {
    /// State, code of the fault, and their number.
    pub status: Status,
    /// At this tick.
    #[serde(with = "postcard::fixint::le")]
    pub tick: u32,
    /// Device time, µs.
    #[serde(with = "postcard::fixint::le")]
    pub time_us: u64,
}

/// The device is there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Alive {
    /// From the request.
    #[serde(with = "postcard::fixint::le")]
    pub token: u32,
    /// Device time, µs.
    #[serde(with = "postcard::fixint::le")]
    pub time_us: u64,
    /// State and fault.
    pub status: Status,
    /// Energy that the passivity guard has observed, J: positive if the device gave it to the loop; 0 without
    /// a guard.
    pub observed_energy_j: f32,
}
