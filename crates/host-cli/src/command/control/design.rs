//! `control design`: from wishes to a controller file, with the best PID of order 1 beside it.

mod report;

use self::report::Report;
use super::draw::{design_columns, draw_design};
use super::loops::{
    Limits, NamedPlant, PlantArguments, check_step, controller_scheme, parse_limits, samples,
};
use super::words::refused;
use crate::files::{Files, PROGRAM, Place, save_picture};
use crate::output::Output;
use crate::parse::{in_range, number_within, within};
use clap::Args;
use fracdiff::parameter::Shown;
use fracdiff::{Scheme, Seconds};
use fractional_control::ControlError;
use fractional_control::design::{ControlAnswer, ControlDesign};
use fractional_control::run::samples_for;
use fractional_control::tuning::{Bound, Specification};
use haptic_experiment::document::{ControllerFile, ControllerOrigin};
use haptic_experiment::parameters::range;
use haptic_experiment::{Failure, parameters};
use haptic_quantity::{Angle, AngularFrequency, QuantityError, Time, digits, parse_number};

pub(super) const LONG_ABOUT: &str = "\
Tunes a PI^lambda D^mu: crossover and phase margin exactly, a flat phase there, so that the \
overshoot stays when the plant's gain changes, and bounds on |S| and |T| as well as possible. \
Runs it beside the closest PID of order 1, and proves for which gains of the plant it is stable.

Exit code 1 if a wish is missed by more than 1 %; the report says which, and by how much.";

/// Samples in the time 1/crossover, if no sample time is given.
const SAMPLES_A_RADIAN: f64 = 50.0;

/// Arguments of `control design`.
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
    #[arg(long, value_parser = within::<Time>(range::SAMPLE_TIMES), help_heading = "Controller")]
    sample_time: Option<Time>,
    /// Scheme: full or full-bdf2, each with :TOLERANCE
    #[arg(long, value_parser = controller_scheme, default_value = parameters::CONTROLLER_SCHEME.shown, help_heading = "Controller")]
    scheme: Scheme,
    /// Limits of the command [default: none]
    #[arg(long, value_name = "LOW:HIGH", value_parser = parse_limits, help_heading = "Controller")]
    output_limits: Option<Limits>,
    /// Height of the simulated step
    #[arg(long, value_parser = number_within(range::NUMBERS), default_value = "1")]
    step: f64,
    /// Length of the steps [default: 60 times 1/crossover]
    #[arg(long, value_parser = within::<Time>(range::DURATIONS))]
    duration: Option<Time>,
    #[command(flatten)]
    files: Files,
}

/// The wishes.
#[derive(Debug, Args)]
#[command(next_help_heading = "Wishes")]
struct WishArguments {
    /// Crossover in rad/s or Hz: about 1.3/rise time
    #[arg(long, value_parser = within::<AngularFrequency>(range::ANGULAR_FREQUENCIES), value_name = "FREQUENCY")]
    crossover: AngularFrequency,
    /// Phase margin, as in 60deg
    #[arg(long, value_name = "ANGLE", default_value = "60deg")]
    phase_margin: Angle,
    /// Without flat phase: the overshoot may change with the gain
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
            ..Specification::new(self.crossover.0, self.phase_margin.0)
        }
    }

    /// The wishes as a line of the controller file.
    fn words(&self) -> String {
        let mut words = vec![
            format!("crossover {} rad/s", digits(self.crossover.0, 4)),
            format!(
                "phase margin {}°",
                digits(self.phase_margin.0.to_degrees(), 4)
            ),
        ];
        if !self.not_flat {
            words.push("flat phase".to_owned());
        }
        for (name, most) in [
            ("|S|", self.sensitivity_peak),
            ("|T|", self.complementary_peak),
        ] {
            words.extend(most.map(|most| format!("{name} ≤ {}", digits(most, 4))));
        }
        for (name, side, bound) in [
            ("|T|", "from", self.noise),
            ("|S|", "up to", self.disturbance),
        ] {
            words.extend(bound.map(|bound| {
                let (most, omega) = (digits(bound.at_most, 4), digits(bound.omega_rad_s, 4));
                format!("{name} ≤ {most} {side} {omega} rad/s")
            }));
        }
        words.join(", ")
    }
}

/// The next 1, 2 or 5 times a power of ten that is not longer.
fn round_down(time_s: f64) -> f64 {
    let decade = 10_f64.powf(time_s.log10().floor());
    let steps = [5.0, 2.0, 1.0].into_iter();
    let step = steps
        .map(|step| step * decade)
        .find(|step| *step <= time_s * (1.0 + 1e-9));
    let time_s = step.unwrap_or(decade);
    // 2e-3 and not 0.0020000000000000005.
    format!("{time_s:.0e}").parse().unwrap_or(time_s)
}

/// The sample time that goes with a crossover.
fn sample_time_for(crossover_rad_s: f64) -> Result<f64, Failure> {
    let time = |sample_time_s: f64| 1.0 / (SAMPLES_A_RADIAN * sample_time_s);
    let [low, high] = range::SAMPLE_TIMES.ends().map(time);
    let sample_time_s = round_down(1.0 / (SAMPLES_A_RADIAN * crossover_rad_s));
    if range::SAMPLE_TIMES.contains(sample_time_s) {
        return Ok(sample_time_s);
    }
    Err(Failure::bad_input(format_args!(
        "crossover {} rad/s is not from {} to {} rad/s: change --crossover, or give --sample-time",
        Shown(crossover_rad_s),
        Shown(high),
        Shown(low)
    )))
}

/// The gain of a controller is about one over that of the plant at the crossover, and may be no more than other numbers.
fn check_gain(plant: &NamedPlant, crossover_rad_s: f64) -> Result<(), Failure> {
    let [_, most] = range::NUMBERS.ends();
    let gain = plant.plant.response(crossover_rad_s).map(|g| g.norm());
    match gain.filter(|gain| gain.is_nan() || !(1.0 / most..=most).contains(gain)) {
        None => Ok(()),
        Some(gain) => Err(Failure::bad_input(format_args!(
            "the plant's gain {} at --crossover {} rad/s is not from {} to {}: change its units",
            Shown(gain),
            Shown(crossover_rad_s),
            Shown(1.0 / most),
            Shown(most)
        ))),
    }
}

impl Arguments {
    pub(super) fn run(self, output: Output) -> Result<(), Failure> {
        let mut place = self.files.look("controller", &["toml"])?;
        let plant = self.plant.resolve()?;
        let design = self.design(&plant)?;
        let answer = &design.answer().map_err(|error| match error {
            ControlError::NotFound { .. } => {
                refused(error).and("see --crossover, --phase-margin and --not-flat")
            }
            error => refused(error),
        })?;
        let design = &design;
        let report = Report { design, answer };
        let file = ControllerFile {
            setup: answer.fractional.setup.clone(),
            origin: ControllerOrigin {
                plant: plant.words.clone(),
                wishes: self.wishes.words(),
                program: PROGRAM.to_owned(),
                note: report.note(),
            },
        };
        let controller = place.text("toml", &file.to_toml());
        let files = write(&plant, answer, &mut place);
        output.summary(&report.value(&plant.words, controller.as_deref(), &files))?;
        place.close(report.judge())
    }

    fn design(&self, plant: &NamedPlant) -> Result<ControlDesign, Failure> {
        check_step(self.step)?;
        let crossover = self.wishes.crossover.0;
        let sample_time_s = match self.sample_time {
            Some(time) => time.0,
            None => sample_time_for(crossover)?,
        };
        check_gain(plant, crossover)?;
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
fn write(plant: &NamedPlant, answer: &ControlAnswer, place: &mut Place) -> Vec<String> {
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
        place.write(|folder| folder.write_named_table("csv", &names, rows))
    });
    let picture = place.write(|folder| {
        let picture = draw_design(answer, plant).transpose();
        picture
            .map(|picture| save_picture(folder, picture))
            .transpose()
    });
    table.into_iter().chain(picture.flatten()).collect()
}

/// Reads a largest amplitude ratio: a number, or in decibel.
fn parse_peak(text: &str) -> Result<f64, String> {
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
fn parse_bound(text: &str) -> Result<Bound, String> {
    let parts = || -> Result<Bound, String> {
        let (frequency, gain) =
            (text.split_once(':')).ok_or_else(|| format!("\"{text}\" is not FREQUENCY:GAIN"))?;
        let frequency: AngularFrequency = frequency
            .parse()
            .map_err(|error: QuantityError| error.to_string())?;
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
    fn a_sample_time_is_a_round_number() {
        for (time, round) in [
            (0.2, 0.2),
            (0.19, 0.1),
            (4e-4, 2e-4),
            (1e-3, 1e-3),
            (7.0, 5.0),
        ] {
            assert_eq!(round_down(time), round, "{time}");
        }
    }

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
