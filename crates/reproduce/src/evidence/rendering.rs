//! Claims 10 to 12: the force that a hand feels.

use super::{Evidence, Formulas, fine_orders};
use crate::Kind;
use crate::relaxation::relaxation_error;
use fracdiff::{FrequencyResponse, Order, grunwald_weight};
use haptic_analysis::AnalysisError;
use std::f64::consts::PI;

pub(crate) fn effective_stiffness(kind: Kind, _: &Formulas) -> Result<Evidence, AnalysisError> {
    let least = |mu: f64| -> Result<f64, AnalysisError> {
        let operator = kind.operator(mu)?;
        let real = (1..=4000).map(|i| operator.response(PI * f64::from(i) / 4000.0).re);
        Ok(real.fold(f64::INFINITY, f64::min))
    };
    let mut low = (f64::INFINITY, 0.0);
    for mu in fine_orders().filter(|mu| *mu <= 1.0) {
        let value = least(mu)?;
        if value < low.0 {
            low = (value, mu);
        }
    }
    let mut always_negative = true;
    for mu in fine_orders().filter(|mu| *mu > 1.0) {
        always_negative &= least(mu)? < 0.0;
    }
    Ok(Evidence {
        // Rounding: Re P at μ = 1 tends to 0 at low frequency.
        holds: low.0 >= -1e-12 && always_negative,
        numbers: format!(
            "least Re P for μ ≤ 1: {:.2e} at μ = {}; for each μ > 1 it is {}",
            low.0,
            low.1,
            if always_negative {
                "negative somewhere"
            } else {
                "not always negative somewhere"
            }
        ),
    })
}

/// μ of the cancerous prostate.
const TISSUE_ORDER: f64 = 0.2247;

pub(crate) fn short_memory(kind: Kind, _: &Formulas) -> Result<Evidence, AnalysisError> {
    let order = Order::new(TISSUE_ORDER)?;
    // 200 s after the start of a 1 s ramp at 1 kHz the last 1000 samples are all on the hold, so a
    // short memory gives the sum of its weights.
    let (n, ramp) = (200_000_u64, 1000_u64);
    // Full history of a ramp 0, 1, 2, …: Σ c_{n−j}·j = c^(μ−1)_n·n/(1 − μ).
    let below = Order::new(TISSUE_ORDER - 1.0)?;
    let of_ramp = |n: u64| grunwald_weight(below, n) * n as f64 / (1.0 - TISSUE_ORDER);
    let full = (of_ramp(n) - of_ramp(n - ramp)) / ramp as f64;
    let short = match kind {
        // Σ_{j<1000} c_j
        Kind::Exact => grunwald_weight(below, ramp - 1),
        Kind::Muir => kind.operator(TISSUE_ORDER)?.response(0.0).re,
    };
    let slope = |j: u64| {
        let ratio = grunwald_weight(order, 2 * j) / grunwald_weight(order, j);
        -ratio.ln() / j as f64
    };
    let ratio = short / full;
    Ok(Evidence {
        holds: (ratio - 1.0).abs() < 0.01,
        numbers: format!(
            "force after 200 s: {ratio:.3} times the truth; decay rate of the weights per sample {:.1e} at lag 100, \
             {:.1e} at lag 100 000 (an exponential would have one)",
            slope(100),
            slope(100_000)
        ),
    })
}

pub(crate) fn relaxation(kind: Kind, formulas: &Formulas) -> Result<Evidence, AnalysisError> {
    let error = relaxation_error(kind, formulas.stress_factor)?;
    Ok(Evidence {
        holds: error < 0.01,
        numbers: format!(
            "largest relative deviation from the closed form, 1.1 s to 200 s: {error:.2e}"
        ),
    })
}
