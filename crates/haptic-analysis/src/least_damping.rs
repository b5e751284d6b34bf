//! Least device damping of a coupled port: the supremum of Llewellyn's third condition over θ, and
//! the cases that have none.

use crate::extremum::{Grid, Maximum};
use crate::transparency::finite;
use crate::{AnalysisError, ForcePath};
use fracdiff::FrequencyResponse;
use num_complex::Complex;
use std::f64::consts::PI;

/// Device damping that makes the coupled port passive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LeastDamping {
    /// Passive from this damping on, itself included.
    Enough {
        /// Least b, N·s/m.
        damping_n_s_per_m: f64,
        /// θ that asks for it, rad/sample; 0 for a limit.
        worst_theta: f64,
    },
    /// `Re(1/Z_c)` is not positive at a frequency where the hold takes energy: no b is enough.
    NoneIsEnough {
        /// Such a θ, rad/sample.
        theta: f64,
    },
}

impl LeastDamping {
    /// In another unit.
    pub(crate) fn times(self, scale: f64) -> Result<Self, AnalysisError> {
        Ok(match self {
            Self::Enough {
                damping_n_s_per_m,
                worst_theta,
            } => Self::Enough {
                damping_n_s_per_m: finite("least damping", damping_n_s_per_m * scale, "N·s/m")?,
                worst_theta,
            },
            none => none,
        })
    }
}

/// With `b_c` = 0: b = `k_c`·h/2, and h is largest, 1/4, at cos(θ/2) = 1/2.
const WITHOUT_DISSIPATION: LeastDamping = LeastDamping::Enough {
    damping_n_s_per_m: 0.125,
    worst_theta: 2.0 * PI / 3.0,
};

/// `k_c` and `b_c·T^μ` as parts of their sum.
#[derive(Clone, Copy)]
pub(crate) struct Shares {
    /// `k_c`.
    pub(crate) stiffness: f64,
    /// `b_c·T^μ`.
    pub(crate) dissipation: f64,
}

impl Shares {
    /// |Z|²·|P|²·Re(1/Z) = k|P|² + g·Re P, k the one share and g the other: has the sign of Re(1/Z).
    fn real_part(self, p: Complex<f64>) -> f64 {
        self.stiffness * p.norm_sqr() + self.dissipation * p.re
    }

    /// h/(2 Re(1/Z)) = h·|kP + g|²/(2(k|P|² + g·Re P)).
    fn damping(self, hold: f64, p: Complex<f64>) -> f64 {
        0.5 * hold * (p * self.stiffness + self.dissipation).norm_sqr() / self.real_part(p)
    }

    /// For (1 − w)^μ, in closed form.
    pub(crate) fn least_of_exact(self, mu: f64) -> Result<LeastDamping, AnalysisError> {
        if self.dissipation == 0.0 {
            return Ok(WITHOUT_DISSIPATION);
        }
        if mu > 1.0 {
            // cos(μ(π−θ)/2) ≤ −sin(π(μ−1)/4) up to θ = π(μ−1)/(2μ), and k|P| ≤ k·θ^μ is less than g
            // times that up to the second bound: Re(1/Z) < 0 there and at every lower frequency.
            let cosine = libm::sin(0.25 * PI * (mu - 1.0));
            let phase_bound = 0.5 * PI * (mu - 1.0) / mu;
            let size_bound = 0.5 * libm::pow(self.dissipation * cosine / self.stiffness, 1.0 / mu);
            return Ok(LeastDamping::NoneIsEnough {
                theta: phase_bound.min(size_bound).max(f64::MIN_POSITIVE),
            });
        }
        // θ → 0: h → θ²/8, |P| → θ^μ, so 0 for μ < 1; for μ = 1 Re P → θ²/2.
        let at_zero = if mu < 1.0 {
            0.0
        } else {
            self.dissipation * self.dissipation / (8.0 * (2.0 * self.stiffness + self.dissipation))
        };
        let value = |theta: f64| self.damping(hold(theta), exact(mu, theta));
        enough(Grid::new(1).maximum(at_zero, value))
    }

    /// For another operator, with the rounding of Re P in mind: an operator sums its coefficients, so
    /// where Re P cancels it is off by about `NOISE`.
    pub(crate) fn least_of(
        self,
        operator: &dyn FrequencyResponse,
        memory: usize,
        hold: &dyn Hold,
    ) -> Result<LeastDamping, AnalysisError> {
        const NOISE: f64 = 1e-15;
        /// Accepted relative error of Re(1/Z) from rounding.
        const RESOLVED: f64 = 1e-10;
        let grid = Grid::new(memory + hold.ripple());
        if self.dissipation == 0.0 {
            return match hold.of_damper() {
                Some(known) => Ok(known),
                None => enough(grid.maximum(0.0, |theta| 0.5 * hold.at(theta))),
            };
        }
        // Below this θ a value that rounding spoils is left out, and the limit extrapolated.
        let low = hold.low();
        let noise = |p: Complex<f64>| NOISE * self.dissipation * p.norm().max(1.0);
        // Re(1/Z) < 0 beyond rounding: no damping.
        let negative = grid.maximum(f64::NEG_INFINITY, |theta| {
            let p = operator.response(theta);
            -self.real_part(p) - 10.0 * noise(p)
        });
        match negative {
            None => return enough(None),
            Some(worst) if worst.value > 0.0 => {
                return Ok(LeastDamping::NoneIsEnough { theta: worst.theta });
            }
            Some(_) => {}
        }
        let resolved = |theta: f64, p: Complex<f64>| {
            theta >= low || (hold.is_exact() && noise(p) <= RESOLVED * self.real_part(p))
        };
        let value = |theta: f64| {
            let p = operator.response(theta);
            if !resolved(theta, p) {
                f64::NEG_INFINITY
            } else if self.real_part(p) <= 10.0 * noise(p) && hold.at(theta) > 0.0 {
                f64::INFINITY
            } else {
                self.damping(hold.at(theta), p)
            }
        };
        let thetas = grid.thetas();
        let unresolved = |theta: &f64| !resolved(*theta, operator.response(*theta));
        let at_zero = match thetas.iter().rposition(unresolved) {
            Some(last) => limit_at_rest(thetas[last + 1], value),
            None => f64::NEG_INFINITY,
        };
        let found = grid.maximum(at_zero, value);
        match found {
            Some(worst) if worst.value == f64::INFINITY => {
                Ok(LeastDamping::NoneIsEnough { theta: worst.theta })
            }
            found => enough(found),
        }
    }
}

/// Value at 0 of an even analytic function known from θ = `first` on; −∞ if it does not look like one.
fn limit_at_rest(first: f64, value: impl Fn(f64) -> f64) -> f64 {
    let thetas = [1.0, 4.0 / 3.0, 5.0 / 3.0, 2.0].map(|ratio| ratio * first);
    let values = thetas.map(value);
    // Lagrange in θ², at θ = 0, through the first three and through all four.
    let through = |count: usize| -> f64 {
        let term = |i: usize| {
            let others = (0..count).filter(|&j| j != i);
            others.fold(values[i], |product, j| {
                let ratio = thetas[i] / thetas[j];
                product / (1.0 - ratio * ratio)
            })
        };
        (0..count).map(term).sum()
    };
    let (three, four) = (through(3), through(4));
    if libm::fabs(three - four) <= 1e-7 * libm::fabs(four) {
        four
    } else {
        f64::NEG_INFINITY
    }
}

fn enough(found: Option<Maximum>) -> Result<LeastDamping, AnalysisError> {
    let (value, theta) = found.map_or((f64::NAN, 0.0), |worst| (worst.value, worst.theta));
    Ok(LeastDamping::Enough {
        damping_n_s_per_m: finite("least damping", value, "N·s/m")?,
        worst_theta: theta,
    })
}

/// h, the energy that the hold can take at a frequency, as a share of the largest.
pub(crate) trait Hold {
    /// h(θ), at least 0.
    fn at(&self, theta: f64) -> f64;
    /// Samples in which it may ripple.
    fn ripple(&self) -> usize;
    /// θ from which on values are right to rounding.
    fn low(&self) -> f64;
    /// True if h keeps its digits below that, too.
    fn is_exact(&self) -> bool;
    /// The least damping of a pure damper of 1 N·s/m, if it is known.
    fn of_damper(&self) -> Option<LeastDamping>;
}

/// The dissertation's device under Tustin's rule.
pub(crate) struct TustinHold;

impl Hold for TustinHold {
    fn at(&self, theta: f64) -> f64 {
        // 0 at π itself, where the cosine of the nearest number is not.
        if theta < PI { hold(theta) } else { 0.0 }
    }

    fn ripple(&self) -> usize {
        0
    }

    fn low(&self) -> f64 {
        0.05
    }

    fn is_exact(&self) -> bool {
        true
    }

    fn of_damper(&self) -> Option<LeastDamping> {
        Some(WITHOUT_DISSIPATION)
    }
}

/// A force that is really held, late and lagging.
pub(crate) struct SampledHold(pub(crate) ForcePath);

impl Hold for SampledHold {
    fn at(&self, theta: f64) -> f64 {
        if self.0.is_whole() {
            // 1 − cos((d + 1)θ)
            let turn = libm::sin(0.5 * (self.0.whole_samples() + 1) as f64 * theta);
            return 2.0 * turn * turn;
        }
        // √(|M|² + V) − Re(wM)
        let profile = self.0.profile(theta);
        let (sin, cos) = libm::sincos(theta);
        let square = 2.0 * (1.0 - cos) * profile.spread;
        let late = Complex::new(cos, -sin) * profile.mean;
        (libm::sqrt(profile.mean.norm_sqr() + square) - late.re).max(0.0)
    }

    fn ripple(&self) -> usize {
        self.0.whole_samples() + 2
    }

    fn low(&self) -> f64 {
        0.05 / (1.0 + self.0.mean_delay())
    }

    fn is_exact(&self) -> bool {
        self.0.is_whole()
    }

    fn of_damper(&self) -> Option<LeastDamping> {
        None
    }
}

/// |p₁₂p₂₁| + Re(p₁₂p₂₁) = cos(θ/2)(1 − cos(θ/2)) = cos(θ/2)·2 sin²(θ/4).
pub(crate) fn hold(theta: f64) -> f64 {
    let quarter = libm::sin(0.25 * theta);
    2.0 * quarter * quarter * libm::cos(0.5 * theta)
}

/// (1 − w)^μ with cos(μ(π−θ)/2) as sin((π(1−μ) + μθ)/2): the real part keeps its digits where μ is
/// near 1 and θ near 0, which decide here.
pub(crate) fn exact(mu: f64, theta: f64) -> Complex<f64> {
    let magnitude = libm::pow(2.0 * libm::sin(0.5 * theta), mu);
    let real = libm::sin(0.5 * (PI * (1.0 - mu) + mu * theta));
    let imaginary = libm::sin(0.5 * mu * (PI - theta));
    Complex::new(magnitude * real, magnitude * imaginary)
}
