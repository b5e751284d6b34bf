//! A place on the upper half circle, and what a walk along it has seen.

use core::f64::consts::PI;
use num_complex::Complex;

/// A place on the circle: w = e^(−jθ) and v = 1 − w, both accurate near θ = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The angle θ, rad, that the other numbers were computed from.
    pub theta: f64,
    /// w = e^(−jθ), the delay by one sample.
    pub w: Complex<f64>,
    /// v = 1 − w, computed without cancellation near θ = 0.
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

/// The verdict on a loop, stable or not, by the zeros of its characteristic function F in |w| ≤ 1, with its distance from the edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StabilityVerdict {
    /// No zero of F in |w| ≤ 1. Not so on the boundary, where `unstable_poles` is `None`.
    pub stable: bool,
    /// Zeros of F in |w| < 1, each a pole with |z| > 1; `None` on the boundary, where F comes too close to 0 on the circle to tell.
    pub unstable_poles: Option<usize>,
    /// The least |F| met on the circle, relative to the size that is given with it.
    pub distance: f64,
    /// The angle at which that was, rad/sample.
    pub theta: f64,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Winding {
    /// The turn of F so far, rad.
    pub(crate) turned: f64,
    closest: f64,
    theta: f64,
}

impl Winding {
    /// Winding with the turn up to where the walk begins.
    pub(crate) const fn new(turned: f64) -> Self {
        Self {
            turned,
            closest: f64::INFINITY,
            theta: 0.0,
        }
    }

    pub(crate) fn meets(&mut self, size: f64, theta: f64) {
        if size < self.closest {
            (self.closest, self.theta) = (size, theta);
        }
    }

    /// The zeros, if the whole walk was proved and they are this near to a whole number: rounding errors turn F by less.
    pub(crate) fn counted(&self, is_proved: bool, near: f64) -> StabilityVerdict {
        let zeros = -self.turned / PI;
        let whole = libm::round(zeros);
        let holds = is_proved && whole >= 0.0 && (zeros - whole).abs() < near;
        StabilityVerdict {
            stable: holds && whole == 0.0,
            unstable_poles: holds.then_some(whole as usize),
            distance: self.closest,
            theta: self.theta,
        }
    }
}
