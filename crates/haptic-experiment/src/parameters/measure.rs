//! Of a measurement of the device itself.

use super::experiment::SAMPLE_TIME;
use super::kind::{Parameter, parameters};
use super::range::Range;

parameters! {
    /// Sample time of a measurement, s.
    MEASURE_SAMPLE_TIME = number("sample_time_s", SAMPLE_TIME.default_number(), SAMPLE_TIME.shown, Range::Within(1e-4, 1e-2), "Sample time");
    /// Force limit of a device that is measured, N.
    MEASURE_FORCE_LIMIT = number("force_limit_n", 10.0, "10N", Range::Within(1e-3, 1e3),
        "Largest force that the device may make; the measurement uses a fifth of it at most");
    /// Box of a measurement, m.
    MEASURE_BOX = number("box_m", 5e-3, "5mm", Range::Within(1e-4, 1.0),
        "Distance from the start within which the device stays; beyond it the force falls to zero");
    /// Length of the multi-sine, s.
    MEASURE_DURATION = number("duration_s", 8.0, "8s", Range::Within(1.0, 600.0), "Length of the multi-sine");
}

/// Of a measurement.
pub const MEASURE: &[Parameter] = &[
    MEASURE_SAMPLE_TIME,
    MEASURE_FORCE_LIMIT,
    MEASURE_BOX,
    MEASURE_DURATION,
];
