//! A fractional transfer function from a record of input and output.

mod fit;
mod numbers;
mod record;
mod spectrum;
mod whole;

use self::fit::{Fit, Ran};
use self::numbers::Numbers;
pub(crate) use self::record::UNFIT;
use crate::autoregression::Autoregression;
use crate::largest;
use core::slice::from_ref;
use fracdiff::Seconds;
use fracdiff::parameter::{positive, range};
use fractional_control::{
    ControlError, FractionalTransferFunction, PowerMemory, Rule, SumOfParts, Term,
};
use levenberg_marquardt::LevenbergMarquardt;
use nalgebra::DMatrix;
pub use record::{DeadTime, FreeNumber, InputOutputRecord, StartState};
pub(crate) use record::{Free, answers_at_once, free_numbers};
pub use spectrum::{
    IdentifiedResponse, KramersKronig, identify_response, kramers_kronig, search_response,
};
pub use whole::{WholeGuess, WholeShape, whole_guess};
pub(crate) use whole::{next_guess, projected, solved};

/// A function that was found, and how well it fits.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Identified {
    /// The function that fits best, with the terms of the guess.
    pub function: FractionalTransferFunction,
    /// Its parts, of a sum; the function alone of any other.
    pub parts: Vec<FractionalTransferFunction>,
    /// The dead time before it; free if it is one of the numbers that were fitted.
    pub dead_time: DeadTime,
    /// Root mean square of the residual, in the unit of y.
    pub rms_residual: f64,
    /// 1 less the residual's share of the variance of y.
    pub fit: f64,
    /// Its output for the input of the record, run exactly where its orders are whole.
    pub model: Vec<f64>,
    /// c of a [`StartState`] that is not known, in the unit of y.
    pub offset: f64,
    /// `u_p`, the earlier input of a plant that had settled, in the unit of u.
    pub input_before: f64,
    /// Number of fitted values that describe the initial state of the plant.
    pub start_numbers: usize,
    /// The noise expected in the residual.
    pub noise: Autoregression,
    /// Standard errors of the free numbers, in the order of [`FreeNumber`]s, those of one part after those of another, as accurate as that noise
    /// model.
    pub standard_errors: Vec<(FreeNumber, f64)>,
    /// Covariance of these errors, in the order in which they stand.
    pub(crate) covariance: DMatrix<f64>,
}

/// Fits the coefficients and orders of a function to a record by least squares, from a first guess.
///
/// The guess sets the terms and the signs of their coefficients. The last coefficient of the denominator stays fixed, or function and gain
/// could not be separated; orders that are 0 stay 0. A free dead time is fitted with them, exactly between samples too, and may fall to 0.
/// Output error: the model is run over the whole record, with its full history.
///
/// - *Cost*: some ten to a hundred runs over the record. *Accuracy*: of second order in T, so sample at a twentieth of the fastest time constant.
/// ```
/// use fracdiff::Seconds;
/// use control_identification::autoregression::Autoregression;
/// use fractional_control::{FractionalTransferFunction, PowerMemory, Rule, step_response};
/// use control_identification::{DeadTime, InputOutputRecord, StartState, identify};
///
/// let truth: FractionalTransferFunction = "2/(0.8s^1.3+1)".parse()?;
/// let t = Seconds(0.05);
/// let y = step_response(&truth, PowerMemory::new(Rule::Bdf2, 1e-8, 10.0)?, t, 200)?;
/// let record = InputOutputRecord { sample_time: t, time_s: &[], input: &[1.0; 200], output: &y, held: true, dead_time: DeadTime::NONE, start: StartState::Rest, noise: Autoregression::WHITE };
/// let found = identify(&"1/(s+1)".parse()?, &record)?;
/// assert!((found.function.denominator().degree() - 1.3).abs() < 1e-4);
/// # Ok::<(), fractional_control::ControlError>(())
/// ```
///
/// # Errors
/// Records of different lengths, shorter than the free numbers, not finite, or without any output; a search that fails.
pub fn identify(
    guess: &FractionalTransferFunction,
    record: &InputOutputRecord<'_>,
) -> Result<Identified, ControlError> {
    identify_by(from_ref(guess), record, Free::All)
}

/// Fits with fixed orders: only the coefficients are free, and may change their signs.
///
/// A function of whole orders, more of them below than above, runs exactly, so poles that are fast for the samples, swing long or grow are no
/// trouble. [`whole_guess`] finds a first guess.
///
/// # Errors
/// As [`identify`].
pub fn identify_coefficients(
    guess: &FractionalTransferFunction,
    record: &InputOutputRecord<'_>,
) -> Result<Identified, ControlError> {
    identify_by(from_ref(guess), record, Free::Coefficients)
}

/// A fit of any freedom. Where the poles stay the errors are those that all coefficients have together, for the poles are as unknown as they were.
pub(crate) fn identify_by(
    guess: &[FractionalTransferFunction],
    record: &InputOutputRecord<'_>,
    freedom: Free,
) -> Result<Identified, ControlError> {
    let found = searched(guess, record, freedom)?;
    if freedom != Free::Above {
        return Ok(found.identified());
    }
    let freedom = Free::Coefficients;
    let dead_time = match found.record.dead_time {
        DeadTime::From(_) => DeadTime::From(Seconds(found.late * record.sample_time.0)),
        known @ (DeadTime::Known(_) | DeadTime::JustAfter(_)) => known,
    };
    let record = InputOutputRecord {
        dead_time,
        ..found.record
    };
    let numbers = Numbers::new(&found.parts, freedom, dead_time);
    check(&record, numbers.free.len())?;
    let problem = Fit::new(numbers, memory_of(&record)?, record, 1);
    Ok(Searched { problem, ..found }.identified())
}

/// The root mean square alone, filtered, that either of them leaves, without standard errors, which are a search's dearest step.
pub(crate) fn least_residual(
    guess: &FractionalTransferFunction,
    record: &InputOutputRecord<'_>,
    freedom: Free,
) -> Result<f64, ControlError> {
    let searched = searched(from_ref(guess), record, freedom)?;
    Ok(libm::sqrt(searched.white / record.output.len() as f64))
}

/// A search ends where a step makes the sum of squares less by no more than this share, over the number of samples: a tenth of a standard
/// error, of white noise. What is exact falls to what rounding leaves before that.
const SMALL_STEP: f64 = 0.01;
/// That share at most, and that of the numbers.
const CONVERGED: [f64; 2] = [1e-5, 1e-7];

/// Steps of a rule in a sample at most, and in a record at most.
const STEPS: usize = 16;
const ALL_STEPS: usize = 50_000;

/// The better of two fits: a record of a plant is followed by many steps of a rule in a sample, one that a rule made itself by one.
fn searched<'a>(
    guess: &[FractionalTransferFunction],
    record: &InputOutputRecord<'a>,
    freedom: Free,
) -> Result<Searched<'a>, ControlError> {
    let numbers = Numbers::new(guess, freedom, record.dead_time);
    check(record, numbers.free.len())?;
    let once = searched_by(numbers.clone(), record, 1);
    let steps = (ALL_STEPS / record.input.len()).min(STEPS);
    let found = if numbers.runs_exactly(guess) || steps < 2 {
        once
    } else {
        let begin = once.as_ref().map_or(guess, |once| &once.parts);
        let often = Numbers::new(begin, freedom, record.dead_time);
        let often = searched_by(often, record, steps);
        match (once, often) {
            (Ok(once), Ok(often)) if once.white <= often.white => Ok(once),
            (once, Err(_)) => once,
            (_, often) => often,
        }
    }?;
    if record.dead_time.is_free() && found.late == 0.0 {
        let prompt = InputOutputRecord {
            dead_time: DeadTime::NONE,
            ..*record
        };
        return searched(&found.parts, &prompt, freedom);
    }
    Ok(found)
}

struct Searched<'a> {
    problem: Fit<'a>,
    record: InputOutputRecord<'a>,
    parts: Vec<FractionalTransferFunction>,
    function: FractionalTransferFunction,
    late: f64,
    /// Σ of the squares that are left, and of those of y less its mean.
    left: f64,
    variance: f64,
    /// That of what the filter leaves.
    white: f64,
    run: Ran,
}

impl Searched<'_> {
    fn rms_residual(&self) -> f64 {
        libm::sqrt(self.left / self.record.output.len() as f64)
    }

    fn identified(self) -> Identified {
        let (free, covariance) = self.problem.covariance(self.white);
        let diagonal = covariance.diagonal();
        let errors = free.into_iter().zip(diagonal.iter());
        Identified {
            rms_residual: self.rms_residual(),
            fit: 1.0 - self.left / self.variance,
            standard_errors: errors
                .map(|(number, square)| (number, libm::sqrt(*square)))
                .collect(),
            covariance,
            noise: self.record.noise,
            dead_time: match self.record.dead_time {
                DeadTime::From(_) => DeadTime::From(Seconds(self.late * self.record.sample_time.0)),
                known @ (DeadTime::Known(_) | DeadTime::JustAfter(_)) => known,
            },
            function: of_positive_sign(self.function),
            parts: self.parts.into_iter().map(of_positive_sign).collect(),
            model: self.run.output,
            offset: self.run.offset,
            input_before: self.run.input_before,
            start_numbers: self.run.numbers,
        }
    }
}

/// The function with a denominator that is not negative in all coefficients.
fn of_positive_sign(function: FractionalTransferFunction) -> FractionalTransferFunction {
    let (above, below) = (function.numerator().terms(), function.denominator().terms());
    if below.iter().any(|term| term.coefficient > 0.0) {
        return function;
    }
    let turned = |terms: &[Term]| -> Vec<Term> {
        let turned = terms.iter();
        turned
            .map(|term| Term::new(-term.coefficient, term.order))
            .collect()
    };
    FractionalTransferFunction::new(&turned(above), &turned(below)).unwrap_or(function)
}

fn searched_by<'a>(
    numbers: Numbers,
    record: &InputOutputRecord<'a>,
    steps: usize,
) -> Result<Searched<'a>, ControlError> {
    let problem = Fit::new(numbers, memory_of(record)?, *record, steps);
    let (problem, report) = LevenbergMarquardt::new()
        .with_ftol((SMALL_STEP / record.input.len() as f64).min(CONVERGED[0]))
        .with_xtol(CONVERGED[1])
        .with_patience(30)
        .minimize(problem);
    if report.termination.was_usage_issue() {
        return Err(UNFIT);
    }
    let (parts, late) = problem.found().map_err(|_| UNFIT)?;
    let function = SumOfParts::new(parts.clone())?.function();
    let run = problem.run_of_found(&parts, late)?;
    let output = record.output;
    let mean = output.iter().sum::<f64>() / output.len() as f64;
    let variance: f64 = output.iter().map(|y| (y - mean) * (y - mean)).sum();
    let pairs = output.iter().zip(&run.output);
    let left: Vec<f64> = pairs.map(|(y, modelled)| y - modelled).collect();
    let power = |signal: &[f64]| signal.iter().map(|x| x * x).sum::<f64>();
    let [left, white] = [&left, &record.noise.whitened(&left)].map(|left| power(left));
    if left.is_nan() || left >= variance {
        return Err(UNFIT);
    }
    Ok(Searched {
        run,
        problem,
        record: *record,
        parts,
        function,
        late,
        left,
        variance,
        white,
    })
}

/// The output of a sum of parts over a record, as a fit runs it.
pub(crate) fn run_alone(
    parts: &[FractionalTransferFunction],
    record: &InputOutputRecord<'_>,
) -> Option<Vec<f64>> {
    let memory = memory_of(record).ok()?;
    let numbers = Numbers::fixed(parts, Free::Coefficients);
    let fit = Fit::new(numbers, memory, *record, 1);
    Some(fit.run?.output)
}

/// The memory of a rule over a record.
fn memory_of(record: &InputOutputRecord<'_>) -> Result<PowerMemory, ControlError> {
    let horizon = record.input.len() as f64 * record.sample_time.0;
    PowerMemory::new(Rule::Bdf2, 1e-7, horizon)
}

fn check(record: &InputOutputRecord<'_>, free: usize) -> Result<(), ControlError> {
    let t = positive("sample time", record.sample_time.0, "s")?;
    let dead_time = record.dead_time.seconds();
    let inside = (0.0..t * record.input.len() as f64).contains(&dead_time);
    let allowed = "at least 0, shorter than the record";
    range("dead time", dead_time, inside, allowed, "s")?;
    let (inputs, outputs) = (record.input.len() as f64, record.output.len() as f64);
    let same = record.input.len() == record.output.len();
    let allowed = "as many as of the input";
    range("samples of the output", outputs, same, allowed, "")?;
    let stamps = record.time_s.len();
    let same = stamps == 0 || stamps == record.input.len();
    let allowed = "none, or as many as of the input";
    range("times of the record", stamps as f64, same, allowed, "")?;
    let enough = record.input.len() > 2 * free;
    let allowed = "more than twice the free numbers";
    range("samples of the record", inputs, enough, allowed, "")?;
    for sample in record.input.iter().chain(record.output) {
        range("sample of the record", *sample, true, "finite", "")?;
    }
    positive("largest output of the record", largest(record.output), "")?;
    Ok(())
}
