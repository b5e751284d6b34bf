//! The virtual coupler as a two port: Corollary 2, and the least device damping by Llewellyn's conditions.

use crate::extremum::{Grid, Maximum};
use crate::transparency::finite;
use crate::{AnalysisError, ForcePath};
use fracdiff::parameter::{not_negative, positive, range};
use fracdiff::{FrequencyResponse, Order};
use num_complex::Complex;
use std::f64::consts::PI;
use std::fmt;

/// A virtual coupler between the device and any passive environment; velocity in, force out.
/// ```text
/// Z_c(w) = k_c + b_c·(T/(1 − w))^μ        exact
/// Z_c(w) = k_c + b_c·T^μ/P(w)             with an operator P of order μ
/// ```
/// - *Units*: `k_c` N·s/m; `b_c` N·s^(1−μ)/m. At μ = 1 `k_c` is the damper and `b_c` the spring.
/// - *Orders*: 0 ≤ μ ≤ 2. For the exact operator with μ > 1 and `b_c` > 0 no device damping makes the
///   port passive: [`LeastDamping::NoneIsEnough`].
/// - *Accuracy* of the least damping: 1e-12 in closed form. With an operator, where Re P near θ = 0
///   cancels to rounding (μ = 1 in a polynomial), the limit is extrapolated: 1e-9.
/// - *Cost*: 4·memory + 400 responses for the least damping, on the heap.
///
/// Source: O. Tokatlı, *Fractional Order Control in Haptics*, section 5.2, after R. J. Adams, B. Hannaford, *Stable haptic interaction with
/// virtual environments*, IEEE Trans. Robotics and Automation 15(3), 1999.
/// ```
/// use fracdiff::Order;
/// use haptic_analysis::{Coupler, LeastDamping};
///
/// // k_c = 10 N·s/m, b_c = 2 N·s^0.5/m at 1 ms.
/// let coupler = Coupler::exact(Order::new(0.5)?, 1e-3, 10.0, 2.0)?;
/// let LeastDamping::Enough { damping_n_s_per_m, .. } = coupler.least_damping()? else {
///     panic!("some damping is enough below order 1");
/// };
/// assert!(damping_n_s_per_m > coupler.corollary_damping()); // Corollary 2 promises too much
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy)]
pub struct Coupler<'a> {
    stiffness: f64,
    /// `b_c·T^μ`, N·s/m.
    dissipation: f64,
    order: Order,
    sample_time_s: f64,
    /// The operator that runs and its memory; `None` for (1 − w)^μ itself.
    operator: Option<(&'a dyn FrequencyResponse, usize)>,
}

impl<'a> Coupler<'a> {
    /// The exact operator. `stiffness` is `k_c`, `dissipation` is `b_c`.
    ///
    /// # Errors
    /// `k_c` or `b_c` below 0, or both 0; μ < 0; T not above 0; `b_c·T^μ` too large.
    pub fn exact(
        order: Order,
        sample_time_s: f64,
        stiffness: f64,
        dissipation: f64,
    ) -> Result<Self, AnalysisError> {
        let mu = order.get();
        let allowed = "in [0, 2], the orders of the coupler";
        range("order", mu, mu >= 0.0, allowed, "")?;
        let t = positive("sample time", sample_time_s, "s")?;
        let stiffness = not_negative("coupler damping", stiffness, "N·s/m")?;
        let dissipation = not_negative("coupler spring", dissipation, "N·s^(1−μ)/m")?;
        let per_sample = dissipation * libm::pow(t, mu);
        positive("impedance of the coupler", stiffness + per_sample, "N·s/m")?;
        Ok(Self {
            stiffness,
            dissipation: per_sample,
            order,
            sample_time_s: t,
            operator: None,
        })
    }

    /// Runs the coupler by an operator of its order. `memory` in samples, 1 for unlimited memory:
    /// as in [`OnePort::with_memory`](crate::OnePort::with_memory).
    #[must_use]
    pub fn with_operator<'b>(
        self,
        operator: &'b dyn FrequencyResponse,
        memory: usize,
    ) -> Coupler<'b> {
        Coupler {
            operator: Some((operator, memory)),
            ..self
        }
    }

    /// Corollary 2: `8b ≥ k_c + b_c·(T/2)^μ`, b in N·s/m. Not sufficient: it takes the worst of the two sides at different frequencies, and
    /// the criterion itself asks for up to twice as much (`k_c` = 0, μ = 1); equal only where `b_c` = 0 or μ = 0. An operator that is not
    /// exact may ask for more still. For μ > 1 it promises what no damping can keep.
    ///
    /// Source: O. Tokatlı, *Fractional Order Control in Haptics*, eq. 5.20.
    #[must_use]
    pub fn corollary_damping(&self) -> f64 {
        0.125 * (self.stiffness + self.dissipation * libm::pow(2.0, -self.order.get()))
    }

    /// The least b for which Llewellyn's conditions hold at every 0 ≤ θ ≤ π.
    /// ```text
    /// p₁₁ = m·(2/T)(1 − w)/(1 + w) + b,   p₁₂ = (1 + w)/2,   p₂₁ = −1,   p₂₂ = 1/Z_c,   velocity of the hand, force of the environment
    /// b ≥ 0,   Re(1/Z_c) ≥ 0,   2b·Re(1/Z_c) ≥ cos(θ/2)(1 − cos(θ/2)):   b = sup over θ of cos(θ/2)(1 − cos(θ/2))/(2 Re(1/Z_c))
    /// ```
    ///
    /// # Errors
    /// An operator without a finite response.
    pub fn least_damping(&self) -> Result<LeastDamping, AnalysisError> {
        let (scale, shares) = self.shares();
        let outcome = match self.operator {
            None => shares.least_of_exact(self.order.get()),
            Some((operator, memory)) => shares.least_of(operator, memory, Hold::Tustin),
        };
        outcome?.times(scale)
    }

    /// The least b for which the *really sampled* device, its force held between samples, late and lagging by `path`, is passive
    /// with the coupler and every passive object behind it: stable in every passive hand, then.
    /// ```text
    /// b = sup over θ of h(θ)/(2 Re(1/Z_c)),   h = √(|M|² + V) − Re(wM),   h = 1 − cos((d + 1)θ) for d whole samples of delay
    /// ```
    /// M and V are mean and variance of the force within a sample. Llewellyn's h, cos(θ/2)(1 − cos(θ/2)), is less than a quarter of it: his
    /// device is one under Tustin's rule, whose force acts half a sample earlier. So [`least_damping`](Self::least_damping) is not enough
    /// for a sampled device: a spring (μ = 1) needs four times as much, `b_c·T/2`, and a damper eight times, `k_c`.
    ///
    /// *Derivation*: passivity of a sampled port asks b ≥ (Re(cZ) + √(Re²(cZ) + V|Z|²))/2, c = −wM, at each θ (Theorem 1 with
    /// the variance within a sample), which is |bY − c/2|² ≥ (|c|² + V)/4 for Y = 1/Z. With an object Y = 1/`Z_c` + 1/`Z_o`, and a
    /// passive `Z_o` can make it any Y with Re Y ≥ Re(1/`Z_c`): the circle has to lie outside of that half-plane.
    ///
    /// *Delays* up to some hundred samples; beyond, the limit at rest of a coupler of order 1 is not resolved.
    ///
    /// # Errors
    /// An operator without a finite response.
    pub fn sampled_damping(&self, path: ForcePath) -> Result<LeastDamping, AnalysisError> {
        let (scale, shares) = self.shares();
        let exact = ExactInverse(self.order.get());
        let (operator, memory) = self.operator.unwrap_or((&exact, 1));
        let outcome = shares.least_of(operator, memory, Hold::Sampled(path));
        outcome?.times(scale)
    }

    pub(crate) const fn order(&self) -> Order {
        self.order
    }

    pub(crate) const fn sample_time_s(&self) -> f64 {
        self.sample_time_s
    }

    /// `k_c` and `b_c·T^μ`, N·s/m.
    pub(crate) const fn gains(&self) -> (f64, f64) {
        (self.stiffness, self.dissipation)
    }

    /// Both gains as shares of their sum, so that no product of the two can overflow, and that sum.
    fn shares(&self) -> (f64, Shares) {
        let scale = self.stiffness + self.dissipation;
        let shares = Shares {
            stiffness: self.stiffness / scale,
            dissipation: self.dissipation / scale,
        };
        (scale, shares)
    }

    /// True if the port is passive with a device of this damping, N·s/m, between any passive hand
    /// and environment.
    ///
    /// # Errors
    /// Damping below 0, or an operator without a finite response.
    pub fn passive(&self, damping: f64) -> Result<bool, AnalysisError> {
        let damping = not_negative("damping", damping, "N·s/m")?;
        Ok(match self.least_damping()? {
            LeastDamping::Enough {
                damping_n_s_per_m, ..
            } => damping >= damping_n_s_per_m,
            LeastDamping::NoneIsEnough { .. } => false,
        })
    }
}

/// (1 − w)^μ with its digits near rest.
struct ExactInverse(f64);

impl FrequencyResponse for ExactInverse {
    fn response(&self, theta: f64) -> Complex<f64> {
        exact(self.0, theta)
    }
}

impl fmt::Debug for Coupler<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Coupler")
            .field("stiffness", &self.stiffness)
            .field("dissipation_t_mu", &self.dissipation)
            .field("order", &self.order)
            .field("sample_time_s", &self.sample_time_s)
            .field("exact", &self.operator.is_none())
            .finish()
    }
}

/// Device damping that makes the coupled port passive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LeastDamping {
    /// Passive from this damping on, itself included.
    Enough {
        /// The least b that is enough, N·s/m.
        damping_n_s_per_m: f64,
        /// θ that asks for it, rad/sample; 0 for a limit.
        worst_theta: f64,
    },
    /// `Re(1/Z_c)` is not positive at a frequency where the hold takes energy: no b is enough.
    NoneIsEnough {
        /// A θ at which that is so, rad/sample.
        theta: f64,
    },
}

impl LeastDamping {
    /// The least damping, N·s/m; `None` if no damping is enough.
    #[must_use]
    pub const fn damping_n_s_per_m(self) -> Option<f64> {
        match self {
            Self::Enough {
                damping_n_s_per_m, ..
            } => Some(damping_n_s_per_m),
            Self::NoneIsEnough { .. } => None,
        }
    }

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

/// Least damping with `b_c` = 0: b = `k_c`·h/2, and h is largest, 1/4, at cos(θ/2) = 1/2.
const WITHOUT_DISSIPATION: LeastDamping = LeastDamping::Enough {
    damping_n_s_per_m: 0.125,
    worst_theta: 2.0 * PI / 3.0,
};

/// `k_c` and `b_c·T^μ` as parts of their sum.
#[derive(Clone, Copy)]
pub(crate) struct Shares {
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

    /// Least damping for (1 − w)^μ, in closed form.
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
        enough(Grid::new(1).maximum(at_zero, &value))
    }

    /// Least damping for another operator, with the rounding of Re P in mind: an operator sums its coefficients, so
    /// where Re P cancels it is off by about `NOISE`.
    pub(crate) fn least_of(
        self,
        operator: &dyn FrequencyResponse,
        memory: usize,
        hold: Hold,
    ) -> Result<LeastDamping, AnalysisError> {
        const NOISE: f64 = 1e-15;
        /// Accepted relative error of Re(1/Z) from rounding.
        const RESOLVED: f64 = 1e-10;
        let grid = Grid::new(memory + hold.ripple());
        if self.dissipation == 0.0 {
            return match hold {
                Hold::Tustin => Ok(WITHOUT_DISSIPATION),
                Hold::Sampled(_) => enough(grid.maximum(0.0, &|theta| 0.5 * hold.at(theta))),
            };
        }
        // Below this θ a value that rounding spoils is left out, and the limit extrapolated.
        let (low, is_exact) = hold.low();
        let noise = |p: Complex<f64>| NOISE * self.dissipation * p.norm().max(1.0);
        // Re(1/Z) < 0 beyond rounding: no damping.
        let negative = grid.maximum(f64::NEG_INFINITY, &|theta| {
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
            theta >= low || (is_exact && noise(p) <= RESOLVED * self.real_part(p))
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
        let found = grid.maximum(at_zero, &value);
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

/// The hold of a device: what it can take at a frequency, as a share of the largest, is h(θ) ≥ 0.
#[derive(Clone, Copy)]
pub(crate) enum Hold {
    /// The dissertation's device under Tustin's rule.
    Tustin,
    /// A force that is really held, late and lagging.
    Sampled(ForcePath),
}

impl Hold {
    fn at(self, theta: f64) -> f64 {
        let path = match self {
            // 0 at π itself, where the cosine of the nearest number is not.
            Self::Tustin => return if theta < PI { hold(theta) } else { 0.0 },
            Self::Sampled(path) => path,
        };
        if path.is_whole() {
            // 1 − cos((d + 1)θ)
            let turn = libm::sin(0.5 * (path.whole_samples() + 1) as f64 * theta);
            return 2.0 * turn * turn;
        }
        // √(|M|² + V) − Re(wM)
        let profile = path.profile(theta);
        let (sin, cos) = libm::sincos(theta);
        let square = 2.0 * (1.0 - cos) * profile.spread;
        let late = Complex::new(cos, -sin) * profile.mean;
        (libm::sqrt(profile.mean.norm_sqr() + square) - late.re).max(0.0)
    }

    fn ripple(self) -> usize {
        match self {
            Self::Tustin => 0,
            Self::Sampled(path) => path.whole_samples() + 2,
        }
    }

    /// θ from which on values are right to rounding, and if h keeps its digits below that, too.
    fn low(self) -> (f64, bool) {
        match self {
            Self::Tustin => (0.05, true),
            Self::Sampled(path) => (0.05 / (1.0 + path.mean_delay()), path.is_whole()),
        }
    }
}

/// |p₁₂p₂₁| + Re(p₁₂p₂₁) = cos(θ/2)(1 − cos(θ/2)) = cos(θ/2)·2 sin²(θ/4).
pub(crate) fn hold(theta: f64) -> f64 {
    let quarter = libm::sin(0.25 * theta);
    2.0 * quarter * quarter * libm::cos(0.5 * theta)
}

/// (1 − w)^μ with cos(μ(π−θ)/2) as sin((π(1−μ) + μθ)/2): the real part keeps its digits where μ is near 1 and θ near 0, which decide here.
pub(crate) fn exact(mu: f64, theta: f64) -> Complex<f64> {
    let magnitude = libm::pow(2.0 * libm::sin(0.5 * theta), mu);
    let real = libm::sin(0.5 * (PI * (1.0 - mu) + mu * theta));
    let imaginary = libm::sin(0.5 * mu * (PI - theta));
    Complex::new(magnitude * real, magnitude * imaginary)
}
