//! Errors and verdicts as sentences, angles in degrees.

use core::f64::consts::PI;
use fractional_control::ControllerSetup;
use fractional_control::analysis::{AT_REST, Cause, LoopAnalysis, OtherGain};
use fractional_control::{ControlError, Crossing, Margins};
use haptic_experiment::Failure;
use haptic_experiment::parameters::{DELAY, SAMPLE_TIME};
use haptic_quantity::{Key, digits, written};

/// What the tuning is asked for.
const CROSSOVER: Key = Key("crossover_rad_s");
const PHASE_MARGIN: Key = Key("phase_margin_rad");

/// A refusal of the library: bad input, or a search that ended with nothing.
pub(super) fn refused(error: ControlError) -> Failure {
    let text = in_degrees(&error);
    match error {
        ControlError::NotFound { .. } => Failure::Run(anyhow::anyhow!("{text}")),
        _ => Failure::bad_input(text),
    }
}

/// The text of an error with angles in degrees.
pub(super) fn in_degrees(error: &ControlError) -> String {
    match *error {
        ControlError::Range(range) if range.unit == "rad" => format!(
            "{} {}° is not {}: give {PHASE_MARGIN}, as in 60deg",
            range.what,
            digits(range.value.to_degrees(), 4),
            range.allowed.replace('π', "180°")
        ),
        ControlError::Range(range)
            if range.what == "crossover" && range.allowed.contains("sample") =>
        {
            format!("{range}; shorten {SAMPLE_TIME} or lower {CROSSOVER}")
        }
        ControlError::Range(range) if range.what == "crossover" => {
            format!("{range}: give {CROSSOVER}")
        }
        ControlError::Range(range) if range.what == "dead time" && range.unit == "samples" => {
            format!(
                "dead time of {} samples is not {}: lengthen {SAMPLE_TIME}, or shorten {DELAY} or the plant's dead time",
                range.value, range.allowed
            )
        }
        ControlError::Range(range)
            if range.what == "dead time" && range.allowed.contains("record") =>
        {
            format!("{range}: give a smaller {DELAY}")
        }
        ControlError::Range(range) if range.what == "samples of the record" => {
            format!("{range}: record for longer, or give --model with fewer terms")
        }
        ControlError::Contradiction {
            first,
            first_value,
            second,
            second_value,
            remedy,
        } => format!(
            "{} {} contradicts {} {}: {remedy}",
            Key(first),
            with_unit(first, first_value),
            Key(second),
            with_unit(second, second_value)
        ),
        error => error.to_string(),
    }
}

/// The value of a wish with its unit.
fn with_unit(name: &str, value: f64) -> String {
    match name {
        "phase_margin_rad" => format!("{}°", digits(value.to_degrees(), 4)),
        "crossover_rad_s" => format!("{} rad/s", digits(value, 4)),
        _ => digits(value, 4),
    }
}

/// The controller in notation, its numbers in five digits.
pub(super) fn law(file: &ControllerSetup) -> String {
    let Some(mut pid) = file.pid() else {
        return file.law.to_string();
    };
    let few = |value: &mut f64| *value = digits(*value, 5).parse().unwrap_or(*value);
    for value in [
        &mut pid.proportional,
        &mut pid.integral,
        &mut pid.integral_order,
        &mut pid.derivative,
        &mut pid.derivative_order,
    ] {
        few(value);
    }
    pid.to_string()
}

/// An amplitude ratio in decibel.
pub(super) fn decibel(size: f64) -> f64 {
    20.0 * size.log10()
}

/// The verdict on a stable loop, and what would end that.
fn stable(margins: &Margins) -> String {
    let at = |crossing: &Crossing| digits(crossing.omega_rad_s, 4);
    let times = |gain: &Crossing, words: &str| {
        format!("{} {words} (at {} rad/s)", digits(gain.value, 4), at(gain))
    };
    let up = margins.gain_up.map(|gain| times(&gain, "times the gain"));
    let down = margins.gain_down.map(|gain| times(&gain, "of the gain"));
    let delay = margins.delay_s.map(|delay| {
        let longer = written("delay_s", delay.value);
        format!("{longer} more dead time (at {} rad/s)", at(&delay))
    });
    let ways: Vec<String> = [up, down, delay].into_iter().flatten().collect();
    let nearest = &margins.sensitivity;
    let text = format!(
        "Stable, and proved. It comes closest to the boundary at {} rad/s, where errors grow {} times",
        at(nearest),
        digits(nearest.value, 4)
    );
    if ways.is_empty() {
        return format!("{text}; neither more gain nor more dead time makes it unstable.");
    }
    format!("{text}; it becomes unstable at {}.", ways.join(", or at "))
}

/// The verdict, its root and the way to the boundary, in sentences.
pub(super) fn verdict(analysis: &LoopAnalysis) -> String {
    let text = of_the_loop(analysis);
    let Some(times) = analysis.coarse else {
        return text;
    };
    // Where that is lost, and at what frequency, only the model says.
    let text = match text.split_once(", and proved") {
        Some((word, _)) => format!("{word} by the sampled model, not proved."),
        None => text,
    };
    format!(
        "{text} The loop is too fast for the sampled model of this fractional plant: the plant may behave differently. Shorten the \
         sample time at least {} times.",
        digits(times, 4)
    )
}

/// True if the loop comes nearest to the boundary where nothing moves.
fn at_rest(analysis: &LoopAnalysis) -> bool {
    // The curve ends at half the sample rate.
    let half = analysis.curve.last().map_or(f64::NAN, |at| at.omega_rad_s);
    analysis.verdict.omega_rad_s < AT_REST / PI * half
}

fn of_the_loop(analysis: &LoopAnalysis) -> String {
    let poles = match analysis.verdict.unstable_poles {
        Some(1) => "one pole grows".to_owned(),
        Some(poles) => format!("{poles} poles grow"),
        None => "a pole does not decay".to_owned(),
    };
    match analysis.cause {
        Cause::Stable => stable(&analysis.margins),
        Cause::Boundary | Cause::Cancelled if at_rest(analysis) => {
            "On the boundary, as far as can be told: a pole neither decays nor grows within 1e8 samples. If an integral of the controller meets a factor s of the plant, \
             or the reverse, omit one or add a proportional part; else raise the gain or the sample time."
                .to_owned()
        }
        Cause::Boundary => format!(
            "On the boundary, as far as can be told: {poles} at {} rad/s. Change the gain a little.",
            digits(analysis.verdict.omega_rad_s, 4)
        ),
        Cause::Cancelled => format!(
            "On the boundary, as far as can be told: {poles} at {} rad/s, whatever the gain, as a zero cancels a pole there: omit both, or move the zero.",
            digits(analysis.verdict.omega_rad_s, 4)
        ),
        Cause::TooLarge => {
            "Not decided: a number of this loop is above 1e308 or below 1e-308. Give plant and controller in other units."
                .to_owned()
        }
        Cause::NearWhole(order) => format!(
            "Not decided: order {order} is too close to {}. Write the whole order.",
            order.round()
        ),
        cause => format!("Unstable, and proved: {poles}{}", why_unstable(analysis, cause)),
    }
}

/// The reason of an unstable loop, behind its poles, and the remedy.
fn why_unstable(analysis: &LoopAnalysis, cause: Cause) -> String {
    let at = |crossing: &Crossing| digits(crossing.omega_rad_s, 4);
    match cause {
        Cause::GainTooHigh(OtherGain { edge, end, .. }) => format!(
            ": the gain is too high. At {} rad/s the loop inverts errors and grows them {} times; it is stable {} of the gain.",
            at(&edge),
            digits(1.0 / edge.value, 4),
            end.map_or_else(
                || format!("below {}", digits(edge.value, 4)),
                |end| format!("between {} and {}", digits(end, 4), digits(edge.value, 4))
            )
        ),
        Cause::GainTooLow(OtherGain { edge, end, .. }) => format!(
            ": the gain is too low to hold the plant (at {} rad/s). It is stable {} times the gain.",
            at(&edge),
            end.map_or_else(
                || format!("above {}", digits(edge.value, 4)),
                |end| format!("between {} and {}", digits(edge.value, 4), digits(end, 4))
            )
        ),
        Cause::WrongSign(gain) => format!(
            ": the sign is wrong. With the opposite sign of the controller's gains, or of the plant's, {}it is stable.",
            match gain {
                1.0 => String::new(),
                gain => format!("and {} times as much gain, ", digits(gain, 4)),
            }
        ),
        Cause::DeadTime(delay) => format!(
            ": the dead time is too long. The loop is stable up to {} of it (at {} rad/s).",
            written("delay_s", delay.value),
            at(&delay)
        ),
        _ => format!(
            ". Neither 100 times more or less gain nor less dead time makes it stable: change the controller{} or sample faster.",
            (analysis.margins.phase.as_ref()).map_or_else(String::new, |crossover| {
                format!(" (more phase near {} rad/s)", at(crossover))
            })
        ),
    }
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
