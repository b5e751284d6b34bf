//! Controllers, margins and refusals as a report has them.

use fractional_control::{ControlError, Crossing, Margins, Shape};
use haptic_experiment::Failure;
use haptic_experiment::control::in_degrees;
use serde_json::{Value, json};

/// A refusal of the library: bad input, or a search that ended with nothing.
pub(crate) fn refused(error: ControlError) -> Failure {
    let text = in_degrees(&error);
    if matches!(error, ControlError::NotFound { .. }) {
        return Failure::run(format_args!("{text}"));
    }
    Failure::bad_input(text)
}

pub(super) fn margins(margins: &Margins) -> Value {
    let value = |crossing: Option<Crossing>| crossing.map(|crossing| crossing.value);
    let frequency = |crossing: Option<Crossing>| crossing.map(|crossing| crossing.omega_rad_s);
    json!({
        "crossover_rad_s": frequency(margins.phase),
        "crossovers": margins.crossovers,
        "phase_margin_deg": value(margins.phase).map(f64::to_degrees),
        "gain_up": value(margins.gain_up),
        "gain_up_rad_s": frequency(margins.gain_up),
        "gain_down": value(margins.gain_down),
        "gain_down_rad_s": frequency(margins.gain_down),
        "delay_margin_s": value(margins.delay_s),
        "sensitivity_peak": margins.sensitivity.value,
        "sensitivity_peak_rad_s": margins.sensitivity.omega_rad_s,
        "complementary_peak": margins.complementary.value,
        "complementary_peak_rad_s": margins.complementary.omega_rad_s,
    })
}

pub(super) fn shape(shape: &Shape, sample_time_s: f64) -> Value {
    json!({
        "overshoot": shape.overshoot,
        "rise_time_s": shape.rise.map(|samples| samples * sample_time_s),
        "settling_time_s": shape.settled.map(|samples| samples as f64 * sample_time_s),
        "final_error": shape.final_error,
    })
}
