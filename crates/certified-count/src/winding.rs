//! What a walk along the upper half of the circle has seen.

use core::f64::consts::PI;

/// Zeros of a function in |w| ≤ 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Count {
    /// `None` where it comes too close to 0 on the circle.
    pub zeros: Option<usize>,
    /// The least |F| met, relative to the size that was given with it.
    pub closest: f64,
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
    /// With the turn up to where the walk begins.
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
    pub(crate) fn counted(&self, is_proved: bool, near: f64) -> Count {
        let zeros = -self.turned / PI;
        let whole = libm::round(zeros);
        let holds = is_proved && whole >= 0.0 && (zeros - whole).abs() < near;
        Count {
            zeros: holds.then_some(whole as usize),
            closest: self.closest,
            theta: self.theta,
        }
    }
}
