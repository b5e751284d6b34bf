//! Sums of products as functions on the unit circle, enclosed on an arc, so that a count of their zeros is a proof.

use crate::{ControlError, records::largest};
use certified_count::{Arc, Enclosed, Enclosing, Jet};
use core::{fmt::Debug, ops::SubAssign};
use fracdiff::parameter::range;
use num_complex::Complex;
use std::vec::Vec;

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Factor {
    /// `Σ c_j w^j`.
    InW(Vec<f64>),
    /// `Σ c_k v^k`, v = 1 − w.
    InV(Vec<f64>),
    /// v^n; an n below 0 sums.
    Difference(i32),
    /// w^d, a delay by d samples.
    Delay(usize),
    /// `Σ k_j w^j + Σ W_q/(1 − r_q w)`: taps, and `W_q` with `1 − r_q`.
    Memory(Vec<f64>, Vec<(f64, f64)>),
    Law(SharedLaw),
}

/// Σ `c_k` x^k and its derivative by x.
fn horner(coefficients: &[f64], x: Complex<f64>) -> (Complex<f64>, Complex<f64>) {
    let zero = Complex::new(0.0, 0.0);
    let terms = coefficients.iter().rev();
    terms.fold((zero, zero), |(value, slope), c| {
        (value * x + c, slope * x + value)
    })
}

/// `Σ k|c_k|·most^(k−1)` and `Σ k(k−1)|c_k|·most^(k−2)`
fn slopes(coefficients: &[f64], most: f64) -> (f64, f64) {
    let sizes: (f64, f64, f64) =
        coefficients
            .iter()
            .rev()
            .fold((0.0, 0.0, 0.0), |(value, slope, curl), c| {
                (
                    value * most + c.abs(),
                    slope * most + value,
                    curl * most + 2.0 * slope,
                )
            });
    (sizes.1, sizes.2)
}

/// dw/dθ = −jw, dv/dθ = jw
const TURN: Complex<f64> = Complex::new(0.0, -1.0);

/// Polynomial in powers of v, or of w with its size of 1.
fn polynomial(
    coefficients: &[f64],
    x: Complex<f64>,
    turn: Complex<f64>,
    most: f64,
    arc: &Arc,
) -> Enclosed {
    let (value, slope) = horner(coefficients, x);
    let (rate, curl) = slopes(coefficients, most);
    Enclosed::bent(Jet::new(value, slope * turn), rate, rate + curl, arc)
}

impl Factor {
    pub(crate) fn at(&self, arc: &Arc) -> Enclosed {
        let turn = arc.w * TURN;
        match self {
            Self::InW(c) => polynomial(c, arc.w, turn, 1.0, arc),
            Self::InV(c) => polynomial(c, arc.v, -turn, arc.most, arc),
            Self::Difference(n) => {
                let power = |less: i32| {
                    let factor: i32 = (0..less).map(|k| n - k).product();
                    match factor {
                        0 => 0.0,
                        _ => f64::from(factor) * libm::pow(arc.most, f64::from(n - less)),
                    }
                };
                let slope = match n {
                    0 => Complex::new(0.0, 0.0),
                    _ => arc.v.powi(n - 1) * f64::from(*n) * -turn,
                };
                let rate = power(1);
                Enclosed::bent(Jet::new(arc.v.powi(*n), slope), rate, rate + power(2), arc)
            }
            Self::Delay(d) => {
                let d = *d as f64;
                let (sin, cos) = libm::sincos(d * arc.middle());
                let value = Complex::new(cos, -sin);
                Enclosed::bent(Jet::new(value, value * TURN * d), d, d * d, arc)
            }
            Self::Memory(taps, modes) => {
                let Enclosed {
                    mut middle,
                    mut rate,
                    mut bend,
                    ..
                } = polynomial(taps, arc.w, turn, 1.0, arc);
                for &(weight, decay) in modes {
                    // 1 − rw = d + rv, |1 − rw|² = d² + r|v|²
                    let r = 1.0 - decay;
                    let least = decay * decay + r * arc.least_square;
                    let mode = (arc.v * r + decay).inv();
                    middle.value += mode * weight;
                    middle.rate += mode * mode * turn * (r * weight);
                    let steep = weight.abs() * r / least;
                    rate += steep;
                    bend += steep * (1.0 + 2.0 * r / libm::sqrt(least));
                }
                Enclosed::bent(middle, rate, bend, arc)
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
    pub scale: f64,
    pub factors: Vec<Factor>,
}

impl Product {
    pub(crate) const fn new(scale: f64, factors: Vec<Factor>) -> Self {
        Self { scale, factors }
    }
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sum(pub Vec<Product>);

impl Sum {
    pub(crate) fn at(&self, arc: &Arc) -> Enclosed {
        let one = Enclosed::bent(Jet::ONE, 0.0, 0.0, arc);
        let nothing = one.scaled(0.0);
        self.0.iter().fold(nothing, |sum, product| {
            let factors = product.factors.iter();
            let value = factors.fold(one, |value, factor| value.times(factor.at(arc)));
            sum.plus(value.scaled(product.scale))
        })
    }

    /// Sum without the power of v that all products have in common.
    pub(crate) fn without_differences(self) -> Self {
        self.without_common(|product| match product.factors.first_mut() {
            Some(Factor::Difference(n)) => Some(n),
            _ => None,
        })
    }

    /// Sum without the whole samples of dead time with which all products end.
    pub(crate) fn prompt(self) -> Self {
        self.without_common(|product| match product.factors.last_mut() {
            Some(Factor::Delay(samples)) => Some(samples),
            _ => None,
        })
    }

    /// Sum without the least of these powers, 0 for a product that has none.
    fn without_common<N: Copy + Default + Ord + SubAssign>(
        mut self,
        power: fn(&mut Product) -> Option<&mut N>,
    ) -> Self {
        let all = self.0.iter_mut();
        let common = all.map(|product| power(product).map_or(N::default(), |n| *n));
        let common = common.min().unwrap_or_default();
        let all = self.0.iter_mut();
        all.filter_map(power).for_each(|n| *n -= common);
        self
    }

    pub(crate) fn with(mut self, factor: &Factor) -> Self {
        for product in &mut self.0 {
            product.factors.push(factor.clone());
        }
        self
    }
}

impl Enclosing for Sum {
    fn at(&self, arc: &Arc) -> Enclosed {
        self.at(arc)
    }
}

/// above/below, neither with a pole in |w| ≤ 1.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Fraction {
    pub above: Sum,
    pub below: Sum,
}

impl Fraction {
    /// Fraction of two sums of products.
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
    /// Z at w = e^(−jθ), θ in rad/sample.
    fn response(&self, theta: f64) -> Complex<f64>;

    /// An upper bound of ∫|dZ/dθ| dθ over \[low, high\], 0 ≤ low ≤ high ≤ π; it falls to 0 with the width.
    fn variation(&self, low: f64, high: f64) -> f64;
}

/// A law that others share.
#[derive(Clone, Debug)]
pub(crate) struct SharedLaw(pub std::sync::Arc<dyn SampledLaw>);

impl PartialEq for SharedLaw {
    fn eq(&self, other: &Self) -> bool {
        std::sync::Arc::ptr_eq(&self.0, &other.0)
    }
}
