//! Short ways to orders, operators and loops that are within their ranges.

use fracdiff::{ExactDifference, Order, Scheme, Seconds};
use haptic_analysis::{ForcePath, LoopOperator, Nondimensional};

/// # Panics
/// Out of range.
#[must_use]
pub fn order(mu: f64) -> Order {
    Order::new(mu).expect("an order in range")
}

/// (1 − w)^μ.
///
/// # Panics
/// Out of range.
#[must_use]
pub fn exact(mu: f64) -> ExactDifference {
    ExactDifference(order(mu))
}

/// An operator as the analysis sees it, at 1 ms and with a horizon of 10⁵ samples.
///
/// # Panics
/// Unknown, or out of range.
#[must_use]
pub fn operator(scheme: &str, mu: f64) -> LoopOperator {
    let scheme: Scheme = scheme.parse().expect("a scheme");
    LoopOperator::new(scheme, order(mu), Seconds(1e-3), 1e5).expect("an operator")
}

/// α, β, δ, γ in this order.
#[must_use]
pub const fn wall(alpha: f64, beta: f64, delta: f64, gamma: f64) -> Nondimensional {
    Nondimensional {
        alpha,
        beta,
        delta,
        gamma,
    }
}

/// Delay and lag, both in samples.
///
/// # Panics
/// Out of range.
#[must_use]
pub fn path(delay: f64, lag: f64) -> ForcePath {
    ForcePath::new(delay, lag).expect("a delay and a lag in range")
}
