//! Parameters: key, default, range and a line for people, once. Files, options with their help, and the reference of keys are
//! made from tables of them. Each kind of experiment has its own beside it; here are those that several share.
//!
//! Keys carry the SI unit of the value. `shown` is the default as a person writes it, and its value is the same (a test
//! holds each against the number).

mod common;
mod controller;
mod kind;
pub mod range;

pub use common::*;
pub use controller::*;
pub use kind::{KeyTable, Parameter, Paths, Value, joined};
pub use range::{Range, in_degrees};

use haptic_quantity::Key;

/// Runs although the analysis says no.
pub const FORCE_UNSTABLE: Key = Key("force_unstable");
/// Folder or file for what a command writes.
pub const OUT: Key = Key("out");
/// Leave to write over a file or into a folder that is there.
pub const OVERWRITE: Key = Key("overwrite");
/// Runs by the clock, not in virtual time.
pub const REALTIME: Key = Key("realtime");
/// Share of the ticks that may be skipped.
pub const SKIPPED_SHARE: Key = Key("skipped_most");
/// Port at which one side of a teleoperation waits.
pub const LISTEN: Key = Key("listen");
/// Address of its other side.
pub const CONNECT: Key = Key("connect");
/// The core to which a loop is bound.
pub const PIN: Key = Key("pin");
/// Rate of a loop, Hz.
pub const RATE: Key = Key("rate_hz");
