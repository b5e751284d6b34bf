//! `control identify`: a fractional transfer function from a record of input and output.

mod report;

use self::report::{DIGITS, Report, rounded, with_digits};
use super::draw::draw_identified;
use super::words::{digits, refused};
use crate::column;
use crate::files::PlaceOfFile;
use crate::output::{Output, note, warn};
use crate::within::within;
use clap::Args;
use fractional_control::model_search::{Found, Guess, InputOutput, candidates, identify, shifted};
use fractional_control::{ControlError, FractionalTransferFunction};
use haptic_experiment::failure::Failure;
use haptic_experiment::input::short;
use haptic_experiment::parameters;
use haptic_experiment::plant_file::{PlantFile, PlantModel};
use haptic_experiment::record_check::{check_signals, check_times};
use haptic_quantity::Time;
use haptic_tissue::open_file;
use std::path::PathBuf;

pub(super) const LONG_ABOUT: &str = "\
Fits a fractional transfer function to a record of input and output that begins at rest: coefficients and orders together, by least squares \
of the output, with the whole history. Writes a plant file that the other commands of control take.

DATA is a CSV with a header; the time runs in equal steps. Without --model, functions of whole orders up to four poles are fitted, whether they \
decay, swing, grow or add up, and functions of one and two powers of s with free orders, all begun from the record itself; the one with the least BIC is taken. With --model the terms and \
the first values are yours. A warning says what the function leaves unexplained, and which numbers the record does not determine.

JSON: function, delay_s, samples, sample_time_s, rms_residual, fit, bic, unstable_poles (null with one that neither grows nor decays), numbers[{name, value, standard_error, \
determined}], candidates[{function, rms_residual, bic}] (the best six), plant_file, files, warnings.";

/// Arguments of `control identify`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  host-cli control identify step.csv --out plant.toml\n  host-cli control identify record.csv --input valve --output \
                  temperature --delay 2s --model '2/(30s^0.9+1)' --subtract-start"
)]
pub struct Arguments {
    /// The record: CSV with a header
    #[arg(value_name = "DATA")]
    data: PathBuf,
    /// Column of the time, s
    #[arg(
        long,
        value_name = "COLUMN",
        default_value = "time_s",
        help_heading = "Table"
    )]
    time: String,
    /// Column of the input
    #[arg(
        long,
        value_name = "COLUMN",
        default_value = "input",
        help_heading = "Table"
    )]
    input: String,
    /// Column of the output
    #[arg(
        long,
        value_name = "COLUMN",
        default_value = "output",
        help_heading = "Table"
    )]
    output: String,
    /// Count input and output from their first row: the record begins at rest, but not at 0
    #[arg(long, help_heading = "Table")]
    subtract_start: bool,
    /// The input is smooth between its samples; without this it is held, as a command is
    #[arg(long, help_heading = "Table")]
    smooth: bool,
    /// Terms and first values, as in '2/(30s^0.9+1)' [default: found from the record]
    #[arg(long, value_name = "FUNCTION", allow_hyphen_values = true)]
    model: Option<String>,
    /// Known dead time
    #[arg(
        long, value_parser = within::<Time>(parameters::DEAD_TIME.range()),
        value_name = "TIME",
        default_value = "0",
        allow_hyphen_values = true
    )]
    delay: Time,
    /// Plant file to write, *.toml; a picture of the same name goes beside it
    #[arg(long, value_name = "FILE.toml", help_heading = "Files")]
    out: Option<PathBuf>,
    /// Replace the files of an earlier identification
    #[arg(long, help_heading = "Files")]
    overwrite: bool,
}

/// A record of more samples is said to take its time.
const LONG: usize = 200_000;
/// What a sample takes on one core of 2024, s, about.
const A_SAMPLE_S: f64 = 6e-5;

const NONE_FITS: &str = "\
none of the functions that are tried fits the record: look whether a row is far from the others; give --delay if there is a dead time, \
--subtract-start if the record does not begin at 0, or --model with terms and first values";

/// Terms and first values.
fn guess(text: &str) -> Result<FractionalTransferFunction, Failure> {
    let refused = |error: &dyn std::fmt::Display| {
        Failure::bad_input(format_args!("model \"{text}\": {error}; change --model"))
    };
    let guess: FractionalTransferFunction = text.parse().map_err(|error| refused(&error))?;
    if guess.denominator().degree() == 0.0 {
        return Err(refused(
            &"it has no power of s below, so there is no motion to fit: give one, as in 2/(30s^0.9+1)",
        ));
    }
    Ok(guess)
}

impl Arguments {
    /// Runs the command.
    ///
    /// # Errors
    /// A record that cannot be read or fitted, files that cannot be written.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let mut place = PlaceOfFile::look(self.out.as_deref(), self.overwrite, "plant")?;
        let record = self.read()?;
        if record.time_s.len() > LONG && !output.quiet {
            let words = format!(
                "{} samples take about {:.0} s; fewer, as every tenth, say nearly as much of a plant that is slow against them",
                record.time_s.len(),
                A_SAMPLE_S * record.time_s.len() as f64
            );
            note("note", words);
        }
        let delayed = shifted(&record, self.delay.0).map_err(refused)?;
        let guesses = match &self.model {
            Some(text) => {
                vec![Guess::Orders(guess(text)?)]
            }
            None => candidates(&delayed, !self.smooth),
        };
        let found = identify(&delayed, &guesses, !self.smooth).map_err(|error| match error {
            // Nobody gave a guess.
            ControlError::NotFound { .. } if self.model.is_none() => {
                Failure::Run(anyhow::anyhow!("{NONE_FITS}"))
            }
            error => refused(error),
        })?;
        let [best, ..] = &found[..] else {
            return Err(Failure::Run(anyhow::anyhow!(
                "no function was found: give --model with other terms"
            )));
        };
        let mut report = Report::new(&found, best, &record, self.delay.0);
        self.write(best, &record, &mut report, &mut place);
        for warning in &report.warnings {
            warn(warning);
        }
        output.summary(&report, |out| report.print(out))?;
        place.close(Ok(()))
    }

    /// Refuses a column that stands for two things.
    fn check_columns(&self) -> Result<(), Failure> {
        let named = [
            ("--time", &self.time),
            ("--input", &self.input),
            ("--output", &self.output),
        ];
        for (k, (first, name)) in named.iter().enumerate() {
            if let Some((second, _)) = named[k + 1..].iter().find(|(_, other)| other == name) {
                return Err(Failure::bad_input(format_args!(
                    "column {} is named by {first} and by {second}: give each its own",
                    short(name)
                )));
            }
        }
        Ok(())
    }

    fn read(&self) -> Result<InputOutput, Failure> {
        self.check_columns()?;
        let name = self.data.display().to_string();
        let column = |wanted: &str, option: &str| {
            let file = open_file(&self.data).map_err(|error| {
                Failure::bad_input(format_args!(
                    "cannot read the record `{name}`: {error}; give the path of a CSV file"
                ))
            })?;
            column::read_named(file, &name, wanted, &format!("give {option} one of them"))
        };
        let mut record = InputOutput {
            time_s: column(&self.time, "--time")?,
            input: column(&self.input, "--input")?,
            output: column(&self.output, "--output")?,
            late_s: 0.0,
        };
        check_times(&record).map_err(|error| {
            Failure::bad_input(format_args!(
                "{name}: {error}; the time is column {}, that of --time",
                short(&self.time)
            ))
        })?;
        if self.subtract_start {
            record.subtract_start();
        }
        check_signals(&record, [&self.input, &self.output]).map_err(|error| {
            Failure::bad_input(format_args!(
                "{name}: {error}; the columns are those of --input and --output"
            ))
        })?;
        Ok(record)
    }

    /// Writes the plant file and its picture.
    fn write(
        &self,
        best: &Found,
        record: &InputOutput,
        report: &mut Report,
        place: &mut PlaceOfFile,
    ) {
        let name = self.data.file_name().unwrap_or(self.data.as_os_str());
        let name = name.to_string_lossy();
        let file = PlantFile {
            intervals: Vec::new(),
            model: PlantModel::Function {
                function: Box::new(with_digits(&best.identified.function, DIGITS)),
                delay_s: self.delay.0,
            },
            program: concat!("host-cli ", env!("CARGO_PKG_VERSION")).to_owned(),
            note: format!(
                "identified from {name}, {} samples, rms {}",
                report.samples,
                digits(report.rms_residual)
            ),
        };
        let picture = || {
            draw_identified(
                &record.time_s,
                &record.input,
                &record.output,
                &best.identified.model,
                &rounded(&best.identified.function),
                &format!("{name} · {} samples", report.samples),
            )
        };
        let text = || file.to_toml().unwrap_or_default();
        let (plant_file, figure) = place.write(text, picture);
        report.plant_file = plant_file;
        report.files.extend(figure);
    }
}
