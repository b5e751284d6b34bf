//! From a controller to TOML.

use super::content::{ControllerFile, ControllerOrigin};
use crate::document::parameters as p;
use crate::document::parameters::Parameter;
use fractional_control::{ControllerParameters, ControllerSetup};

/// `{:?}` of a number is the shortest text that reads back to the same bits.
pub(super) fn toml(file: &ControllerFile) -> String {
    let line = |parameter: &Parameter, value: f64| format!("{} = {value:?}\n", parameter.key);
    let setup = &file.setup;
    let mut text = law(setup);
    text += &format!(
        "\n[loop]\n{}{} = \"{}\"\n",
        line(&p::CONTROLLER_SAMPLE_TIME, setup.sample_time_s),
        p::CONTROLLER_SCHEME.key,
        setup.scheme
    );
    for (parameter, value) in [
        (&p::MEMORY, setup.memory_s),
        (&p::OUTPUT_LOW, setup.output_low),
        (&p::OUTPUT_HIGH, setup.output_high),
    ] {
        text += &value.map_or_else(String::new, |value| line(parameter, value));
    }
    text += &line(&p::FADE_TIME, setup.fade_time_s);
    if file.origin != ControllerOrigin::default() {
        text += "\n[source]\n";
        for (parameter, words) in [
            (&p::SOURCE_PLANT, &file.origin.plant),
            (&p::SOURCE_WISHES, &file.origin.wishes),
            (&p::SOURCE_PROGRAM, &file.origin.program),
            (&p::SOURCE_NOTE, &file.origin.note),
        ] {
            if !words.is_empty() {
                let quoted = toml::Value::from(words.as_str());
                text += &format!("{} = {quoted}\n", parameter.key);
            }
        }
    }
    text
}

/// The table of the controller, its name first.
fn law(setup: &ControllerSetup) -> String {
    let weights = setup.set_point;
    let (name, numbers): (&str, Vec<(&Parameter, f64)>) = match &setup.law {
        ControllerParameters::Pid(own) => (
            "pid",
            vec![
                (&p::PROPORTIONAL_GAIN, own.proportional),
                (&p::INTEGRAL_GAIN, own.integral),
                (&p::INTEGRAL_ORDER, own.integral_order),
                (&p::DERIVATIVE_GAIN, own.derivative),
                (&p::DERIVATIVE_ORDER, own.derivative_order),
                (&p::SET_POINT_WEIGHT, weights.proportional),
                (&p::DERIVATIVE_SET_POINT_WEIGHT, weights.derivative),
            ],
        ),
        ControllerParameters::Tid(own) => (
            "tid",
            vec![
                (&p::TILT_GAIN, own.tilt),
                (&p::TILT_DIVISOR, own.tilt_divisor),
                (&p::TID_INTEGRAL_GAIN, own.integral),
                (&p::TID_DERIVATIVE_GAIN, own.derivative),
                (&p::DERIVATIVE_SET_POINT_WEIGHT, weights.derivative),
            ],
        ),
        ControllerParameters::Crone(own) => (
            "crone",
            vec![
                (&p::SHAPED_GAIN, own.gain),
                (&p::SHAPED_ORDER, own.order),
                (&p::CRONE_LOW, own.low_rad_s),
                (&p::CRONE_HIGH, own.high_rad_s),
            ],
        ),
        ControllerParameters::LeadLag(own) => (
            "lead_lag",
            vec![
                (&p::SHAPED_GAIN, own.gain),
                (&p::SHAPED_ORDER, own.order),
                (&p::LEAD_LAMBDA, own.lambda_s),
                (&p::LEAD_X, own.x),
            ],
        ),
        other => {
            return format!("[transfer_function]\n{} = \"{other}\"\n", p::FUNCTION.key);
        }
    };
    let lines = numbers
        .into_iter()
        .map(|(parameter, value)| format!("{} = {value:?}\n", parameter.key));
    format!("[{name}]\n{}", lines.collect::<String>())
}
