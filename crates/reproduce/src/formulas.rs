//! The formulas of the dissertation, and what computing says of a claim with them.

use fracdiff::Order;
use haptic_analysis::{AnalysisError, corollary_delta};
use serde::Serialize;

/// The formulas of the dissertation under test. A test replaces one and sees a verdict change.
#[derive(Clone, Copy, Debug)]
pub struct Formulas {
    /// Corollary 1 (5.1): least δ from μ, α, β.
    pub passivity: fn(Order, f64, f64) -> Result<f64, AnalysisError>,
    /// Corollary 2 (5.20): least b from μ, T, `k_c`, `b_c`.
    pub coupling: fn(f64, f64, f64, f64) -> f64,
    /// Closed form of the tissue's stress (theory of figure 7.2), as a factor on it.
    pub stress_factor: f64,
}

impl Default for Formulas {
    fn default() -> Self {
        Self {
            passivity: corollary_delta,
            // 8b ≥ k_c + b_c(T/2)^μ
            coupling: |mu, t, k, b| (k + b * (0.5 * t).powf(mu)) / 8.0,
            stress_factor: 1.0,
        }
    }
}

/// What one operator says of a claim.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Evidence {
    /// Whether the claim holds with it.
    pub holds: bool,
    /// The numbers that decide.
    pub numbers: String,
}
