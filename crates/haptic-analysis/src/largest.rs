//! The largest value of one parameter of a condition that is linear in it at every frequency.

use crate::AnalysisError;
use crate::extremum::Maximum;
use crate::transparency::finite;
use num_complex::Complex;

/// The largest value of a parameter at which the loop is passive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Largest {
    /// The loop is passive just below `value` and not from there on. (With a delay it may cease to be
    /// passive again far below: then the parameter helps at another frequency.)
    Below {
        /// The supremum; not passive itself, since Theorem 1 is strict.
        value: f64,
        /// θ that stops it, rad/sample.
        worst_theta: f64,
    },
    /// Passive for any value: no frequency sets a limit.
    Any,
    /// Passive for none, not even 0.
    Empty,
}

impl Largest {
    pub(crate) fn times(self, factor: f64) -> Result<Self, AnalysisError> {
        let Self::Below { value, worst_theta } = self else {
            return Ok(self);
        };
        let value = finite("largest value", value * factor, "")?;
        Ok(Self::Below { value, worst_theta })
    }
}

/// Largest x with sup over θ of f(θ, x) = δ, each f convex in x; where f = x·p + q, inf of (δ − q)/p, p > 0.
///
/// The supremum is a convex function of x, so Newton's method from above falls monotonically to its largest root, and no pole of the
/// quotient is ever searched. `supremum(x)` finds it, `steepest` is that of the slopes p for large x, and `tangent(θ, x)` is the line (p,
/// q) that touches f there, or its asymptote for an infinite x.
pub(crate) fn largest(
    delta: f64,
    supremum: impl Fn(f64) -> Result<Maximum, AnalysisError>,
    steepest: Maximum,
    tangent: impl Fn(f64, f64) -> (f64, f64),
) -> Result<Largest, AnalysisError> {
    if steepest.value <= 0.0 {
        // p ≤ 0 everywhere: more of x never hurts, and helps where p < 0.
        const HUGE: f64 = 1e12;
        let free = supremum(HUGE * (1.0 + delta))?.value < delta;
        return Ok(if free { Largest::Any } else { Largest::Empty });
    }
    let mut worst_theta = steepest.theta;
    let (mut slope, mut given) = tangent(worst_theta, f64::INFINITY);
    let mut start = 1.0 + delta;
    while given == f64::NEG_INFINITY && start < f64::MAX / 16.0 {
        // q has no bound where p is steepest: start right of the largest root instead.
        start *= 16.0;
        let worst = supremum(start)?;
        let at_worst = tangent(worst.theta, start);
        if worst.value >= delta && at_worst.0 > 0.0 {
            (worst_theta, (slope, given)) = (worst.theta, at_worst);
        }
    }
    let mut value = f64::INFINITY;
    for _ in 0..100 {
        // The frequency θ alone reaches δ at x = (δ − q)/p.
        let next = (delta - given) / slope;
        if slope <= 0.0 || next <= 0.0 {
            // At the point where the tangent from above meets δ, the supremum has passed its minimum, or x is
            // negative: no x ≥ 0 is passive.
            return Ok(Largest::Empty);
        }
        if next >= value * (1.0 - 1e-14) {
            break;
        }
        value = next;
        worst_theta = supremum(value)?.theta;
        (slope, given) = tangent(worst_theta, value);
    }
    finite("largest value", value, "")?;
    Ok(Largest::Below { value, worst_theta })
}

/// Theorem 1 at one frequency.
#[derive(Clone, Copy, Debug)]
pub(crate) struct At {
    /// Re{(1 − w)M}/|1 − w|² and Re{(1 − w)MP}/|1 − w|².
    pub(crate) u: f64,
    pub(crate) v: f64,
    pub(crate) p: Complex<f64>,
    /// V/|1 − w|².
    pub(crate) spread: f64,
}

impl At {
    /// δ = (r + √(r² + s|q|²))/2,   r = αu + βv,  q = α + βP,  s = V/|1 − w|²
    pub(crate) fn needed(&self, alpha: f64, beta: f64) -> f64 {
        let r = weighted(alpha, self.u) + weighted(beta, self.v);
        if self.spread == 0.0 {
            return r;
        }
        let p = if beta > 0.0 {
            self.p * beta
        } else {
            0.0.into()
        };
        larger_root(r, self.spread * (p + alpha).norm_sqr())
    }

    /// Slope and value at 0 of the tangent of δ at `x`, for r = x·r₁ + `given`·r₂ and q = x·q₁ + `given`·q₂;
    /// of the asymptote for an infinite x.
    pub(crate) fn tangent(
        &self,
        [(r1, q1), (r2, q2)]: [(f64, Complex<f64>); 2],
        x: f64,
        given: f64,
    ) -> (f64, f64) {
        let rest = weighted(given, r2);
        if self.spread == 0.0 {
            return (r1, rest);
        }
        // ρ² = x²A + 2xC + …,  A = r₁² + s|q₁|²,  C = r₁r₀ + s·Re(q₁·q₀*),  r₀ and q₀ without x
        let other = if given > 0.0 { q2 * given } else { 0.0.into() };
        let squared = r1 * r1 + self.spread * q1.norm_sqr();
        let cross = r1 * rest + self.spread * (q1 * other.conj()).re;
        if x.is_infinite() {
            let root = libm::sqrt(squared);
            let mixed = if root > 0.0 { cross / root } else { 0.0 };
            return (0.5 * (r1 + root), 0.5 * (rest + mixed));
        }
        let r = x * r1 + rest;
        let square = self.spread * (q1 * x + other).norm_sqr();
        let root = libm::sqrt(r * r + square);
        let value = larger_root(r, square);
        let slope = if root > 0.0 && root.is_finite() {
            0.5 * (r1 + (x * squared + cross) / root)
        } else {
            0.0
        };
        (slope, value - x * slope)
    }
}

/// (r + √(r² + square))/2 without cancellation.
fn larger_root(r: f64, square: f64) -> f64 {
    let root = libm::sqrt(r * r + square);
    if r >= 0.0 {
        0.5 * (r + root)
    } else if root.is_infinite() {
        0.0
    } else {
        0.5 * square / (root - r)
    }
}

/// factor·x, 0 for the factor 0 whatever x.
fn weighted(factor: f64, x: f64) -> f64 {
    if factor > 0.0 { factor * x } else { 0.0 }
}
