//! Intervals of parameters by fitting again to records that might have been.
//!
//! Each is the fitted curve and the residuals of the fit, over their errors where these are known, drawn anew in blocks of some lengths over which residuals are alike:
//! 1 sample for white noise, ⌈4τ⌉ for noise of which one in τ is independent, an eighth of the record at most. Slow noise has its slow
//! part in the fit and not in the residuals: the profiles give it back, the bootstrap does not, and is narrower. The interval is from
//! the 2.5 % to the 97.5 % point of the refitted parameters. Records are numbered and each number seeds its own generator, so that the
//! result does not depend on the number of threads.
//!
//! Source: H. R. Künsch, *The jackknife and the bootstrap for general stationary observations*, Annals of Statistics 17, 1989.

use super::elements::Candidate;
use super::fit::parameters;
use super::search::{Best, Compared, FINE, loose, ranges};
use super::target::Target;
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng as _, SeedableRng as _};
use rayon::prelude::*;
use spring_pots::{Elements, minimise};

/// Fits `records` resampled records; `independent` residuals set the length of a block. Calls `progress` for each.
pub(super) fn intervals(
    candidate: Candidate,
    target: &Target,
    best: &Best,
    independent: f64,
    records: usize,
    seed: u64,
    progress: &(dyn Fn(usize) + Sync),
) -> (Vec<(f64, f64)>, usize) {
    let n = target.len();
    let (mut curve, mut residuals) = (vec![0.0; n], vec![0.0; n]);
    target.residuals(candidate, &best.elements, |i, _, slope| {
        residuals[i] = slope.value / target.noise_size(i);
        curve[i] = slope.value + target.wanted(i);
    });
    target.apart(candidate, &best.elements, |i, residual| {
        curve[i] = residual + target.wanted(i);
    });
    let alike = n as f64 / independent;
    let block = if alike > 1.0 { 4.0 * alike } else { 1.0 };
    let block = (block.ceil() as usize).clamp(1, (n / 8).max(1));
    let ranges = ranges(candidate, target);
    let start = best.elements.variables(candidate.joint());
    let free = loose(&ranges);
    let fits: Vec<Vec<f64>> = (0..records)
        .into_par_iter()
        .filter_map(|record| {
            if target.stops() {
                return None;
            }
            let drawn = draw(&residuals, block, seed.wrapping_add(record as u64));
            let drawn = target.sharing(drawn);
            let pairs = curve.iter().zip(drawn).enumerate();
            let values =
                pairs.map(|(n, (curve, residual))| curve + residual * target.noise_size(n));
            let target = target.with_values(values.collect());
            let fit = minimise(
                &Compared(candidate, &target),
                &ranges,
                &start,
                &free,
                &[],
                FINE,
            );
            progress(1);
            let elements = candidate.sorted(Elements::from_variables(&fit.values));
            fit.converged
                .then(|| parameters(candidate, &elements, target.unit_s))
        })
        .collect();
    let ends = (0..candidate.kind().parameters().len())
        .map(|v| ends(fits.iter().map(|fit| fit[v]).collect()));
    (ends.collect(), fits.len())
}

/// Draws a series of the same length from the residuals, in blocks from random places.
fn draw(residuals: &[f64], block: usize, seed: u64) -> Vec<f64> {
    let n = residuals.len();
    let mut generator = Pcg64::seed_from_u64(seed);
    let mut drawn = Vec::with_capacity(n + block);
    while drawn.len() < n {
        // 64 bits over far fewer places: the bias of the remainder is below 1e-12.
        let first = (generator.next_u64() % (n - block + 1) as u64) as usize;
        drawn.extend_from_slice(&residuals[first..first + block]);
    }
    drawn.truncate(n);
    drawn
}

/// The 2.5 % and the 97.5 % point, between neighbours by proportion; NaN without values.
fn ends(mut values: Vec<f64>) -> (f64, f64) {
    values.sort_by(f64::total_cmp);
    let point = |share: f64| {
        let rank = share * (values.len().saturating_sub(1)) as f64;
        let below = rank as usize;
        let low = values.get(below).copied().unwrap_or(f64::NAN);
        let high = values.get(below + 1).copied().unwrap_or(low);
        low + (rank - below as f64) * (high - low)
    };
    (point(0.025), point(0.975))
}
