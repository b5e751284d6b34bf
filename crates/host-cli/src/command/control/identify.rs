//! `control identify`: a fractional transfer function from a record of input and output.

use super::draw::draw_identified;
use super::words::refused;
use crate::command::conduct::progress_bar;
use crate::files::{File, PROGRAM, PlaceOfFile};
use crate::output::{Output, note, warn};
use crate::parse::{of, whole};
use crate::picture::short_name;
use crate::table;
use clap::Args;
use fracdiff::Seconds;
use fractional_control::model_search::{
    DeadTimeEvidence, Found, InputOutput, Unexplained, Validation, Wanted, candidates,
    candidates_of, dead_time_evidence, find_start, identify, settles_as_well, validate,
};
use fractional_control::{
    ControlError, DeadTime, FractionalPolynomial, FractionalTransferFunction, FreeNumber,
    Identified, Plant, Start, Term,
};
use haptic_experiment::document::short;
use haptic_experiment::document::{check_signals, fill_gaps, one_row_a_time};
use haptic_experiment::run::PlantModel;
use haptic_experiment::{Failure, parameters};
use haptic_quantity::{digits, written};
use haptic_tissue::identify::table::rows_named;
use indicatif::ProgressBar;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Fit a fractional transfer function to a record
///
/// Fits coefficients, orders and dead time together, to a CSV record at any times, and where the plant was when it
/// began: at rest, settled at another input, or moving. Writes a plant file for the other commands of control.
///
/// Without --model it tries integer orders with up to four poles, and one or two powers of s with
/// free orders, and takes the simplest function whose BIC is close to the lowest. Warnings say what
/// the function does not explain, which numbers the record does not determine, and whether dead
/// time and a pole can be told apart.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli control identify record.csv --columns \
                  input=valve,output=temperature --out plant.toml"
)]
pub(crate) struct Arguments {
    /// CSV with a header
    #[arg(value_name = "DATA")]
    data: PathBuf,
    /// Columns, as in `input=valve,output=temperature` [default: `time_s`, `input`, `output`]
    #[arg(long, value_name = "SIGNAL=COLUMN", value_delimiter = ',', value_parser = signal)]
    #[arg(help_heading = "Table")]
    columns: Vec<(usize, String)>,
    /// Time from row to row of a table without times
    #[arg(long, value_name = "TIME", value_parser = of(parameters::SAMPLE_TIME), help_heading = "Table")]
    sample_time: Option<f64>,
    /// Subtract the first row: the record begins at rest, but not at 0
    #[arg(long, help_heading = "Table")]
    subtract_start: bool,
    /// The input is smooth between samples, not held
    #[arg(long, help_heading = "Table")]
    smooth: bool,
    /// Terms and first values as in '2exp(-5s)/(30s^0.9+1)' [default: found from the record]
    #[arg(long, value_name = "FUNCTION", allow_hyphen_values = true)]
    model: Option<String>,
    /// Integer orders with this number of poles, 1 to 4 [default: found from the record]
    #[arg(long, value_name = "N", conflicts_with = "model", value_parser = whole(1_u8..=4))]
    poles: Option<u8>,
    /// Only functions that come to rest by themselves
    #[arg(long)]
    stable: bool,
    /// A second record with the same columns, on which the function is tried
    #[arg(long, value_name = "RECORD")]
    validate: Option<PathBuf>,
    /// Known dead time [default: found from the record]
    #[arg(long, value_name = "TIME", value_parser = of(parameters::DEAD_TIME))]
    delay: Option<f64>,
    #[command(flatten)]
    file: File,
}

/// Number of samples above which the time is announced.
const LONG: usize = 200_000;
/// Approximate time for a sample on one core of 2024, s.
const A_SAMPLE_S: f64 = 6e-5;

/// Advice for a poor fit.
const TRY: &str = "give --delay, --subtract-start or --model";

/// Signals, and the columns that they are in.
const SIGNALS: [(&str, &str); 3] = [("time", "time_s"), ("input", "input"), ("output", "output")];

/// Index of a signal in [`SIGNALS`], and its column.
fn signal(text: &str) -> Result<(usize, String), String> {
    let split = text.split_once('=').and_then(|(name, column)| {
        let index = SIGNALS.iter().position(|signal| signal.0 == name.trim())?;
        Some((index, column.trim().to_owned()))
    });
    split.ok_or_else(|| "is not time=COLUMN, input=COLUMN or output=COLUMN".to_owned())
}

/// Works with a progress bar of `steps` steps.
fn shown<T>(
    what: &'static str,
    steps: usize,
    output: Output,
    work: impl FnOnce(&ProgressBar) -> T,
) -> T {
    let bar = progress_bar(steps as u64, output);
    bar.set_message(what);
    let done = work(&bar);
    bar.finish_and_clear();
    done
}

/// The function and the dead time to begin from.
fn guess(text: &str) -> Result<(FractionalTransferFunction, Option<Seconds>), Failure> {
    let refused = |error: &dyn std::fmt::Display| {
        Failure::bad_input(format_args!("model \"{text}\": {error}; change --model"))
    };
    let plant: Plant = text.parse().map_err(|error| refused(&error))?;
    let guess = plant
        .function()
        .filter(|guess| guess.denominator().degree() > 0.0);
    let Some(guess) = guess else {
        return Err(refused(
            &"its denominator has no power of s: give one, as in 2/(30s^0.9+1)",
        ));
    };
    let late = plant.delay_s();
    Ok((*guess, (late > 0.0).then_some(Seconds(late))))
}

/// A function beside the record that it is tried on.
struct Tried {
    record: InputOutput,
    beside: Validation,
}

impl Arguments {
    pub(crate) fn run(self, output: Output) -> Result<(), Failure> {
        let mut outputs = PlaceOfFile::look(&self.file, "plant")?;
        let (mut record, notes) = self.read(&self.data)?;
        let other = self.validate.as_deref().map(|path| self.read(path));
        let other = other.transpose()?;
        if record.time_s.len() > LONG && !output.quiet {
            let words = format!(
                "{} samples take about {}; every tenth may be enough for a slow plant",
                record.time_s.len(),
                written("time_s", A_SAMPLE_S * record.time_s.len() as f64)
            );
            note("note", words);
        }
        let known = self.delay.map(Seconds);
        let found = self.search(&mut record, known, output)?;
        let [best, ..] = &found[..] else {
            return Err(Failure::run(format_args!(
                "no function was found: give --model with other terms"
            )));
        };
        // A calmer function may stand first; the closest one represents the record.
        let closest = found.iter().min_by(|a, b| a.bic.total_cmp(&b.bic));
        if !closest.unwrap_or(best).shows_a_response(&record) {
            return Err(Failure::run(format_args!(
                "the record shows no response to its input: {} explains {} % of the output's variance, and as much as chance would; move the input more, or check --columns",
                rounded(&best.identified.function),
                digits(100.0 * best.identified.fit, 2)
            )));
        }
        let evidence = match known {
            None => shown("dead time", 1, output, |_| {
                dead_time_evidence(&found, &record, !self.smooth)
            }),
            Some(_) => None,
        };
        let tried = other.and_then(|(record_of_other, _)| {
            let beside = validate(best, record.start, &record_of_other, !self.smooth)?;
            Some(Tried {
                record: record_of_other,
                beside,
            })
        });
        let mut warnings = notes;
        warnings.extend(self::warnings(&found, best, &record));
        warnings.extend(evidence.and_then(|evidence| unsure(&evidence, best)));
        warnings.extend(tried.as_ref().and_then(|tried| worse(tried, best)));
        let (plant_file, figure) = self.write(best, &record, tried.as_ref(), &mut outputs);
        for warning in &warnings {
            warn(warning);
        }
        let mut report = report(&found, best, &record, evidence);
        if let Value::Object(rows) = &mut report {
            let validated = tried.as_ref().map(|tried| {
                json!({
                    "samples": tried.record.time_s.len(),
                    "rms_residual": tried.beside.rms_residual,
                    "fit": tried.beside.fit,
                })
            });
            rows.insert("validation".to_owned(), json!(validated));
            rows.insert("plant_file".to_owned(), json!(plant_file));
            rows.insert("files".to_owned(), json!(figure.as_slice()));
            rows.insert("warnings".to_owned(), json!(warnings));
        }
        output.summary(&report)?;
        outputs.close(Ok(()))
    }

    /// The functions that fit, the one to take first.
    fn search(
        &self,
        record: &mut InputOutput,
        known: Option<Seconds>,
        output: Output,
    ) -> Result<Vec<Found>, Failure> {
        let held = !self.smooth;
        let wanted = Wanted {
            poles: self.poles.map(usize::from),
            is_stable: self.stable,
        };
        let model = self.model.as_deref().map(guess).transpose()?;
        let guesses = shown("first guesses", 1, output, |_| {
            find_start(record, held, known);
            match model {
                Some((model, late)) => candidates_of(model, record, held, known, late),
                None => candidates(record, held, known, wanted),
            }
        });
        let found = shown("functions", guesses.len(), output, |bar| {
            identify(record, &guesses, held, wanted, &|done| bar.inc(done as u64))
        });
        found.map_err(|error| {
            let is_found = !matches!(error, ControlError::NotFound { .. });
            let is_asked = self.poles.is_some() || self.stable;
            // With a model that was given the error names it.
            if is_found || (self.model.is_some() && !is_asked) {
                return refused(error);
            }
            Failure::run(match is_asked {
                true => format!("no function that was asked for fits the record: leave --poles or --stable out, or {TRY}"),
                false => format!("no function fits the record: {TRY}"),
            })
        })
    }

    fn columns(&self) -> Result<[&str; 3], Failure> {
        let mut names = SIGNALS.map(|(_, column)| column);
        for (index, name) in &self.columns {
            names[*index] = name;
        }
        let twice = (1..names.len()).find(|&index| names[..index].contains(&names[index]));
        match twice {
            None => Ok(names),
            Some(index) => Err(Failure::bad_input(format_args!(
                "column {} is used for two signals: give each its own with --columns",
                short(names[index])
            ))),
        }
    }

    /// The record of a file, and notices about its rows.
    fn read(&self, path: &Path) -> Result<(InputOutput, Vec<String>), Failure> {
        let [time, input, output] = self.columns()?;
        let wrong = |error: String| table::wrong(path, format_args!("{error}; see --columns"));
        let remedy = "see --columns; a table without times takes --sample-time";
        let found = table::record(path, [time, input, output], remedy)?;
        let gaps = found.gaps().map(|rows| {
            format!("{rows} without an output: it is put on a straight line between its neighbours")
        });
        let mut notes: Vec<String> = gaps.into_iter().collect();
        let (mut lines, [mut time_s, input_values, output_values]) = (found.lines, found.columns);
        match (self.sample_time, time_s.is_empty()) {
            (None, false) => {}
            (None, true) => {
                return Err(table::wrong(
                    path,
                    format_args!("no column {time}; {remedy}"),
                ));
            }
            (Some(_), false) => {
                let what = "it has a column of time: leave --sample-time out, or that column";
                return Err(table::wrong(path, what));
            }
            (Some(step), true) => time_s = (0..lines.len()).map(|n| step * n as f64).collect(),
        }
        let mut record = InputOutput {
            time_s,
            input: input_values,
            output: output_values,
            ..InputOutput::default()
        };
        let repeated = one_row_a_time(&mut record, &mut lines)
            .map_err(|error| wrong(format!("{error}; the time is column {}", short(time))))?;
        let repeated = rows_named(&repeated);
        notes.extend(repeated.map(|rows| {
            format!("{rows} at the time of the row before: of one time the first output counts and the last input, which acts from then on")
        }));
        fill_gaps(&mut record, &lines, [input, output]).map_err(wrong)?;
        if self.subtract_start {
            record.subtract_start();
        }
        check_signals(&record, &lines, [input, output]).map_err(wrong)?;
        Ok((record, notes))
    }

    /// Writes the plant file and its picture; their names.
    fn write(
        &self,
        best: &Found,
        record: &InputOutput,
        tried: Option<&Tried>,
        outputs: &mut PlaceOfFile,
    ) -> (Option<String>, Option<String>) {
        let name = self.data.file_name().unwrap_or(self.data.as_os_str());
        let name = name.to_string_lossy();
        let (identified, samples) = (&best.identified, record.time_s.len());
        let model = PlantModel::Function {
            function: Box::new(with_digits(&identified.function, DIGITS)),
            delay_s: identified.dead_time.seconds(),
        };
        let rms = digits(identified.rms_residual, 4);
        let begins = counted_from(record, identified);
        let note = format!("identified from {name}, {samples} samples, rms {rms}{begins}");
        let picture = || {
            let source = format!("{} · {samples} samples", short_name(&name));
            draw_identified(
                record,
                &identified.model,
                tried.map(|tried| (&tried.record, &tried.beside.model[..])),
                &rounded(&identified.function),
                &source,
            )
        };
        let text = || model.to_toml(PROGRAM, &note).unwrap_or_default();
        outputs.write(text, picture)
    }
}

/// The report, but for files and warnings.
fn report(
    found: &[Found],
    best: &Found,
    record: &InputOutput,
    evidence: Option<DeadTimeEvidence<'_>>,
) -> Value {
    let (identified, start) = (&best.identified, start_of(record, &best.identified));
    let interval = evidence.map(|evidence| evidence.interval_s);
    let candidates = found.iter().map(|found| {
        json!({
            "function": with_digits(&found.identified.function, DIGITS).to_string(),
            "rms_residual": found.identified.rms_residual,
            "bic": found.bic,
        })
    });
    json!({
        "function": with_digits(&identified.function, DIGITS).to_string(),
        "delay_s": identified.dead_time.seconds(),
        // Null of a dead time that was given.
        "delay_low_s": interval.map(|[low, _]| low),
        "delay_high_s": interval.map(|[_, high]| high),
        "delay_determined": evidence.map(|evidence| evidence.is_determined),
        // Null of a record that begins at rest.
        "offset": (record.start != Start::Rest).then_some(identified.offset),
        "input_before": (start == Start::Settled).then_some(identified.input_before),
        "begins": begins(start),
        "output_read": reading(identified, record),
        "samples": record.time_s.len(),
        "sample_time_s": record.sample_time_s(),
        "rms_residual": identified.rms_residual,
        "fit": identified.fit,
        "bic": best.bic,
        "noise_order": identified.noise.order(),
        "order_reason": order_reason(found, best),
        // Null with a pole at s = 0 or on the imaginary axis.
        "unstable_poles": identified.function.unstable_poles(),
        // Behaviour of the record, if it does not come to rest.
        "unstable_poles_reason": (identified.fit >= LEAST && settles_as_well(found, record).is_none())
            .then(|| nature(&identified.function)).flatten(),
        "numbers": numbers(best).iter().map(Number::value).collect::<Vec<_>>(),
        "candidates": candidates.collect::<Vec<_>>(),
    })
}

/// A plant of other than whole orders has no finite state, so it counts as settled.
fn start_of(record: &InputOutput, found: &Identified) -> Start {
    match record.start {
        Start::Moving if !is_whole(&found.function) => Start::Settled,
        start @ (Start::Rest | Start::Offset | Start::Settled | Start::Moving) => start,
    }
}

fn is_whole(function: &FractionalTransferFunction) -> bool {
    let sides = [function.numerator(), function.denominator()];
    let mut terms = sides.iter().flat_map(|side| side.terms());
    terms.all(|term| term.order.fract() == 0.0)
}

/// Initial state of the plant, to follow its other figures.
fn counted_from(record: &InputOutput, found: &Identified) -> String {
    let offset = digits(found.offset, 5);
    match start_of(record, found) {
        Start::Rest => String::new(),
        Start::Offset => format!(", output counted from {offset}"),
        Start::Settled => {
            let before = digits(found.input_before, 5);
            format!(", output counted from {offset}, input from {before}")
        }
        Start::Moving => format!(", output counted from {offset}, of a plant that was moving"),
    }
}

/// The start in words.
fn begins(start: Start) -> &'static str {
    match start {
        Start::Rest => "at rest",
        Start::Offset => "at rest, at an offset",
        Start::Settled => "settled at an input before",
        Start::Moving => "moving",
    }
}

/// Both readings of a table of a plant that answers at once: nothing else separates an output that was read before its row's input from one that was
/// read with an input of the row before.
fn reading(found: &Identified, record: &InputOutput) -> Option<String> {
    let function = &found.function;
    let at_once = function.numerator().degree() >= function.denominator().degree();
    let more = written("delay_s", record.sample_time_s());
    at_once.then(|| match found.dead_time {
        DeadTime::JustAfter(_) => format!(
            "before the new input of its row; read with it, another function behind {more} more fits the same"
        ),
        DeadTime::Known(_) | DeadTime::From(_) => "with the new input of its row".to_owned(),
    })
}

/// A number whose standard error is above this share of it is not determined.
const LOOSE: f64 = 0.5;
/// A share of the variance that no useful function leaves, and one that only noise may.
const MUCH: f64 = 0.05;
const SOME: f64 = 0.001;
/// Fit below which nothing more is reported about a function.
const LEAST: f64 = 0.5;
/// Neighbouring samples that are so much alike are no white noise.
const ALIKE: f64 = 0.3;
/// Ratio to the residual on its own record from which on that on another record is reported.
const WORSE: f64 = 2.0;
/// Digits of a plant file: more than any record has.
const DIGITS: usize = 9;

/// The function with numbers of five digits.
fn rounded(function: &FractionalTransferFunction) -> String {
    with_digits(function, 5).to_string()
}

/// The function with numbers of this many digits.
fn with_digits(function: &FractionalTransferFunction, digits: usize) -> FractionalTransferFunction {
    let few = |value: f64| format!("{value:.*e}", digits - 1).parse().unwrap_or(value);
    let terms = |polynomial: &FractionalPolynomial| {
        let terms = polynomial.terms().iter();
        terms
            .map(|term| Term::new(few(term.coefficient), few(term.order)))
            .collect::<Vec<_>>()
    };
    let (above, below) = (terms(function.numerator()), terms(function.denominator()));
    FractionalTransferFunction::new(&above, &below).unwrap_or(*function)
}

/// A number of the function that was found.
struct Number {
    name: String,
    value: f64,
    standard_error: f64,
}

impl Number {
    fn of(found: &Identified, number: FreeNumber, error: f64) -> Self {
        let function = &found.function;
        let (above, below) = (function.numerator().terms(), function.denominator().terms());
        let (part, terms, n, is_order) = match number {
            FreeNumber::NumeratorCoefficient(n) => ("numerator", above, n, false),
            FreeNumber::NumeratorOrder(n) => ("numerator", above, n, true),
            FreeNumber::DenominatorCoefficient(n) => ("denominator", below, n, false),
            FreeNumber::DenominatorOrder(n) => ("denominator", below, n, true),
            FreeNumber::DeadTime => {
                return Self {
                    name: "delay_s".to_owned(),
                    value: found.dead_time.seconds(),
                    standard_error: error,
                };
            }
        };
        let of = |term: &Term| {
            if is_order {
                term.order
            } else {
                term.coefficient
            }
        };
        let value = terms.get(n).map_or(f64::NAN, of);
        // Errors of coefficients are relative.
        let (kind, scale) = if is_order {
            ("order", 1.0)
        } else {
            ("coefficient", value.abs())
        };
        Self {
            name: format!("{part}_{kind}_{}", n + 1),
            value,
            standard_error: error * scale,
        }
    }

    /// The error is at most half of the value.
    fn is_determined(&self) -> bool {
        self.standard_error <= LOOSE * self.value.abs()
    }

    fn value(&self) -> Value {
        json!({
            "name": self.name,
            "value": self.value,
            // Null where the record says nothing.
            "standard_error": self.standard_error,
            "determined": self.is_determined(),
        })
    }
}

fn numbers(best: &Found) -> Vec<Number> {
    let found = &best.identified;
    let errors = found.standard_errors.iter();
    errors
        .map(|(number, error)| Number::of(found, *number, *error))
        .collect()
}

/// Warning about a stretch with a large residual that is not noise, though a small part of the whole record.
fn lacking(at: &Unexplained) -> String {
    let part = if at.share > 1.0 {
        format!("{} times the output", digits(at.share, 4))
    } else {
        format!("{} % of the output", digits(100.0 * at.share, 4))
    };
    format!(
        "from {} to {} the function leaves {part}, not noise: record a shorter time, or give --model",
        written("from_s", at.from_s),
        written("to_s", at.to_s)
    )
}

/// Warnings about unexplained parts of the record and undetermined numbers.
fn warnings(found: &[Found], best: &Found, record: &InputOutput) -> Vec<String> {
    let mut warnings = Vec::new();
    if record.start == Start::Moving && !is_whole(&best.identified.function) {
        let what = "the plant was moving when the record began, and one of these orders has no finite state: only an offset and an input before are fitted";
        warnings.push(what.to_owned());
    }
    let unexplained = unexplained(best);
    warnings.extend(unexplained.or_else(|| best.unexplained.as_ref().map(lacking)));
    if best.identified.fit < LEAST {
        return warnings;
    }
    let loose = numbers(best)
        .into_iter()
        .filter(|number| !number.is_determined());
    let loose: Vec<String> = loose.map(|number| number.name).collect();
    if !loose.is_empty() {
        let loose = loose.join(", ");
        let remedy = "record for longer, or give --model with fewer terms";
        warnings.push(format!("the record does not determine {loose}: {remedy}"));
    }
    warnings.extend(one_of_two(best, record));
    if let Some(other) = settles_as_well(found, record) {
        warnings.push(format!(
            "{}, which comes to rest, fits nearly as well (BIC {:+.1}): record for longer",
            rounded(&other.identified.function),
            other.bic - best.bic
        ));
    }
    warnings
}

/// An input that never changes makes one constant of what passes at once and of an offset.
fn one_of_two(best: &Found, record: &InputOutput) -> Option<String> {
    let first = *record.input.first()?;
    let rests = record.input.iter().all(|u| (u - first).abs() == 0.0);
    let is_open = rests && record.start != Start::Rest;
    is_open.then(|| {
        let offset = best.identified.offset;
        format!(
            "the input never changes: an offset of {} and a direct path of {} explain the record alike; begin before the input moves",
            digits(offset, 4),
            digits(offset / first, 4)
        )
    })
}

/// A second record that the function leaves much more of than of its own.
fn worse(tried: &Tried, best: &Found) -> Option<String> {
    let [own, other] = [best.identified.rms_residual, tried.beside.rms_residual];
    (other > WORSE * own).then(|| {
        format!(
            "of the record of --validate the function leaves {} times as much as of its own (fit {})",
            digits(other / own, 3),
            digits(tried.beside.fit, 4)
        )
    })
}

/// Another function with another dead time that fits as well, or an interval that is long.
fn unsure(evidence: &DeadTimeEvidence<'_>, best: &Found) -> Option<String> {
    let Some(other) = evidence.instead else {
        let [low, high] = evidence.interval_s.map(|end| written("delay_s", end));
        return (!evidence.is_determined).then(|| {
            format!("the record does not determine the dead time, from {low} to {high}: jump the input more often, or give --delay")
        });
    };
    Some(format!(
        "the record cannot tell its dead time from a pole: {} behind {} fits as well (BIC {:+.1}): sample faster, or give --delay",
        rounded(&other.identified.function),
        written("delay_s", other.identified.dead_time.seconds()),
        other.bic - best.bic
    ))
}

/// Reason for the number of parameters.
fn order_reason(found: &[Found], best: &Found) -> String {
    let numbers = |found: &Found| found.identified.standard_errors.len();
    let count = numbers(best);
    let nearest = |is_other: &dyn Fn(usize) -> bool| {
        let others = found.iter().filter(|found| is_other(numbers(found)));
        let nearest = others.min_by(|a, b| a.bic.total_cmp(&b.bic));
        nearest.map(|other| format!("{:+.1} with {}", other.bic - best.bic, numbers(other)))
    };
    let others = [nearest(&|n| n < count), nearest(&|n| n > count)];
    let others: Vec<String> = others.into_iter().flatten().collect();
    match others.is_empty() {
        true => format!("nothing else fits, with {count} numbers"),
        false => format!("{count} numbers; BIC {}", others.join(", ")),
    }
}

/// Warning about a large residual.
fn unexplained(best: &Found) -> Option<String> {
    let (left, neighbours) = (1.0 - best.identified.fit, best.neighbours);
    let what = match (neighbours.abs() < ALIKE, best.identified.noise.order()) {
        // White noise is not correlated from sample to sample.
        (true, 0) if left > MUCH => "as noise does".to_owned(),
        (true, order) if left > MUCH => format!(
            "as slow noise does (an autoregression of order {order}, which errors and choice count with)"
        ),
        _ if left > MUCH || (left > SOME && neighbours > ALIKE) => {
            format!("not as noise does (correlation of neighbours {neighbours:.2}): {TRY}")
        }
        _ => return None,
    };
    let share = digits(100.0 * left, 4);
    Some(format!(
        "the function leaves {share} % of the output's variance, {what}"
    ))
}

/// Warning about the nature of a function.
fn nature(function: &FractionalTransferFunction) -> Option<&'static str> {
    match function.unstable_poles() {
        Some(0) => None,
        Some(_) => Some("the record grows: close the loop with host-cli control design"),
        None if function.denominator().lowest() == 0.0 => {
            Some("the record oscillates undamped: close the loop with host-cli control design")
        }
        None => Some("the plant integrates: close the loop with host-cli control design"),
    }
}
