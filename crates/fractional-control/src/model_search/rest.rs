//! Poles at rest: those that a zero cancels as far as the record goes, and those that it does not ask for.

use super::record::InputOutput;
use crate::{FractionalTransferFunction, Term};
use fracdiff::roots;
use std::vec;
use std::vec::Vec;

/// A pole or zero that moves by less than this over the whole record is at rest.
const AT_REST: f64 = 0.3;
/// A pole that moves by less than this is as good as an integrator, whatever follows the record.
const STANDS: f64 = 0.03;
/// What is left may grow by this factor where a pole at rest is cancelled.
pub(super) const AS_MUCH: f64 = 2.0;

/// Order of the pole at s = 0: 1 of an integrator.
pub(super) fn order_at_rest(function: &FractionalTransferFunction) -> f64 {
    function.denominator().lowest() - function.numerator().lowest()
}

/// A function of whole orders without a pole and a zero that are both at rest: within the record the one cancels the other.
pub(super) fn cancelled(
    function: &FractionalTransferFunction,
    record: &InputOutput,
) -> Option<FractionalTransferFunction> {
    let above = without_rest(&coefficients(function.numerator().terms()), record)?;
    let below = without_rest(&coefficients(function.denominator().terms()), record)?;
    FractionalTransferFunction::new(&terms(&above), &terms(&below)).ok()
}

/// True if a function that settles shows some of that within the record: the last coefficient below acts beside the one before.
pub(super) fn comes_to_rest(function: &FractionalTransferFunction, record: &InputOutput) -> bool {
    let below = function.denominator().terms();
    let Some([next, last]) = below.last_chunk::<2>() else {
        return true;
    };
    let moved = libm::pow(length_s(record), next.order - last.order);
    (last.coefficient / next.coefficient * moved).abs() > STANDS
}

/// A function of whole orders whose slowest pole that moves is at rest within the record, with that pole at s = 0.
pub(super) fn integrating(
    function: &FractionalTransferFunction,
    record: &InputOutput,
) -> Option<FractionalTransferFunction> {
    let below = coefficients(function.denominator().terms());
    let integrators = below.iter().position(|c| *c != 0.0)?;
    let faster = without_rest(&below[integrators..], record)?;
    let unit = faster.first().map(|c| c.abs()).filter(|c| *c > 0.0)?;
    let zeros = core::iter::repeat_n(0.0, integrators + 1);
    let below: Vec<f64> = zeros.chain(faster.iter().map(|c| c / unit)).collect();
    let above = coefficients(function.numerator().terms());
    let above: Vec<f64> = above.iter().map(|c| c / unit).collect();
    FractionalTransferFunction::new(&terms(&above), &terms(&below)).ok()
}

fn length_s(record: &InputOutput) -> f64 {
    record.sample_time_s() * record.time_s.len() as f64
}

/// Of s⁰ first.
fn coefficients(terms: &[Term]) -> Vec<f64> {
    let degree = terms.first().map_or(0.0, |term| term.order);
    let mut all = vec![0.0; degree as usize + 1];
    for term in terms {
        all[term.order as usize] = term.coefficient;
    }
    all
}

fn terms(coefficients: &[f64]) -> Vec<Term> {
    let terms = coefficients.iter().enumerate().filter(|(_, c)| **c != 0.0);
    terms.map(|(k, c)| Term::new(*c, k as f64)).collect()
}

/// The polynomial without its slowest root, if that is real and at rest.
fn without_rest(coefficients: &[f64], record: &InputOutput) -> Option<Vec<f64>> {
    let root = roots(coefficients).into_iter().next()?;
    if root.im != 0.0 || root.re.abs() * length_s(record) > AT_REST {
        return None;
    }
    // Horner's rule from above.
    let mut left = Vec::new();
    for c in coefficients.iter().skip(1).rev() {
        let before = left.last().map_or(0.0, |last| last * root.re);
        left.push(c + before);
    }
    left.reverse();
    Some(left)
}
