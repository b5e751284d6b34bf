//! Corollary 1: the device damping that a wall asks for, in one line.

use crate::AnalysisError;
use crate::environment::finite;
use fracdiff::Order;
use fracdiff::parameter::{not_negative, range};

/// Corollary 1, nondimensional: δ > α/2 + β·2^(μ−1); with units b > KT/2 + B(T/2)^(1−μ).
///
/// Equal to Theorem 1 for the exact operator (1 − w)^μ without extra delay and 0 ≤ μ ≤ 2 (in fact for
/// every μ ≥ 0; worst at θ = π). It says nothing about another operator: the Muir polynomial of the
/// dissertation needs up to a third more on the β term. Nor about a delay: d samples make the α term
/// 2d + 1 times as large, and the β term larger where μ < 1 (where μ ≥ 1 it stays sufficient).
///
/// # Errors
/// α or β below 0, or μ < 0.
///
/// Source: O. Tokatlı, *Fractional Order Control in Haptics*, eqs. 5.1, 5.2.
pub fn corollary_delta(order: Order, alpha: f64, beta: f64) -> Result<f64, AnalysisError> {
    check_order(order)?;
    let alpha = not_negative("alpha", alpha, "")?;
    let beta = not_negative("beta", beta, "")?;
    // α/2 + β·2^(μ−1)
    finite(
        "least delta",
        0.5 * alpha + beta * libm::pow(2.0, order.get() - 1.0),
        "",
    )
}

/// Theorem 1 has a bound for derivatives only.
pub(crate) fn check_order(order: Order) -> Result<(), AnalysisError> {
    let value = order.get();
    let allowed = "in [0, 2], where the passivity theorem has a bound";
    range("order", value, value >= 0.0, allowed, "")?;
    Ok(())
}
