//! A record, and the numbers of a function that are free when it is fitted to one.

use crate::FractionalTransferFunction;
use fracdiff::Seconds;
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
    /// The input acts so much later: the part of a dead time that is no whole sample, 0 to T.
    pub late: Seconds,
}

impl Record<'_> {
    /// h, the share of a sample by which the input acts later.
    pub(super) fn fraction(&self) -> f64 {
        self.late.0 / self.sample_time.0
    }
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

/// The numbers of a function that a fit may change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Free {
    /// Coefficients, of which signs stay, and orders that are not 0.
    All,
    /// Coefficients and their signs.
    Coefficients,
}

/// All but the last coefficient of the denominator, and orders of 0.
pub(super) fn free_numbers(guess: &FractionalTransferFunction, freedom: Free) -> Vec<FreeNumber> {
    let mut free = Vec::new();
    let is_free = |order: f64| order > 0.0 && freedom == Free::All;
    for (n, term) in guess.numerator().terms().iter().enumerate() {
        free.push(FreeNumber::NumeratorCoefficient(n));
        if is_free(term.order) {
            free.push(FreeNumber::NumeratorOrder(n));
        }
    }
    let terms = guess.denominator().terms();
    for (n, term) in terms.iter().enumerate() {
        if n + 1 < terms.len() {
            free.push(FreeNumber::DenominatorCoefficient(n));
        }
        if is_free(term.order) {
            free.push(FreeNumber::DenominatorOrder(n));
        }
    }
    free
}
