//! Theorem 1 at one frequency.

use num_complex::Complex;

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
