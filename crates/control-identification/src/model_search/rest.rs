//! Poles and zeros of whole orders that a record cannot tell from rest, or from each other.

use super::record::InputOutput;
use crate::{FreeNumber, Identified};
use fracdiff::roots;
use fractional_control::whole_orders::{coefficients, of_coefficients, without_root};
use fractional_control::{FractionalTransferFunction, Term};
use num_complex::Complex;

/// A pole or zero that moves by less than this over the whole record is at rest.
const AT_REST: f64 = 0.3;
/// A pole that moves by less than this is equivalent to an integrator, whatever follows the record.
pub(super) const STANDS: f64 = 0.03;

/// Order of the pole at s = 0: 1 of an integrator.
pub(super) fn order_at_rest(function: &FractionalTransferFunction) -> f64 {
    function.denominator().lowest() - function.numerator().lowest()
}

/// A function of whole orders without a pole and a zero, or a pair of each, that are at rest: within the record the one cancels the other.
pub(super) fn cancelled(
    function: &FractionalTransferFunction,
    record: &InputOutput,
) -> Option<FractionalTransferFunction> {
    let above = coefficients(function.numerator());
    let mut below = coefficients(function.denominator());
    let zero = at_rest(&above, record)?;
    let poles = if zero.im == 0.0 { 1 } else { 2 };
    for _ in 0..poles {
        let pole = at_rest(&below, record).filter(|pole| pole.im == 0.0)?;
        below = without_root(&below, pole);
    }
    of_coefficients(&without_root(&above, zero), &below)
}

/// A pole and a zero of a function of whole orders that are as near to each other.
pub(super) struct Pair {
    pub(super) pole: Complex<f64>,
    pub(super) zero: Complex<f64>,
    /// Their distance over its standard error.
    pub(super) errors: f64,
}

/// A root moves by −Σ s^k·`dc_k`/N′(s) with the coefficients c of N: its slope by each free number, which is relative.
fn slopes(root: Complex<f64>, terms: &[Term]) -> impl Fn(usize) -> Complex<f64> {
    let power = |order: f64| root.powi(order as i32);
    let steep = terms.iter().filter(|term| term.order > 0.0);
    let steep = steep.map(|term| power(term.order - 1.0) * (term.order * term.coefficient));
    let steep: Complex<f64> = steep.sum();
    let parts = terms
        .iter()
        .map(|term| -power(term.order) * term.coefficient / steep);
    let parts: Vec<Complex<f64>> = parts.collect();
    move |n| parts[n]
}

/// Each zero and each pole that could cancel it, the nearest in their errors first.
pub(super) fn pairs(model: &Identified) -> Vec<Pair> {
    let [above, below] = [model.function.numerator(), model.function.denominator()];
    let [zeros, poles] = [above, below].map(|side| roots(&coefficients(side)));
    let pairs = zeros
        .iter()
        .flat_map(|zero| poles.iter().map(move |pole| (*zero, *pole)));
    let alike = pairs.filter(|(zero, pole)| (zero.im == 0.0) == (pole.im == 0.0));
    let judged = alike.map(|(zero, pole)| {
        let derivatives = (slopes(zero, above.terms()), slopes(pole, below.terms()));
        let slope = |(number, _): &(FreeNumber, f64)| match *number {
            FreeNumber::NumeratorCoefficient(n) => derivatives.0(n),
            FreeNumber::DenominatorCoefficient(n) if pole.norm() > 0.0 => -derivatives.1(n),
            FreeNumber::DenominatorCoefficient(_)
            | FreeNumber::NumeratorOrder(_)
            | FreeNumber::DenominatorOrder(_)
            | FreeNumber::DeadTime => Complex::ZERO,
        };
        let slopes: Vec<Complex<f64>> = model.standard_errors.iter().map(slope).collect();
        let square: f64 = (0..slopes.len())
            .flat_map(|n| (0..slopes.len()).map(move |k| (n, k)))
            .map(|(n, k)| (slopes[n].conj() * slopes[k]).re * model.covariance[(n, k)])
            .sum();
        Pair {
            pole,
            zero,
            errors: (zero - pole).norm() / libm::sqrt(square),
        }
    });
    let mut judged: Vec<Pair> = judged.collect();
    judged.sort_by(|a, b| a.errors.total_cmp(&b.errors));
    judged
}

/// Standard errors within which two roots count as one, if they are no further apart than this share of the larger one.
const ONE: f64 = 2.0;
const CLOSE: f64 = 0.5;
/// A swing is barely damped below this damping ratio.
const BARELY: f64 = 0.02;
/// Probability that noise draws such a swing.
const BY_CHANCE: f64 = 0.001;

/// The errors that hide a pole behind a zero. Of N samples a barely damped swing has the choice of N/2 frequencies, and noise is largest at one of
/// them: N/2·exp(−e²/2) bounds its chance to go beyond e (W. Feller, *An introduction to probability theory*, 1968, VII.1, for each).
fn hides(pair: &Pair, samples: usize) -> f64 {
    let is_barely_damped = pair.pole.im != 0.0 && -pair.pole.re < BARELY * pair.pole.norm();
    if is_barely_damped {
        libm::sqrt(2.0 * libm::log(samples as f64 / (2.0 * BY_CHANCE)))
    } else {
        ONE
    }
}

/// The function without a pole and a zero that are one within their errors.
pub(super) fn without_pair(
    model: &Identified,
    record: &InputOutput,
) -> Option<FractionalTransferFunction> {
    let function = &model.function;
    let [above, below] = [function.numerator(), function.denominator()].map(coefficients);
    let is_near = |pair: &Pair| {
        let apart = (pair.zero - pair.pole).norm();
        let slow = 1.0 / record.length_s();
        apart <= CLOSE * pair.zero.norm().max(pair.pole.norm()).max(slow)
    };
    let is_hidden = |pair: &&Pair| pair.errors <= hides(pair, record.output.len());
    let pairs = pairs(model);
    let pair = pairs.iter().filter(|pair| is_near(pair)).find(is_hidden)?;
    of_coefficients(
        &without_root(&above, pair.zero),
        &without_root(&below, pair.pole),
    )
}

/// True if a function that settles shows some of that within the record: the last coefficient below acts beside the one before.
pub(super) fn comes_to_rest(function: &FractionalTransferFunction, record: &InputOutput) -> bool {
    moves(function, record) > STANDS
}

/// True of a function of order 0 at rest whose slowest pole is not at rest within the record.
pub(super) fn rests(function: &FractionalTransferFunction, record: &InputOutput) -> bool {
    order_at_rest(function) == 0.0 && moves(function, record) > AT_REST
}

/// Approximate share by which the slowest pole settles within the record.
fn moves(function: &FractionalTransferFunction, record: &InputOutput) -> f64 {
    let below = function.denominator().terms();
    below
        .last_chunk::<2>()
        .map_or(f64::INFINITY, |[next, last]| {
            let moved = libm::pow(record.length_s(), next.order - last.order);
            (last.coefficient / next.coefficient * moved).abs()
        })
}

/// A function of whole orders whose slowest pole that moves is at rest within the record, with that pole at s = 0.
pub(super) fn integrating(
    function: &FractionalTransferFunction,
    record: &InputOutput,
) -> Option<FractionalTransferFunction> {
    let below = coefficients(function.denominator());
    let integrators = below.iter().position(|c| *c != 0.0)?;
    let faster = without_rest(&below[integrators..], record)?;
    let below = [vec![0.0; integrators + 1], faster].concat();
    of_coefficients(&coefficients(function.numerator()), &below)
}

/// The polynomial without its slowest root, if that is real and at rest.
fn without_rest(coefficients: &[f64], record: &InputOutput) -> Option<Vec<f64>> {
    let root = at_rest(coefficients, record).filter(|root| root.im == 0.0)?;
    Some(without_root(coefficients, root))
}

/// The slowest root of a polynomial, if it is at rest.
fn at_rest(coefficients: &[f64], record: &InputOutput) -> Option<Complex<f64>> {
    let root = roots(coefficients).into_iter().next();
    root.filter(|root| root.norm() * record.length_s() <= AT_REST)
}
