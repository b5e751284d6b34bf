//! Polynomials of whole orders as lists of coefficients, the lowest first.

use crate::{FractionalPolynomial, FractionalTransferFunction, Term};
use num_complex::Complex;
use std::{vec, vec::Vec};

/// The function of these coefficients, the lowest of them below made 1 or −1; `None` where it is no function.
#[must_use]
pub fn of_coefficients(above: &[f64], below: &[f64]) -> Option<FractionalTransferFunction> {
    let unit = below.iter().find(|c| **c != 0.0)?.abs();
    let terms = |all: &[f64]| terms(&all.iter().map(|c| c / unit).collect::<Vec<f64>>());
    FractionalTransferFunction::new(&terms(above), &terms(below)).ok()
}

/// Coefficients of a polynomial of whole orders, that of s⁰ first.
#[must_use]
pub fn coefficients(polynomial: &FractionalPolynomial) -> Vec<f64> {
    let mut all = vec![0.0; polynomial.degree() as usize + 1];
    for term in polynomial.terms() {
        all[term.order as usize] = term.coefficient;
    }
    all
}

fn terms(coefficients: &[f64]) -> Vec<Term> {
    let terms = coefficients.iter().enumerate().filter(|(_, c)| **c != 0.0);
    terms.map(|(k, c)| Term::new(*c, k as f64)).collect()
}

/// A polynomial without a root, and without the conjugate one.
#[must_use]
pub fn without_root(coefficients: &[f64], root: Complex<f64>) -> Vec<f64> {
    let mut left: Vec<Complex<f64>> = coefficients.iter().map(|c| (*c).into()).collect();
    let times = if root.im == 0.0 { 1 } else { 2 };
    for root in [root, root.conj()].into_iter().take(times) {
        // Horner's rule from above; the lowest becomes the remainder.
        for k in (0..left.len().saturating_sub(1)).rev() {
            let above = left[k + 1];
            left[k] += root * above;
        }
        left.drain(..left.len().min(1));
    }
    left.iter().map(|c| c.re).collect()
}
