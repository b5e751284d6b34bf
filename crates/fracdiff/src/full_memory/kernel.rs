//! The two kernels a full memory can have: their weights, and the densities they are moments of.

use crate::Order;
use crate::weights::{
    grunwald_closed_form, piecewise_linear_closed_form, piecewise_linear_increment,
};
use core::f64::consts::PI;

/// What the samples are taken for, and so which weights the memory has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// Backward differences, (1 − w)^μ: what the stability and passivity formulas assume. Its error
    /// is O(T). Weights Γ(j−μ)/(Γ(−μ)Γ(j+1)).
    Grunwald,
    /// The samples joined by straight lines, differentiated exactly (Caputo L1; for integrals the
    /// product trapezoidal rule): exact for piecewise-linear input that starts from zero, for
    /// −2 ≤ μ ≤ 1. For 1 < μ ≤ 2 the L1 kernel of order μ − 1 acts on the backward difference.
    PiecewiseLinear,
}

/// The part of a kernel that modes approximate: D^φ, −1 < φ < 1, the integer part taken away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Core {
    kind: CoreKind,
    /// φ.
    pub(crate) fraction: f64,
    /// Number of differences (> 0) or accumulations (< 0) that turn the core into D^μ.
    pub(crate) integer: i32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum CoreKind {
    Grunwald,
    /// Second differences of j^(1−φ).
    Linear,
    /// Third differences of j^(1−μ): what accumulates to a piecewise-linear integral, μ < −1.
    LinearIncrement,
}

impl Core {
    pub(crate) fn new(kernel: Kernel, order: Order) -> Self {
        let (integer, fraction) = order.split();
        let kind = match kernel {
            Kernel::Grunwald => CoreKind::Grunwald,
            Kernel::PiecewiseLinear if integer >= 0 => CoreKind::Linear,
            Kernel::PiecewiseLinear => CoreKind::LinearIncrement,
        };
        Self {
            kind,
            fraction,
            integer,
        }
    }

    /// Whether the core is an integer difference or sum, so that taps alone are exact.
    pub(crate) fn is_finite(self) -> bool {
        self.fraction == 0.0
    }

    /// Number of taps without which the density does not describe the kernel.
    pub(crate) const LEAST_TAPS: usize = 4;

    /// Weight of lag j ≥ 0, to about 1e-14 relative.
    pub(crate) fn weight(self, lag: f64) -> f64 {
        let fraction = self.fraction;
        match self.kind {
            CoreKind::Grunwald => grunwald_closed_form(fraction, lag),
            CoreKind::Linear if self.is_finite() => f64::from(u8::from(lag == 0.0)),
            CoreKind::Linear => piecewise_linear_closed_form(fraction, lag),
            // r_j of the double integral, exactly: (1 + 4w + w²)/6 behind two sums.
            CoreKind::LinearIncrement if self.integer == -2 => match lag {
                0.0 | 2.0 => 1.0 / 6.0,
                1.0 => 2.0 / 3.0,
                _ => 0.0,
            },
            CoreKind::LinearIncrement => piecewise_linear_increment(fraction - 1.0, lag),
        }
    }

    /// Sign of the weights beyond the first few: −1 for a derivative, +1 for an integral.
    pub(crate) fn sign(self) -> f64 {
        if self.fraction > 0.0 { -1.0 } else { 1.0 }
    }

    /// |sin πφ|/π · s·ρ(s): the density of |`c_j`| over ln s, at s = e^u.
    pub(crate) fn density(self, s: f64) -> f64 {
        let fraction = self.fraction;
        // (2 sinh(s/2))² = e^(−s)·(e^s − 1)²
        let growth = libm::expm1(s);
        let bump = libm::exp(-s) * growth * growth;
        let density = match self.kind {
            // s·e^(φs)(1 − e^(−s))^φ
            CoreKind::Grunwald => s * libm::pow(growth, fraction),
            // s·s^(φ−2)(2 sinh(s/2))²
            CoreKind::Linear => libm::pow(s, fraction - 1.0) * bump,
            // s·s^(φ−3)(e^s − 1)(2 sinh(s/2))²
            CoreKind::LinearIncrement => libm::pow(s, fraction - 2.0) * growth * bump,
        };
        libm::sin(PI * fraction.abs()) / PI * density
    }
}
