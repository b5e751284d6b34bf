//! Keys of `[relax]` and `[creep]`: a tissue and how it is rendered.

use crate::document::parameters::kind::{Parameter, parameters};
use crate::document::parameters::range::{DURATIONS, STRAINS, STRESSES};
use crate::document::parameters::{
    AREA, CONTACT, DEVICE_MODEL, ENCODER_RESOLUTION, FORCE_LIMIT, FORCE_RATE_LIMIT, LIBRARY,
    SAMPLE_TIME, SCHEME, SEED, SENSOR_NOISE, THICKNESS, TISSUE,
};

parameters! {
    /// Strain of a relaxation.
    STRAIN = number("strain", 0.05, "5%", STRAINS, "Strain to hold");
    /// Ramp of a relaxation, s.
    RAMP_TIME = number("ramp_time_s", 1.0, "1s", DURATIONS, "Time to reach it");
    /// End of a relaxation, s.
    RELAX_DURATION = number("duration_s", 200.0, "200s", DURATIONS,
        "Duration, from the start of the ramp");
    /// Stress of a creep test, Pa.
    STRESS = number("stress_pa", 100.0, "100Pa", STRESSES, "Stress to hold");
    /// End of a creep test, s.
    CREEP_DURATION = number("duration_s", 200.0, "200s", DURATIONS, "Duration");
    /// Number type of the loop.
    PRECISION = text("precision", "f64", "Number type of the loop");
}

/// Of `[relax]`, beside [`RENDERING`].
pub const RELAX: &[Parameter] = &[STRAIN, RAMP_TIME, RELAX_DURATION];

/// Of `[creep]`, beside [`RENDERING`].
pub const CREEP: &[Parameter] = &[STRESS, CREEP_DURATION];

/// Of the rendering: the tissue, and how it is rendered.
pub const RENDERING: &[Parameter] = &[
    TISSUE,
    LIBRARY,
    AREA,
    THICKNESS,
    SCHEME,
    PRECISION,
    SAMPLE_TIME,
    CONTACT,
    ENCODER_RESOLUTION,
    SENSOR_NOISE,
    SEED,
    FORCE_LIMIT,
    FORCE_RATE_LIMIT,
    DEVICE_MODEL,
];
