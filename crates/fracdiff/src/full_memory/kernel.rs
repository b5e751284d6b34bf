//! The two kernels a full memory can have: their weights, and the densities they are moments of.

use crate::Order;
use crate::weights::{
    grunwald_closed_form, piecewise_linear_closed_form, piecewise_linear_increment,
    piecewise_linear_slope,
};
use core::f64::consts::PI;

/// The signal that the samples stand for, which decides the weights of the memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Kernel {
    /// Backward differences, (1 − w)^μ: what the stability and passivity formulas assume. Its error
    /// is O(T). Weights Γ(j−μ)/(Γ(−μ)Γ(j+1)).
    Grunwald,
    /// The samples joined by straight lines, differentiated exactly (Caputo L1; for integrals the
    /// product trapezoidal rule): exact for piecewise-linear input that starts from zero, for
    /// −2 ≤ μ ≤ 1. For 1 < μ ≤ 2 the L1 kernel of order μ − 1 acts on the backward difference.
    PiecewiseLinear,
}

/// The part of a kernel that modes approximate: a fractional integral of order ν, 0 ≤ ν < 1, with the integer
/// part ⌈μ⌉ = μ + ν taken away. All its weights are positive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Core {
    kind: CoreKind,
    /// ν.
    integral: f64,
    /// Number of differences (> 0) or accumulations (< 0) that turn the core into D^μ.
    pub(crate) integer: i32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum CoreKind {
    Grunwald,
    /// First differences of j^ν: what the increments meet in the L1 kernel, μ > 0.
    LinearSlope,
    /// Second differences of j^(1+ν): the product trapezoidal rule, −1 < μ ≤ 0.
    Linear,
    /// Third differences of j^(1−μ): what accumulates to a piecewise-linear integral, μ < −1.
    LinearIncrement,
}

impl Core {
    pub(crate) fn new(kernel: Kernel, order: Order) -> Self {
        let (integer, integral) = order.split_up();
        let kind = match kernel {
            Kernel::Grunwald => CoreKind::Grunwald,
            Kernel::PiecewiseLinear if integer > 0 => CoreKind::LinearSlope,
            Kernel::PiecewiseLinear if integer == 0 => CoreKind::Linear,
            Kernel::PiecewiseLinear => CoreKind::LinearIncrement,
        };
        Self {
            kind,
            integral,
            integer,
        }
    }

    /// True if the core is an integer difference or sum, so that taps alone are exact.
    pub(crate) fn is_finite(self) -> bool {
        self.integral == 0.0
    }

    /// 1 − ν > 0: the weights fall like j^(ν−1), the density rises like s^(1−ν) over ln s.
    pub(crate) fn exponent(self) -> f64 {
        1.0 - self.integral
    }

    /// Number of taps without which the density does not describe the kernel.
    const LEAST_TAPS: usize = 4;

    /// Does not compile for fewer.
    pub(crate) const fn check_taps<const TAPS: usize>() {
        const {
            assert!(
                TAPS >= Core::LEAST_TAPS,
                "a full memory has at least 4 taps"
            );
        };
    }

    /// Weight of lag j ≥ 0, to about 1e-14 relative.
    pub(crate) fn weight(self, lag: f64) -> f64 {
        let integral = self.integral;
        match self.kind {
            CoreKind::Grunwald => grunwald_closed_form(-integral, lag),
            CoreKind::Linear | CoreKind::LinearSlope if self.is_finite() => {
                f64::from(u8::from(lag == 0.0))
            }
            CoreKind::LinearSlope => piecewise_linear_slope(integral, lag),
            CoreKind::Linear => piecewise_linear_closed_form(-integral, lag),
            // r_j of the double integral, exactly: (1 + 4w + w²)/6 behind two sums.
            CoreKind::LinearIncrement if self.integer == -2 => match lag {
                0.0 | 2.0 => 1.0 / 6.0,
                1.0 => 2.0 / 3.0,
                _ => 0.0,
            },
            CoreKind::LinearIncrement => piecewise_linear_increment(-1.0 - integral, lag),
        }
    }

    /// (sin πν/π)·s·ρ(s): the density of `c_j` over ln s, at s = e^u.
    pub(crate) fn density(self, s: f64) -> f64 {
        let integral = self.integral;
        // (2 sinh(s/2))² = e^(−s)·(e^s − 1)²
        let growth = libm::expm1(s);
        let bump = libm::exp(-s) * growth * growth;
        let density = match self.kind {
            // s·(e^s − 1)^(−ν)
            CoreKind::Grunwald => s * libm::pow(growth, -integral),
            // s·s^(−1−ν)(1 − e^(−s))
            CoreKind::LinearSlope => -libm::pow(s, -integral) * libm::expm1(-s),
            // s·s^(−2−ν)(2 sinh(s/2))²
            CoreKind::Linear => libm::pow(s, -1.0 - integral) * bump,
            // s·s^(−3−ν)(e^s − 1)(2 sinh(s/2))²
            CoreKind::LinearIncrement => libm::pow(s, -2.0 - integral) * growth * bump,
        };
        // sin πν = sin π(1 − ν), and 1 − ν is exact where ν is near 1.
        let angle = libm::fmin(integral, self.exponent());
        libm::sin(PI * angle) / PI * density
    }
}
