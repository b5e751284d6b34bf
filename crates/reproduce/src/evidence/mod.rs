//! Evidence on each claim: the numbers that decide it, with either operator.

pub(crate) mod coupling;
pub(crate) mod passivity;
pub(crate) mod region;
pub(crate) mod rendering;
pub(crate) mod robustness;
pub(crate) mod sensitivity;

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

/// Evidence on a claim with one operator.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Evidence {
    /// True if the claim holds with it.
    pub holds: bool,
    /// The numbers that decide.
    pub numbers: String,
}

/// 0, 0.1, …, 2.
fn fine_orders() -> impl Iterator<Item = f64> {
    (0..=20).map(|i| f64::from(i) / 10.0)
}

/// A list of numbers.
fn list(values: impl IntoIterator<Item = f64>) -> String {
    let texts: Vec<String> = values.into_iter().map(|v| format!("{v:.4}")).collect();
    texts.join(", ")
}

/// True if the values fall strictly.
fn falls(values: &[f64]) -> bool {
    values.windows(2).all(|pair| pair[1] < pair[0])
}
