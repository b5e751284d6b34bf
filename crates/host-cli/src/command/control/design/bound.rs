//! Bounds of amplitude ratios, as numbers or in decibel.

use crate::command::words::parse_number;
use crate::within::in_range;
use fracdiff::parameter::Shown;
use fractional_control::tuning::Bound;
use haptic_experiment::parameters::range;
use haptic_quantity::AngularFrequency;

/// Reads a largest amplitude ratio: a number, or in decibel.
pub(super) fn parse_peak(text: &str) -> Result<f64, String> {
    parse_gain(text).map_err(|refused| format!("{refused}: give one as in 1.6 or 4dB"))
}

/// Reads a gain. What is refused stands there as it was given.
fn parse_gain(text: &str) -> Result<f64, String> {
    let none = |_| format!("\"{text}\" is neither a number nor decibel");
    let Some(decibel) = text.trim().strip_suffix("dB") else {
        let gain = parse_number(text).map_err(none)?;
        return in_range(gain, range::BOUNDS).map_err(|refused| format!("gain {refused}"));
    };
    let decibel = parse_number(decibel).map_err(none)?;
    // The ends in decibel, rounded: they are whole.
    let [low, high] = (range::BOUNDS.ends()).map(|end| (20.0 * end.log10()).round());
    if (low..=high).contains(&decibel) {
        Ok(10_f64.powf(decibel / 20.0))
    } else {
        Err(format!(
            "gain {} dB is not from {low} to {high} dB",
            Shown(decibel)
        ))
    }
}

/// Reads a frequency and a gain.
pub(super) fn parse_bound(text: &str) -> Result<Bound, String> {
    let parts = || -> Result<Bound, String> {
        let (frequency, gain) =
            (text.split_once(':')).ok_or_else(|| format!("\"{text}\" is not FREQUENCY:GAIN"))?;
        let frequency: AngularFrequency = frequency
            .parse()
            .map_err(|error: haptic_quantity::QuantityError| error.to_string())?;
        Ok(Bound {
            omega_rad_s: in_range(frequency, range::ANGULAR_FREQUENCIES)
                .map_err(|refused| format!("frequency {refused}"))?
                .0,
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
        for (text, said) in [
            ("-1e9dB", "gain -1e9 dB is not from -300 to 120 dB"),
            ("7e150 dB", "gain 7e150 dB is not from -300 to 120 dB"),
            ("1e-300", "gain 1e-300 is not from 1e-15 to 1e6"),
        ] {
            assert_eq!(parse_gain(text), Err(said.to_owned()));
            let both = parse_bound(&format!("3rad/s:{text}")).expect_err("refused");
            assert_eq!(both, format!("{said}: give both as in 10rad/s:-20dB"));
        }
        let fast = parse_bound("1e10rad/s:0.1").expect_err("refused");
        assert!(
            fast.contains("frequency 1e10 rad/s is not from 1e-12 to 1e9 rad/s"),
            "{fast}"
        );
    }
}
