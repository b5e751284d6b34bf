//! The report on a plant that was found, with its warnings.

use super::keys::{FIRST_ROW, KNOWN_DELAY, MODEL, VALIDATE};
use control_identification::model_search::{
    DeadTimeEvidence, Found, InputOutput, Unexplained, Validation, settles_as_well,
};
use control_identification::{DeadTime, FreeNumber, Identified, StartState};
use fractional_control::{FractionalPolynomial, FractionalTransferFunction, SumOfParts, Term};
use haptic_quantity::{digits, written};
use serde::Serialize;

/// The report. The keys are a contract of the command line.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlantReport {
    /// The function in notation, without its dead time.
    pub function: String,
    /// The dead time that was found or given.
    pub delay_s: f64,
    /// Low end of the 95 % interval of the dead time; null of one that was given.
    pub delay_low_s: Option<f64>,
    /// High end of that 95 % interval; null of one that was given.
    pub delay_high_s: Option<f64>,
    /// True if the record determines the dead time.
    pub delay_determined: Option<bool>,
    /// Output at rest; null of a record that begins at rest.
    pub offset: Option<f64>,
    /// Input that the plant had settled at.
    pub input_before: Option<f64>,
    /// State of the plant at the beginning of the record, in words.
    pub begins: &'static str,
    /// The reading of the table, of a plant that answers at once.
    pub output_read: Option<String>,
    /// Rows of the record that was fitted.
    pub samples: usize,
    /// Mean time from row to row.
    pub sample_time_s: f64,
    /// Root mean square of what the function leaves.
    pub rms_residual: f64,
    /// 1 less the share of the output's variance that it leaves.
    pub fit: f64,
    /// Schwarz's criterion: the lower, the better.
    pub bic: f64,
    /// Order of the noise as an autoregression; 0 of white noise.
    pub noise_order: usize,
    /// Why the function has as many numbers as it has.
    pub order_reason: String,
    /// Poles that grow; null with a pole at s = 0 or on the imaginary axis.
    pub unstable_poles: Option<usize>,
    /// Behaviour of the record, if it does not come to rest.
    pub unstable_poles_reason: Option<&'static str>,
    /// The numbers of the function.
    pub numbers: Vec<NumberRow>,
    /// Functions that fit, the chosen one first.
    pub candidates: Vec<CandidateRow>,
    /// The function on the second record.
    pub validation: Option<ValidationRow>,
    /// Sentences that one should read.
    pub warnings: Vec<String>,
}

/// A number of the function.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NumberRow {
    /// Its place, as `denominator_order_1`, with the part that it is of: `part_2_denominator_order_1`.
    pub name: String,
    /// The number.
    pub value: f64,
    /// Its standard error; infinite where the record says nothing.
    pub standard_error: f64,
    /// Low end of its 95 % interval.
    pub low_95: f64,
    /// High end of its 95 % interval.
    pub high_95: f64,
    /// True if the error is at most half of the value.
    pub determined: bool,
}

/// A function that fits, with the numbers by which candidates are compared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CandidateRow {
    /// The function in notation, without its dead time.
    pub function: String,
    /// Root mean square of what it leaves.
    pub rms_residual: f64,
    /// Schwarz's criterion: the lower, the better.
    pub bic: f64,
}

/// The function on a second record.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ValidationRow {
    /// Rows of the second record.
    pub samples: usize,
    /// Root mean square of what the function leaves of it.
    pub rms_residual: f64,
    /// 1 less the share of its variance that the function leaves.
    pub fit: f64,
}

/// A function beside another record than its own.
#[derive(Clone, Debug)]
pub struct Tried {
    /// The second record, to which the function was not fitted.
    pub record: InputOutput,
    /// Output of the function for the input of that record, and the residual.
    pub validation: Validation,
}

impl PlantReport {
    pub(crate) fn of(
        found: &[Found],
        best: &Found,
        record: &InputOutput,
        evidence: Option<DeadTimeEvidence<'_>>,
        tried: Option<&Tried>,
    ) -> Self {
        let (identified, start) = (&best.identified, start_of(record, &best.identified));
        let interval = evidence.map(|evidence| evidence.interval_s);
        let candidates = found.iter().map(|found| CandidateRow {
            function: shown(&found.identified.parts, DIGITS),
            rms_residual: found.identified.rms_residual,
            bic: found.bic,
        });
        let mut warnings = warnings(found, best, record);
        warnings.extend(evidence.and_then(|evidence| unsure(&evidence, best)));
        warnings.extend(tried.and_then(|tried| worse(tried, best)));
        let grows = identified.fit >= LEAST && settles_as_well(found, record).is_none();
        Self {
            function: shown(&identified.parts, DIGITS),
            delay_s: identified.dead_time.seconds(),
            delay_low_s: interval.map(|[low, _]| low),
            delay_high_s: interval.map(|[_, high]| high),
            delay_determined: evidence.map(|evidence| evidence.is_determined),
            offset: (record.start != StartState::Rest).then_some(identified.offset),
            input_before: (start == StartState::Settled)
                .then_some(input_before(record, identified)),
            begins: begins(start),
            output_read: reading(identified, record),
            samples: record.time_s.len(),
            sample_time_s: record.sample_time_s(),
            rms_residual: identified.rms_residual,
            fit: identified.fit,
            bic: best.bic,
            noise_order: identified.noise.order(),
            order_reason: order_reason(found, best),
            unstable_poles: identified.function.unstable_poles(),
            unstable_poles_reason: grows.then(|| nature(&identified.function)).flatten(),
            numbers: numbers(best),
            candidates: candidates.collect(),
            validation: tried.map(|tried| ValidationRow {
                samples: tried.record.time_s.len(),
                rms_residual: tried.validation.rms_residual,
                fit: tried.validation.fit,
            }),
            warnings,
        }
    }

    /// Report with these sentences before its own warnings.
    pub fn warned(mut self, notes: Vec<String>) -> Self {
        self.warnings.splice(..0, notes);
        self
    }
}

/// A plant of other than whole orders has no finite state, so it counts as settled; as does one whose input is counted from its first value.
fn start_of(record: &InputOutput, found: &Identified) -> StartState {
    match record.start {
        StartState::Offset if record.input_zero != 0.0 => StartState::Settled,
        StartState::Moving if !found.function.is_whole() => StartState::Settled,
        start @ (StartState::Rest
        | StartState::Offset
        | StartState::Settled
        | StartState::Moving) => start,
    }
}

/// Input at which a plant had settled, in the unit of u.
fn input_before(record: &InputOutput, found: &Identified) -> f64 {
    record.input_zero + found.input_before
}

/// State of the plant at the beginning of the record, after its other figures.
pub fn counted_from(record: &InputOutput, found: &Identified) -> String {
    let offset = digits(found.offset, 5);
    match start_of(record, found) {
        StartState::Rest => String::new(),
        StartState::Offset => format!(", output counted from {offset}"),
        StartState::Settled => {
            let before = digits(input_before(record, found), 5);
            format!(", output counted from {offset}, input from {before}")
        }
        StartState::Moving => format!(", output counted from {offset}, of a plant that was moving"),
    }
}

/// Start in words, as a sentence has it.
fn begins(start: StartState) -> &'static str {
    match start {
        StartState::Rest => "at rest",
        StartState::Offset => "at rest, at an offset",
        StartState::Settled => "settled at an input before",
        StartState::Moving => "moving",
    }
}

/// Both readings of a table of a plant that answers at once: nothing else tells an output that was read before its row's input from one that was
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

/// Keys that help a function to fit.
pub fn remedies() -> String {
    format!("give {KNOWN_DELAY}, {FIRST_ROW} or {MODEL}")
}

/// A number whose standard error is above this share of it is not determined.
const LOOSE: f64 = 0.5;
/// A share of the variance that no useful function leaves, and one that only noise may.
const MUCH: f64 = 0.05;
const SOME: f64 = 0.001;
/// Share of the variance; of a function that explains less, nothing more is said.
const LEAST: f64 = 0.5;
/// Neighbouring samples that are so much alike are no white noise.
const ALIKE: f64 = 0.3;
/// Times what a function leaves of its own record, from which on it is said of another one.
const WORSE: f64 = 2.0;
/// Digits of a plant file: more than any record has.
pub const DIGITS: usize = 9;

/// The function with numbers of five digits.
pub fn rounded(found: &Identified) -> String {
    shown(&found.parts, 5)
}

/// The sum of these parts with numbers of so many digits.
pub fn shown(parts: &[FractionalTransferFunction], digits: usize) -> String {
    let parts = parts.iter().map(|part| with_digits(part, digits)).collect();
    SumOfParts::new(parts).map_or_else(|error| error.to_string(), |sum| sum.to_string())
}

/// The function with numbers of so many digits.
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

impl NumberRow {
    /// A number of one of these parts, or the dead time.
    pub(crate) fn of(
        parts: &[FractionalTransferFunction],
        n_part: usize,
        delay_s: f64,
        number: FreeNumber,
        error: f64,
    ) -> Self {
        let function = &parts[n_part];
        let (above, below) = (function.numerator().terms(), function.denominator().terms());
        let (part, terms, n, is_order) = match number {
            FreeNumber::NumeratorCoefficient(n) => ("numerator", above, n, false),
            FreeNumber::NumeratorOrder(n) => ("numerator", above, n, true),
            FreeNumber::DenominatorCoefficient(n) => ("denominator", below, n, false),
            FreeNumber::DenominatorOrder(n) => ("denominator", below, n, true),
            FreeNumber::DeadTime => {
                return Self::with_error("delay_s".to_owned(), delay_s, error);
            }
        };
        let value = |term: &Term| {
            if is_order {
                term.order
            } else {
                term.coefficient
            }
        };
        let value = terms.get(n).map_or(f64::NAN, value);
        // Errors of coefficients are relative.
        let (kind, scale) = if is_order {
            ("order", 1.0)
        } else {
            ("coefficient", value.abs())
        };
        let of_sum = match parts.len() {
            1 => String::new(),
            _ => format!("part_{}_", n_part + 1),
        };
        let name = format!("{of_sum}{part}_{kind}_{}", n + 1);
        Self::with_error(name, value, error * scale)
    }

    fn with_error(name: String, value: f64, standard_error: f64) -> Self {
        Self {
            name,
            value,
            standard_error,
            low_95: value - IN_95 * standard_error,
            high_95: value + IN_95 * standard_error,
            determined: standard_error <= LOOSE * value.abs(),
        }
    }
}

/// Standard errors in half of a 95 % interval.
const IN_95: f64 = 1.96;

fn numbers(best: &Found) -> Vec<NumberRow> {
    let found = &best.identified;
    let late = found.dead_time.seconds();
    let mut begun = 0;
    let errors = found.standard_errors.iter().map(|(number, error)| {
        // With this number a part begins.
        begun += usize::from(*number == FreeNumber::NumeratorCoefficient(0));
        NumberRow::of(&found.parts, begun.max(1) - 1, late, *number, *error)
    });
    errors.collect()
}

/// A residual that is large and not noise, though a small part of the whole record.
fn lacking(at: &Unexplained) -> String {
    let part = if at.share > 1.0 {
        format!("{} times the output", digits(at.share, 4))
    } else {
        format!("{} % of the output", digits(100.0 * at.share, 4))
    };
    format!(
        "from {} to {} the function leaves {part}, not noise: record a shorter time, or give {MODEL}",
        written("from_s", at.from_s),
        written("to_s", at.to_s)
    )
}

/// Warnings about the residual, and about numbers that the record does not determine.
fn warnings(found: &[Found], best: &Found, record: &InputOutput) -> Vec<String> {
    let mut warnings = Vec::new();
    if record.start == StartState::Moving && !best.identified.function.is_whole() {
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
        .filter(|number| !number.determined);
    let loose: Vec<String> = loose.map(|number| number.name).collect();
    if !loose.is_empty() {
        let loose = loose.join(", ");
        warnings.push(format!(
            "the record does not determine {loose}: record for longer, or give {MODEL} with fewer terms"
        ));
    }
    warnings.extend(one_of_two(best, record));
    if let Some(other) = settles_as_well(found, record) {
        warnings.push(format!(
            "{}, which comes to rest, fits nearly as well (BIC {:+.1}): record for longer",
            rounded(&other.identified),
            other.bic - best.bic
        ));
    }
    warnings
}

/// An input that never changes makes one constant of what passes at once and of an offset.
fn one_of_two(best: &Found, record: &InputOutput) -> Option<String> {
    let first = *record.input.first()?;
    let rests = record.input.iter().all(|u| (u - first).abs() == 0.0);
    let is_open = rests && record.start != StartState::Rest;
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
    let [best_rms, other] = [best.identified.rms_residual, tried.validation.rms_residual];
    (other > WORSE * best_rms).then(|| {
        format!(
            "of the record of {VALIDATE} the function leaves {} times as much as of its own (fit {})",
            digits(other / best_rms, 3),
            digits(tried.validation.fit, 4)
        )
    })
}

/// Another function that follows the record, or a second one, better in simulation.
pub fn nearer(best: &Found, (other, [own, least]): (&Found, [f64; 2]), record: &str) -> String {
    let functions = [(best, own), (other, least)].map(|(found, left)| {
        let function = &found.identified.function;
        let gain = function.gain_at_rest();
        let gain = if gain.is_infinite() {
            "none, as it adds up".to_owned()
        } else {
            digits(gain, 4)
        };
        let left = digits(left, 3);
        format!(
            "{} (rms {left}, gain at rest {gain})",
            rounded(&found.identified)
        )
    });
    let [chosen, other] = functions;
    format!(
        "{chosen} is chosen by the next sample; in simulation over {record} {other} is nearer: record for longer with more jumps of the input, or give {MODEL}"
    )
}

/// Another function with another dead time that fits as well, or an interval that is long.
fn unsure(evidence: &DeadTimeEvidence<'_>, best: &Found) -> Option<String> {
    let Some(other) = evidence.instead else {
        let [low, high] = evidence.interval_s.map(|end| written("delay_s", end));
        return (!evidence.is_determined).then(|| {
            format!("the record does not determine the dead time, from {low} to {high}: jump the input more often, or give {KNOWN_DELAY}")
        });
    };
    Some(format!(
        "the record cannot tell its dead time from a pole: {} behind {} fits as well (BIC {:+.1}): sample faster, or give {KNOWN_DELAY}",
        rounded(&other.identified),
        written("delay_s", other.identified.dead_time.seconds()),
        other.bic - best.bic
    ))
}

/// Why the function has as many numbers as it has.
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
    if others.is_empty() {
        format!("nothing else fits, with {count} numbers")
    } else {
        format!("{count} numbers; BIC {}", others.join(", "))
    }
}

/// A large residual between function and record.
fn unexplained(best: &Found) -> Option<String> {
    let (left, neighbours) = (1.0 - best.identified.fit, best.neighbours);
    let what = match (neighbours.abs() < ALIKE, best.identified.noise.order()) {
        // White noise is uncorrelated from sample to sample.
        (true, 0) if left > MUCH => "as noise does".to_owned(),
        (true, order) if left > MUCH => format!(
            "as slow noise does (an autoregression of order {order}, which errors and choice count with)"
        ),
        _ if left > MUCH || (left > SOME && neighbours > ALIKE) => {
            format!(
                "not as noise does (correlation of neighbours {neighbours:.2}): {}",
                remedies()
            )
        }
        _ => return None,
    };
    let share = digits(100.0 * left, 4);
    Some(format!(
        "the function leaves {share} % of the output's variance, {what}"
    ))
}

/// Warnings about a function before it is used.
fn nature(function: &FractionalTransferFunction) -> Option<&'static str> {
    match function.unstable_poles() {
        Some(0) => None,
        Some(_) => Some("the record grows: close the loop with control design"),
        None if function.denominator().lowest() == 0.0 => {
            Some("the record oscillates undamped: close the loop with control design")
        }
        None => Some("the plant integrates: close the loop with control design"),
    }
}
