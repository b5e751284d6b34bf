//! Closed forms of a mass with damper and hand, from δ and γ: poles, step response, matrices.

use crate::ForcePath;
use nalgebra::{DMatrix, DVector, RowDVector};

/// x″ + δx′ + γx = f, and a·(u − f) = f′ where there is a lag, in samples.
pub(crate) fn matrices(
    delta: f64,
    gamma: f64,
    path: ForcePath,
) -> (DMatrix<f64>, DVector<f64>, RowDVector<f64>) {
    // Natural units: the fastest of a sample, the damping and a radian of oscillation sets the time.
    let rate = libm::sqrt(gamma).max(1.0);
    let stiff = gamma / rate;
    if path.lag_samples() == 0.0 {
        return (
            DMatrix::from_row_slice(2, 2, &[0.0, rate, -stiff, -delta]),
            DVector::from_column_slice(&[0.0, 1.0 / rate]),
            RowDVector::from_row_slice(&[1.0, 0.0]),
        );
    }
    let a = 1.0 / path.lag_samples();
    #[rustfmt::skip]
    let matrix = [
        0.0,    rate,   0.0,
        -stiff, -delta, 1.0 / rate,
        0.0,    0.0,    -a,
    ];
    (
        DMatrix::from_row_slice(3, 3, &matrix),
        DVector::from_column_slice(&[0.0, 0.0, a]),
        RowDVector::from_row_slice(&[1.0, 0.0, 0.0]),
    )
}

/// n₁ + n₀ and c₂ + c₃.
pub(crate) struct Poles {
    pub(crate) sum: f64,
    pub(crate) pole_sum: f64,
}

impl Poles {
    pub(crate) fn new(delta: f64, gamma: f64) -> Self {
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
pub(crate) fn step_response(delta: f64, gamma: f64) -> f64 {
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
