//! Poles and zeros of whole orders that a record cannot tell from rest, or from each other.

use super::found::Found;
use super::record::InputOutput;
use crate::{FractionalTransferFunction, FreeNumber, Term};
use fracdiff::roots;
use num_complex::Complex;
use std::vec;
use std::vec::Vec;

/// A pole or zero that moves by less than this over the whole record is at rest.
const AT_REST: f64 = 0.3;
/// A pole that moves by less than this is as good as an integrator, whatever follows the record.
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
    let above = coefficients(function.numerator().terms());
    let mut below = coefficients(function.denominator().terms());
    let zero = at_rest(&above, record)?;
    let poles = if zero.im == 0.0 { 1 } else { 2 };
    for _ in 0..poles {
        let pole = at_rest(&below, record).filter(|pole| pole.im == 0.0)?;
        below = without(&below, pole);
    }
    of_coefficients(&without(&above, zero), &below)
}

/// A relative error of a coefficient above which it says nothing of a root.
const CLOSE: f64 = 0.02;

/// The function without the pole and the zero that are nearest to each other, if they are one within twice their errors.
pub(super) fn without_pair(found: &Found) -> Option<FractionalTransferFunction> {
    let own = &found.identified;
    let (above, below) = (own.function.numerator(), own.function.denominator());
    let [above, below] = [above, below].map(|side| coefficients(side.terms()));
    let errors = own.standard_errors.iter();
    let errors = errors.filter(|(number, _)| *number != FreeNumber::DeadTime);
    let error = errors.fold(0.0, |most: f64, (_, error)| most.max(*error));
    let poles: Vec<_> = roots(&below)
        .into_iter()
        .filter(|p| p.norm() > 0.0)
        .collect();
    let zeros = roots(&above);
    let pairs = zeros
        .iter()
        .flat_map(|zero| poles.iter().map(move |pole| (*zero, *pole)));
    let apart = |(zero, pole): &(Complex<f64>, Complex<f64>)| (zero / pole - 1.0).norm();
    let (zero, pole) = pairs.min_by(|a, b| apart(a).total_cmp(&apart(b)))?;
    let alike = apart(&(zero, pole)) <= 2.0 * error.min(CLOSE);
    let alike = alike && (zero.im == 0.0) == (pole.im == 0.0);
    alike.then(|| of_coefficients(&without(&above, zero), &without(&below, pole)))?
}

/// True if a function that settles shows some of that within the record: the last coefficient below acts beside the one before.
pub(super) fn comes_to_rest(function: &FractionalTransferFunction, record: &InputOutput) -> bool {
    let below = function.denominator().terms();
    let Some([next, last]) = below.last_chunk::<2>() else {
        return true;
    };
    let moved = libm::pow(record.length_s(), next.order - last.order);
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
    let below = [vec![0.0; integrators + 1], faster].concat();
    of_coefficients(&coefficients(function.numerator().terms()), &below)
}

/// The function whose lowest coefficient below is 1 or −1: a fit leaves it so.
pub(super) fn of_coefficients(above: &[f64], below: &[f64]) -> Option<FractionalTransferFunction> {
    let unit = below.iter().find(|c| **c != 0.0)?.abs();
    let terms = |all: &[f64]| terms(&all.iter().map(|c| c / unit).collect::<Vec<f64>>());
    FractionalTransferFunction::new(&terms(above), &terms(below)).ok()
}

pub(super) fn coefficients(terms: &[Term]) -> Vec<f64> {
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
    let root = at_rest(coefficients, record).filter(|root| root.im == 0.0)?;
    Some(without(coefficients, root))
}

/// The slowest root of a polynomial, if it is at rest.
fn at_rest(coefficients: &[f64], record: &InputOutput) -> Option<Complex<f64>> {
    let root = roots(coefficients).into_iter().next();
    root.filter(|root| root.norm() * record.length_s() <= AT_REST)
}

/// A polynomial without a root, and without the conjugate one.
fn without(coefficients: &[f64], root: Complex<f64>) -> Vec<f64> {
    let mut left: Vec<Complex<f64>> = coefficients.iter().map(|c| (*c).into()).collect();
    let times = if root.im == 0.0 { 1 } else { 2 };
    for root in [root, root.conj()].into_iter().take(times) {
        // Horner's rule from above; what is left of the lowest is the remainder.
        for k in (0..left.len().saturating_sub(1)).rev() {
            let above = left[k + 1];
            left[k] += root * above;
        }
        left.remove(0);
    }
    left.iter().map(|c| c.re).collect()
}
