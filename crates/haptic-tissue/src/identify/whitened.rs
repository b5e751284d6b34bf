//! Models compared where neighbouring residuals are alike.
//! ```text
//! fit → autoregression of the residuals → both sides through its filter → fit, four times
//! criterion = n·ln(Σ e²/n) + what the first samples add + (k + order)·ln n + …       e the filtered residuals, one n for all candidates
//! ```
//! A residual that drifts makes every criterion prefer the model that draws the drift. The filter runs along time or frequency, in each series
//! of residuals by itself. Order 0, of white noise, changes nothing. Neither does a residual that does not look like noise: more than a few per
//! cent of the record, or so smooth that its filter leaves next to nothing of it. That is what a model misses, and no drift excuses it.
//!
//! Parameters stay those of least squares: with either filter they are the same within their errors, and the errors know how alike residuals are.
//!
//! - *Cost*: some ten evaluations of the model a round; a record of more than 4000 samples is compared by means of neighbours.
//! - *Source*: D. Cochrane, G. H. Orcutt, *Application of least squares regression to relationships containing auto-correlated error
//!   terms*, Journal of the American Statistical Association 44, 1949.

use super::elements::{Candidate, Elements};
use super::fit::criteria_of;
use super::search::{Best, polished};
use super::target::{EXACT, Target};
use fractional_control::autoregression::Autoregression;

const ROUNDS: usize = 4;
/// Noise is at most this share of a record, and its filter leaves at least this share of it.
const NOISE: f64 = 0.1;
const NEW: f64 = 0.2;

/// Residuals as they are weighted.
fn residuals(candidate: Candidate, target: &Target<'_>, elements: &Elements) -> Vec<f64> {
    let mut all = vec![0.0; target.len()];
    target.residuals(candidate, elements, |n, root, slope| {
        all[n] = root * slope.value;
    });
    all
}

/// AIC and BIC of a candidate by filtered residuals, from the best fit of plain ones; none if what is left is white, or no noise.
pub(super) fn criteria(candidate: Candidate, target: &Target<'_>, best: &Best) -> Option<[f64; 2]> {
    let plain = target.averaged();
    let (mut best, mut noise) = (best.clone(), Autoregression::default());
    for _ in 0..ROUNDS {
        let left = residuals(candidate, &plain, &best.elements);
        let next = Autoregression::of(&plain.series(&left));
        let size = |all: &[f64]| all.iter().map(|x| x * x).sum::<f64>();
        let new: f64 = (plain.series(&left).iter())
            .map(|part| size(&next.whitened(part)))
            .sum();
        let is_noise =
            size(&left) < NOISE * NOISE * left.len() as f64 && new > NEW * NEW * size(&left);
        if !is_noise || next.order() + noise.order() == 0 {
            return None;
        }
        noise = next;
        let start = best.elements.variables(candidate);
        let to = plain.filtered(noise.clone());
        best = polished(candidate, &to, [start].iter()).ok()?;
    }
    let left = residuals(candidate, &plain, &best.elements);
    let deviance = noise.deviance(&plain.series(&left), EXACT);
    let numbers = candidate.parameters() + target.beside + noise.order();
    Some(criteria_of(plain.len(), deviance, numbers))
}
