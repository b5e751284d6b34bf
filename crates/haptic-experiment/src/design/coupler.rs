//! The stiffest passive virtual coupler of each order, for a device with a given damping.
//!
//! ```text
//! Z_c = k_c + b_c·(T/(1 − w))^μ,    least damping by Llewellyn b(k_c, b_c), in proportion to both
//! b_c = b / b(r, 1),  k_c = r·b_c   for the ratio r = k_c/b_c that makes b_c largest
//! ```
//! The damper part `k_c` can lower what the spring part `b_c` needs, so the ratio is searched: 0, and
//! 200 ratios over six decades around the T^μ at which the two are alike, then golden sections around
//! the best. Compared by the stiffness that is felt at a frequency, `|jω·Z_c(jω)|`. For μ > 1 no damping
//! makes the port passive. Source: O. Tokatlı, *Fractional Order Control in Haptics*, eqs. 5.14–5.20.

use haptic_analysis::{AnalysisError, Coupler, LeastDamping, LoopOperator};
use serde::Serialize;
use std::f64::consts::PI;

/// The stiffest coupler of an order.
#[derive(Clone, Debug, Serialize)]
pub struct CouplerCandidate {
    /// μ.
    pub order: f64,
    /// `k_c`, N·s/m; null if no coupler of this order is passive.
    pub stiffness: Option<f64>,
    /// `b_c`, N·s^(1−μ)/m.
    pub dissipation: Option<f64>,
    /// The device's damping over what the coupler needs: a little above 1.
    pub margin: Option<f64>,
    /// `|jω·Z_c(jω)|` at the frequency, N/m.
    pub felt_stiffness_n_per_m: Option<f64>,
    /// Why there is none.
    pub reason: Option<String>,
}

/// Share of the largest coupler that is taken: Llewellyn's criterion is met with equality otherwise.
const INSIDE: f64 = 1.0 - 1e-6;
/// Ratios tried.
const RATIOS: u32 = 200;

/// The stiffest passive coupler with this operator on a device with damping b, N·s/m.
///
/// # Errors
/// A sample time or damping outside its range.
pub fn stiffest_coupler(
    operator: &LoopOperator,
    damping: f64,
    sample_time_s: f64,
    frequency_hz: f64,
) -> Result<CouplerCandidate, AnalysisError> {
    let order = operator.order();
    let mu = order.get();
    // A finite memory ripples as fast as it is long.
    let memory = match operator.polynomials() {
        Some((numerator, [_])) => numerator.len(),
        _ => 1,
    };
    let least = |ratio: f64| -> Result<Option<f64>, AnalysisError> {
        let exact = Coupler::exact(order, sample_time_s, ratio, 1.0)?;
        let coupler = exact.with_operator(operator, memory);
        Ok(match coupler.least_damping()? {
            LeastDamping::Enough {
                damping_n_s_per_m, ..
            } => Some(damping_n_s_per_m),
            LeastDamping::NoneIsEnough { .. } => None,
        })
    };
    let none = |reason: &str| CouplerCandidate {
        order: mu,
        stiffness: None,
        dissipation: None,
        margin: None,
        felt_stiffness_n_per_m: None,
        reason: Some(reason.to_owned()),
    };
    if damping <= 0.0 {
        return Ok(none(
            "the device has no damping, so no coupler is passive on it",
        ));
    }
    let Some(bare) = least(0.0)? else {
        return Ok(none(
            "a coupler of this order is active by itself: no damping makes the port passive",
        ));
    };
    let (ratio, required) = cheapest(bare, sample_time_s.powf(mu), least)?;
    let dissipation = INSIDE * damping / required;
    let stiffness = ratio * dissipation;
    // jω·Z_c with (T/(1 − w))^μ ≈ (jω)^(−μ)
    let omega = 2.0 * PI * frequency_hz;
    let (angle, size) = (-0.5 * PI * mu, dissipation * omega.powf(-mu));
    let felt = omega * (stiffness + size * angle.cos()).hypot(size * angle.sin());
    Ok(CouplerCandidate {
        order: mu,
        stiffness: Some(stiffness),
        dissipation: Some(dissipation),
        margin: Some(1.0 / INSIDE),
        felt_stiffness_n_per_m: Some(felt),
        reason: None,
    })
}

/// The ratio `k_c/b_c` that needs the least damping, and that damping, which is `bare` without `k_c`: on a grid, then by golden
/// sections.
fn cheapest(
    bare: f64,
    scale: f64,
    least: impl Fn(f64) -> Result<Option<f64>, AnalysisError>,
) -> Result<(f64, f64), AnalysisError> {
    let ratio_at = |step: f64| scale * 10f64.powf(6.0 * step / f64::from(RATIOS) - 3.0);
    let needed =
        |step: f64| Ok::<f64, AnalysisError>(least(ratio_at(step))?.unwrap_or(f64::INFINITY));
    let mut best = (0.0, bare);
    let mut best_step = None;
    for step in 0..=RATIOS {
        let value = needed(f64::from(step))?;
        if value < best.1 {
            best = (ratio_at(f64::from(step)), value);
            best_step = Some(f64::from(step));
        }
    }
    if let Some(step) = best_step {
        let (mut low, mut high) = (step - 1.0, step + 1.0);
        let golden = 0.5 * (5f64.sqrt() - 1.0);
        for _ in 0..40 {
            let (a, b) = (high - golden * (high - low), low + golden * (high - low));
            if needed(a)? <= needed(b)? {
                high = b;
            } else {
                low = a;
            }
        }
        let middle = 0.5 * (low + high);
        best = (ratio_at(middle), needed(middle)?);
    }
    Ok(best)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fracdiff::{Order, Scheme, Seconds};

    fn operator(scheme: Scheme, mu: f64) -> LoopOperator {
        let order = Order::new(mu).expect("valid");
        LoopOperator::new(scheme, order, Seconds(1e-3), 1e4).expect("valid")
    }

    #[test]
    fn the_designed_coupler_is_passive_and_a_hair_more_is_not() {
        for (scheme, memory) in [(Scheme::Exact, 1), (Scheme::Muir { degree: 3 }, 4)] {
            for mu in [0.0, 0.5, 0.75, 1.0] {
                let operator = operator(scheme, mu);
                let found = stiffest_coupler(&operator, 0.7, 1e-3, 1.0).expect("valid");
                let (k, b) = (
                    found.stiffness.expect("one"),
                    found.dissipation.expect("one"),
                );
                let passive = |k: f64, b: f64| {
                    let exact = Coupler::exact(operator.order(), 1e-3, k, b).expect("valid");
                    let coupler = exact.with_operator(&operator, memory);
                    coupler.passive(0.7).expect("valid")
                };
                assert!(passive(k, b), "{scheme} μ {mu}: {found:?}");
                assert!(
                    !passive(1.00001 * k, 1.00001 * b),
                    "{scheme} μ {mu}: {found:?}"
                );
                // No ratio on a coarse grid of its own does better.
                for decade in -4..=4 {
                    let ratio = 1e-3_f64.powf(mu) * 10f64.powi(decade);
                    assert!(
                        !passive(1.001 * b * ratio, 1.001 * b),
                        "{scheme} μ {mu}, {ratio}"
                    );
                }
            }
        }
    }

    #[test]
    fn above_order_one_and_without_damping_there_is_none() {
        for (mu, damping) in [(1.5, 1.0), (0.5, 0.0)] {
            let operator = operator(Scheme::Exact, mu);
            let found = stiffest_coupler(&operator, damping, 1e-3, 1.0).expect("valid");
            assert!(
                found.dissipation.is_none() && found.reason.is_some(),
                "{found:?}"
            );
        }
    }
}
