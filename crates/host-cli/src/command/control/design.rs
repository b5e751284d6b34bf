//! `control design`: from wishes to a controller file, with the best integer-order PID beside it.

mod report;

use self::report::Report;
use super::draw::{design_columns, draw_design};
use super::loops::{
    Limits, NamedPlant, PlantArguments, check_step, controller_scheme, parse_limits, samples,
};
use super::refused;
use crate::files::{Files, PROGRAM, Place};
use crate::output::Output;
use crate::parse::{in_range, quantity};
use clap::Args;
use fracdiff::parameter::Shown;
use fracdiff::{Scheme, Seconds};
use fractional_control::ControlError;
use fractional_control::design::{ControlAnswer, ControlDesign};
use fractional_control::run::samples_for;
use fractional_control::tuning::{Bound, Specification};
use haptic_experiment::Failure;
use haptic_experiment::control::{check_gain, sample_time_for};
use haptic_experiment::parameters::{self, Range};
use haptic_quantity::parse_for_key;

/// Bounds of an amplitude ratio, -300 to 120 dB: a smaller ratio is lost in the rounding of a loop.
const BOUNDS: Range = Range::Within(1e-15, 1e6);

/// Angles; that of the phase margin is judged in degrees, by the tuning.
const ANGLES: Range = Range::Within(f64::MIN, f64::MAX);

/// Tune a fractional PID and compare it with the best integer-order PID
///
/// The controller is a PI^lambda D^mu. It meets crossover and phase margin exactly, makes the phase
/// flat there (so that the overshoot stays the same when the plant's gain changes), and keeps
/// bounds on |S| and |T| as well as possible. The result is simulated beside the closest
/// integer-order PID. The verdict on the sampled loop is a proof for an interval of plant gains,
/// with a warning if that does not reach from half to double.
///
/// Exit code 1 if a wish is missed by more than 1 %; the report says which, and by how much.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli control design --plant '0.55exp(-s)/(62s+1)' --crossover \
                  0.1rad/s --phase-margin 65deg --out oven"
)]
pub(crate) struct Arguments {
    #[command(flatten)]
    plant: PlantArguments,
    #[command(flatten)]
    wishes: WishArguments,
    /// Sample time [default: about 1/(50 crossover)]
    #[arg(long, value_name = "TIME", value_parser = quantity("_s", parameters::SAMPLE_TIME.range()), help_heading = "Controller")]
    sample_time: Option<f64>,
    /// Scheme: full or full-bdf2, each with :TOLERANCE
    #[arg(long, value_parser = controller_scheme, default_value = parameters::CONTROLLER_SCHEME.shown, help_heading = "Controller")]
    scheme: Scheme,
    /// Limits of the command [default: none]
    #[arg(long, value_name = "LOW:HIGH", value_parser = parse_limits, help_heading = "Controller")]
    output_limits: Option<Limits>,
    /// Height of the simulated step
    #[arg(long, value_parser = quantity("", parameters::OUTPUT_HIGH.range()), default_value = "1")]
    step: f64,
    /// Length of the steps [default: 60 times 1/crossover]
    #[arg(long, value_name = "TIME", value_parser = quantity("_s", parameters::TRIAL_DURATION.range()))]
    duration: Option<f64>,
    #[command(flatten)]
    files: Files,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Wishes")]
struct WishArguments {
    /// Crossover in rad/s or Hz: about 1.3/rise time
    #[arg(long, value_parser = quantity("_rad_s", parameters::analysis::OMEGA_MAX.range()), value_name = "FREQUENCY")]
    crossover: f64,
    /// Phase margin, as in 60deg
    #[arg(long, value_name = "ANGLE", value_parser = quantity("_rad", ANGLES), default_value = "60deg")]
    phase_margin: f64,
    /// Do not make the phase flat: the overshoot may then change with the gain
    #[arg(long)]
    not_flat: bool,
    /// Largest |S|: how much errors may grow
    #[arg(long, value_name = "GAIN", value_parser = parse_peak)]
    sensitivity_peak: Option<f64>,
    /// Largest |T|
    #[arg(long, value_name = "GAIN", value_parser = parse_peak)]
    complementary_peak: Option<f64>,
    /// Noise: largest |T| above a frequency, as in 10rad/s:-20dB
    #[arg(long, value_name = "FREQUENCY:GAIN", value_parser = parse_bound)]
    noise: Option<Bound>,
    /// Disturbance: largest |S| below a frequency, as in 0.01rad/s:0.1
    #[arg(long, value_name = "FREQUENCY:GAIN", value_parser = parse_bound)]
    disturbance: Option<Bound>,
}

impl WishArguments {
    fn specification(&self) -> Specification {
        Specification {
            iso_damping: !self.not_flat,
            noise: self.noise,
            disturbance: self.disturbance,
            sensitivity_peak: self.sensitivity_peak,
            complementary_peak: self.complementary_peak,
            ..Specification::new(self.crossover, self.phase_margin)
        }
    }
}

impl Arguments {
    pub(super) fn run(self, output: Output) -> Result<(), Failure> {
        let mut outputs = self.files.look("controller", &["toml"])?;
        let plant = self.plant.resolve()?;
        let design = self.design(&plant)?;
        let answer = &design.answer().map_err(|error| {
            if matches!(error, ControlError::NotFound { .. }) {
                return refused(error).and("see --crossover, --phase-margin and --not-flat");
            }
            refused(error)
        })?;
        let design = &design;
        let report = Report { design, answer };
        let file = report.words().file(&plant.words, &design.wishes, PROGRAM);
        let controller = outputs.text("toml", &file.to_toml());
        let files = write(&plant, answer, &mut outputs);
        output.summary(&report.value(&plant.words, controller.as_deref(), &files))?;
        outputs.close(report.judge())
    }

    fn design(&self, plant: &NamedPlant) -> Result<ControlDesign, Failure> {
        check_step(self.step)?;
        let crossover = self.wishes.crossover;
        let sample_time_s = match self.sample_time {
            Some(sample_time_s) => sample_time_s,
            None => sample_time_for(crossover)?.0,
        };
        check_gain(&plant.plant, crossover)?;
        Ok(ControlDesign {
            plant: plant.plant.clone(),
            wishes: self.wishes.specification(),
            sample_time: Seconds(sample_time_s),
            scheme: self.scheme,
            output_low: self.output_limits.map(|limits| limits.low),
            output_high: self.output_limits.map(|limits| limits.high),
            step: self.step,
            samples: samples(self.duration, sample_time_s, || {
                samples_for(Some(crossover), sample_time_s)
            })?,
        })
    }
}

/// Writes table and picture, if a folder was given and the plant runs; their names.
fn write(plant: &NamedPlant, answer: &ControlAnswer, outputs: &mut Place) -> Vec<String> {
    let mut columns = design_columns(&answer.fractional, "");
    if let Ok(integer) = &answer.integer {
        columns.extend(design_columns(integer, "integer_"));
    }
    let t = answer.fractional.setup.sample_time_s;
    let table = columns.first().and_then(|(_, first)| {
        let names = columns.iter().map(|(name, _)| name.as_str());
        let names: Vec<&str> = std::iter::once("time_s").chain(names).collect();
        let rows = (0..first.len()).map(|n| {
            let values = columns.iter().map(|(_, column)| column[n]);
            let row = std::iter::once(n as f64 * t).chain(values);
            row.collect::<Vec<f64>>()
        });
        outputs.write(|folder| folder.write_table(&names, rows))
    });
    let picture = draw_design(answer, plant).transpose();
    let picture = picture.and_then(|picture| outputs.picture(|| picture));
    table.into_iter().chain(picture).collect()
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
        return in_range("", gain, BOUNDS).map_err(|refused| format!("gain {refused}"));
    };
    let decibel = parse_for_key("", decibel).map_err(none)?;
    // The ends in decibel, rounded: they are whole.
    let [low, high] = (BOUNDS.ends()).map(|end| (20.0 * end.log10()).round());
    if (low..=high).contains(&decibel) {
        Ok(10_f64.powf(decibel / 20.0))
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
        let key = "frequency_rad_s";
        let frequency = parse_for_key(key, frequency).map_err(|error| error.to_string())?;
        let frequency = in_range(key, frequency, parameters::analysis::OMEGA_MAX.range());
        Ok(Bound {
            omega_rad_s: frequency.map_err(|refused| format!("frequency {refused}"))?,
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
            fast.contains("frequency 1e10 rad/s is not from 1e-12 rad/s to 1e9 rad/s"),
            "{fast}"
        );
    }
}
