//! A controller for a plant, by wishes: the command, the page and Python ask for it by this.

pub mod report;

use super::form::form;
use crate::words::{check_gain, sample_time_for};
use control_tuning::design::ControlDesign;
use control_tuning::{Bound, Specification};
use fracdiff::parameter::Shown;
use fracdiff::{Scheme, Seconds};
use fractional_control::Plant;
use fractional_control::run::{SAMPLES_MOST, samples_for};
use haptic_document::Failure;
use haptic_document::parameters::range::{
    ANGULAR_FREQUENCIES, DURATIONS, NUMBERS, Range, SAMPLE_TIMES,
};
use haptic_document::parameters::{CONTROLLER_SCHEME, Parameter};
use haptic_quantity::{digits, parse_for_key, short};
use std::f64::consts::PI;

/// Amplitude ratios, -300 to 120 dB: a smaller ratio is lost in the rounding of a loop.
const GAINS: Range = Range::Within(1e-15, 1e6);
/// Margin as `60deg` is read, to the last bit.
const USUAL_MARGIN: f64 = 60.0 * (PI / 180.0);
/// Angles, which the tuning judges in degrees.
const ANGLES: Range = Range::Within(f64::MIN, f64::MAX);

form! {
    /// Wishes, and how they are tried, by the names of keys; numbers in SI units.
    DesignForm, CONTROL_DESIGN:
    "Wishes"
    CROSSOVER = crossover_rad_s: optional(ANGULAR_FREQUENCIES, "Crossover in rad/s or Hz: about 1.3/rise time");
    PHASE_MARGIN = phase_margin_rad: number(USUAL_MARGIN, "60deg", ANGLES, "Phase margin");
    NOT_FLAT = not_flat: flag("Do not make the phase flat: the overshoot may then change with the gain");
    SENSITIVITY_PEAK = sensitivity_peak: text("", "Largest |S|: how much errors may grow, as in 1.6 or 4dB");
    COMPLEMENTARY_PEAK = complementary_peak: text("", "Largest |T|, as in 1.3 or 2dB");
    NOISE = noise: text("", "Noise: largest |T| above a frequency, as in 10rad/s:-20dB");
    DISTURBANCE = disturbance: text("", "Disturbance: largest |S| below a frequency, as in 0.01rad/s:0.1");
    "Controller"
    LOOP_TIME = sample_time_s: optional(SAMPLE_TIMES, "Sample time [default: about 1/(50 crossover)]");
    DESIGN_SCHEME = scheme: text(CONTROLLER_SCHEME.shown, CONTROLLER_SCHEME.help);
    OUTPUT_LIMITS = output_limits: text("", "Limits of the command, as in -10:10 [default: none]");
    "Trial"
    STEP = step: number(1.0, "1", NUMBERS, "Height of the simulated step");
    STEP_LENGTH = duration_s: optional(DURATIONS, "Length of the steps [default: 60 times 1/crossover]");
}

/// Limits of a command, in its own unit, the low one below the high one.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "the lower and the upper one")]
pub struct CommandLimits {
    pub low: f64,
    pub high: f64,
}

impl CommandLimits {
    /// Reads `-10:10`.
    ///
    /// # Errors
    /// Another text, a number beyond 1e12, limits that do not rise.
    pub fn parse(text: &str) -> Result<Self, String> {
        let wrong = || format!("\"{}\" is not LOW:HIGH, as in -10:10", short(text));
        let (low, high) = text.split_once(':').ok_or_else(wrong)?;
        let end = |text| {
            let end = parse_for_key("", text).map_err(|_| wrong())?;
            let outside = || format!("{} is not {NUMBERS}", Shown(end));
            NUMBERS.contains(end).then_some(end).ok_or_else(outside)
        };
        let (low, high) = (end(low)?, end(high)?);
        if low < high {
            Ok(Self { low, high })
        } else {
            Err(format!(
                "the low limit {} is not below the high limit {}",
                digits(low, 4),
                digits(high, 4)
            ))
        }
    }
}

/// Reads a scheme that a controller may have.
///
/// # Errors
/// No scheme, or one that is not for a controller.
pub(crate) fn controller_scheme(text: &str) -> Result<Scheme, String> {
    let scheme: Scheme = text
        .parse()
        .map_err(|error: fracdiff::SchemeError| error.to_string())?;
    let full = matches!(scheme, Scheme::Full { .. } | Scheme::FullBdf2 { .. });
    (full && text.starts_with("full"))
        .then_some(scheme)
        .ok_or_else(|| {
            format!("scheme \"{scheme}\" is not for a controller: give full or full-bdf2")
        })
}

/// Refuses a step that moves nothing.
///
/// # Errors
/// If it has no height.
pub(crate) fn check_step(height: f64) -> Result<(), Failure> {
    match height {
        0.0 => Err(Failure::bad_input(format_args!(
            "a step of height 0 moves nothing: give {STEP} another height"
        ))),
        _ => Ok(()),
    }
}

/// Samples of a run of this length, or else so many.
///
/// # Errors
/// Too few or too many.
pub fn samples(
    duration: Option<f64>,
    sample_time_s: f64,
    or_else: impl FnOnce() -> f64,
) -> Result<usize, Failure> {
    let samples = duration.map_or_else(or_else, |time| (time / sample_time_s).round() + 1.0);
    if (2.0..=SAMPLES_MOST).contains(&samples) {
        return Ok(samples as usize);
    }
    Err(Failure::bad_input(format_args!(
        "{} samples of {} s are not 2 to {SAMPLES_MOST:e}: change {STEP_LENGTH} or {LOOP_TIME}",
        digits(samples, 4),
        Shown(sample_time_s)
    )))
}

/// A text of a key, if there is one, that is read so.
pub(crate) fn read<T>(
    parameter: Parameter,
    text: &str,
    read: fn(&str) -> Result<T, String>,
) -> Result<Option<T>, Failure> {
    let given = Some(text).filter(|text| !text.is_empty());
    let refused = |why| Failure::bad_input(format_args!("{parameter}: {why}"));
    given.map(read).transpose().map_err(refused)
}

impl DesignForm {
    /// The wishes.
    ///
    /// # Errors
    /// A number outside its range, a text that its key does not allow.
    pub fn wishes(&self) -> Result<Specification, Failure> {
        self.check()?;
        let Some(crossover) = self.crossover_rad_s else {
            return Err(Failure::bad_input(format_args!(
                "{CROSSOVER} is missing: give it, as in 0.05rad/s"
            )));
        };
        let margin = self.phase_margin_rad;
        let margin = margin.unwrap_or(PHASE_MARGIN.default_number());
        Ok(Specification {
            iso_damping: !self.not_flat,
            noise: read(NOISE, &self.noise, parse_bound)?,
            disturbance: read(DISTURBANCE, &self.disturbance, parse_bound)?,
            sensitivity_peak: read(SENSITIVITY_PEAK, &self.sensitivity_peak, parse_peak)?,
            complementary_peak: read(COMPLEMENTARY_PEAK, &self.complementary_peak, parse_peak)?,
            ..Specification::new(crossover, margin)
        })
    }

    /// The design for a plant.
    ///
    /// # Errors
    /// As [`wishes`](Self::wishes); a crossover at which the plant has no gain.
    pub fn design(&self, plant: Plant) -> Result<ControlDesign, Failure> {
        let wishes = self.wishes()?;
        let step = self.step.unwrap_or(STEP.default_number());
        check_step(step)?;
        let crossover = wishes.crossover_rad_s;
        let sample_time = match self.sample_time_s {
            Some(sample_time_s) => Seconds(sample_time_s),
            None => sample_time_for(crossover)?,
        };
        check_gain(&plant, crossover)?;
        let scheme = if self.scheme.is_empty() {
            CONTROLLER_SCHEME.shown
        } else {
            &self.scheme
        };
        let limits = read(OUTPUT_LIMITS, &self.output_limits, CommandLimits::parse)?;
        let usual = || samples_for(Some(crossover), sample_time.0);
        Ok(ControlDesign {
            plant,
            wishes,
            sample_time,
            scheme: controller_scheme(scheme).map_err(Failure::bad_input)?,
            output_low: limits.map(|limits| limits.low),
            output_high: limits.map(|limits| limits.high),
            step,
            samples: samples(self.duration_s, sample_time.0, usual)?,
        })
    }
}

/// Reads a largest amplitude ratio: a number, or in decibel.
fn parse_peak(text: &str) -> Result<f64, String> {
    parse_gain(text).map_err(|refused| format!("{refused}: give one as in 1.6 or 4dB"))
}

/// Reads a gain. What is refused stands there as it was given.
fn parse_gain(text: &str) -> Result<f64, String> {
    let none = |_| format!("\"{text}\" is neither a number nor decibel");
    let Some(decibel) = text.trim().strip_suffix("dB") else {
        let gain = parse_for_key("", text).map_err(none)?;
        let outside = || format!("gain {} is not {GAINS}", Shown(gain));
        return GAINS.contains(gain).then_some(gain).ok_or_else(outside);
    };
    let decibel = parse_for_key("", decibel).map_err(none)?;
    // The ends in decibel, rounded: they are whole.
    let [low, high] = (GAINS.ends()).map(|end| (20.0 * libm::log10(end)).round());
    if (low..=high).contains(&decibel) {
        Ok(libm::exp10(decibel / 20.0))
    } else {
        Err(format!(
            "gain {} dB is not from {low} to {high} dB",
            Shown(decibel)
        ))
    }
}

fn parse_bound(text: &str) -> Result<Bound, String> {
    let parts = || -> Result<Bound, String> {
        let (frequency, gain) =
            (text.split_once(':')).ok_or_else(|| format!("\"{text}\" is not FREQUENCY:GAIN"))?;
        let omega_rad_s =
            parse_for_key("frequency_rad_s", frequency).map_err(|error| error.to_string())?;
        if !ANGULAR_FREQUENCIES.contains(omega_rad_s) {
            return Err(format!(
                "frequency {} rad/s is not {ANGULAR_FREQUENCIES} rad/s",
                Shown(omega_rad_s)
            ));
        }
        Ok(Bound {
            omega_rad_s,
            at_most: parse_gain(gain)?,
        })
    };
    parts().map_err(|refused| format!("{refused}: give both as in 10rad/s:-20dB"))
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "round numbers are exact")]
mod tests {
    use super::*;

    #[test]
    fn gains_are_numbers_or_decibel() {
        assert_eq!(parse_gain("0.5"), Ok(0.5));
        assert_eq!(parse_gain("-20 dB"), Ok(0.1));
        assert!(parse_gain("-20d").is_err());
        let bound = parse_bound("2Hz:-20dB").expect("a bound");
        assert!((bound.omega_rad_s - 12.566).abs() < 1e-3 && bound.at_most == 0.1);
        assert!(parse_bound("2").is_err() && parse_bound("2m:1").is_err());
    }

    #[test]
    fn the_ends_in_decibel_are_those_of_the_numbers() {
        for (decibel, number) in [("-300dB", "1e-15"), ("120dB", "1e6")] {
            let [a, b] = [decibel, number].map(|text| parse_gain(text).expect(text));
            assert!((a / b - 1.0).abs() < 1e-12, "{a} {b}");
        }
        for text in ["-300.1dB", "120.1dB", "0.9e-15", "1.1e6", "0", "-1"] {
            assert!(parse_gain(text).is_err(), "{text}");
        }
    }

    #[test]
    fn what_is_refused_is_what_was_given() {
        for (text, reason) in [
            ("-1e9dB", "gain -1e9 dB is not from -300 to 120 dB"),
            ("7e150 dB", "gain 7e150 dB is not from -300 to 120 dB"),
            ("1e-300", "gain 1e-300 is not from 1e-15 to 1e6"),
        ] {
            assert_eq!(parse_gain(text), Err(reason.to_owned()));
            let both = parse_bound(&format!("3rad/s:{text}")).expect_err("refused");
            assert_eq!(both, format!("{reason}: give both as in 10rad/s:-20dB"));
        }
        let fast = parse_bound("1e10rad/s:0.1").expect_err("refused");
        assert!(
            fast.contains("frequency 1e10 rad/s is not from 1e-12 to 1e9 rad/s"),
            "{fast}"
        );
    }
}
