//! The two kernels a full memory can have: their weights, the densities they are moments of, and the nodes of the
//! trapezoid rule over ln s that a tolerance and a horizon need.

use crate::Order;
use crate::weights::{
    grunwald_closed_form, piecewise_linear_closed_form, piecewise_linear_increment,
    piecewise_linear_slope,
};
use core::f64::consts::PI;

/// Assumed course of the signal between samples, which decides the weights of the memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Kernel {
    /// Backward differences, (1 − w)^μ: what the stability and passivity formulas assume. Its error is O(T). Weights Γ(j−μ)/(Γ(−μ)Γ(j+1)).
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

/// A decaying mode: it adds weight·e^(−j·rate) to the weight of lag j.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DecayingMode {
    /// `s_q` > 0, per sample.
    pub rate: f64,
    /// `w_q` > 0, dimensionless.
    pub weight: f64,
}

impl DecayingMode {
    /// `1 − e^(−s_q)`: the share of its state that the mode loses in a sample.
    #[must_use]
    pub fn decay(&self) -> f64 {
        -libm::expm1(-self.rate)
    }

    pub(super) fn sort(modes: &mut [Self]) {
        modes.sort_unstable_by(|a, b| b.rate.total_cmp(&a.rate));
    }
}

/// Nodes s = e^(kh) of the trapezoid rule that matter between the taps and the horizon.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    core: Core,
    pub(super) step: f64,
    /// Fastest node that still counts at the first lag after the taps.
    first: i32,
    /// Slowest node kept separately; all slower ones are lumped.
    last: i32,
}

impl Grid {
    pub(super) fn new(core: Core, taps: usize, tolerance: f64, horizon: f64, step: f64) -> Self {
        // Up to where a node adds less than a twentieth of the tolerance at the first lag after the taps.
        let lag = taps as f64;
        let negligible = 0.05 * tolerance * core.weight(lag) / step;
        // Two Gauss nodes for e^(−js) on 0 ≤ s ≤ s₀ with the density s^(−ν) miss about
        // (s₀j)^(5−ν)/4320 of the weight (remainder f⁗/4! times the squared norm of P₂).
        let lumped = libm::pow(1000.0 * tolerance, 1.0 / (4.0 + core.exponent()));
        let slowest = lumped.min(1.0) / horizon;
        let mut fastest = 40.0 / lag;
        // Next to ν = 1 no node may count: all that matters is slower than the horizon.
        while fastest > slowest && core.density(fastest) * libm::exp(-lag * fastest) < negligible {
            fastest *= 0.98;
        }
        let index = |s: f64| libm::floor(libm::log(s) / step) as i32;
        Self {
            core,
            step,
            first: index(fastest) + 1,
            last: index(slowest) + 1,
        }
    }

    /// The largest step that keeps the trapezoid error within half the tolerance.
    pub(super) fn step_for(core: Core, tolerance: f64) -> f64 {
        Self::step_of(core.exponent(), tolerance)
    }

    /// Step as by [`step_for`](Self::step_for), for a density that rises like s^exponent over ln s.
    pub(super) fn step_of(exponent: f64, tolerance: f64) -> f64 {
        // 2|Γ(x+iy)|/Γ(x) = tolerance/2, x = 1 − ν, y = 2π/h, with |Γ(x+iy)| ≈ √(2π)·y^(x−½)·e^(−πy/2)
        let scale = 4.0 * libm::sqrt(2.0 * PI) / (libm::tgamma(exponent) * tolerance);
        let mut y = 10.0;
        for _ in 0..20 {
            y = libm::fmax(
                (libm::log(scale) + (exponent - 0.5) * libm::log(y)) * 2.0 / PI,
                2.0,
            );
        }
        2.0 * PI / y
    }

    fn node(&self, index: i32) -> DecayingMode {
        let rate = libm::exp(f64::from(index) * self.step);
        DecayingMode {
            rate,
            weight: self.step * self.core.density(rate),
        }
    }

    /// All modes, fastest first: nodes one by one, then two for the rest.
    pub(super) fn modes(&self) -> impl Iterator<Item = DecayingMode> + '_ {
        let nodes = (self.last..=self.first).rev().map(|index| self.node(index));
        nodes.chain(self.lump())
    }

    /// Two modes with the moments ∫ s^m dW, m = 0..3, of all nodes slower than the last.
    fn lump(&self) -> [DecayingMode; 2] {
        // In units of the last node's rate, so that moments are of order one.
        let unit = libm::exp(f64::from(self.last) * self.step);
        let mut moments = [0.0; 4];
        let mut index = self.last - 1;
        loop {
            let DecayingMode { rate, weight } = self.node(index);
            let s = rate / unit;
            // Below 1e-18 the density is s^(1−ν) to rounding: the rest is a geometric series.
            let done = rate < 1e-18;
            let mut term = weight;
            for (m, moment) in moments.iter_mut().enumerate() {
                let exponent = self.core.exponent() + m as f64;
                let tail = -libm::expm1(-self.step * exponent);
                *moment += if done { term / tail } else { term };
                term *= s;
            }
            if done {
                break;
            }
            index -= 1;
        }
        gauss_pair(moments).map(|DecayingMode { rate, weight }| DecayingMode {
            rate: rate * unit,
            weight,
        })
    }
}

/// The two-node Gauss rule with the moments m₀ to m₃, faster node first.
///
/// The nodes are the roots of the orthogonal polynomial s² − p·s + q
/// (W. Gautschi, *Orthogonal Polynomials: Computation and Approximation*, 2004, §1.4).
pub(super) fn gauss_pair([m0, m1, m2, m3]: [f64; 4]) -> [DecayingMode; 2] {
    let determinant = m0 * m2 - m1 * m1;
    let p = (m0 * m3 - m1 * m2) / determinant;
    let q = (m1 * m3 - m2 * m2) / determinant;
    let fast = 0.5 * (p + libm::sqrt(p * p - 4.0 * q));
    let slow = q / fast;
    let weight = (m1 - slow * m0) / (fast - slow);
    [
        DecayingMode { rate: fast, weight },
        DecayingMode {
            rate: slow,
            weight: m0 - weight,
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Poisson's sum of ∫ s^x·e^(−s) d ln s errs by 2|Γ(x + iy)|/Γ(x), y = 2π/h, where |Γ(½ + iy)|² = π/cosh(πy)
    /// and |Γ(1 + iy)|² = πy/sinh(πy).
    #[test]
    fn a_step_errs_by_half_its_tolerance() {
        for tolerance in [1e-3, 1e-6, 1e-9] {
            let y = |exponent| 2.0 * PI / Grid::step_of(exponent, tolerance);
            let [half, one] = [y(0.5), y(1.0)];
            let errors = [
                2.0 * libm::sqrt(1.0 / libm::cosh(PI * half)),
                2.0 * libm::sqrt(PI * one / libm::sinh(PI * one)),
            ];
            for error in errors {
                assert!((2.0 * error / tolerance - 1.0).abs() < 1e-6, "{tolerance}");
            }
        }
    }
}
