//! Keys of `[coupler]`.

use crate::document::parameters::kind::{Parameter, joined, parameters};
use crate::document::parameters::range::{COUPLER_ORDERS, DAMPINGS, OBJECT_MASSES, STIFFNESSES};
use crate::document::parameters::{
    COUPLER_DISSIPATION, COUPLER_STIFFNESS, DAMPING, DEVICE_MODEL, HAND_STIFFNESS, LESS_THAN_IDEAL,
    MASS, SAMPLE_TIME,
};
use crate::experiment::trial::keys::{TRIAL, TRIAL_LOOP};

parameters! {
    /// Order of a coupler.
    COUPLER_ORDER = optional("order", COUPLER_ORDERS,
        "Order of the coupler: 1 a spring beside a damper, below 1 the spring creeps; above 1 it would generate energy");
    /// Mass of the object, kg.
    OBJECT_MASS = number("object_mass_kg", 0.1, "100g", OBJECT_MASSES, "Mass of the object behind the coupler");
    /// Damping of the object, N·s/m.
    OBJECT_DAMPING = number("object_damping_n_s_per_m", 1.0, "1", DAMPINGS, "Viscous damping of the object");
    /// Spring of the object, N/m.
    OBJECT_STIFFNESS = number("object_stiffness_n_per_m", 500.0, "500", STIFFNESSES,
        "Spring between object and ground; 0 = the object drifts");
    /// True if a refused coupler is a failure.
    COUPLER_MUST_BE_STABLE = flag("must_be_stable",
        "Fail unless trial, analysis and Llewellyn's criterion accept the coupler");
}

/// Of `[coupler]` that have to be given in a file.
pub const COUPLER_REQUIRED: &[Parameter] = &[
    MASS,
    DAMPING,
    SAMPLE_TIME,
    COUPLER_ORDER,
    COUPLER_STIFFNESS,
    COUPLER_DISSIPATION,
];

/// Of `[coupler]`, with defaults.
pub const COUPLER: &[Parameter] = &joined::<19>(&[
    &[DEVICE_MODEL, OBJECT_MASS, OBJECT_DAMPING, OBJECT_STIFFNESS],
    &[HAND_STIFFNESS],
    LESS_THAN_IDEAL,
    TRIAL_LOOP,
    TRIAL,
    &[COUPLER_MUST_BE_STABLE],
]);
