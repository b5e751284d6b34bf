//! Claims 7 and 8: which walls are passive.

use super::{Evidence, Formulas, falls, fine_orders, list};
use crate::{DELTA, Kind};
use fracdiff::Order;
use haptic_analysis::{AnalysisError, Largest, OnePort};

/// α, β of walls on which the corollary is tried.
const WALLS: [(f64, f64); 3] = [(0.0, 1.0), (1.0, 0.0), (0.3, 0.7)];

pub(crate) fn corollary_one(kind: Kind, formulas: &Formulas) -> Result<Evidence, AnalysisError> {
    // The largest needed over promised.
    let mut worst = (0.0_f64, 0.0, (0.0, 0.0), 0.0, 0.0);
    for mu in fine_orders() {
        let operator = kind.operator(mu)?;
        let order = Order::new(mu)?;
        let port = OnePort::new(&operator, order)?;
        for (alpha, beta) in WALLS {
            let required = port.required_delta(alpha, beta)?.delta;
            let promised = (formulas.passivity)(order, alpha, beta)?;
            let factor = required / promised;
            if factor > worst.0 {
                worst = (factor, mu, (alpha, beta), required, promised);
            }
        }
    }
    let (factor, mu, (alpha, beta), required, promised) = worst;
    let (alpha_c, beta_c) = WALLS[2];
    // Colgate: b > KT/2 + B, so δ > α/2 + β.
    let colgate =
        (formulas.passivity)(Order::new(1.0)?, alpha_c, beta_c)? - (0.5 * alpha_c + beta_c);
    let enough = factor <= 1.0 + 1e-9;
    let most = if enough {
        format!(
            "the damping of (5.1) is enough, at least {:.9} times what is needed",
            1.0 / factor
        )
    } else {
        format!(
            "not enough by a factor {factor:.3} at μ = {mu}, α = {alpha}, β = {beta}: δ = {required:.4} needed, \
             {promised:.4} promised"
        )
    };
    Ok(Evidence {
        holds: enough && colgate.abs() <= 1e-9,
        numbers: if colgate == 0.0 {
            format!("{most}; at μ = 1 it is Colgate's")
        } else {
            format!("{most}; at μ = 1 it differs from Colgate's by {colgate:.1e}")
        },
    })
}

/// Area of the passive walls in the α–β plane at the δ of section 4.4, by `steps` steps in α, from the largest down.
pub(crate) fn passive_boundary(
    kind: Kind,
    mu: f64,
    delta: f64,
    steps: usize,
) -> Result<Vec<(f64, f64)>, AnalysisError> {
    let operator = kind.operator(mu)?;
    let port = OnePort::new(&operator, Order::new(mu)?)?;
    let Largest::Below { value: most, .. } = port.largest_alpha(delta, 0.0)? else {
        return Ok(Vec::new());
    };
    let points = (0..=steps).map(|step| {
        // A hair below the largest α, where the largest β is 0.
        let alpha = most * (1.0 - step as f64 / steps as f64).min(1.0 - 1e-9);
        Ok(match port.largest_beta(delta, alpha)? {
            Largest::Below { value, .. } => (value.max(0.0), alpha),
            _ => (0.0, alpha),
        })
    });
    points.collect()
}

pub(crate) fn passivity_region(kind: Kind, _: &Formulas) -> Result<Evidence, AnalysisError> {
    let areas = (0..=8)
        .map(|quarter| {
            let boundary = passive_boundary(kind, f64::from(quarter) / 4.0, DELTA, 200)?;
            let trapezoids = boundary
                .windows(2)
                .map(|p| 0.5 * (p[0].1 - p[1].1) * (p[0].0 + p[1].0));
            Ok(trapezoids.sum())
        })
        .collect::<Result<Vec<f64>, AnalysisError>>()?;
    Ok(Evidence {
        holds: falls(&areas),
        numbers: format!(
            "area at μ = 0, 0.5, 1, 1.5, 2: {}",
            list(areas.into_iter().step_by(2))
        ),
    })
}
