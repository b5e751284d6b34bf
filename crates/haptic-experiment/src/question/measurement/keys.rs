//! Keys of a measurement.

use crate::document::parameters::kind::{Parameter, parameters};
use crate::document::parameters::range::Range;
use crate::document::parameters::{DEVICE, MAX_AGE_TICKS, SAMPLE_TIME, WATCHDOG};

parameters! {
    /// Sample time of a measurement, s.
    MEASURE_SAMPLE_TIME = number("sample_time_s", SAMPLE_TIME.default_number(), SAMPLE_TIME.shown, Range::Within(1e-4, 1e-2), "Sample time");
    /// Force limit of a device that is measured, N.
    MEASURE_FORCE_LIMIT = number("force_limit_n", 10.0, "10N", Range::Within(1e-3, 1e3),
        "Largest force of the device; the measurement uses at most a fifth");
    /// Box of a measurement, m.
    MEASURE_BOX = number("box_m", 5e-3, "5mm", Range::Within(1e-4, 1.0),
        "Largest distance from the start; beyond it the force falls to zero");
    /// Length of the multi-sine, s.
    MEASURE_DURATION = number("duration_s", 8.0, "8s", Range::Within(1.0, 600.0), "Length of the multi-sine");
    /// A hand at the device.
    HELD = flag("held", "A hand holds the device as still as it can: its stiffness is found too");
    /// The device that is measured.
    MEASURE_DEVICE = text("device", "serial:auto", DEVICE.help);
}

/// Of a measurement.
pub const MEASURE: &[Parameter] = &[
    MEASURE_SAMPLE_TIME,
    MEASURE_FORCE_LIMIT,
    MEASURE_BOX,
    MEASURE_DURATION,
    HELD,
];

/// Of the device that is measured, and of the line to it.
pub(crate) const MEASURED: &[Parameter] = &[MEASURE_DEVICE, WATCHDOG, MAX_AGE_TICKS];
