//! How much of a coupler is taken: the ratio of its parts that needs the least damping, and the share that the sampled loop bears.

use crate::judge::preflight::softer;
use haptic_analysis::{AnalysisError, CoupledLoop};

/// Share of the largest coupler that is taken: the criterion is met with equality otherwise, and the operator of a longer run is
/// another one within its tolerance.
pub(super) const INSIDE: f64 = 1.0 - 1e-4;
/// Ratios tried.
const RATIOS: u32 = 200;
/// Gain margin of the sampled loop.
const LOOP_MARGIN: f64 = 2.0;

/// The largest share of a coupler, up to 1, whose loop has the gain margin, and the margin that it has.
pub(super) fn with_margin(
    closed: &CoupledLoop<'_>,
) -> Result<Option<(f64, Option<f64>)>, AnalysisError> {
    let margin = |share: f64| -> Result<Option<Option<f64>>, AnalysisError> {
        let closed = closed.scaled(share);
        if !closed.is_stable() {
            return Ok(None);
        }
        Ok(Some(closed.gain_margin()?.map(|edge| edge.value)))
    };
    let edge = match margin(1.0)? {
        Some(None) => return Ok(Some((1.0, None))),
        Some(Some(edge)) if edge >= LOOP_MARGIN => return Ok(Some((1.0, Some(edge)))),
        Some(Some(edge)) => Some(edge),
        None => softer(|factor| Ok(closed.scaled(factor).is_stable()))?,
    };
    let Some(edge) = edge else {
        return Ok(None);
    };
    let share = INSIDE * edge / LOOP_MARGIN;
    Ok(margin(share)?.map(|margin| (share, margin)))
}

/// The ratio `k_c/b_c` that needs the least damping, and that damping, which is `bare` without `k_c`: on a grid, then by golden
/// sections.
pub(super) fn cheapest(
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
