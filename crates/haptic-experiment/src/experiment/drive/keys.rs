//! Keys of `[drive]`.

use crate::document::parameters::CONTROLLER;
use crate::document::parameters::kind::{Parameter, parameters};
use crate::document::parameters::range::FORCE_LIMITS;

parameters! {
    /// Force limit of the drive, N.
    DRIVE_FORCE_LIMIT = number("drive_force_limit_n", 10.0, "10N", FORCE_LIMITS, "Largest force of the drive on the indenter");
}

/// Of `[drive]`, beside `[relax]` or `[creep]`.
pub const DRIVE: &[Parameter] = &[CONTROLLER, DRIVE_FORCE_LIMIT];
