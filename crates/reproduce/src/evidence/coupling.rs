//! Claim 9: which virtual couplings are passive.

use super::{Evidence, Formulas};
use crate::Kind;
use fracdiff::Order;
use haptic_analysis::{AnalysisError, Coupler, LeastDamping};

pub(crate) fn corollary_two(kind: Kind, formulas: &Formulas) -> Result<Evidence, AnalysisError> {
    /// T, s, and couplers (`k_c`, `b_c`·(T/2)^μ), both in N·s/m.
    const T: f64 = 1e-3;
    const COUPLERS: [(f64, f64); 5] = [(1.0, 0.0), (1.0, 0.3), (1.0, 1.0), (0.3, 1.0), (0.0, 1.0)];
    let mut worst = (1.0_f64, 0.0, (0.0, 0.0));
    let mut active_above_one = true;
    for mu in [0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0] {
        let operator = kind.operator(mu)?;
        for (k, scaled) in COUPLERS {
            let b = scaled / (0.5 * T).powf(mu);
            let exact = Coupler::exact(Order::new(mu)?, T, k, b)?;
            let coupler = match kind {
                Kind::Exact => exact,
                Kind::Muir => exact.with_operator(&operator, 4),
            };
            match coupler.least_damping()? {
                LeastDamping::Enough {
                    damping_n_s_per_m, ..
                } => {
                    if mu > 1.0 {
                        active_above_one &= b == 0.0;
                    } else {
                        let factor = damping_n_s_per_m / (formulas.coupling)(mu, T, k, b);
                        if factor > worst.0 {
                            worst = (factor, mu, (k, scaled));
                        }
                    }
                }
                LeastDamping::NoneIsEnough { .. } => {
                    if mu <= 1.0 {
                        worst = (f64::INFINITY, mu, (k, scaled));
                    }
                }
            }
        }
    }
    let (factor, mu, (k, b)) = worst;
    let sufficient = factor <= 1.0 + 1e-9;
    let above = if active_above_one {
        "none is enough"
    } else {
        "some is enough"
    };
    Ok(Evidence {
        holds: sufficient && active_above_one,
        numbers: if sufficient {
            format!("(5.20) is enough for all couplers; for μ > 1 {above}")
        } else if factor.is_infinite() {
            format!(
                "at μ = {mu}, k_c : b_c(T/2)^μ = {k} : {b} no damping is enough; for μ > 1 {above}"
            )
        } else {
            format!(
                "at μ = {mu}, k_c : b_c(T/2)^μ = {k} : {b} the port needs {factor:.3} times (5.20); for μ > 1 {above}"
            )
        },
    })
}
