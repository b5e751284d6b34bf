//! Advice when a teleoperation refuses a parameter.

use super::keys::{
    HAND_COUPLER_DISSIPATION, HAND_COUPLER_STIFFNESS, LINE_DELAY, LINE_DUPLICATION, LINE_JITTER,
    LINE_LOSS, SILENCE, WAVE_IMPEDANCE,
};
use crate::document::advice;
use crate::document::failure::Failure;
use crate::document::parameters::Parameter;
use haptic_loop::ParameterError;

/// A parameter that a side or its loop refuses, with the key that sets it.
pub(super) fn parameter(error: ParameterError) -> Failure {
    let ParameterError::Range(range) = &error else {
        return advice::parameter(error);
    };
    let change = |key: Parameter| format!("change {key}");
    let advice = match range.what {
        "delay of the line" => change(LINE_DELAY),
        "jitter" => change(LINE_JITTER),
        "chance of a lost message" => change(LINE_LOSS),
        "chance of a repeated message" => change(LINE_DUPLICATION),
        "silence" => change(SILENCE),
        "wave impedance" => change(WAVE_IMPEDANCE),
        "coupler stiffness and dissipation together" => {
            format!("give {HAND_COUPLER_STIFFNESS} or {HAND_COUPLER_DISSIPATION} above 0")
        }
        _ => return advice::parameter(error),
    };
    Failure::input_with_advice(error, advice)
}
