//! Keys of relaxation and creep: the load, the operator that renders the tissue, and the rig it is rendered on.

use haptic_document::{
    named, parameters, parameters as p,
    parameters::{
        KeyTable, ON_DEVICE, Parameter, joined,
        range::{
            DAMPINGS, DISSIPATIONS, DURATIONS, FORCES_ABOVE_0, MASSES, REACHES_ABOVE_0, SHARES,
            STIFFNESSES, STRAINS, STRESSES,
        },
    },
};
use haptic_trial::safety::keys::SAFETY;
use serde::Serialize;

parameters! {
    pub mod keys;
    /// Depth of a relaxation, m.
    DEPTH = optional("depth_m", REACHES_ABOVE_0, "Depth to hold, instead of a strain");
    /// Strain of a relaxation.
    STRAIN = number("strain", 0.05, "5%", STRAINS, "Strain to hold");
    /// Ramp of a relaxation, s.
    RAMP_TIME = number("ramp_time_s", 1.0, "1s", DURATIONS, "Time to reach it");
    /// End of a relaxation, s.
    RELAX_DURATION = number("duration_s", 200.0, "200s", DURATIONS,
        "Duration, from the start of the ramp");
    /// Stress of a creep test, Pa.
    STRESS = number("stress_pa", 100.0, "100Pa", STRESSES, "Stress to hold");
    /// Force of a creep test, N.
    FORCE = optional("force_n", FORCES_ABOVE_0, "Force to hold, instead of a stress");
    /// End of a creep test, s.
    CREEP_DURATION = number("duration_s", 200.0, "200s", DURATIONS, "Duration");
    /// Contact of the rig of a creep test: what has a mass shows itself before the tissue.
    CREEP_CONTACT = text(p::CONTACT.key, "ideal",
        "Contact between indenter and tissue; with a controller or a device it is compliant");
    /// Stiffness of the spring of the tissue, N/m.
    PIECE_STIFFNESS = optional("stiffness_n_per_m", STIFFNESSES, "Stiffness of the spring instead of the tissue's");
    /// Dissipation of the spring-pot of the tissue, N·s^μ/m.
    PIECE_DISSIPATION = optional("dissipation_n_s_mu_per_m", DISSIPATIONS,
        "Dissipation of the spring-pot, N·s^μ/m, instead of the tissue's");
    /// Order of the spring-pot of the tissue.
    PIECE_ORDER = optional("order", SHARES, "Order of the spring-pot instead of its own: 0 spring, 1 damper");
    /// Mass of each of the two actuators of the rig, kg.
    RIG_MASS = number("rig_mass_kg", 0.065, "65g", MASSES, "Mass of each of the rig's two actuators");
    /// Damping of each of the two actuators of the rig, N·s/m.
    RIG_DAMPING = number("rig_damping_n_s_per_m", 3.5, "3.5", DAMPINGS, "Viscous damping of each actuator");
    /// Number type of the loop.
    PRECISION = text("precision", "f64", "Number type of the loop");
}

/// Keys of `[relax]`, beside [`RENDERING`].
pub const RELAX: &[Parameter] = &[STRAIN, DEPTH, RAMP_TIME, RELAX_DURATION, p::CONTACT];

/// Keys of `[creep]`, beside [`RENDERING`].
pub const CREEP: &[Parameter] = &[STRESS, FORCE, CREEP_DURATION, CREEP_CONTACT];

/// Keys that replace numbers of the piece's tissue: K, B and μ.
pub const CHANGES: &[Parameter] = &[PIECE_STIFFNESS, PIECE_DISSIPATION, PIECE_ORDER];

/// Keys of the rendering: those of the tissue, and how it is rendered.
pub const RENDERING: &[Parameter] = &joined::<28>(&[
    p::PIECE,
    CHANGES,
    &[p::SCHEME, PRECISION, p::SAMPLE_TIME, RIG_MASS, RIG_DAMPING],
    &[p::ENCODER_RESOLUTION, p::SENSOR_NOISE],
    p::FORCE_SENSOR,
    &[p::SEED],
    &[
        p::FORCE_LIMIT,
        p::FORCE_RATE_LIMIT,
        p::DEVICE_MODEL,
        p::AGAINST,
    ],
]);

/// The tables of `[relax]`, under their headings.
pub const RELAX_TABLES: &[KeyTable] = &[
    ("relaxation", RELAX),
    ("rendering", RENDERING),
    ("device", ON_DEVICE),
    ("safety", SAFETY),
];

/// The tables of `[creep]`, likewise.
pub const CREEP_TABLES: &[KeyTable] = &[
    ("creep", CREEP),
    ("rendering", RENDERING),
    ("device", ON_DEVICE),
    ("safety", SAFETY),
];

/// Contact of the indenter with the renderer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum IndenterContact {
    /// A stiff, one-sided spring and damper between two masses, as on a real rig.
    Compliant,
    /// The indentation or the push is imposed exactly; a push still moves the renderer's mass.
    Rigid,
    /// The indentation or the push is imposed exactly on the tissue alone: nothing has a mass.
    Ideal,
}

named! { IndenterContact:
    Compliant = "compliant", "A stiff one-sided spring and damper between two masses, as on a real rig";
    Rigid = "rigid", "The indentation is imposed exactly, or the push on the renderer's mass";
    Ideal = "ideal", "Nothing has a mass: the tissue alone";
}

/// The number type of the loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Precision {
    /// Double, 53 bits.
    F64,
    /// Single, 24 bits, as on a microcontroller.
    F32,
}

named! { Precision:
    F64 = "f64", "Double, 53 bits";
    F32 = "f32", "Single, 24 bits, as on a microcontroller";
}
