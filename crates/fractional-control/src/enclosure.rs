//! Sums of products as functions on the unit circle, enclosed on an arc, so that a count of their zeros is a proof.

use crate::ControlError;
use crate::records::largest;
use certified_count::{Arc, Enclosed};
use core::fmt::Debug;
use fracdiff::parameter::range;
use num_complex::Complex;
use std::vec::Vec;

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Factor {
    /// `Σ c_j w^j`.
    InW(Vec<f64>),
    /// `Σ c_k v^k`, v = 1 − w.
    InV(Vec<f64>),
    /// v^n.
    Difference(i32),
    /// w^d.
    Delay(usize),
    /// `Σ k_j w^j + Σ W_q/(1 − r_q w)`: taps, and `W_q` with `1 − r_q`.
    Memory(Vec<f64>, Vec<(f64, f64)>),
    Law(SharedLaw),
}

fn horner(coefficients: &[f64], x: Complex<f64>) -> Complex<f64> {
    let zero = Complex::new(0.0, 0.0);
    coefficients.iter().rev().fold(zero, |sum, c| sum * x + c)
}

/// `Σ j|c_j|·most^(j−1)`
fn slope(coefficients: &[f64], most: f64) -> f64 {
    let terms = coefficients.iter().enumerate().skip(1);
    terms
        .map(|(j, c)| j as f64 * c.abs() * most.powi(j as i32 - 1))
        .sum()
}

impl Factor {
    pub(crate) fn at(&self, arc: &Arc) -> Enclosed {
        match self {
            Self::InW(c) => Enclosed::new(horner(c, arc.w), slope(c, 1.0), arc),
            Self::InV(c) => Enclosed::new(horner(c, arc.v), slope(c, arc.most), arc),
            Self::Difference(n) => {
                let rate = if *n == 0 {
                    0.0
                } else {
                    f64::from(*n) * arc.most.powi(n - 1)
                };
                Enclosed::new(arc.v.powi(*n), rate, arc)
            }
            Self::Delay(d) => {
                let angle = *d as f64 * arc.middle();
                let (sin, cos) = libm::sincos(angle);
                Enclosed::new(Complex::new(cos, -sin), *d as f64, arc)
            }
            Self::Memory(taps, modes) => {
                let mut value = horner(taps, arc.w);
                let mut rate = slope(taps, 1.0);
                for &(weight, decay) in modes {
                    // 1 − rw = d + rv, |1 − rw|² = d² + r|v|²
                    let r = 1.0 - decay;
                    value += (arc.v * r + decay).inv() * weight;
                    rate += weight.abs() * r / (decay * decay + r * arc.least_square);
                }
                Enclosed::new(value, rate, arc)
            }
            Self::Law(SharedLaw(law)) => {
                let value = law.response(arc.middle());
                // The mean rate that no part of the path exceeds.
                let rate = match arc.half_width() {
                    0.0 => 0.0,
                    half => law.variation(arc.low, arc.high) / half,
                };
                Enclosed::new(value, rate, arc)
            }
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Product {
    pub(crate) scale: f64,
    pub(crate) factors: Vec<Factor>,
}

impl Product {
    pub(crate) const fn new(scale: f64, factors: Vec<Factor>) -> Self {
        Self { scale, factors }
    }
}

/// Σ of products.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sum(pub(crate) Vec<Product>);

impl Sum {
    pub(crate) fn at(&self, arc: &Arc) -> Enclosed {
        let nothing = Enclosed {
            value: Complex::new(0.0, 0.0),
            size: 0.0,
            rate: 0.0,
        };
        self.0.iter().fold(nothing, |sum, product| {
            let one = Enclosed::new(Complex::new(1.0, 0.0), 0.0, arc);
            let factors = product.factors.iter();
            let value = factors.fold(one, |value, factor| value.times(factor.at(arc)));
            sum.plus(value.scaled(product.scale))
        })
    }

    /// Without the power of v that all products have in common.
    pub(crate) fn without_differences(mut self) -> Self {
        let power = |product: &Product| match product.factors.first() {
            Some(Factor::Difference(n)) => *n,
            _ => 0,
        };
        let common = self.0.iter().map(power).min().unwrap_or(0);
        for product in &mut self.0 {
            if let Some(Factor::Difference(n)) = product.factors.first_mut() {
                *n -= common;
            }
        }
        self
    }

    pub(crate) fn with(mut self, factor: &Factor) -> Self {
        for product in &mut self.0 {
            product.factors.push(factor.clone());
        }
        self
    }
}

/// above/below, neither with a pole in |w| ≤ 1.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Fraction {
    pub(crate) above: Sum,
    pub(crate) below: Sum,
}

impl Fraction {
    /// Of sums of products.
    pub(crate) fn new(above: Vec<Product>, below: Vec<Product>) -> Self {
        let (above, below) = (Sum(above), Sum(below));
        Self { above, below }
    }

    /// True if a memory of a fractional order takes part: one of a whole order has no modes that weigh.
    pub(crate) fn remembers(&self) -> bool {
        let products = self.above.0.iter().chain(&self.below.0);
        let mut factors = products.flat_map(|product| &product.factors);
        let is_there = |(weight, _): &(f64, f64)| *weight != 0.0;
        factors
            .any(|factor| matches!(factor, Factor::Memory(_, modes) if modes.iter().any(is_there)))
    }
}

/// Largest ratio of above to below, or of below to above, as a power of two: of two such fractions the square of the product is still a number.
const RATIO_MAX: i32 = 249;

impl Fraction {
    /// Itself, if above and below are numbers of which a loop can be made.
    ///
    /// # Errors
    /// Above and below that are more than 1e75 times apart. `what` is their ratio.
    pub(crate) fn bearable(self, what: &'static str) -> Result<Self, ControlError> {
        // A controller of nothing has no product above.
        if let (Some(above), Some(below)) = (power(&self.above), power(&self.below)) {
            let apart = above - below;
            let ratio = libm::ldexp(1.0, apart.clamp(-1022, 1023));
            let allowed = "from 1e-75 to 1e75 in size: give plant and controller in other units";
            range(what, ratio, apart.abs() <= RATIO_MAX, allowed, "")?;
        }
        Ok(self)
    }
}

/// Approximate log₂ of the largest product; `None` if all are 0.
fn power(sum: &Sum) -> Option<i32> {
    let of_numbers = |numbers: &[f64]| {
        let largest = largest(numbers);
        (largest > 0.0).then(|| libm::ilogb(largest))
    };
    let of_product = |product: &Product| {
        let first = of_numbers(&[product.scale])?;
        product.factors.iter().try_fold(first, |sum, factor| {
            // All others are about 1.
            match factor {
                Factor::InW(c) | Factor::InV(c) => Some(sum + of_numbers(c)?),
                Factor::Difference(_) | Factor::Delay(_) | Factor::Memory(..) | Factor::Law(_) => {
                    Some(sum)
                }
            }
        })
    };
    sum.0.iter().filter_map(of_product).max()
}

/// A sampled law, f = −Z·q, as a function on the unit circle, w = e^(−jθ): analytic in |w| < 1, bounded on the circle.
pub trait SampledLaw: Debug + Send + Sync {
    /// Z(e^(−jθ)).
    fn response(&self, theta: f64) -> Complex<f64>;

    /// An upper bound of ∫|dZ/dθ| dθ over \[low, high\], 0 ≤ low ≤ high ≤ π; it falls to 0 with the width.
    fn variation(&self, low: f64, high: f64) -> f64;
}

/// A law that others share.
#[derive(Clone, Debug)]
pub(crate) struct SharedLaw(pub(crate) std::sync::Arc<dyn SampledLaw>);

impl PartialEq for SharedLaw {
    fn eq(&self, other: &Self) -> bool {
        std::sync::Arc::ptr_eq(&self.0, &other.0)
    }
}
