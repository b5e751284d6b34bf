//! Claims 1 to 3: how large the stability region is.

use super::{Evidence, Formulas, fine_orders, list};
use crate::{DELTA, Kind};
use haptic_analysis::{AnalysisError, SampledPlant, StabilityRegion, StableArea};

/// The stability region of the device of section 4.4 with another δ and γ; `None` if empty.
pub(crate) fn region(
    kind: Kind,
    mu: f64,
    delta: f64,
    gamma: f64,
    points: usize,
) -> Result<Option<StableArea>, AnalysisError> {
    let operator = kind.operator(mu)?;
    let plant = SampledPlant::new(delta, gamma)?;
    let region = StabilityRegion::new(plant, &operator, 0, points)?;
    Ok(region.bounded().cloned())
}

/// Largest α, largest β and area of a region; zeros if empty.
pub(super) fn size(
    kind: Kind,
    mu: f64,
    delta: f64,
    gamma: f64,
) -> Result<(f64, f64, f64), AnalysisError> {
    Ok(region(kind, mu, delta, gamma, 200)?
        .map_or((0.0, 0.0, 0.0), |r| (r.alpha_max, r.beta_max, r.area)))
}

pub(crate) fn area_grows(kind: Kind, _: &Formulas) -> Result<Evidence, AnalysisError> {
    let areas = fine_orders()
        .map(|mu| Ok((mu, size(kind, mu, DELTA, 0.0)?.2)))
        .collect::<Result<Vec<_>, AnalysisError>>()?;
    let fall = areas.windows(2).find(|pair| pair[1].1 <= pair[0].1);
    Ok(Evidence {
        holds: fall.is_none(),
        numbers: format!(
            "area at μ = 0, 0.5, 1, 1.5, 2: {}{}",
            list(areas.iter().step_by(5).map(|(_, area)| *area)),
            fall.map_or_else(String::new, |pair| format!(
                "; it first falls from μ = {} ({:.4}) to {} ({:.4})",
                pair[0].0, pair[0].1, pair[1].0, pair[1].1
            ))
        ),
    })
}

pub(crate) fn stiffest_at_two(kind: Kind, _: &Formulas) -> Result<Evidence, AnalysisError> {
    // The stiffest of the others: at 2 it would be the same number twice.
    let (mut order, mut below) = (0.0, 0.0);
    for mu in fine_orders().filter(|mu| *mu < 2.0) {
        let alpha = size(kind, mu, DELTA, 0.0)?.0;
        if alpha > below {
            (order, below) = (mu, alpha);
        }
    }
    let at_two = size(kind, 2.0, DELTA, 0.0)?.0;
    Ok(Evidence {
        holds: at_two > below,
        numbers: format!(
            "largest α = {at_two:.4} at μ = 2; of the orders below, {below:.4} at μ = {order}"
        ),
    })
}

pub(crate) fn largest_beta_falls(kind: Kind, _: &Formulas) -> Result<Evidence, AnalysisError> {
    let before = size(kind, 1.5, DELTA, 0.0)?.1;
    let after = size(kind, 2.0, DELTA, 0.0)?.1;
    Ok(Evidence {
        holds: after < before,
        numbers: format!("largest β = {before:.4} at μ = 1.5, {after:.4} at μ = 2"),
    })
}
