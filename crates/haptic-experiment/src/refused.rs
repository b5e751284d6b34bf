//! Advice when the loop refuses a parameter, and a check for numbers that no device can hold.

use crate::failure::Failure;
use haptic_loop::ParameterError;

/// A parameter that the loop refuses, with the key that sets it.
pub fn parameter(error: ParameterError) -> Failure {
    match advice(&error) {
        Some(advice) => Failure::input_with_advice(error, advice),
        None => Failure::input(error),
    }
}

/// Advice on the error; `None` for an error that says so itself.
fn advice(error: &ParameterError) -> Option<&'static str> {
    let ParameterError::Range(range) = error else {
        return None;
    };
    Some(match range.what {
        "force limit" => "change `force_limit_n`",
        "force rate limit" => "change `force_rate_limit_n_per_s`",
        "sample time" => "change `sample_time_s`",
        "delay of the line" => "change `line_delay_s`",
        "jitter" => "change `line_jitter`",
        "chance of a lost message" => "change `line_loss`",
        "chance of a repeated message" => "change `line_duplication`",
        "silence" => "change `silence_s`",
        "wave impedance" => "change `wave_impedance_n_s_per_m`",
        "coupler stiffness and dissipation together" => {
            "give `coupler_stiffness_n_per_m` or `coupler_dissipation_n_s_mu_per_m` above 0"
        }
        "rise time" => "change `rise_time_s`",
        "stop time" => "change `stop_time_s`",
        "brake force" => "change `brake_force_n`",
        "braking" => "change `braking_n_s_per_m`",
        "stuck force" => "change `stuck_force_n`",
        "stuck time" => "change `stuck_time_s`",
        "jump of the position" => "change `jump_m`",
        "speed limit" | "soft speed limit" => "change `speed_limit_m_per_s`",
        "low end of the workspace" | "high end of the workspace" | "workspace soft zone" => {
            "change `workspace_low_m` or `workspace_high_m`"
        }
        "mass of the device" => "change `device_mass_kg`",
        "damping of the device" | "damping of the guard" | "bound of the guard" => {
            "change damping or mass of the device, or take another guard"
        }
        "noise for the guard" => "change `device_noise_m`",
        "least delay of the guard" | "delay of the guard" => {
            "change the delay of the device, or take another guard"
        }
        "lag of the actuator" => "change the lag of the device, or take another guard",
        "mass" => "change `mass_kg`",
        "damping" => "change `damping_n_s_per_m`",
        "hand stiffness" | "with friction, hand stiffness" => "change `hand_stiffness_n_per_m`",
        "Coulomb friction" => "change `friction_n`",
        "actuator time constant" => "change `current_lag_s`",
        "force delay" => "change `delay_s` or the sample time",
        "fastest motion per step" => {
            "such a device cannot be simulated: take more mass, less damping or stiffness, a longer current lag or a \
             shorter sample time"
        }
        _ => return None,
    })
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
        let good = Limits::default();
        for (limits, option) in [
            (
                Limits {
                    stop_time: Seconds(2.0),
                    ..good
                },
                "`stop_time_s`",
            ),
            (
                Limits {
                    force: Newtons(-1.0),
                    ..good
                },
                "`force_limit_n`",
            ),
            (
                Limits {
                    brake_force: Newtons(20.0),
                    ..good
                },
                "`brake_force_n`",
            ),
        ] {
            let refused = SafetyChain::<f64>::from_limits(&limits, Seconds(1e-3));
            let text = parameter(refused.expect_err("is none")).to_string();
            let options: Vec<&str> = text
                .split(' ')
                .filter(|word| word.starts_with('`'))
                .collect();
            assert_eq!(options, [option], "{text}");
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
