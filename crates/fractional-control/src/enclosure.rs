//! Functions on the unit circle with bounds over an arc: what makes a count of encirclements a proof.
//!
//! ```text
//! |f(θ) − f(m)| ≤ (h/2)·sup|f′|   on an arc of width h about m:   the image of the arc lies in a disc
//! ```

use crate::law::SharedLaw;
use num_complex::Complex;
use std::vec::Vec;

/// An arc θ ∈ \[low, high\] of w = e^(−jθ), 0 ≤ low < high ≤ π, with what is known at its middle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arc {
    pub(crate) low: f64,
    pub(crate) high: f64,
    w: Complex<f64>,
    v: Complex<f64>,
    /// |v|² at the low end and |v| at the high end, v = 1 − w: it grows with θ.
    least_square: f64,
    most: f64,
}

impl Arc {
    pub(crate) fn new(low: f64, high: f64) -> Self {
        let (w, v) = place(0.5 * (low + high));
        let size = |theta: f64| 2.0 * libm::sin(0.5 * theta);
        Self {
            low,
            high,
            w,
            v,
            least_square: size(low) * size(low),
            most: size(high),
        }
    }

    pub(crate) fn middle(&self) -> f64 {
        0.5 * (self.low + self.high)
    }

    pub(crate) fn half_width(&self) -> f64 {
        0.5 * (self.high - self.low)
    }
}

/// w and 1 − w, both accurate near θ = 0.
fn place(theta: f64) -> (Complex<f64>, Complex<f64>) {
    let (s, c) = libm::sincos(0.5 * theta);
    (
        Complex::new((c - s) * (c + s), -2.0 * s * c),
        Complex::new(2.0 * s * s, 2.0 * s * c),
    )
}

/// A value at the middle of an arc, and bounds of the size and of the derivative on all of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Enclosed {
    pub(crate) value: Complex<f64>,
    pub(crate) size: f64,
    pub(crate) rate: f64,
}

impl Enclosed {
    pub(crate) fn new(value: Complex<f64>, rate: f64, arc: &Arc) -> Self {
        let size = value.norm() + rate * arc.half_width();
        Self { value, size, rate }
    }

    pub(crate) fn plus(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            size: self.size + other.size,
            rate: self.rate + other.rate,
        }
    }

    pub(crate) fn times(self, other: Self) -> Self {
        Self {
            value: self.value * other.value,
            size: self.size * other.size,
            rate: self.rate * other.size + self.size * other.rate,
        }
    }

    pub(crate) fn scaled(self, factor: f64) -> Self {
        Self {
            value: self.value * factor,
            size: self.size * factor.abs(),
            rate: self.rate * factor.abs(),
        }
    }
}

/// One factor of a product.
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
    /// Z of a law.
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

/// scale·Π factors.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Product {
    pub(crate) scale: f64,
    pub(crate) factors: Vec<Factor>,
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

    /// Each product with one more factor.
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
    /// True if a memory of a fractional order takes part: one of a whole order has no modes that weigh.
    pub(crate) fn remembers(&self) -> bool {
        let products = self.above.0.iter().chain(&self.below.0);
        let mut factors = products.flat_map(|product| &product.factors);
        factors.any(|factor| match factor {
            Factor::Memory(_, modes) => modes.iter().any(|(weight, _)| *weight != 0.0),
            _ => false,
        })
    }
}

/// Zeros of a function in |w| ≤ 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Count {
    /// `None` where it comes too close to 0 on the circle.
    pub(crate) zeros: Option<usize>,
    /// The least of |F| over the sum of the sizes of its terms that was met, and where.
    pub(crate) closest: f64,
    pub(crate) theta: f64,
}

/// |F| over the sizes of its terms below which it counts as 0.
const ZERO: f64 = 1e-11;
/// Arcs at most: some ten times what any loop of the tests takes.
const ARCS_MAX: usize = 200_000;

/// Counts the zeros of F in |w| ≤ 1 by the turn of its image of the upper half circle. F is real on the real axis.
///
/// ```text
/// zeros = −(1/π)·Σ arg(F(θ_{i+1})/F(θ_i)),   each arc with |F(m)| > (h/2)·sup|F′|, so that each turn is below π
/// ```
pub(crate) fn count(f: impl Fn(&Arc) -> Enclosed) -> Count {
    let at = |theta: f64| f(&Arc::new(theta, theta)).value;
    let pi = core::f64::consts::PI;
    let (mut closest, mut place) = (f64::INFINITY, 0.0);
    let (mut turn, mut theta, mut here) = (0.0, 0.0, at(0.0));
    let mut width = 1e-9;
    for _ in 0..ARCS_MAX {
        let next = if theta + width > pi {
            pi
        } else {
            theta + width
        };
        let arc = Arc::new(theta, next);
        let enclosed = f(&arc);
        let relative = enclosed.value.norm() / enclosed.size;
        if relative < closest {
            (closest, place) = (relative, 0.5 * (theta + next));
        }
        if relative.is_nan() || relative <= ZERO || width < 1e-13 {
            return Count {
                zeros: None,
                closest,
                theta: place,
            };
        }
        if enclosed.value.norm() <= 1.01 * arc.half_width() * enclosed.rate {
            width *= 0.5;
            continue;
        }
        let there = at(next);
        turn += (there / here).arg();
        (theta, here) = (next, there);
        if theta >= pi {
            let zeros = libm::round(-turn / pi);
            let whole = (zeros + turn / pi).abs() < 1e-3 && zeros >= 0.0;
            return Count {
                zeros: whole.then_some(zeros as usize),
                closest,
                theta: place,
            };
        }
        width *= 2.0;
    }
    Count {
        zeros: None,
        closest,
        theta: place,
    }
}

/// True if below + k·above is proved to be 0 nowhere on the circle, whatever k is from `low` to `high`, both above 0.
///
/// ```text
/// min over k of |d + kn| > (h/2)·(sup|d′| + high·sup|n′|)   on each arc,   the least at k = −Re(d·n̄)/|n|², or at an end
/// ```
pub(crate) fn is_clear(f: impl Fn(&Arc) -> (Enclosed, Enclosed), [low, high]: [f64; 2]) -> bool {
    let pi = core::f64::consts::PI;
    let (mut theta, mut width) = (0.0, 1e-9);
    for _ in 0..ARCS_MAX {
        let next = if theta + width > pi {
            pi
        } else {
            theta + width
        };
        let arc = Arc::new(theta, next);
        let (below, above) = f(&arc);
        let (d, n) = (below.value, above.value);
        let nearest = -(d * n.conj()).re / n.norm_sqr();
        // Where n is 0 any k will do.
        let k = if nearest > low {
            nearest.min(high)
        } else {
            low
        };
        let distance = (d + n * k).norm();
        let size = below.size + high * above.size;
        let rate = below.rate + high * above.rate;
        let is_zero = distance <= ZERO * size;
        if is_zero || distance.is_nan() || width < 1e-13 {
            return false;
        }
        if distance <= 1.01 * arc.half_width() * rate {
            width *= 0.5;
            continue;
        }
        theta = next;
        if theta >= pi {
            return true;
        }
        width *= 2.0;
    }
    false
}
