//! Remedies for numbers that a library refuses, and a check for numbers that no device can hold.

use crate::{
    keys::admittance::{FORCE_CUTOFF, ROBOT_BANDWIDTH, ROBOT_DAMPING, ROBOT_DEAD_TIME},
    safety::keys::{
        DEVICE_DAMPING, DEVICE_DELAY_LEAST, DEVICE_DELAY_MOST, DEVICE_LAG, GUARD, SAFETY,
        WORKSPACE_HIGH, WORKSPACE_LOW,
    },
};
use fracdiff::parameter::Shown;
use fractional_control::ControlError;
use haptic_analysis::AnalysisError;
use haptic_document::{
    Failure, bad_input,
    parameters::{
        CURRENT_LAG, DAMPING, DELAY, FORCE_LIMIT, FORCE_RATE_LIMIT, FRICTION,
        HAND_COUPLER_DISSIPATION, HAND_COUPLER_STIFFNESS, HAND_STIFFNESS, MASS, Parameter,
        SAMPLE_TIME,
    },
};
use haptic_loop::LoopParameterError;
use haptic_quantity::{Key, digits, label, written};

/// Parameters that the libraries call by their label, as those of the safety chain.
const BY_LABEL: [Parameter; 7] = [
    FORCE_LIMIT,
    FORCE_RATE_LIMIT,
    SAMPLE_TIME,
    MASS,
    DAMPING,
    HAND_STIFFNESS,
    FRICTION,
];

/// Quantities derived from several parameters: the library's name, and the remedy.
#[rustfmt::skip]
const FOLLOWS: [(&str, &str, &[Parameter]); 20] = [
    ("alpha", "it is K·T²/m: change the stiffness, ", &[MASS, SAMPLE_TIME]),
    ("beta", "it is B·T^(2−μ)/m: change the dissipation, ", &[MASS, SAMPLE_TIME]),
    ("delta", "it is b·T/m: change ", &[DAMPING, MASS, SAMPLE_TIME]),
    ("gamma", "it is k·T²/m: change ", &[HAND_STIFFNESS, MASS, SAMPLE_TIME]),
    ("delay", "change ", &[DELAY, SAMPLE_TIME]),
    ("current lag", "change ", &[CURRENT_LAG, SAMPLE_TIME]),
    ("fastest motion per step", "such a device cannot be simulated: change ",
        &[MASS, DAMPING, HAND_STIFFNESS, CURRENT_LAG, SAMPLE_TIME]),
    ("coupler stiffness and dissipation together", "change ", &[HAND_COUPLER_STIFFNESS, HAND_COUPLER_DISSIPATION]),
    ("low end of the workspace", "change ", &[WORKSPACE_LOW, WORKSPACE_HIGH]),
    ("least delay of the guard", "change ", &[DELAY, DEVICE_DELAY_LEAST, GUARD]),
    ("high end of the workspace", "change ", &[WORKSPACE_LOW, WORKSPACE_HIGH]),
    ("damping of the device", "change ", &[DAMPING, DEVICE_DAMPING, GUARD]),
    ("delay of the guard", "change ", &[DELAY, DEVICE_DELAY_MOST, GUARD]),
    ("lag of the actuator", "change ", &[CURRENT_LAG, DEVICE_LAG, GUARD]),
    ("natural frequency of the robot's loop", "change ", &[ROBOT_BANDWIDTH]),
    ("natural frequency of the robot", "change ", &[ROBOT_BANDWIDTH]),
    ("damping ratio of the robot's loop", "change ", &[ROBOT_DAMPING]),
    ("corner frequency of the force filter", "change ", &[FORCE_CUTOFF]),
    ("dead time", "change ", &[ROBOT_DEAD_TIME, SAMPLE_TIME]),
    ("dead time of the robot", "change ", &[ROBOT_DEAD_TIME]),
];

/// Remedy for a quantity that a library refuses; `None` if no parameter sets it.
fn change(what: &str) -> Option<String> {
    if let Some((_, words, made_of)) = FOLLOWS.iter().find(|(known, ..)| *known == what) {
        let keys: Vec<String> = made_of.iter().map(ToString::to_string).collect();
        let (last, first) = keys.split_last()?;
        return Some(if first.is_empty() {
            format!("{words}{last}")
        } else {
            format!("{words}{} or {last}", first.join(", "))
        });
    }
    let mut all = SAFETY.iter().chain(&BY_LABEL);
    let key = all.find(|parameter| label(parameter.key) == what)?;
    Some(format!("change {key}"))
}

/// A parameter that the loop refuses, with the keys to change.
pub fn parameter(error: LoopParameterError) -> Failure {
    if let LoopParameterError::Range(range) = &error
        && let Some(advice) = change(range.what)
    {
        return Failure::input_with_advice(error, advice);
    }
    Failure::input(error)
}

/// Adds advice to the error of an analysis.
pub fn analysed(error: AnalysisError) -> Failure {
    if let AnalysisError::Range(range) = &error
        && let Some(advice) = change(range.what)
    {
        return Failure::input_with_advice(error, advice);
    }
    if matches!(error, AnalysisError::Unresolved { .. }) {
        let advice = format!(
            "a motion is much faster or slower than {SAMPLE_TIME}: change that, the device or {ROBOT_BANDWIDTH}"
        );
        return Failure::input_with_advice(error, advice);
    }
    Failure::input_with_advice(
        error,
        "use a device, a wall and a sample time that are more usual",
    )
}

/// Refuses a number outside the range of its parameter.
///
/// # Errors
/// With value, range and the parameter to change.
pub fn check(parameter: &Parameter, value: f64) -> Result<(), Failure> {
    let range = parameter.range();
    if range.contains(value) {
        return Ok(());
    }
    Err(bad_input!(
        "{} = {} is not {range}: change {parameter}",
        parameter.key,
        Shown(value)
    ))
}

/// A number as a device has it, in single precision.
///
/// # Errors
/// One that overflows or vanishes there; `name` is the name under which the user gave it.
pub fn single(name: &str, value: f64) -> Result<f32, Failure> {
    let single = value as f32;
    if single.is_finite() && (single != 0.0 || value == 0.0) {
        Ok(single)
    } else {
        Err(bad_input!(
            "{name} {value:e} is not in single precision, 0 or 1.4e-45 to 3.4e38: change {name}"
        ))
    }
}

/// Wishes of the tuning: the crossover, rad/s, and the phase margin, rad.
pub const CROSSOVER: Key = Key("crossover_rad_s");
const PHASE_MARGIN: Key = Key("phase_margin_rad");

/// The text of an error with angles in degrees, and what to change.
#[must_use]
pub fn in_degrees(error: &ControlError) -> String {
    if let ControlError::Contradiction {
        first,
        first_value,
        second,
        second_value,
        remedy,
    } = *error
    {
        let [a, b] = [(first, first_value), (second, second_value)]
            .map(|(key, value)| format!("{} {}", Key(key), with_unit(key, value)));
        return format!("{a} contradicts {b}: {remedy}");
    }
    let ControlError::Range(range) = *error else {
        return error.to_string();
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
            format!("{range}: record for longer, or ask for a function of fewer terms")
        }
        _ => range.to_string(),
    }
}

/// A refusal of the library: bad input, or a search that ended with nothing.
#[must_use]
pub fn refused(error: ControlError) -> Failure {
    let text = in_degrees(&error);
    if matches!(error, ControlError::NotFound { .. }) {
        Failure::run(text)
    } else {
        Failure::bad_input(text)
    }
}

/// The value of a wish with its unit, an angle in degrees.
pub fn with_unit(key: &str, value: f64) -> String {
    if key == PHASE_MARGIN.0 {
        format!("{}°", digits(value.to_degrees(), 4))
    } else {
        written(key, value)
    }
}

#[cfg(test)]
mod tests {
    use crate::advice::*;
    use control_tuning::{Specification, tune};
    use fractional_control::Plant;
    use haptic_loop::{
        SafetyChain, SafetyLimits,
        units::{Newtons, Seconds},
    };

    #[test]
    fn the_option_of_the_parameter_is_named_and_no_other() {
        type Change = fn(&mut SafetyLimits);
        let wrong: [(Change, &str); 3] = [
            (|limits| limits.stop_time = Seconds(2.0), "`stop_time_s`"),
            (|limits| limits.force = Newtons(-1.0), "`force_limit_n`"),
            (
                |limits| limits.brake_force = Newtons(20.0),
                "`brake_force_n`",
            ),
        ];
        for (change, option) in wrong {
            let mut limits = SafetyLimits::default();
            change(&mut limits);
            let refused = SafetyChain::<f64>::from_limits(&limits, Seconds(1e-3));
            let text = parameter(refused.expect_err("is none")).to_string();
            let options = text.split(' ').filter(|word| word.starts_with('`'));
            assert_eq!(options.collect::<Vec<_>>(), [option], "{text}");
        }
    }

    #[test]
    fn what_single_precision_cannot_hold_is_refused_as_it_was_typed() {
        for (value, shown) in [(1e39, "1e39"), (-1e39, "-1e39"), (1e-60, "1e-60")] {
            let text = single("stiffness", value)
                .expect_err("too much")
                .to_string();
            assert!(
                text.starts_with(&format!("stiffness {shown} is not")),
                "{text}"
            );
        }
        for value in [0.0, 1e-40, -3e38] {
            assert!(single("stiffness", value).is_ok(), "{value}");
        }
    }

    #[test]
    fn wishes_are_said_in_degrees() {
        let plant: Plant = "1/(s+1)".parse().expect("valid");
        let refusal = |wishes: Specification| in_degrees(&tune(&plant, None, &wishes).unwrap_err());
        let wide = Specification::new(1.0, 200_f64.to_radians());
        assert_eq!(
            refusal(wide),
            "phase margin 200° is not above 0 and below 180°: give `phase_margin_rad`, as in 60deg"
        );
        let peak = Specification {
            sensitivity_peak: Some(0.9),
            ..Specification::new(1.0, 60_f64.to_radians())
        };
        assert_eq!(
            refusal(peak),
            "`sensitivity_peak` 0.9 contradicts `phase_margin_rad` 60°: allow at least 1/(2 sin(margin/2))"
        );
    }
}
