//! `control identify`: a fractional transfer function from a record of input and output.

mod report;

use self::report::{DIGITS, Report, rounded, with_digits};
use super::draw::draw_identified;
use super::words::refused;
use crate::column;
use crate::files::PlaceOfFile;
use crate::output::{Output, note, warn};
use crate::within::within;
use clap::Args;
use fractional_control::model_search::{Found, Guess, InputOutput, candidates, identify, shifted};
use fractional_control::{ControlError, FractionalTransferFunction};
use haptic_experiment::Failure;
use haptic_experiment::document::record_check::{check_signals, check_times};
use haptic_experiment::document::short;
use haptic_experiment::parameters;
use haptic_experiment::run::{PlantFile, PlantModel};
use haptic_quantity::{Time, digits, written};
use haptic_tissue::open_file;
use std::path::PathBuf;

pub(super) const LONG_ABOUT: &str = "\
Fits a fractional transfer function, coefficients and orders together, to a CSV record that begins at rest, with time in equal steps. \
Writes a plant file for the other commands of control.

Without --model it tries whole orders up to four poles, and one and two powers of s with free orders, and takes the least BIC. Warnings \
name what the function leaves unexplained, and the numbers that the record does not determine.";

/// Arguments of `control identify`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli control identify record.csv --columns input=valve,output=temperature --delay 2s --out plant.toml"
)]
pub struct Arguments {
    /// CSV with a header
    #[arg(value_name = "DATA")]
    data: PathBuf,
    /// Columns of time / s, input and output, as in `input=valve,output=temperature` [default: `time_s`, `input`, `output`]
    #[arg(long, value_name = "SIGNAL=COLUMN", value_delimiter = ',', value_parser = signal, help_heading = "Table")]
    columns: Vec<(usize, String)>,
    /// Subtract the first row: the record begins at rest, but not at 0
    #[arg(long, help_heading = "Table")]
    subtract_start: bool,
    /// The input is smooth between samples, not held
    #[arg(long, help_heading = "Table")]
    smooth: bool,
    /// Terms and first values as in '2/(30s^0.9+1)' [default: found from the record]
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
    /// Plant file to write, with a picture beside it
    #[arg(long, value_name = "FILE.toml", help_heading = "Files")]
    out: Option<PathBuf>,
    /// Replace existing files
    #[arg(long, help_heading = "Files")]
    overwrite: bool,
}

/// A record of more samples is said to take its time.
const LONG: usize = 200_000;
/// What a sample takes on one core of 2024, s, about.
const A_SAMPLE_S: f64 = 6e-5;

const NONE_FITS: &str = "\
no function fits the record: look for outliers; give --delay for a dead time, --subtract-start for a record that does not begin at 0, \
or --model with terms and first values";

/// Signals, and the columns that they are in.
const SIGNALS: [(&str, &str); 3] = [("time", "time_s"), ("input", "input"), ("output", "output")];

/// Place of a signal in [`SIGNALS`], and its column.
fn signal(text: &str) -> Result<(usize, String), String> {
    let split = text.split_once('=').and_then(|(name, column)| {
        let place = SIGNALS.iter().position(|signal| signal.0 == name.trim())?;
        Some((place, column.trim().to_owned()))
    });
    split.ok_or_else(|| "is not time=COLUMN, input=COLUMN or output=COLUMN".to_owned())
}

/// Terms and first values.
fn guess(text: &str) -> Result<FractionalTransferFunction, Failure> {
    let refused = |error: &dyn std::fmt::Display| {
        Failure::bad_input(format_args!("model \"{text}\": {error}; change --model"))
    };
    let guess: FractionalTransferFunction = text.parse().map_err(|error| refused(&error))?;
    if guess.denominator().degree() == 0.0 {
        return Err(refused(
            &"its denominator has no power of s: give one, as in 2/(30s^0.9+1)",
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
                "{} samples take about {}; every tenth may tell as much of a slow plant",
                record.time_s.len(),
                written("time_s", A_SAMPLE_S * record.time_s.len() as f64)
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
        output.summary(&report)?;
        place.close(Ok(()))
    }

    /// The columns of time, input and output.
    ///
    /// # Errors
    /// A column that stands for two things.
    fn columns(&self) -> Result<[&str; 3], Failure> {
        let mut names = SIGNALS.map(|(_, column)| column);
        for (place, name) in &self.columns {
            names[*place] = name;
        }
        let twice = (1..names.len()).find(|&place| names[..place].contains(&names[place]));
        match twice {
            None => Ok(names),
            Some(place) => Err(Failure::bad_input(format_args!(
                "column {} stands for two signals: give each its own with --columns",
                short(names[place])
            ))),
        }
    }

    fn read(&self) -> Result<InputOutput, Failure> {
        let [time, input, output] = self.columns()?;
        let name = self.data.display().to_string();
        let column = |wanted: &str, signal: &str| {
            let file = open_file(&self.data).map_err(|error| {
                Failure::bad_input(format_args!(
                    "cannot read the record `{name}`: {error}; give the path of a CSV file"
                ))
            })?;
            column::read_named(
                file,
                &name,
                wanted,
                &format!("give --columns {signal}=NAME"),
            )
        };
        let mut record = InputOutput {
            time_s: column(time, "time")?,
            input: column(input, "input")?,
            output: column(output, "output")?,
            late_s: 0.0,
        };
        check_times(&record).map_err(|error| {
            Failure::bad_input(format_args!(
                "{name}: {error}; the time is column {}, see --columns",
                short(time)
            ))
        })?;
        if self.subtract_start {
            record.subtract_start();
        }
        check_signals(&record, [input, output])
            .map_err(|error| Failure::bad_input(format_args!("{name}: {error}; see --columns")))?;
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
                digits(report.rms_residual, 4)
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
