//! Keys that several kinds share, or that a room below the kinds names.

use crate::document::parameters::kind::parameters;
use crate::document::parameters::range::{
    DAMPINGS, DISSIPATIONS, DURATIONS, FORCE_LIMITS, FORCE_RATES, SAMPLE_TIMES, SPECIMENS,
};

parameters! {
    /// `k_c` of a coupler, N·s/m.
    COUPLER_STIFFNESS = optional("coupler_stiffness_n_s_per_m", DAMPINGS,
        "Damper of the coupler: force = damper v + spring (integral of order mu of v), v the velocity of the deflection");
    /// `b_c` of a coupler, N·s^(1−μ)/m.
    COUPLER_DISSIPATION = optional("coupler_dissipation_n_s_1_minus_mu_per_m", DISSIPATIONS,
        "Spring of the coupler, N·s^(1−μ)/m: at order 1 N/m");
    /// Name of a tissue.
    TISSUE = text("tissue", "prostate-cancerous", "Tissue: a name from `host-cli materials list`, or a TOML file");
    /// Folder of tissues.
    LIBRARY = text("library", "", "Folder with more tissue files");
    /// Area of the specimen, m².
    AREA = number("area_m2", 4e-4, "4cm2", SPECIMENS, "Area of the specimen");
    /// Thickness of the specimen, m.
    THICKNESS = number("thickness_m", 0.02, "20mm", SPECIMENS, "Thickness of the specimen");
    /// Scheme of the operator.
    SCHEME = text("scheme", "full", "Fractional operator: full, grunwald:1000, tustin-muir:3, …");
    /// Sample time of any loop, s.
    SAMPLE_TIME = number("sample_time_s", 1e-3, "1ms", SAMPLE_TIMES, "Sample time of the loop");
    /// Contact of the rig.
    CONTACT = text("contact", "compliant", "Contact between indenter and tissue");
    /// Force limit of a rendered tissue, N.
    FORCE_LIMIT = number("force_limit_n", 10.0, "10N", FORCE_LIMITS, "Largest force the loop may command");
    /// Controller of the indenter.
    CONTROLLER = text("controller", "", "Controller file: its controller drives the indenter, which is then a mass");
    /// Rate limit of a rendered tissue, N/s.
    FORCE_RATE_LIMIT = number("force_rate_limit_n_per_s", 1000.0, "1000N/s", FORCE_RATES, "Largest rate of change of the force");
    /// Number of axes.
    TOUCH_AXES = count("axes", 2, "2", "Number of axes, 2 or 3");
    /// Length of a trial, s.
    TRIAL_DURATION = number("duration_s", 5.0, "5s", DURATIONS, "Length of a run");
}
