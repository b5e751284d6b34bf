//! Keys of a wall.

use super::trial::{TRIAL, TRIAL_LOOP};
use crate::safety::keys::SAFETY;
use haptic_document::{
    parameters,
    parameters::{
        DAMPING, DEVICE_MODEL, HAND_STIFFNESS, KeyTable, LESS_THAN_IDEAL, MASS, ON_DEVICE,
        Parameter, Paths, SAMPLE_TIME, TISSUE_IN_LOG, UNNAMED_PIECE, joined,
        range::{DISSIPATIONS, STIFFNESSES, WALL_ORDERS},
    },
};

parameters! {
    ORDER = optional("order", WALL_ORDERS, "Order of the dissipation: 0 a spring, 1 a damper");
    /// Stiffness of a wall, N/m.
    STIFFNESS = optional("stiffness_n_per_m", STIFFNESSES, "Stiffness K of the wall");
    /// Dissipation of a wall, N·s^μ/m.
    DISSIPATION = optional("dissipation_n_s_mu_per_m", DISSIPATIONS, "Dissipation B of the wall, N·s^μ/m");
    /// A tissue in place of K, B and order.
    WALL_TISSUE = file("tissue", "", Paths::Toml, Some(TISSUE_IN_LOG),
        "Tissue in place of order, K and B: a name from `host-cli materials list`, or a TOML file");
    /// True if a wall only pushes.
    ONE_SIDED = flag("one_sided", "Push but never pull; otherwise the wall is linear, as the analysis assumes, and pulls too");
    /// Memory of a wall that only pushes.
    WALL_CONTACT = text("contact", "depth", "Input of the memory of a wall that only pushes");
    /// True if an unstable wall is a failure.
    MUST_BE_STABLE = flag("must_be_stable", "Fail unless trial and analysis call the wall stable");
}

/// Keys of `[wall]` that have to be given in a file.
pub const WALL_REQUIRED: &[Parameter] = &[MASS, DAMPING, SAMPLE_TIME];

/// Keys of the law: order, K and B, or a piece of tissue.
pub const WALL_LAW: &[Parameter] = &joined::<11>(&[
    &[ORDER, STIFFNESS, DISSIPATION],
    &[WALL_TISSUE],
    UNNAMED_PIECE,
]);

/// Keys of `[wall]` with defaults.
pub const WALL: &[Parameter] = &joined::<21>(&[
    &[DEVICE_MODEL, HAND_STIFFNESS],
    LESS_THAN_IDEAL,
    TRIAL_LOOP,
    &[ONE_SIDED, WALL_CONTACT],
    TRIAL,
    &[MUST_BE_STABLE],
]);

/// Keys of the table `[wall]`, under their headings.
pub const WALL_TABLES: &[KeyTable] = &[
    ("required", WALL_REQUIRED),
    ("law", WALL_LAW),
    ("wall", WALL),
    ("device", ON_DEVICE),
    ("safety", SAFETY),
];
