//! The device with its hand behind a zero-order hold, as the loop sees it once a sample.

use crate::AnalysisError;
use crate::error::not_negative;

/// Nondimensional sampled plant (4.1): mass, damper and spring behind a zero-order hold.
///
/// ```text
/// x'' + δ·x' + γ·x = u,   time in samples:   G(w) = (n₁w + n₀w²) / A(w),   w = z^(−1)
/// A(w) = 1 − (c₂ + c₃)w + e^(−δ)w²,   c₂,₃ = e^(−s₂,₃),   s₂,₃ = (δ ± √(δ² − 4γ))/2
/// n₁ = exp[−s₂, −s₃, 0],   n₀ = exp[−s₂, −s₃, −δ]   (divided differences)
/// ```
/// The closed forms of the dissertation divide by c₁γ and lose everything near γ = 0 and δ² = 4γ.
/// Here nothing cancels:
///
/// ```text
/// n₁ + n₀ = φ₁(s₂)·φ₁(s₃),   φ₁(s) = (1 − e^(−s))/s        A(1) = γ·(n₁ + n₀)
/// A = A(1) + a₁v + e^(−δ)v²,   a₁ = (1 − e^(−δ)) − A(1)     n₁ + n₀w = (n₁ + n₀) − n₀v,   v = 1 − w
/// ```
/// and n₁ comes from its power series over a step so short that the series is exact, and then from
/// doublings of that step.
///
/// - *Ranges*: δ = bT/m from 0 to 1e6, γ = kT²/m from 0 to 1e12; all dimensionless.
/// - *Accuracy*: 1e-12 relative for δ and γ from 1e-9 to 10, over-, critically and under-damped, and
///   at every removable singularity, against 50 digits (`tests/golden/plant.csv`). Beyond, a phase
///   of ω radians in a sample is known to ω rounding errors.
/// - *Cost*: a few exponentials and about 30 multiply-adds, once.
///
/// Source: O. Tokatlı, *Fractional Order Control in Haptics*, eq. 4.1 (which prints c₂ twice).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampledPlant {
    delta: f64,
    gamma: f64,
    n1: f64,
    n0: f64,
    sum: f64,
    pole_sum: f64,
    pole_product: f64,
    slope: f64,
}

impl SampledPlant {
    /// Largest δ: a motion that dies out a million times faster than a sample is sampled wrongly.
    pub const DELTA_MAX: f64 = 1e6;
    /// Largest γ.
    pub const GAMMA_MAX: f64 = 1e12;

    /// From δ and γ.
    ///
    /// # Errors
    /// Unless 0 ≤ δ ≤ 1e6 and 0 ≤ γ ≤ 1e12.
    pub fn new(delta: f64, gamma: f64) -> Result<Self, AnalysisError> {
        let delta = not_above("delta", delta, Self::DELTA_MAX, "from 0 to 1e6")?;
        let gamma = not_above("gamma", gamma, Self::GAMMA_MAX, "from 0 to 1e12")?;
        let Poles { sum, pole_sum } = Poles::new(delta, gamma);
        let pole_product = libm::exp(-delta);
        let n1 = step_response(delta, gamma);
        Ok(Self {
            delta,
            gamma,
            n1,
            n0: sum - n1,
            sum,
            pole_sum,
            pole_product,
            slope: -libm::expm1(-delta) - gamma * sum,
        })
    }

    /// δ.
    #[must_use]
    pub fn delta(&self) -> f64 {
        self.delta
    }

    /// γ.
    #[must_use]
    pub fn gamma(&self) -> f64 {
        self.gamma
    }

    /// n₁, the coefficient of w in the numerator: where a unit force has moved the device to after
    /// one sample, from rest.
    #[must_use]
    pub fn n1(&self) -> f64 {
        self.n1
    }

    /// n₀, the coefficient of w² in the numerator.
    #[must_use]
    pub fn n0(&self) -> f64 {
        self.n0
    }

    /// n₁ + n₀ = φ₁(s₂)φ₁(s₃), the numerator at w = 1.
    #[must_use]
    pub fn numerator_sum(&self) -> f64 {
        self.sum
    }

    /// c₂ + c₃, the sum of the poles in z.
    #[must_use]
    pub fn pole_sum(&self) -> f64 {
        self.pole_sum
    }

    /// e^(−δ) = c₂c₃, the product of the poles in z.
    #[must_use]
    pub fn pole_product(&self) -> f64 {
        self.pole_product
    }

    /// A(1) = 1 − (c₂ + c₃) + e^(−δ) = γ·(n₁ + n₀), without cancellation.
    #[must_use]
    pub fn denominator_at_rest(&self) -> f64 {
        self.gamma * self.sum
    }

    /// A in powers of v = 1 − w, of v⁰ first.
    pub(crate) fn denominator_in_v(&self) -> [f64; 3] {
        [self.gamma * self.sum, self.slope, self.pole_product]
    }
}

fn not_above(
    what: &'static str,
    value: f64,
    most: f64,
    allowed: &'static str,
) -> Result<f64, AnalysisError> {
    let value = not_negative(what, value, "")?;
    if value <= most {
        return Ok(value);
    }
    Err(AnalysisError::Range {
        what,
        value,
        allowed,
        unit: "",
    })
}

/// n₁ + n₀ and c₂ + c₃.
struct Poles {
    sum: f64,
    pole_sum: f64,
}

impl Poles {
    fn new(delta: f64, gamma: f64) -> Self {
        // δ² − 4γ as a product: a square root of it loses half the digits at critical damping, but
        // both results are smooth and even in it.
        let root = libm::sqrt(gamma);
        let discriminant = (delta - 2.0 * root) * (delta + 2.0 * root);
        if discriminant >= 0.0 {
            // s₃ = γ/s₂: the small root without a difference.
            let s2 = 0.5 * (delta + libm::sqrt(discriminant));
            let s3 = if s2 > 0.0 { gamma / s2 } else { 0.0 };
            return Self {
                sum: phi1(s2) * phi1(s3),
                pole_sum: libm::exp(-s2) + libm::exp(-s3),
            };
        }
        // s₂,₃ = σ ± jω: φ₁(s₂)φ₁(s₃) = [σ²φ₁(σ)² + ω²e^(−σ)(sin(ω/2)/(ω/2))²]/(σ² + ω²), a mean.
        let sigma = 0.5 * delta;
        let omega = 0.5 * libm::sqrt(-discriminant);
        let share = (sigma / root) * (sigma / root);
        let sinc = if omega > 0.0 {
            libm::sin(0.5 * omega) / (0.5 * omega)
        } else {
            1.0
        };
        let decay = libm::exp(-sigma);
        Self {
            sum: share * phi1(sigma) * phi1(sigma) + (1.0 - share) * decay * sinc * sinc,
            pole_sum: 2.0 * decay * libm::cos(omega),
        }
    }
}

/// (1 − e^(−s))/s.
fn phi1(s: f64) -> f64 {
    if s > 0.0 { -libm::expm1(-s) / s } else { 1.0 }
}

/// n₁ = x(1) for a unit force from rest.
///
/// ```text
/// X(t) = ∫₀ᵗ h,   h'' + δh' + γh = 0,  h(0) = 0,  h'(0) = 1
/// X = t² Σ_{k≥0} (−1)^k h_k/(k + 2)!,   h_k = δt·h_{k−1} − γt²·h_{k−2},   h₀ = 1,  h₋₁ = 0
/// X(2t) = 2X − γX² + h²,    h(2t) = h·(2 − 2γX − δh)
/// ```
fn step_response(delta: f64, gamma: f64) -> f64 {
    // δt and √(γ)t at most a half: 18 terms are exact.
    let fastest = delta.max(libm::sqrt(gamma));
    let halvings = if fastest < 0.5 {
        0
    } else {
        libm::ilogb(fastest) + 2
    };
    let step = libm::ldexp(1.0, -halvings);
    let (mut damping, mut stiffness) = (delta * step, gamma * step * step);
    // `impulse` is h/t and `position` is X/t².
    let (mut impulse, mut position) = (0.0, 0.0);
    let (mut before, mut term, mut factorial) = (0.0, 1.0, 1.0);
    for k in 1..=18_u32 {
        // `term` is (−1)^(k−1) h_{k−1}, `factorial` k!
        factorial *= f64::from(k);
        impulse += term / factorial;
        position += term / (factorial * f64::from(k + 1));
        let next = -damping * term - stiffness * before;
        before = term;
        term = next;
    }
    for _ in 0..halvings {
        let settled = stiffness * position;
        let doubled = 2.0 * position - settled * position + impulse * impulse;
        impulse *= 1.0 - settled - 0.5 * damping * impulse;
        position = 0.25 * doubled;
        damping *= 2.0;
        stiffness *= 4.0;
    }
    position
}
