//! A place on the unit circle.

use num_complex::Complex;

/// A place on the circle: w = e^(−jθ) and v = 1 − w, both accurate near θ = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// θ.
    pub theta: f64,
    /// w.
    pub w: Complex<f64>,
    /// v.
    pub v: Complex<f64>,
    /// |v| = 2 sin(θ/2).
    pub size_v: f64,
    /// 2 cos(θ/2) = |1 + w|.
    pub size_u: f64,
}

impl Place {
    /// 0 ≤ θ ≤ π.
    #[must_use]
    pub fn new(theta: f64) -> Self {
        let (s, c) = libm::sincos(0.5 * theta);
        // w = (c − js)², v = 2s(s + jc)
        Self {
            theta,
            w: Complex::new((c - s) * (c + s), -2.0 * s * c),
            v: Complex::new(2.0 * s * s, 2.0 * s * c),
            size_v: 2.0 * s,
            size_u: 2.0 * c,
        }
    }
}
