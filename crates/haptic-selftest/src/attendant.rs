//! The person beside the device, and the way to it.

use super::promise::Promise;
use haptic_experiment::Failure;
use haptic_remote::serial::SerialLink;
use std::fmt;
use std::sync::atomic::AtomicBool;

/// Notice for the person beside the device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Notice {
    /// The device is real and may move with this force, N.
    MayMove(f32),
    /// This promise is tried now.
    Trying(Promise),
    /// The emergency stop is to be pressed within [`SelfTest::PATIENCE`](super::SelfTest::PATIENCE).
    PressEmergencyStop,
    /// It is to be released again.
    ReleaseEmergencyStop,
}

/// Somebody who connects, watches, and may end the test.
#[derive(Clone, Copy)]
pub struct Attendant<'a> {
    /// Connects with the device; called again after the link was closed.
    pub connect: &'a dyn Fn() -> Result<SerialLink, Failure>,
    /// Hears what goes on.
    pub notice: &'a dyn Fn(Notice),
    /// Set to end the test.
    pub stop: &'a AtomicBool,
}

impl fmt::Debug for Attendant<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Attendant").finish_non_exhaustive()
    }
}
