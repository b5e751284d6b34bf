//! What the targets share: scripts for a device, read from the bytes of the fuzzer.
#![forbid(unsafe_code)]

mod device;
mod script;
#[path = "../../crates/haptic-remote/tests/remote/witness.rs"]
mod witness;

pub use device::Bench;
pub use script::{Step, Steps};
