//! The function that was found.

use fractional_control::model_search::{Found, InputOutput, Unexplained, settles_as_well};
use fractional_control::{FractionalTransferFunction, FreeNumber};
use haptic_quantity::{digits, written};
use serde::Serialize;

/// The result.
#[derive(Serialize)]
pub(super) struct Report {
    function: String,
    delay_s: f64,
    pub(super) samples: usize,
    sample_time_s: f64,
    pub(super) rms_residual: f64,
    fit: f64,
    bic: f64,
    /// Null with a pole at s = 0 or on the imaginary axis.
    unstable_poles: Option<usize>,
    /// What the record does, if it does not come to rest.
    unstable_poles_reason: Option<&'static str>,
    numbers: Vec<Number>,
    candidates: Vec<Candidate>,
    pub(super) plant_file: Option<String>,
    pub(super) files: Vec<String>,
    pub(super) warnings: Vec<String>,
}

#[derive(Serialize)]
struct Number {
    name: String,
    value: f64,
    /// Null where the record says nothing.
    standard_error: Option<f64>,
    /// The error is at most half of the value.
    determined: bool,
}

#[derive(Serialize)]
struct Candidate {
    function: String,
    rms_residual: f64,
    bic: f64,
}

/// A number whose standard error is above this share of it is not determined.
const LOOSE: f64 = 0.5;
/// A share of the variance that no useful function leaves, and one that only noise may.
const MUCH: f64 = 0.05;
const SOME: f64 = 0.001;
/// Of a function that explains less than this nothing more is said.
const LEAST: f64 = 0.5;
/// Neighbouring samples that are so much alike are no white noise.
const ALIKE: f64 = 0.3;
/// Digits of a plant file: more than any record has.
pub(super) const DIGITS: usize = 9;

/// The function with numbers of five digits.
pub(super) fn rounded(function: &FractionalTransferFunction) -> String {
    with_digits(function, 5).to_string()
}

/// The function with numbers of so many digits.
pub(super) fn with_digits(
    function: &FractionalTransferFunction,
    digits: usize,
) -> FractionalTransferFunction {
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

/// Where a function leaves much that is no noise, though little of the whole record.
fn lacking(at: &Unexplained) -> String {
    let part = if at.share > 1.0 {
        format!("{} times the output", digits(at.share, 4))
    } else {
        format!("{} % of the output", digits(100.0 * at.share, 4))
    };
    format!(
        "from {} to {} the function leaves {part}, which is not noise: look at the candidates, record a shorter time, or give --model with \
         other terms",
        written("from_s", at.from_s),
        written("to_s", at.to_s)
    )
}

impl Report {
    pub(super) fn new(found: &[Found], best: &Found, record: &InputOutput, delay_s: f64) -> Self {
        let own = &best.identified;
        let numbers = own.standard_errors.iter().map(|(number, error)| {
            let (name, value, absolute) = named(&own.function, *number);
            let error = error * absolute;
            Number {
                name,
                value,
                standard_error: Some(error).filter(|error| error.is_finite()),
                determined: error <= LOOSE * value.abs(),
            }
        });
        let candidates = found.iter().map(|found| Candidate {
            function: with_digits(&found.identified.function, DIGITS).to_string(),
            rms_residual: found.identified.rms_residual,
            bic: found.bic,
        });
        let mut report = Self {
            function: with_digits(&own.function, DIGITS).to_string(),
            delay_s,
            samples: record.time_s.len(),
            sample_time_s: record.sample_time_s(),
            rms_residual: own.rms_residual,
            fit: own.fit,
            bic: best.bic,
            unstable_poles: own.function.unstable_poles(),
            unstable_poles_reason: None,
            numbers: numbers.collect(),
            candidates: candidates.collect(),
            plant_file: None,
            files: Vec::new(),
            warnings: Vec::new(),
        };
        let unexplained = report.unexplained(best.neighbours);
        report
            .warnings
            .extend(unexplained.or_else(|| best.unexplained.as_ref().map(lacking)));
        report.warnings.extend(report.not_determined());
        if report.fit < LEAST {
            return report;
        }
        report.unstable_poles_reason = nature(&own.function);
        if let Some(other) = settles_as_well(found, record) {
            report.unstable_poles_reason = None;
            report.warnings.push(format!(
                "the record does not tell whether the plant comes to rest: {}, which does, fits nearly as well (BIC {:+.1}): record for longer, \
                 then choose with --model",
                rounded(&other.identified.function),
                other.bic - best.bic
            ));
        }
        report
    }

    /// What is left between function and record, where it is much.
    fn unexplained(&self, neighbours: f64) -> Option<String> {
        let left = 1.0 - self.fit;
        let share = format!("{} %", digits(100.0 * left, 4));
        // What noise leaves has nothing in common from a sample to the next.
        if left > MUCH && neighbours.abs() < ALIKE {
            return Some(format!(
                "the function leaves {share} of the output's variance, uncorrelated from sample to sample: it is noise, or too fast for these samples"
            ));
        }
        let what = if left > MUCH {
            format!("the function leaves {share} of the output's variance unexplained")
        } else if left > SOME && neighbours > ALIKE {
            format!(
                "the function leaves {share} of the output's variance, which is not noise (correlation of neighbouring samples {neighbours:.2})"
            )
        } else {
            return None;
        };
        Some(format!(
            "{what}: look at the picture; give --delay for a dead time, --subtract-start for a record that does not begin at 0, or --model with \
             other terms"
        ))
    }

    /// The numbers that other values would do for as well.
    fn not_determined(&self) -> Option<String> {
        if self.fit < LEAST {
            return None;
        }
        let loose = self.numbers.iter().filter(|number| !number.determined);
        let loose: Vec<&str> = loose.map(|number| number.name.as_str()).collect();
        (!loose.is_empty()).then(|| {
            format!(
                "the record does not determine {}: record for longer, or give --model with fewer terms",
                loose.join(", ")
            )
        })
    }
}

/// What to know of a function before it is used.
fn nature(function: &FractionalTransferFunction) -> Option<&'static str> {
    match function.unstable_poles() {
        Some(0) => None,
        Some(_) => Some("the record grows: close the loop with host-cli control design"),
        None if function.denominator().lowest() == 0.0 => Some(
            "the record oscillates without damping: close the loop with host-cli control design",
        ),
        None => Some(
            "the record does not come to rest, the plant integrates: close the loop with host-cli control design",
        ),
    }
}
