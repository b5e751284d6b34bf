//! A fractional transfer function from a record of input and output.

use crate::{ControlError, FractionalTransferFunction, Memory, Rule, Term, respond};
use fracdiff::Seconds;
use fracdiff::parameter::{positive, range};
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn};
use std::vec::Vec;

/// A record: input and output at the same instants, T apart, from rest.
#[derive(Clone, Copy, Debug)]
pub struct Record<'a> {
    /// T.
    pub sample_time: Seconds,
    /// u, one a sample.
    pub input: &'a [f64],
    /// y, one a sample.
    pub output: &'a [f64],
    /// True if u is a command that was held from its sample to the next, as in a step; false for a smooth signal that was sampled.
    pub held: bool,
}

/// A function that was found, and how well it fits.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Identified {
    /// The function.
    pub function: FractionalTransferFunction,
    /// Root mean square of what is left, in the unit of y.
    pub rms_residual: f64,
    /// 1 less the share of the variance of y that is left.
    pub fit: f64,
    /// Standard errors of the free numbers, in the order of [`FreeNumber`]s.
    pub standard_errors: Vec<(FreeNumber, f64)>,
}

/// A number of the function that was free.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum FreeNumber {
    /// Coefficient of the n-th term of the numerator, highest order first; the error is relative.
    NumeratorCoefficient(usize),
    /// Its order.
    NumeratorOrder(usize),
    /// Coefficient of the n-th term of the denominator; the error is relative.
    DenominatorCoefficient(usize),
    /// Its order.
    DenominatorOrder(usize),
}

/// Fits the coefficients and orders of a function to a record by least squares, from a first guess.
///
/// The guess sets the terms and the signs of their coefficients. Of the denominator the last coefficient stays, or function and gain would
/// not be told apart; orders that are 0 stay 0. Output error: the model is run over the whole record, with its full
/// history.
///
/// - *Cost*: some hundred runs over the record. *Accuracy*: of second order in T, so sample at a twentieth of the fastest time constant.
///
/// ```
/// use fracdiff::Seconds;
/// use fractional_control::{FractionalTransferFunction, Memory, Record, Rule, identify, step_response};
///
/// let truth: FractionalTransferFunction = "2/(0.8s^1.3+1)".parse()?;
/// let t = Seconds(0.05);
/// let y = step_response(&truth, Memory::new(Rule::Bdf2, 1e-8, 10.0)?, t, 200)?;
/// let record = Record { sample_time: t, input: &[1.0; 200], output: &y, held: true };
/// let found = identify(&"1/(s+1)".parse()?, &record)?;
/// assert!((found.function.denominator().degree() - 1.3).abs() < 1e-4);
/// # Ok::<(), fractional_control::ControlError>(())
/// ```
/// # Errors
/// Records of different lengths, shorter than the free numbers, not finite, or without any output; a search that fails.
pub fn identify(
    guess: &FractionalTransferFunction,
    record: &Record<'_>,
) -> Result<Identified, ControlError> {
    let free = free_numbers(guess);
    check(record, free.len())?;
    let horizon = record.input.len() as f64 * record.sample_time.0;
    let memory = Memory::new(Rule::Bdf2, 1e-7, horizon)?;
    let mut input = record.input.to_vec();
    if record.held {
        // What a hold does between two samples.
        for n in (0..input.len()).rev() {
            let last = if n > 0 { record.input[n - 1] } else { 0.0 };
            input[n] = 0.5 * (record.input[n] + last);
        }
    }
    let problem = Fit {
        guess: *guess,
        parameters: DVector::from_iterator(
            free.len(),
            free.iter().map(|number| value(guess, *number)),
        ),
        free,
        memory,
        record,
        input,
    };
    let (problem, report) = LevenbergMarquardt::new()
        .with_patience(30)
        .minimize(problem);
    let residuals = problem
        .residuals()
        .filter(|_| !report.termination.was_usage_issue());
    let unfit = ControlError::NotFound {
        what: "a function that fits the record",
        why: "begin from another guess, nearer in gain and time constant, or with other terms",
    };
    let residuals = residuals.ok_or(unfit)?;
    let function = problem.function().and_then(|found| settled(&found));
    let function = function.map_err(|_| unfit)?;
    let samples = record.output.len() as f64;
    let mean = record.output.iter().sum::<f64>() / samples;
    let variance: f64 = record.output.iter().map(|y| (y - mean) * (y - mean)).sum();
    let left = residuals.norm_squared();
    if left.is_nan() || left >= variance {
        return Err(unfit);
    }
    Ok(Identified {
        function,
        rms_residual: libm::sqrt(left / samples),
        fit: 1.0 - left / variance,
        standard_errors: problem.errors(left),
    })
}

fn check(record: &Record<'_>, free: usize) -> Result<(), ControlError> {
    positive("sample time", record.sample_time.0, "s")?;
    let (inputs, outputs) = (record.input.len() as f64, record.output.len() as f64);
    let same = record.input.len() == record.output.len();
    range(
        "samples of the output",
        outputs,
        same,
        "as many as of the input",
        "",
    )?;
    let enough = record.input.len() > 2 * free;
    range(
        "samples of the record",
        inputs,
        enough,
        "more than twice the free numbers",
        "",
    )?;
    for sample in record.input.iter().chain(record.output) {
        range("sample of the record", *sample, true, "finite", "")?;
    }
    let largest = record
        .output
        .iter()
        .fold(0.0, |most: f64, y| most.max(y.abs()));
    positive("largest output of the record", largest, "")?;
    Ok(())
}

/// All but the last coefficient of the denominator, and orders of 0.
fn free_numbers(guess: &FractionalTransferFunction) -> Vec<FreeNumber> {
    let mut free = Vec::new();
    for (n, term) in guess.numerator().terms().iter().enumerate() {
        free.push(FreeNumber::NumeratorCoefficient(n));
        if term.order > 0.0 {
            free.push(FreeNumber::NumeratorOrder(n));
        }
    }
    let terms = guess.denominator().terms();
    for (n, term) in terms.iter().enumerate() {
        if n + 1 < terms.len() {
            free.push(FreeNumber::DenominatorCoefficient(n));
        }
        if term.order > 0.0 {
            free.push(FreeNumber::DenominatorOrder(n));
        }
    }
    free
}

/// An order, or the logarithm of the size of a coefficient.
fn value(function: &FractionalTransferFunction, number: FreeNumber) -> f64 {
    let (above, below) = (function.numerator().terms(), function.denominator().terms());
    match number {
        FreeNumber::NumeratorCoefficient(n) => libm::log(above[n].coefficient.abs()),
        FreeNumber::NumeratorOrder(n) => above[n].order,
        FreeNumber::DenominatorCoefficient(n) => libm::log(below[n].coefficient.abs()),
        FreeNumber::DenominatorOrder(n) => below[n].order,
    }
}

struct Fit<'a> {
    guess: FractionalTransferFunction,
    free: Vec<FreeNumber>,
    parameters: DVector<f64>,
    memory: Memory,
    record: &'a Record<'a>,
    /// The samples that the model is fed with.
    input: Vec<f64>,
}

/// Step of a central difference, of orders and logarithms alike.
const STEP: f64 = 1e-5;
/// Orders nearer than this to a whole number are that number: no record tells them apart, and a plant of whole orders is sampled exactly.
const WHOLE: f64 = 1e-4;

fn settled(found: &FractionalTransferFunction) -> Result<FractionalTransferFunction, ControlError> {
    let whole = |terms: &[Term]| -> Vec<Term> {
        let settle = |term: &Term| {
            let nearest = libm::round(term.order);
            let is_near = (term.order - nearest).abs() < WHOLE;
            Term::new(term.coefficient, if is_near { nearest } else { term.order })
        };
        terms.iter().map(settle).collect()
    };
    FractionalTransferFunction::new(
        &whole(found.numerator().terms()),
        &whole(found.denominator().terms()),
    )
}

/// A residual where there is no model, in units of the largest output.
const NONE: f64 = 1e3;

impl Fit<'_> {
    fn function(&self) -> Result<FractionalTransferFunction, ControlError> {
        self.with(&self.parameters)
    }

    fn with(&self, parameters: &DVector<f64>) -> Result<FractionalTransferFunction, ControlError> {
        let mut above = self.guess.numerator().terms().to_vec();
        let mut below = self.guess.denominator().terms().to_vec();
        let coefficient = |term: &mut Term, x: f64| {
            term.coefficient = libm::exp(x) * term.coefficient.signum();
        };
        for (number, x) in self.free.iter().zip(parameters.iter()) {
            match *number {
                FreeNumber::NumeratorCoefficient(n) => coefficient(&mut above[n], *x),
                FreeNumber::NumeratorOrder(n) => above[n].order = *x,
                FreeNumber::DenominatorCoefficient(n) => coefficient(&mut below[n], *x),
                FreeNumber::DenominatorOrder(n) => below[n].order = *x,
            }
        }
        FractionalTransferFunction::new(&above, &below)
    }

    /// Model less record.
    fn left(&self, parameters: &DVector<f64>) -> DVector<f64> {
        let largest = self
            .record
            .output
            .iter()
            .fold(0.0, |most: f64, y| most.max(y.abs()));
        let limit = NONE * largest;
        let model = self.with(parameters).and_then(|function| {
            respond(&function, self.memory, self.record.sample_time, &self.input)
        });
        let output = self.record.output;
        match model {
            Ok(model) => {
                let pairs = model.iter().zip(output);
                // An unstable model overflows.
                let left = pairs.map(|(have, want)| (have - want).clamp(-limit, limit));
                let left = left.map(|left| if left.is_finite() { left } else { limit });
                DVector::from_iterator(output.len(), left)
            }
            Err(_) => DVector::from_element(output.len(), limit),
        }
    }

    fn slopes(&self) -> DMatrix<f64> {
        let mut slopes = DMatrix::zeros(self.record.output.len(), self.free.len());
        for column in 0..self.free.len() {
            let moved = |step: f64| {
                let mut parameters = self.parameters.clone();
                parameters[column] += step;
                self.left(&parameters)
            };
            let slope = (moved(STEP) - moved(-STEP)) / (2.0 * STEP);
            slopes.set_column(column, &slope);
        }
        slopes
    }

    /// √ of the diagonal of σ²(JᵀJ)⁻¹; infinite where the record says nothing.
    fn errors(&self, left: f64) -> Vec<(FreeNumber, f64)> {
        let slopes = self.slopes();
        let free = self.free.len();
        let scale = left / (self.record.output.len() - free) as f64;
        let inverse = (slopes.transpose() * &slopes).try_inverse();
        let error = |n: usize| match &inverse {
            Some(inverse) => libm::sqrt((inverse[(n, n)] * scale).max(0.0)),
            None => f64::INFINITY,
        };
        self.free
            .iter()
            .enumerate()
            .map(|(n, number)| (*number, error(n)))
            .collect()
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Fit<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, parameters: &DVector<f64>) {
        self.parameters.copy_from(parameters);
    }

    fn params(&self) -> DVector<f64> {
        self.parameters.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        Some(self.left(&self.parameters))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        Some(self.slopes())
    }
}
