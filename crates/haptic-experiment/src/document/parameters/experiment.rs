//! Of `[relax]` and `[creep]`: a tissue and how it is rendered.

use super::device::DEVICE_MODEL;
use super::kind::{Parameter, parameters};
use super::range::{
    DURATIONS, FORCE_LIMITS, FORCE_RATES, SAMPLE_TIMES, SENSOR_STEPS, SPECIMENS, STRAINS, STRESSES,
};

parameters! {
    /// Strain of a relaxation.
    STRAIN = number("strain", 0.05, "5%", STRAINS, "Strain that is held");
    /// Ramp of a relaxation, s.
    RAMP_TIME = number("ramp_time_s", 1.0, "1s", DURATIONS, "Time to reach it");
    /// End of a relaxation, s.
    RELAX_DURATION = number("duration_s", 200.0, "200s", DURATIONS,
        "End of the experiment, from the start of the ramp");
    /// Stress of a creep test, Pa.
    STRESS = number("stress_pa", 100.0, "100Pa", STRESSES, "Stress that is held");
    /// End of a creep test, s.
    CREEP_DURATION = number("duration_s", 200.0, "200s", DURATIONS, "How long");
    /// Name of a tissue.
    TISSUE = text("tissue", "prostate-cancerous", "Tissue: a name from `host-cli materials list`, or the path of a TOML file");
    /// Folder of tissues.
    LIBRARY = text("library", "", "Folder with more tissue files");
    /// Area of the specimen, m².
    AREA = number("area_m2", 4e-4, "4cm2", SPECIMENS, "Area of the specimen");
    /// Thickness of the specimen, m.
    THICKNESS = number("thickness_m", 0.02, "20mm", SPECIMENS, "Thickness of the specimen");
    /// Scheme of the operator.
    SCHEME = text("scheme", "full", "Fractional operator, as in full, grunwald:1000 or tustin-muir:3");
    /// Number type of the loop.
    PRECISION = text("precision", "f64", "Number type of the loop");
    /// Sample time of any loop, s.
    SAMPLE_TIME = number("sample_time_s", 1e-3, "1ms", SAMPLE_TIMES, "Sample time of the loop");
    /// Contact of the rig.
    CONTACT = text("contact", "compliant", "Contact between indenter and tissue: stiff springs between masses, or imposed exactly");
    /// Encoder of a simulated device, m.
    ENCODER_RESOLUTION = number("encoder_resolution_m", 0.0, "0", SENSOR_STEPS,
        "Resolution of the position encoder per count; 0 for an ideal one");
    /// Noise of a simulated sensor, m.
    SENSOR_NOISE = number("sensor_noise_m", 0.0, "0", SENSOR_STEPS, "Standard deviation of the sensor noise; 0 for none");
    /// Seed of the noise.
    SEED = count("seed", 1, "1", "Seed of the noise: the same seed gives the same run, bit for bit");
    /// Force limit of a rendered tissue, N.
    FORCE_LIMIT = number("force_limit_n", 10.0, "10N", FORCE_LIMITS, "Largest force the loop may command");
    /// Controller of the indenter.
    CONTROLLER = text("controller", "", "Controller file of the drive: the indenter is a mass that it holds on its way");
    /// Force limit of the drive, N.
    DRIVE_FORCE_LIMIT = number("drive_force_limit_n", 10.0, "10N", FORCE_LIMITS, "Largest force of the drive on the indenter");
    /// Rate limit of a rendered tissue, N/s.
    FORCE_RATE_LIMIT = number("force_rate_limit_n_per_s", 1000.0, "1000N/s", FORCE_RATES, "Largest rate at which the force may change");
}

/// Of `[relax]`, beside [`RENDERING`].
pub const RELAX: &[Parameter] = &[STRAIN, RAMP_TIME, RELAX_DURATION];
/// Of `[creep]`, beside [`RENDERING`].
pub const CREEP: &[Parameter] = &[STRESS, CREEP_DURATION];
/// Of `[drive]`, beside `[relax]` or `[creep]`.
pub const DRIVE: &[Parameter] = &[CONTROLLER, DRIVE_FORCE_LIMIT];
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
