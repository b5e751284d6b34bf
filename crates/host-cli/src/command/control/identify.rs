//! `control identify`: a fractional transfer function from a record of input and output.

use super::draw::draw_identified;
use super::print::{table, written};
use super::words::{digits, refused};
use crate::column;
use crate::files::overwrite_acts;
use crate::output::Output;
use crate::picture_file::{self, PictureFileError};
use crate::within::within;
use clap::Args;
use fractional_control::{FractionalTransferFunction, FreeNumber};
use haptic_experiment::control::identification::{
    Found, InputOutput, candidates, identify, shifted,
};
use haptic_experiment::failure::Failure;
use haptic_experiment::folder::write_text;
use haptic_experiment::parameters;
use haptic_experiment::plant_file::{PlantFile, PlantModel};
use haptic_quantity::Time;
use serde::Serialize;
use std::fs::File;
use std::path::PathBuf;

pub(super) const LONG_ABOUT: &str = "\
Fits a fractional transfer function to a record of input and output that begins at rest: coefficients and orders together, by least squares \
of the output, with the whole history. Writes a plant file that the other commands of control take.

DATA is a CSV with a header; the time runs in equal steps. Without --model, functions of one and two powers of s are fitted, begun from the \
record itself, and the one with the least BIC is taken; of a record that does not come to rest also functions that add up or grow. With --model the terms and the first values are yours.

JSON: function, delay_s, samples, sample_time_s, rms_residual, fit, bic, unstable_poles (null with one that neither grows nor decays), numbers[{name, value, standard_error}], candidates[{function, \
rms_residual, bic}], plant_file, files.";

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

/// The result.
#[derive(Serialize)]
struct Report {
    function: String,
    delay_s: f64,
    samples: usize,
    sample_time_s: f64,
    rms_residual: f64,
    fit: f64,
    bic: f64,
    /// Null with a pole at s = 0 or on the imaginary axis.
    unstable_poles: Option<usize>,
    numbers: Vec<Number>,
    candidates: Vec<Candidate>,
    plant_file: Option<String>,
    files: Vec<String>,
}

#[derive(Serialize)]
struct Number {
    name: String,
    value: f64,
    /// Null where the record says nothing.
    standard_error: Option<f64>,
}

#[derive(Serialize)]
struct Candidate {
    function: String,
    rms_residual: f64,
    bic: f64,
}

impl Arguments {
    /// Runs the command.
    ///
    /// # Errors
    /// A record that cannot be read or fitted, files that cannot be written.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        overwrite_acts(self.out.as_deref(), self.overwrite)?;
        self.check_out()?;
        let record = self.read()?;
        let delayed = shifted(&record, self.delay.0).map_err(refused)?;
        let guesses = match &self.model {
            Some(text) => {
                let guess: FractionalTransferFunction = text.parse().map_err(|error| {
                    Failure::bad_input(format_args!("model \"{text}\": {error}; change --model"))
                })?;
                vec![guess]
            }
            None => candidates(&delayed),
        };
        let found = identify(&delayed, &guesses, !self.smooth).map_err(refused)?;
        let [best, ..] = &found[..] else {
            return Err(Failure::Run(anyhow::anyhow!(
                "no function was found: give --model with other terms"
            )));
        };
        let mut report = self.report(best, &found, &record);
        self.write(best, &record, &mut report)?;
        output.summary(&report, |out| report.print(out))
    }

    fn check_out(&self) -> Result<(), Failure> {
        let Some(path) = &self.out else {
            return Ok(());
        };
        let is_toml = path.extension().is_some_and(|own| own == "toml");
        if !is_toml {
            return Err(Failure::bad_input(format_args!(
                "`{}` is no plant file: give --out a name that ends in .toml, as in plant.toml",
                path.display()
            )));
        }
        if !self.overwrite && path.symlink_metadata().is_ok() {
            return Err(haptic_log::record::NewFileError::Exists(path.clone()).into());
        }
        Ok(())
    }

    fn read(&self) -> Result<InputOutput, Failure> {
        let name = self.data.display().to_string();
        let column = |wanted: &str, option: &str| {
            let file = File::open(&self.data).map_err(|error| {
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
        };
        record
            .check_times()
            .map_err(|error| Failure::bad_input(format_args!("{name}: {error}")))?;
        if self.subtract_start {
            record.subtract_start();
        }
        Ok(record)
    }

    fn report(&self, best: &Found, found: &[Found], record: &InputOutput) -> Report {
        let own = &best.identified;
        let numbers = own.standard_errors.iter().map(|(number, error)| {
            let (name, value, absolute) = named(&own.function, *number);
            Number {
                name,
                value,
                standard_error: Some(error * absolute).filter(|error| error.is_finite()),
            }
        });
        let candidates = found.iter().map(|found| Candidate {
            function: with_digits(&found.identified.function, DIGITS).to_string(),
            rms_residual: found.identified.rms_residual,
            bic: found.bic,
        });
        Report {
            function: with_digits(&own.function, DIGITS).to_string(),
            delay_s: self.delay.0,
            samples: record.time_s.len(),
            sample_time_s: record.sample_time_s(),
            rms_residual: own.rms_residual,
            fit: own.fit,
            bic: best.bic,
            unstable_poles: own.function.unstable_poles(),
            numbers: numbers.collect(),
            candidates: candidates.collect(),
            plant_file: None,
            files: Vec::new(),
        }
    }

    fn write(
        &self,
        best: &Found,
        record: &InputOutput,
        report: &mut Report,
    ) -> Result<(), Failure> {
        let Some(path) = &self.out else {
            return Ok(());
        };
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
        let text = file.to_toml().unwrap_or_default();
        let picture = draw_identified(
            &record.time_s,
            &record.input,
            &record.output,
            &best.model,
            &rounded(&best.identified.function),
            &format!("{name} · {} samples", report.samples),
        );
        let picture = picture.map_err(PictureFileError::from)?;
        write_text(path, &text, self.overwrite)?;
        let saved = picture_file::save(&picture, &path.with_extension(""), self.overwrite)?;
        report.plant_file = Some(path.display().to_string());
        report.files.push(saved.shown().display().to_string());
        Ok(())
    }
}

/// A number whose standard error is above this share of it is not determined.
const LOOSE: f64 = 0.5;
/// Digits of a plant file: more than any record has.
const DIGITS: usize = 9;

/// The function with numbers of five digits.
fn rounded(function: &FractionalTransferFunction) -> String {
    with_digits(function, 5).to_string()
}

/// The function with numbers of so many digits.
fn with_digits(function: &FractionalTransferFunction, digits: usize) -> FractionalTransferFunction {
    let few = |value: f64| format!("{value:.*e}", digits - 1).parse().unwrap_or(value);
    let terms = |polynomial: &fractional_control::FractionalPolynomial| {
        let terms = polynomial.terms().iter();
        terms
            .map(|term| fractional_control::Term::new(few(term.coefficient), few(term.order)))
            .collect::<Vec<_>>()
    };
    let (above, below) = (terms(function.numerator()), terms(function.denominator()));
    FractionalTransferFunction::new(&above, &below).unwrap_or(*function)
}

/// Name and value of a number, and the factor that makes its standard error absolute.
fn named(function: &FractionalTransferFunction, number: FreeNumber) -> (String, f64, f64) {
    let (above, below) = (function.numerator().terms(), function.denominator().terms());
    let of = |part: &str, term: Option<&fractional_control::Term>, n: usize, is_order: bool| {
        let (coefficient, order) = term.map_or((f64::NAN, f64::NAN), |t| (t.coefficient, t.order));
        match is_order {
            true => (format!("{part}_order_{}", n + 1), order, 1.0),
            // Errors of coefficients are relative.
            false => (
                format!("{part}_coefficient_{}", n + 1),
                coefficient,
                coefficient.abs(),
            ),
        }
    };
    match number {
        FreeNumber::NumeratorCoefficient(n) => of("numerator", above.get(n), n, false),
        FreeNumber::NumeratorOrder(n) => of("numerator", above.get(n), n, true),
        FreeNumber::DenominatorCoefficient(n) => of("denominator", below.get(n), n, false),
        FreeNumber::DenominatorOrder(n) => of("denominator", below.get(n), n, true),
        _ => ("number".to_owned(), f64::NAN, 1.0),
    }
}

impl Report {
    /// What to know of the function before it is used.
    fn sentences(&self) -> Vec<String> {
        let mut said = Vec::new();
        match self.unstable_poles {
            Some(0) => {}
            Some(_) => said.push(
                "The record grows: this plant does not hold itself. Close the loop with host-cli control design."
                    .to_owned(),
            ),
            None => said.push(
                "The record does not come to rest: this plant adds up what goes in. Close the loop with host-cli control design."
                    .to_owned(),
            ),
        }
        let loose = |number: &&Number| {
            let error = number.standard_error.unwrap_or(f64::INFINITY);
            error > LOOSE * number.value.abs()
        };
        let loose: Vec<&str> = (self.numbers.iter().filter(loose))
            .map(|number| number.name.as_str())
            .collect();
        if !loose.is_empty() {
            said.push(format!(
                "The record does not determine {}: record for longer, or give --model with fewer terms.",
                loose.join(", ")
            ));
        }
        said
    }

    fn print(&self, out: &mut dyn std::io::Write) -> std::io::Result<()> {
        let function: Result<FractionalTransferFunction, _> = self.function.parse();
        let shown = function.map_or_else(|_| self.function.clone(), |function| rounded(&function));
        let delay = match self.delay_s {
            0.0 => String::new(),
            delay => format!(", dead time {delay} s"),
        };
        writeln!(out, "{shown}{delay}")?;
        writeln!(
            out,
            "{} samples, {} s apart; rms of what is left {}, {:.4} % of the variance",
            self.samples,
            digits(self.sample_time_s),
            digits(self.rms_residual),
            100.0 * (1.0 - self.fit)
        )?;
        if self.candidates.len() > 1 {
            let mut rows = vec![["", "rms", "BIC"].map(str::to_owned).to_vec()];
            for (n, candidate) in self.candidates.iter().enumerate() {
                let mark = if n == 0 { "* " } else { "  " };
                let function: Result<FractionalTransferFunction, _> = candidate.function.parse();
                let function = function.map_or_else(
                    |_| candidate.function.clone(),
                    |function| rounded(&function),
                );
                rows.push(vec![
                    format!("{mark}{function}"),
                    digits(candidate.rms_residual),
                    format!("{:.1}", candidate.bic),
                ]);
            }
            table(out, &rows)?;
        }
        let mut rows = vec![
            ["number", "value", "std. error"]
                .map(str::to_owned)
                .to_vec(),
        ];
        for number in &self.numbers {
            let error = number.standard_error.map_or_else(|| "–".to_owned(), digits);
            rows.push(vec![number.name.clone(), digits(number.value), error]);
        }
        table(out, &rows)?;
        for sentence in self.sentences() {
            writeln!(out, "{sentence}")?;
        }
        written(out, self.plant_file.as_slice())?;
        written(out, &self.files)
    }
}
