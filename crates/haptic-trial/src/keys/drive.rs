//! Keys of a drive.

use haptic_document::{
    parameters,
    parameters::{
        CONTROLLER, DRIVE_DEVICE, DRIVE_DEVICE_MODEL, DRIVE_LOOP, Parameter,
        range::{DAMPINGS, FORCE_LIMITS, STIFFNESSES},
    },
};

parameters! {
    /// Force limit of the drive, N.
    DRIVE_FORCE_LIMIT = optional("drive_force_limit_n", FORCE_LIMITS,
        "Largest force of the drive on the indenter [default: four times the peak that the tissue predicts, and twice the friction of the device; beside [wall] or [coupler] the push]");
    /// Spring of the contact of two devices, N/m.
    CONTACT_STIFFNESS = number("contact_stiffness_n_per_m", 1e5, "100kN/m", STIFFNESSES, "Stiffness of the contact of two devices, for the analysis");
    /// Damper of that contact, N·s/m.
    CONTACT_DAMPING = number("contact_damping_n_s_per_m", 80.0, "80", DAMPINGS, "Damping of that contact, for the analysis");
}

/// Keys of `[drive]`: some are for `[relax]` and `[creep]` alone.
pub const DRIVE: &[Parameter] = &[
    CONTROLLER,
    DRIVE_FORCE_LIMIT,
    DRIVE_DEVICE,
    DRIVE_DEVICE_MODEL,
    DRIVE_LOOP,
    CONTACT_STIFFNESS,
    CONTACT_DAMPING,
];
