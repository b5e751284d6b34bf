//! Models compared where neighbouring residuals are alike.
//! ```text
//! closest fit → autoregression of its residuals → both sides through that filter → fit, four times
//! criterion = n·ln(Σ e²/n) + what the first samples add + (k + order)·ln n + …       e the filtered residuals, one n and filter for all candidates
//! ```
//! A residual that drifts makes every criterion prefer the model that draws the drift. All candidates are compared through one noise, that
//! of the [reference](super::reference), or without one that of the closest: through its own, one that misses the record would have its misfit excused. The filter runs along time or frequency, in each series
//! of residuals separately. Order 0, of white noise, changes nothing. Neither does a residual that does not look like noise: more than a tenth of
//! the record, or so smooth that its filter leaves next to nothing of it. That is what a model misses, and no drift excuses it. Without
//! a reference fewer than 100 samples cannot distinguish the two, and are compared as they are.
//!
//! Parameters stay those of least squares: with either filter they are the same within their errors, and the errors know how alike residuals are.
//!
//! - *Cost*: some ten evaluations of the model a round; a record of more than 4000 samples is compared by means of neighbours.
//! - *Source*: D. Cochrane, G. H. Orcutt, *Application of least squares regression to relationships containing auto-correlated error
//!   terms*, Journal of the American Statistical Association 44, 1949.

use super::elements::Candidate;
use super::fit::criteria_of;
use super::search::{Best, polished};
use super::target::Target;
use control_identification::autoregression::Autoregression;
use spring_pots::Elements;

const ROUNDS: usize = 4;
/// Samples without which a drift and a misfit look alike.
const LEAST: usize = 100;
/// Noise is at most this share of a record, and its filter leaves at least this share of it.
const NOISE: f64 = 0.1;
const NEW: f64 = 0.1;

/// Residuals as they are weighted.
pub(super) fn residuals(
    candidate: Candidate,
    target: &Target<'_>,
    elements: &Elements,
) -> Vec<f64> {
    let mut all = vec![0.0; target.len()];
    target.residuals(candidate, elements, |n, root, slope| {
        all[n] = root * slope.value;
    });
    all
}

/// AIC and BIC of a candidate, from the best fit of plain residuals: by those through the filter of its own noise.
pub(super) fn criteria(candidate: Candidate, target: &Target<'_>, best: &Best) -> [f64; 2] {
    through(noise(candidate, target, best), candidate, target, best).0
}

/// AIC and BIC of a candidate through this filter, refitted, and the fit.
pub(super) fn through(
    noise: Autoregression,
    candidate: Candidate,
    target: &Target<'_>,
    best: &Best,
) -> ([f64; 2], Best) {
    let plain = target.averaged();
    let refitted = (noise.order() > 0).then(|| {
        let start = best.elements.variables(candidate.joint());
        polished(candidate, &plain.filtered(noise), [start].iter()).ok()
    });
    let best = refitted.flatten().unwrap_or_else(|| best.clone());
    (by(&noise, candidate, &plain, &best), best)
}

fn by(noise: &Autoregression, candidate: Candidate, plain: &Target<'_>, best: &Best) -> [f64; 2] {
    let left = residuals(candidate, plain, &best.elements);
    let deviance = noise.deviance(&plain.series(&left), plain.floor);
    let numbers = candidate.parameters() + plain.nuisance;
    criteria_of(plain.len(), deviance, numbers + noise.order())
}

/// The noise of the residual of a fit; white where it does not look like noise, or its filter gains nothing.
pub(super) fn noise(candidate: Candidate, target: &Target<'_>, best: &Best) -> Autoregression {
    let plain = target.averaged();
    let white = Autoregression::default();
    let [_, as_it_is] = by(&white, candidate, &plain, best);
    let found = filtered(candidate, &plain, best);
    let found = found.filter(|(noise, best)| by(noise, candidate, &plain, best)[1] < as_it_is);
    found.map_or(white, |(noise, _)| noise)
}

/// The noise of the residual, and the fit through its filter; `None` if the residual is white, or does not look like noise.
fn filtered(
    candidate: Candidate,
    plain: &Target<'_>,
    best: &Best,
) -> Option<(Autoregression, Best)> {
    let (mut best, mut noise) = (best.clone(), Autoregression::default());
    if plain.len() < LEAST {
        return None;
    }
    for _ in 0..ROUNDS {
        let left = residuals(candidate, plain, &best.elements);
        let series = plain.series(&left);
        let next = Autoregression::of(&series);
        let size = |all: &[f64]| all.iter().map(|x| x * x).sum::<f64>();
        let new: f64 = series.iter().map(|part| size(&next.whitened(part))).sum();
        let is_small = size(&left) < NOISE * NOISE * left.len() as f64;
        let is_noise = is_small && new > NEW * NEW * size(&left);
        if !is_noise || next.order() + noise.order() == 0 {
            return None;
        }
        noise = next;
        let start = best.elements.variables(candidate.joint());
        let to = plain.filtered(noise);
        best = polished(candidate, &to, [start].iter()).ok()?;
    }
    Some((noise, best))
}
