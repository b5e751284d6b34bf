//! The nodes of the trapezoid rule over ln s: which modes a tolerance and a horizon need.

use super::kernel::Core;
use super::mode::Mode;
use core::f64::consts::PI;

/// Nodes s = e^(kh) of the trapezoid rule that matter between the taps and the horizon.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    core: Core,
    pub(super) step: f64,
    /// Fastest node that still counts at the first lag after the taps.
    first: i32,
    /// Slowest node kept by itself; all slower ones are lumped.
    last: i32,
}

impl Grid {
    pub(super) fn new(core: Core, taps: usize, tolerance: f64, horizon: f64, step: f64) -> Self {
        // Up to where a node adds less than a twentieth of the tolerance at the first lag after
        // the taps.
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

    /// The same for a density that rises like s^exponent over ln s.
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

    fn node(&self, index: i32) -> Mode {
        let rate = libm::exp(f64::from(index) * self.step);
        Mode {
            rate,
            weight: self.step * self.core.density(rate),
        }
    }

    /// All modes, fastest first: nodes one by one, then two for the rest.
    pub(super) fn modes(&self) -> impl Iterator<Item = Mode> + '_ {
        let nodes = (self.last..=self.first).rev().map(|index| self.node(index));
        nodes.chain(self.lump())
    }

    /// Two modes with the moments ∫ s^m dW, m = 0..3, of all nodes slower than the last.
    fn lump(&self) -> [Mode; 2] {
        // In units of the last node's rate, so that moments are of order one.
        let unit = libm::exp(f64::from(self.last) * self.step);
        let mut moments = [0.0; 4];
        let mut index = self.last - 1;
        loop {
            let Mode { rate, weight } = self.node(index);
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
        gauss_pair(moments).map(|Mode { rate, weight }| Mode {
            rate: rate * unit,
            weight,
        })
    }
}

/// The two-node Gauss rule with the moments m₀ to m₃, faster node first.
///
/// The nodes are the roots of the orthogonal polynomial s² − p·s + q
/// (W. Gautschi, *Orthogonal Polynomials: Computation and Approximation*, 2004, §1.4).
pub(super) fn gauss_pair([m0, m1, m2, m3]: [f64; 4]) -> [Mode; 2] {
    let determinant = m0 * m2 - m1 * m1;
    let p = (m0 * m3 - m1 * m2) / determinant;
    let q = (m1 * m3 - m2 * m2) / determinant;
    let fast = 0.5 * (p + libm::sqrt(p * p - 4.0 * q));
    let slow = q / fast;
    let weight = (m1 - slow * m0) / (fast - slow);
    [
        Mode { rate: fast, weight },
        Mode {
            rate: slow,
            weight: m0 - weight,
        },
    ]
}
