//! A designed controller in sentences, for the command and the page.

use control_tuning::Specification;
use control_tuning::WishName;
use control_tuning::design::{
    ControlAnswer, ROBUST_GAINS, SAMPLES_A_RADIAN, Trial, usual_sample_time,
};
use fracdiff::Seconds;
use fracdiff::parameter::Shown;
use fractional_control::analysis::{LoopAnalysis, VerdictCause};
use fractional_control::{
    Crossing, Margins, PidParameters, Plant, StepShape, factor_after_division,
};
use haptic_document::parameters::{OUTPUT_HIGH, SAMPLE_TIME};
use haptic_document::{Failure, short};
use haptic_quantity::{Key, digits};
use haptic_trial::advice::{CROSSOVER, in_degrees};
use haptic_trial::controller_file::{ControllerFile, ControllerOrigin};
use serde_json::{Value, json};
use std::f64::consts::LN_10;

/// The sample time of a design that is given none.
///
/// # Errors
/// A crossover for which it would be outside its range.
pub(crate) fn sample_time_for(crossover_rad_s: f64) -> Result<Seconds, Failure> {
    let sample_time = usual_sample_time(crossover_rad_s);
    if SAMPLE_TIME.range().contains(sample_time.0) {
        return Ok(sample_time);
    }
    let crossover = |sample_time_s: f64| 1.0 / (SAMPLES_A_RADIAN * sample_time_s);
    let [low, high] = SAMPLE_TIME.range().ends().map(crossover);
    Err(Failure::bad_input(format_args!(
        "crossover {} rad/s is not from {} to {} rad/s: change {CROSSOVER}, or give {SAMPLE_TIME}",
        Shown(crossover_rad_s),
        Shown(high),
        Shown(low)
    )))
}

/// Next to the crossover, and how far apart gains are there only because of a zero or a pole between.
const BESIDE: f64 = 1.1;
const APART: f64 = 1e6;

/// Refuses a crossover outside a measured band, or at which the plant's gain is no number that a controller can have: about one over it.
///
/// # Errors
/// As said, with the reason.
pub(crate) fn check_gain(plant: &Plant, crossover_rad_s: f64) -> Result<(), Failure> {
    let (low, high) = plant.band();
    let omega = Shown(crossover_rad_s);
    if high.is_finite() && !(low < crossover_rad_s && crossover_rad_s < high) {
        return Err(Failure::bad_input(format_args!(
            "crossover {omega} rad/s is outside the measured band, {} to {} rad/s: change {CROSSOVER}",
            digits(low, 4),
            digits(high, 4)
        )));
    }
    let [_, most] = OUTPUT_HIGH.range().ends();
    let gain_at = |omega: f64| plant.response(omega).map(|g| g.norm());
    let gain = gain_at(crossover_rad_s);
    let Some(gain) = gain.filter(|gain| gain.is_nan() || !(1.0 / most..=most).contains(gain))
    else {
        return Ok(());
    };
    // A gain far from its neighbour's is extreme in any units.
    let near = gain_at(BESIDE * crossover_rad_s).unwrap_or(gain);
    Err(if gain < near / APART {
        Failure::bad_input(format_args!(
            "the plant has a zero at {CROSSOVER} {omega} rad/s: no controller gives the loop a gain there; move {CROSSOVER}"
        ))
    } else if gain > near * APART {
        Failure::bad_input(format_args!(
            "the plant has an undamped pole at {CROSSOVER} {omega} rad/s: no controller bounds the loop's gain there; move {CROSSOVER}"
        ))
    } else {
        Failure::bad_input(format_args!(
            "the plant's gain {} at {CROSSOVER} {omega} rad/s is not from {} to {}: change its units",
            Shown(gain),
            Shown(1.0 / most),
            Shown(most)
        ))
    })
}

/// The wishes of a design in words, for its controller file.
fn in_words(wishes: &Specification) -> String {
    let mut words = vec![
        format!("crossover {} rad/s", digits(wishes.crossover_rad_s, 4)),
        format!(
            "phase margin {}°",
            digits(wishes.phase_margin_rad.to_degrees(), 4)
        ),
    ];
    if wishes.iso_damping {
        words.push("flat phase".to_owned());
    }
    for (name, most) in [
        ("|S|", wishes.sensitivity_peak),
        ("|T|", wishes.complementary_peak),
    ] {
        words.extend(most.map(|most| format!("{name} ≤ {}", digits(most, 4))));
    }
    for (name, side, bound) in [
        ("|T|", "from", wishes.noise),
        ("|S|", "up to", wishes.disturbance),
    ] {
        words.extend(bound.map(|bound| {
            let (most, omega) = (digits(bound.at_most, 4), digits(bound.omega_rad_s, 4));
            format!("{name} ≤ {most} {side} {omega} rad/s")
        }));
    }
    words.join(", ")
}

/// The gains of a PI^λD^μ by the keys of its file.
#[must_use]
pub fn gains(parameters: &PidParameters) -> Value {
    json!({
        "proportional_gain": parameters.proportional,
        "integral_gain_per_s_lambda": parameters.integral,
        "integral_order": parameters.integral_order,
        "derivative_gain_s_mu": parameters.derivative,
        "derivative_order": parameters.derivative_order,
    })
}

/// The margins of a loop as a report has them.
#[must_use]
pub fn margins(margins: &Margins) -> Value {
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

/// The shape of a step as a report has it.
#[must_use]
pub fn shape(shape: &StepShape, sample_time_s: f64) -> Value {
    json!({
        "overshoot": shape.overshoot,
        "rise_time_s": shape.rise.map(|samples| samples * sample_time_s),
        "settling_time_s": shape.settled.map(|samples| samples as f64 * sample_time_s),
        "final_error": shape.final_error,
    })
}

/// The verdict in a few words.
#[must_use]
pub const fn in_short(analysis: &LoopAnalysis) -> &'static str {
    match (analysis.cause, analysis.verdict.stable, analysis.coarse) {
        (VerdictCause::Boundary | VerdictCause::Cancelled, ..) => "on the boundary",
        (VerdictCause::TooLarge | VerdictCause::NearWhole(_), ..) => "not decided",
        (_, true, None) => "stable, proved",
        (_, true, Some(_)) => "not proved: the sampled model comes to rest",
        (_, false, None) => "unstable, proved",
        (_, false, Some(_)) => "not proved: the sampled model grows",
    }
}

/// A sentence that says how a factor after a division was read, if the notation has one.
#[must_use]
pub(crate) fn loose_factor(what: &str, text: &str) -> Option<String> {
    let (before, factor) = text.split_at(factor_after_division(text)?);
    Some(format!(
        "{what} \"{}\": what follows \"{}\" multiplies; put brackets around \"{}\" if it divides",
        short(text),
        short(before.trim_end()),
        short(factor)
    ))
}

/// Key and words of a wish, and its value in the unit of the key.
#[must_use]
pub(crate) fn row_of_wish(name: WishName) -> (&'static str, &'static str, fn(f64) -> f64) {
    let same: fn(f64) -> f64 = |value| value;
    match name {
        WishName::Crossover => ("crossover_rad_s", "crossover / rad/s", same),
        WishName::PhaseMargin => ("phase_margin_deg", "phase margin / °", f64::to_degrees),
        WishName::IsoDamping => (
            "phase_slope_deg_per_decade",
            "slope of the phase / °/decade",
            |slope| (slope * LN_10).to_degrees(),
        ),
        WishName::SensitivityPeak => ("sensitivity_peak", "largest |S|", same),
        WishName::ComplementaryPeak => ("complementary_peak", "largest |T|", same),
        WishName::Noise => ("noise", "|T| above the noise's frequency", same),
        WishName::Disturbance | _ => ("disturbance", "|S| below the disturbance's frequency", same),
    }
}

/// The findings of a design, in sentences.
#[derive(Clone, Copy, Debug)]
pub struct DesignWords<'a>(pub &'a ControlAnswer);

impl DesignWords<'_> {
    /// Wishes that are not met, and a loop that is not robust, for the controller file.
    fn note(&self) -> String {
        let unmet = Some(self.unmet()).filter(|unmet| !unmet.is_empty());
        let parts = unmet.map(|unmet| format!("not met: {unmet}"));
        let parts: Vec<String> = parts.into_iter().chain(self.fragile()).collect();
        parts.join("; ")
    }

    /// The controller file of the design, for this plant and these wishes.
    #[must_use]
    pub fn file(&self, plant: &str, wishes: &Specification, program: &str) -> ControllerFile {
        ControllerFile {
            setup: self.0.fractional.setup.clone(),
            origin: ControllerOrigin {
                plant: plant.to_owned(),
                wishes: in_words(wishes),
                program: program.to_owned(),
                note: self.note(),
            },
        }
    }

    /// The wishes that are not met, and by how much; empty if all are.
    #[must_use]
    pub fn unmet(&self) -> String {
        let missed = self
            .0
            .fractional
            .wishes
            .iter()
            .filter(|wish| !wish.is_met());
        let words = missed.map(|wish| {
            let (_, words, in_unit) = row_of_wish(wish.name);
            let [wanted, reached] = [wish.wanted, wish.reached].map(in_unit);
            let by = match wanted {
                0.0 => String::new(),
                _ => format!(" ({:+.0} %)", 100.0 * (reached / wanted - 1.0)),
            };
            let [reached, wanted] = [reached, wanted].map(|value| digits(value, 4));
            format!("{words} {reached} instead of {wanted}{by}")
        });
        words.collect::<Vec<_>>().join(", ")
    }

    /// The gains of the plant for which the loop is proved stable, if they do not reach from half to double.
    fn fragile(&self) -> Option<String> {
        let trial = self
            .0
            .fractional
            .trial
            .as_ref()
            .filter(|trial| !trial.is_robust())?;
        let [low, high] = trial.stable_gains?;
        let verdict = match trial.analysis.coarse {
            None => "proved stable",
            Some(_) => "held by the sampled model, not proved,",
        };
        Some(format!(
            "the sampled loop is {verdict} only from {} to {} times the plant's gain",
            digits(low, 3),
            digits(high, 3)
        ))
    }

    /// The verdict, for which gains it is proved, and the remedy.
    fn verdict(&self, trial: &Trial) -> String {
        let all = "for half to double the plant's gain";
        if !trial.analysis.verdict.stable {
            return "The sampled loop is not stable.".to_owned();
        }
        let sturdier = match trial.stable_gains {
            Some([low, _]) if low > ROBUST_GAINS[0] => {
                "Raise the crossover: a smaller gain does not hold this plant"
            }
            _ => "Lower the crossover, raise the phase margin or shorten the sample time",
        };
        // Why the verdict of a loop is not that of its plant.
        let too_fast = trial.analysis.coarse.map(|times| {
            let times = digits(times, 4);
            format!("too fast to prove it for the plant: divide the sample time by {times}")
        });
        match (self.fragile(), too_fast) {
            (None, Some(too_fast)) => {
                format!("Warning: the sampled model comes to rest {all}, {too_fast}.")
            }
            (Some(fragile), Some(too_fast)) => {
                format!("Warning: {fragile}, {too_fast}. {sturdier}.")
            }
            (None, None) => format!("The sampled loop is proved stable {all}."),
            (Some(fragile), None) => format!("Warning: {fragile}. {sturdier}."),
        }
    }

    /// The verdict, with notes for the user.
    #[must_use]
    pub fn sentences(&self) -> Vec<String> {
        let Some(trial) = &self.0.fractional.trial else {
            let count = "Not proved: the loop comes to rest by the measured frequencies, if the plant by itself does.";
            let more = "For a proof and steps identify a function, with control identify.";
            return vec![format!("{count} {more}")];
        };
        let mut sentences = vec![self.verdict(trial)];
        let other = self.0.integer.as_ref().ok();
        let other = other.and_then(|other| other.trial.as_ref());
        let spread = |trial: &Trial| trial.overshoot_spread().filter(|_| trial.is_robust());
        match other.map(|other| (spread(trial), spread(other))) {
            Some((Some(fractional), Some(integer))) => {
                sentences.push(format!(
                    "Over these gains its overshoot varies by {} %, that of the integer-order PID by {} %: {}.",
                    digits(100.0 * fractional, 3),
                    digits(100.0 * integer, 3),
                    compared(fractional, integer)
                ));
            }
            Some((Some(_), None)) => {
                sentences
                    .push("The integer-order PID is not stable at all these gains.".to_owned());
            }
            Some(_) => {}
            None => sentences.push(format!(
                "No integer-order PID has this crossover and margin: {}.",
                (self.0.integer.as_ref().err()).map_or("none was found".to_owned(), in_degrees)
            )),
        }
        let order = self.0.fractional.tuned.parameters.integral_order;
        if trial.analysis.verdict.stable && trial.shape.settled.is_none() && order < 1.0 {
            let crossover = self
                .0
                .fractional
                .wishes
                .first()
                .map_or(1.0, |wish| wish.wanted);
            sentences.push(format!(
                "It does not settle in the time shown: its integral fades as t^-{}. In control design, give {}.",
                digits(order, 4),
                Key("disturbance").set_to(format_args!("{}rad/s:0.05", digits(0.05 * crossover, 4)))
            ));
        }
        if !self.0.fractional.tuned.measures.stable_with_dead_time {
            sentences.push("With a dead time in place of the plant's fast lags, which few records tell from it, the loop would not be stable: ask for less crossover, or be sure of these lags.".to_owned());
        }
        if self.unmet().is_empty() {
            sentences.push("Every wish is met within 1 %.".to_owned());
        }
        sentences
    }
}

fn compared(fractional: f64, integer: f64) -> String {
    let least = 1e-3;
    if fractional < least && integer < least {
        "no difference".to_owned()
    } else if fractional <= integer {
        format!("{:.1} times less", integer / fractional.max(1e-6))
    } else {
        "the fractional PID is not better".to_owned()
    }
}
