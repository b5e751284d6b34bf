//! What a response is by its definition.

use fractional_control::num_complex::Complex;

/// `Σ h[j]·e^(−iθj)` of an impulse response.
pub(crate) fn of_impulse_response(weights: &[f64], theta: f64) -> Complex<f64> {
    let terms = weights.iter().enumerate();
    terms
        .map(|(j, h)| Complex::from_polar(*h, -theta * j as f64))
        .sum()
}
