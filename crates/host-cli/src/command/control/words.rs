//! Controllers, margins and refusals as a report and a person see them.

use fractional_control::analysis::{Cause, LoopAnalysis};
use fractional_control::{ControlError, Crossing, Margins, PidParameters, Shape};
use haptic_experiment::Failure;
use haptic_experiment::parameters::{DELAY, SAMPLE_TIME};
use haptic_quantity::{Key, digits, written};
use serde_json::{Value, json};

/// What the tuning is asked for.
pub(super) const CROSSOVER: Key = Key("crossover_rad_s");
pub(super) const PHASE_MARGIN: Key = Key("phase_margin_rad");

/// A refusal of the library: bad input, or a search that ended with nothing.
pub(crate) fn refused(error: ControlError) -> Failure {
    let text = in_degrees(&error);
    match error {
        ControlError::NotFound { .. } => Failure::Run(anyhow::anyhow!("{text}")),
        _ => Failure::bad_input(text),
    }
}

/// The text of an error with angles in degrees, and what to change.
pub(super) fn in_degrees(error: &ControlError) -> String {
    let range = match *error {
        ControlError::Range(range) => range,
        ControlError::Contradiction {
            first,
            first_value,
            second,
            second_value,
            remedy,
        } => {
            let [a, b] = [(first, first_value), (second, second_value)]
                .map(|(key, value)| format!("{} {}", Key(key), with_unit(key, value)));
            return format!("{a} contradicts {b}: {remedy}");
        }
        error => return error.to_string(),
    };
    match (range.what, range.unit) {
        ("phase margin", _) => format!(
            "phase margin {} is not above 0 and below 180°: give {PHASE_MARGIN}, as in 60deg",
            with_unit(PHASE_MARGIN.0, range.value)
        ),
        ("crossover", _) => format!("{range}: give {CROSSOVER}"),
        ("delay", _) => format!("{range}: give a smaller {DELAY}"),
        ("dead time", "samples") => {
            format!("{range}: lengthen {SAMPLE_TIME}, or shorten the dead time")
        }
        ("samples of the record", _) => {
            format!("{range}: record for longer, or give --model with fewer terms")
        }
        _ => range.to_string(),
    }
}

/// The value of a wish with its unit, an angle in degrees.
fn with_unit(key: &str, value: f64) -> String {
    match key == PHASE_MARGIN.0 {
        true => format!("{}°", digits(value.to_degrees(), 4)),
        false => written(key, value),
    }
}

/// The verdict in a few words.
pub(super) const fn in_short(analysis: &LoopAnalysis) -> &'static str {
    match (analysis.cause, analysis.verdict.stable, analysis.coarse) {
        (Cause::Boundary | Cause::Cancelled, ..) => "on the boundary",
        (Cause::TooLarge | Cause::NearWhole(_), ..) => "not decided",
        (_, true, None) => "stable, proved",
        (_, true, Some(_)) => "stable by the sampled model, not proved",
        (_, false, None) => "unstable, proved",
        (_, false, Some(_)) => "unstable by the sampled model, not proved",
    }
}

pub(super) fn margins(margins: &Margins) -> Value {
    let value = |crossing: Option<Crossing>| crossing.map(|crossing| crossing.value);
    let place = |crossing: Option<Crossing>| crossing.map(|crossing| crossing.omega_rad_s);
    json!({
        "crossover_rad_s": place(margins.phase),
        "crossovers": margins.crossovers,
        "phase_margin_deg": value(margins.phase).map(f64::to_degrees),
        "gain_up": value(margins.gain_up),
        "gain_up_rad_s": place(margins.gain_up),
        "gain_down": value(margins.gain_down),
        "gain_down_rad_s": place(margins.gain_down),
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

pub(super) fn pid(own: PidParameters) -> Value {
    json!({
        "proportional_gain": own.proportional,
        "integral_gain_per_s_lambda": own.integral,
        "integral_order": own.integral_order,
        "derivative_gain_s_mu": own.derivative,
        "derivative_order": own.derivative_order,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use fractional_control::Plant;
    use fractional_control::tuning::{Specification, tune};

    #[test]
    fn wishes_are_said_in_degrees() {
        let plant: Plant = "1/(s+1)".parse().expect("valid");
        let of = |wishes: Specification| in_degrees(&tune(&plant, None, &wishes).unwrap_err());
        let wide = Specification::new(1.0, 200_f64.to_radians());
        assert_eq!(
            of(wide),
            "phase margin 200° is not above 0 and below 180°: give `phase_margin_rad`, as in 60deg"
        );
        let peak = Specification {
            sensitivity_peak: Some(0.9),
            ..Specification::new(1.0, 60_f64.to_radians())
        };
        assert_eq!(
            of(peak),
            "`sensitivity_peak` 0.9 contradicts `phase_margin_rad` 60°: allow at least 1/(2 sin(margin/2))"
        );
    }
}
