//! A function that is affine in its coefficients, on the unit circle with its bounds: Σ `c_i`·`t_i`(w), all `c_i` ≥ 0.

use certified_count::{Bounds, Jet, product};
use num_complex::Complex;

/// The terms at one angle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Terms<const N: usize> {
    pub(crate) jets: [Jet; N],
    /// Rounding errors of the terms are these many ε.
    pub(crate) rough: [f64; N],
}

/// Bounds of the terms between two angles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ways<const N: usize> {
    pub(crate) travel: [f64; N],
    pub(crate) bend: [f64; N],
}

impl<const N: usize> Terms<N> {
    pub(crate) fn value(&self, coefficients: &[f64; N]) -> Complex<f64> {
        let terms = self.jets.iter().zip(coefficients);
        terms.fold(Complex::new(0.0, 0.0), |sum, (jet, c)| sum + jet.value * *c)
    }

    /// The derivative; a rate that is infinite counts for nothing without its term.
    pub(crate) fn slope(&self, coefficients: &[f64; N]) -> Complex<f64> {
        let terms = self
            .jets
            .iter()
            .zip(coefficients)
            .filter(|(_, c)| **c != 0.0);
        terms.fold(Complex::new(0.0, 0.0), |sum, (jet, c)| sum + jet.rate * *c)
    }

    /// Size of the derivative, infinite where it is no number.
    pub(crate) fn rate(&self, coefficients: &[f64; N]) -> f64 {
        let rate = self.slope(coefficients).norm();
        if rate.is_nan() { f64::INFINITY } else { rate }
    }

    /// The sizes of the terms, added up.
    pub(crate) fn size(&self, coefficients: &[f64; N]) -> f64 {
        let terms = self.jets.iter().zip(coefficients);
        terms.fold(0.0, |sum, (jet, c)| sum + c * jet.value.norm())
    }

    /// An estimate of the rounding error of the value.
    pub(crate) fn noise(&self, coefficients: &[f64; N]) -> f64 {
        let terms = self.rough.iter().zip(coefficients);
        8.0 * f64::EPSILON * terms.fold(0.0, |sum, (rough, c)| sum + c * rough)
    }
}

impl<const N: usize> Ways<N> {
    pub(crate) fn new(bounds: &[Bounds; N]) -> Self {
        Self {
            travel: bounds.map(|term| term.travel),
            bend: bounds.map(|term| term.bend),
        }
    }

    /// A bound of the length of the function's path between two angles that are so far apart.
    pub(crate) fn path(&self, [a, b]: [&Terms<N>; 2], coefficients: &[f64; N], width: f64) -> f64 {
        let sum = |terms: &[f64; N]| {
            let terms = terms.iter().zip(coefficients);
            terms.fold(0.0, |sum, (term, c)| sum + product(*c, *term))
        };
        let ends = a.rate(coefficients) + b.rate(coefficients);
        let by_bend = 0.5 * width * (ends + 0.5 * width * sum(&self.bend));
        sum(&self.travel).min(by_bend)
    }
}

/// Bounds of Σ `c_i`·`t_i` from those of its terms.
pub(crate) fn weighted<const N: usize>(terms: &[Bounds; N], coefficients: &[f64; N]) -> Bounds {
    let sum = |of: fn(&Bounds) -> f64| {
        let terms = terms.iter().zip(coefficients);
        terms.fold(0.0, |sum, (term, c)| sum + product(*c, of(term)))
    };
    Bounds {
        size: sum(|bounds| bounds.size),
        rate: sum(|bounds| bounds.rate),
        bend: sum(|bounds| bounds.bend),
        travel: sum(|bounds| bounds.travel),
    }
}
