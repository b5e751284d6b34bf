//! Advice when the loop refuses a parameter, and a check for numbers that no device can hold.

use crate::document::failure::Failure;
use crate::document::parameters::{
    CURRENT_LAG, DAMPING, DELAY, DEVICE_MASS, DEVICE_NOISE, FORCE_LIMIT, FORCE_RATE_LIMIT,
    FRICTION, HAND_STIFFNESS, JUMP, MASS, Parameter, SAFETY, SAMPLE_TIME, SPEED_LIMIT,
    WORKSPACE_HIGH, WORKSPACE_LOW,
};
use fracdiff::parameter::Shown;
use haptic_loop::ParameterError;
use haptic_quantity::without_unit;

/// A parameter that the loop refuses, with the key that sets it.
pub(crate) fn parameter(error: ParameterError) -> Failure {
    match advice(&error) {
        Some(advice) => Failure::input_with_advice(error, advice),
        None => Failure::input(error),
    }
}

/// Advice on the error; `None` for an error that says so itself.
fn advice(error: &ParameterError) -> Option<String> {
    let ParameterError::Range(range) = error else {
        return None;
    };
    let change = |key: Parameter| format!("change {key}");
    let plain = [
        FORCE_LIMIT,
        FORCE_RATE_LIMIT,
        SAMPLE_TIME,
        MASS,
        DAMPING,
        HAND_STIFFNESS,
    ];
    let named = |key: &&Parameter| without_unit(key.key).replace('_', " ") == range.what;
    if let Some(&key) = SAFETY.iter().chain(&plain).find(named) {
        return Some(change(key));
    }
    Some(match range.what {
        "jump of the position" => change(JUMP),
        "soft speed limit" => change(SPEED_LIMIT),
        "low end of the workspace" | "high end of the workspace" | "workspace soft zone" => {
            format!("change {WORKSPACE_LOW} or {WORKSPACE_HIGH}")
        }
        "mass of the device" => change(DEVICE_MASS),
        "damping of the device" | "damping of the guard" | "bound of the guard" => {
            "change damping or mass of the device, or take another guard".to_owned()
        }
        "noise for the guard" => change(DEVICE_NOISE),
        "least delay of the guard" | "delay of the guard" => {
            "change the delay of the device, or take another guard".to_owned()
        }
        "lag of the actuator" => "change the lag of the device, or take another guard".to_owned(),
        "with friction, hand stiffness" => change(HAND_STIFFNESS),
        "Coulomb friction" => change(FRICTION),
        "actuator time constant" => change(CURRENT_LAG),
        "force delay" => format!("change {DELAY} or the sample time"),
        "fastest motion per step" => {
            "such a device cannot be simulated: take more mass, less damping or stiffness, a longer current lag or a \
             shorter sample time"
                .to_owned()
        }
        _ => return None,
    })
}

/// Refuses a number outside the range of its parameter.
pub(crate) fn check(parameter: &Parameter, value: f64) -> Result<(), Failure> {
    let range = parameter.range();
    if range.contains(value) {
        return Ok(());
    }
    Err(Failure::bad_input(format_args!(
        "{} = {} is not {range}: change {parameter}",
        parameter.key,
        Shown(value)
    )))
}

/// A number as a device has it, in single precision.
///
/// # Errors
/// One that overflows or vanishes there; `name` is what it came by.
pub fn single(name: &str, value: f64) -> Result<f32, Failure> {
    let single = value as f32;
    if single.is_finite() && (single != 0.0 || value == 0.0) {
        Ok(single)
    } else {
        Err(Failure::bad_input(format_args!(
            "{name} {value:e} is not in the single precision of a device, 0 or 1.4e-45 to 3.4e38: change {name}"
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptic_loop::units::{Newtons, Seconds};
    use haptic_loop::{Limits, SafetyChain};

    #[test]
    fn the_option_of_the_parameter_is_named_and_no_other() {
        type Change = fn(&mut Limits);
        let wrong: [(Change, &str); 3] = [
            (|limits| limits.stop_time = Seconds(2.0), "`stop_time_s`"),
            (|limits| limits.force = Newtons(-1.0), "`force_limit_n`"),
            (
                |limits| limits.brake_force = Newtons(20.0),
                "`brake_force_n`",
            ),
        ];
        for (change, option) in wrong {
            let mut limits = Limits::default();
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
}
