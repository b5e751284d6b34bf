//! Bias of the parameters of a motion by noise in its strain.
//! ```text
//! σ = median |Δ⁶ε|/(0.6745·√924)                Δ⁶ the sixth differences, of which a smooth motion has next to nothing
//! bias of θ ≈ mean of θ(ε + σ·n) − θ(ε)         n standard normal
//! ```
//! A fit of the stress takes the strain as exact and differentiates its noise, and the errors of the parameters are those by the stress alone. As
//! much noise again moves a parameter as far again, so that the bias shows.
//!
//! - *Cost*: four fits of the chosen model, if the strain has noise above 1e-5 of its range.
//! - *Source*: J. R. Cook, L. A. Stefanski, *Simulation-extrapolation estimation in parametric measurement error models*, Journal of the American
//!   Statistical Association 89, 1994.

use super::record::Motion;
use super::reference::normal;
use super::{Fit, Identification, Options, Record, read};
use haptic_quantity::digits;
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng as _;
use std::sync::atomic::AtomicBool;

/// Median of the size of normal numbers, and root of the sum of the squares of the weights of a sixth difference.
const MEDIAN: f64 = 0.6745;
const SIXTH: f64 = 30.397_368_307_141_33;
/// Samples of a motion by which its noise is known.
const SAMPLES: usize = 20;
/// Steps of time differ by this share at most.
const EVEN: f64 = 0.01;
/// Noise below this share of the range of the strain moves nothing.
const NOISY: f64 = 1e-5;
const SETS: u64 = 4;
const STARTS: usize = 4;

/// Standard deviation of the noise of a signal at even times.
fn noise(time_s: &[f64], strain: &[f64]) -> Option<f64> {
    let steps = || time_s.windows(2).map(|pair| pair[1] - pair[0]);
    let (low, high) = (
        steps().fold(f64::INFINITY, f64::min),
        steps().fold(0.0, f64::max),
    );
    if time_s.len() < SAMPLES || high > (1.0 + EVEN) * low {
        return None;
    }
    let sixth = strain.windows(7).map(|e| {
        let ends = (e[0] + e[6]) - 6.0 * (e[1] + e[5]) + 15.0 * (e[2] + e[4]) - 20.0 * e[3];
        ends.abs()
    });
    let mut sixth: Vec<f64> = sixth.collect();
    sixth.sort_by(f64::total_cmp);
    let sigma = sixth[sixth.len() / 2] / (MEDIAN * SIXTH);
    let range = strain.iter().map(|x| (x - strain[0]).abs());
    let range = range.fold(0.0, f64::max);
    (sigma > NOISY * range).then_some(sigma)
}

/// A sentence about parameters that noise of the strain moves by more than their standard errors.
pub(super) fn moves(
    record: &Record,
    options: &Options,
    found: &Identification,
    stop: &AtomicBool,
) -> Option<String> {
    let is_sampled = |motion: &Motion| motion.way.is_none();
    if record.untimed.is_some() || !record.motions.iter().all(is_sampled) {
        return None;
    }
    let mut begin = 0;
    let parts = record.motions.iter().map(|motion| {
        let rows = begin..begin + motion.samples;
        begin = rows.end;
        Some((
            rows.clone(),
            noise(&record.x[rows.clone()], &record.first[rows])?,
        ))
    });
    let parts: Vec<_> = parts.flatten().collect();
    let largest = parts.iter().map(|part| part.1).reduce(f64::max)?;
    let fit = found.fits.first()?;
    let options = Options {
        candidates: vec![fit.kind],
        chosen: None,
        starts: options.starts.min(STARTS),
        bootstrap: 0,
        ..options.clone()
    };
    let noisier = |seed: u64| -> Option<Fit> {
        let mut generator = Pcg64::seed_from_u64(seed);
        let mut noisier = record.clone();
        for (rows, sigma) in &parts {
            // A motion begins at rest.
            for strain in noisier.first[rows.clone()].iter_mut().skip(1) {
                *strain += sigma * normal(&mut generator);
            }
        }
        let found = read(&noisier, &options, stop, &|_| ()).ok()?;
        // A sum may have another number of branches.
        let first = found.fits.into_iter().next();
        first.filter(|other| other.parameters.len() == fit.parameters.len())
    };
    let fits: Vec<Fit> = (1..=SETS).map(noisier).collect::<Option<_>>()?;
    let moved = fit
        .parameters
        .iter()
        .enumerate()
        .filter_map(|(n, estimate)| {
            let values = fits.iter().map(|fit| fit.parameters[n].value);
            let mean = values.sum::<f64>() / SETS as f64;
            let error = estimate.standard_error?;
            let is_moved = (mean - estimate.value).abs() > error;
            is_moved.then(|| {
                let [is, would] = [estimate.value, mean].map(|value| digits(value, 4));
                format!("`{}` from {is} to {would}", estimate.name)
            })
        });
    let moved: Vec<String> = moved.collect();
    (!moved.is_empty()).then(|| {
        format!(
            "the strain has noise of about {}, and as much again moves {}: more than the standard errors, which are by the noise of the \
             stress alone: smooth the strain, or command it",
            digits(largest, 2),
            moved.join(", ")
        )
    })
}
