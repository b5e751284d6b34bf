//! `control design`: from wishes to a controller file, with the best PID of order 1 beside it.

mod bound;
mod report;

use self::bound::{parse_bound, parse_peak};
use self::report::Report;
use super::controller::{Limits, controller_scheme, parse_limits};
use super::draw::{design_columns, draw_design};
use super::plant::{NamedPlant, PlantArguments};
use super::words::refused;
use crate::files::{Place, save_picture};
use crate::output::Output;
use crate::within::{number_within, within};
use clap::Args;
use fracdiff::parameter::Shown;
use fracdiff::{Scheme, Seconds};
use fractional_control::ControlError;
use fractional_control::design::{ControlAnswer, ControlDesign};
use fractional_control::run::{SAMPLES_MOST, samples_for};
use fractional_control::tuning::{Bound, Specification};
use haptic_experiment::Failure;
use haptic_experiment::document::{ControllerFile, ControllerOrigin};
use haptic_experiment::parameters;
use haptic_experiment::parameters::range;
use haptic_experiment::run::write_text;
use haptic_quantity::{Angle, AngularFrequency, Time, digits};
use std::path::PathBuf;

pub(super) const LONG_ABOUT: &str = "\
Tunes a PI^lambda D^mu: crossover and phase margin exactly, a flat phase there (so that the overshoot stays when the plant's gain \
changes), and bounds on |S| and |T| as well as possible, compared with the closest PID of order 1. Both are run; the verdict on the \
sampled loop is a proof, for an interval of plant gains, with a warning if that does not reach from half to double.

Exit code 1 if a wish is missed by more than 1 %; the report says which, and by how much.";

/// Samples in the time 1/crossover, if no sample time is given.
const SAMPLES_A_RADIAN: f64 = 50.0;

/// Arguments of `control design`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli control design --plant '0.55exp(-s)/(62s+1)' --crossover 0.1rad/s --phase-margin 65deg --out oven"
)]
pub struct Arguments {
    #[command(flatten)]
    plant: PlantArguments,
    #[command(flatten)]
    wishes: WishArguments,
    /// Sample time [default: about 1/(50 crossover)]
    #[arg(
        long, value_parser = within::<Time>(range::SAMPLE_TIMES),
        value_name = "TIME",
        allow_hyphen_values = true,
        help_heading = "Controller"
    )]
    sample_time: Option<Time>,
    /// Scheme: full or full-bdf2, each with :TOLERANCE
    #[arg(long, value_parser = controller_scheme, default_value = parameters::CONTROLLER_SCHEME.shown, help_heading = "Controller")]
    scheme: Scheme,
    /// Limits of the command [default: none]
    #[arg(long, value_name = "LOW:HIGH", value_parser = parse_limits, allow_hyphen_values = true, help_heading = "Controller")]
    output_limits: Option<Limits>,
    /// Height of the simulated step
    #[arg(long, value_parser = number_within(range::NUMBERS), default_value = "1", allow_hyphen_values = true)]
    step: f64,
    /// Length of the steps [default: 60 times 1/crossover]
    #[arg(long, value_parser = within::<Time>(range::DURATIONS), value_name = "TIME", allow_hyphen_values = true)]
    duration: Option<Time>,
    /// Folder for controller.toml, the steps as CSV, and a picture
    #[arg(long, value_name = "DIR", help_heading = "Files")]
    out: Option<PathBuf>,
    /// Replace existing files
    #[arg(long, help_heading = "Files")]
    overwrite: bool,
}

/// The wishes.
#[derive(Debug, Args)]
#[command(next_help_heading = "Wishes")]
struct WishArguments {
    /// Crossover in rad/s or Hz: about 1.6/rise time
    #[arg(long, value_parser = within::<AngularFrequency>(range::ANGULAR_FREQUENCIES), value_name = "FREQUENCY", allow_hyphen_values = true)]
    crossover: AngularFrequency,
    /// Phase margin, as in 60deg
    #[arg(
        long,
        value_name = "ANGLE",
        default_value = "60deg",
        allow_hyphen_values = true
    )]
    phase_margin: Angle,
    /// Without flat phase: the overshoot may change with the gain
    #[arg(long)]
    not_flat: bool,
    /// Largest |S|: how much errors may grow
    #[arg(long, value_name = "GAIN", value_parser = parse_peak, allow_hyphen_values = true)]
    sensitivity_peak: Option<f64>,
    /// Largest |T|
    #[arg(long, value_name = "GAIN", value_parser = parse_peak, allow_hyphen_values = true)]
    complementary_peak: Option<f64>,
    /// Noise: largest |T| above a frequency, as in 10rad/s:-20dB
    #[arg(long, value_name = "FREQUENCY:GAIN", value_parser = parse_bound, allow_hyphen_values = true)]
    noise: Option<Bound>,
    /// Disturbance: largest |S| below a frequency, as in 0.01rad/s:0.1
    #[arg(long, value_name = "FREQUENCY:GAIN", value_parser = parse_bound, allow_hyphen_values = true)]
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
            "the plant's gain {} at --crossover {} rad/s is not from {} to {}: give the plant in other units, or change --crossover",
            digits(gain, 4),
            Shown(crossover_rad_s),
            Shown(1.0 / most),
            Shown(most)
        ))),
    }
}

impl Arguments {
    /// Runs the command.
    ///
    /// # Errors
    /// Wishes that contradict each other or are not met, a plant that is wrong, files that cannot be written.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let mut place = Place::look(self.out.as_deref(), "controller", self.overwrite, &["toml"])?;
        let plant = self.plant.resolve()?;
        let design = self.design(&plant)?;
        let answer = design.answer().map_err(|error| match error {
            ControlError::NotFound { .. } => {
                refused(error).and("see --crossover, --phase-margin and --not-flat")
            }
            error => refused(error),
        })?;
        let mut report = Report::new(&plant.words, &design, &answer);
        self.write(&plant, &answer, &mut report, &mut place);
        output.summary(&report)?;
        place.close(report.judge())
    }

    fn design(&self, plant: &NamedPlant) -> Result<ControlDesign, Failure> {
        if self.step == 0.0 {
            return Err(Failure::bad_input(
                "a step of height 0 moves nothing: give --step another height",
            ));
        }
        let crossover = self.wishes.crossover.0;
        let sample_time_s = match self.sample_time {
            Some(time) => time.0,
            None => sample_time_for(crossover)?,
        };
        check_gain(plant, crossover)?;
        let samples = match self.duration {
            Some(duration) => (duration.0 / sample_time_s).round() + 1.0,
            None => samples_for(Some(crossover), sample_time_s),
        };
        if !(2.0..=SAMPLES_MOST).contains(&samples) {
            return Err(Failure::bad_input(format_args!(
                "{} samples of {sample_time_s} s are not 2 to {SAMPLES_MOST:e}: change --duration or --sample-time",
                digits(samples, 4),
                sample_time_s = Shown(sample_time_s)
            )));
        }
        Ok(ControlDesign {
            plant: plant.plant.clone(),
            wishes: self.wishes.specification(),
            sample_time: Seconds(sample_time_s),
            scheme: self.scheme,
            output_low: self.output_limits.map(|limits| limits.low),
            output_high: self.output_limits.map(|limits| limits.high),
            step: self.step,
            samples: samples as usize,
        })
    }

    /// Writes controller, table and picture, if a folder was given.
    fn write(
        &self,
        plant: &NamedPlant,
        answer: &ControlAnswer,
        report: &mut Report,
        place: &mut Place,
    ) {
        let file = ControllerFile {
            setup: answer.fractional.setup.clone(),
            origin: ControllerOrigin {
                plant: plant.words.clone(),
                wishes: self.wishes.words(),
                program: concat!("host-cli ", env!("CARGO_PKG_VERSION")).to_owned(),
                note: report.note(),
            },
        };
        report.controller_file = place.write(|folder| {
            let path = folder.file("toml");
            write_text(&path, &file.to_toml(), self.overwrite)?;
            Ok(path.display().to_string())
        });
        let mut columns = design_columns(&answer.fractional, "");
        if let Ok(integer) = &answer.integer {
            columns.extend(design_columns(integer, "integer_"));
        }
        if let Some((_, first)) = columns.first() {
            let t = answer.fractional.setup.sample_time_s;
            let names = columns.iter().map(|(name, _)| name.as_str());
            let names: Vec<&str> = std::iter::once("time_s").chain(names).collect();
            let rows = (0..first.len()).map(|n| {
                let values = columns.iter().map(|(_, column)| column[n]);
                std::iter::once(n as f64 * t)
                    .chain(values)
                    .collect::<Vec<f64>>()
            });
            let table = place.write(|folder| folder.write_named_table("csv", &names, rows));
            report.files.extend(table);
        }
        let picture = place.write(|folder| {
            let picture = draw_design(answer, plant).transpose();
            picture
                .map(|picture| save_picture(folder, picture))
                .transpose()
        });
        report.files.extend(picture.flatten());
    }
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
}
