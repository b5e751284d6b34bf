//! Keys of `[wall]`.

use crate::document::parameters::kind::{Parameter, joined, parameters};
use crate::document::parameters::range::{DISSIPATIONS, STIFFNESSES, WALL_ORDERS};
use crate::document::parameters::{
    DAMPING, DEVICE_MODEL, HAND_STIFFNESS, LESS_THAN_IDEAL, MASS, SAMPLE_TIME,
};
use crate::experiment::trial::keys::{TRIAL, TRIAL_LOOP};

parameters! {
    /// Order of a wall.
    ORDER = optional("order", WALL_ORDERS, "Order of the dissipation: 0 a spring, 1 a damper");
    /// Stiffness of a wall, N/m.
    STIFFNESS = optional("stiffness_n_per_m", STIFFNESSES, "Stiffness K of the wall");
    /// Dissipation of a wall, N·s^μ/m.
    DISSIPATION = optional("dissipation_n_s_mu_per_m", DISSIPATIONS, "Dissipation B of the wall, N·s^μ/m");
    /// True if a wall only pushes.
    ONE_SIDED = flag("one_sided", "Push but never pull; otherwise the wall is linear, as the theory assumes");
    /// True if an unstable wall is a failure.
    MUST_BE_STABLE = flag("must_be_stable", "Fail unless trial and analysis call the wall stable");
}

/// Of `[wall]` that have to be given in a file.
pub const WALL_REQUIRED: &[Parameter] =
    &[MASS, DAMPING, SAMPLE_TIME, ORDER, STIFFNESS, DISSIPATION];

/// Of `[wall]`, with defaults.
pub const WALL: &[Parameter] = &joined::<17>(&[
    &[DEVICE_MODEL, HAND_STIFFNESS],
    LESS_THAN_IDEAL,
    TRIAL_LOOP,
    &[ONE_SIDED],
    TRIAL,
    &[MUST_BE_STABLE],
]);
