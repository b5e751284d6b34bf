//! A record that a loop made: its samples are those of a model as it is rendered at their sample time.
//! ```text
//! r = σ of the fitted model as rendered, less the record     J = ∂σ/∂θ of the fit     rendered:  |r − J·J⁺r|² ≤ n·e²
//! ```
//! with e the accuracy of any record. What is rendered follows the law of its model in continuous time to the first power of the sample
//! time alone, and the first samples after a kink of the strain miss it by a tenth. That is no misfit of the model, and no further element
//! may be bought with it; but how much it is depends on model, motion and sample time. So the fitted model itself is rendered, at
//! parameters that may lie beside the fitted ones as far as J is straight. A creep is fitted once more to what the record is without the
//! difference between the fitted model and its rendering, if that leaves a quarter of the squares. It is asked of our own logs alone: the
//! records of others are evenly sampled too, and no loop made them.
//!
//! - *Cost*: some 100 multiply-adds for each sample and element, where a fit is near but not exact.
//! - *Source*: C. Lubich, *Discretized fractional calculus*, SIAM Journal on Mathematical Analysis 17, 1986 (the error of the sums).

use super::elements::Candidate;
use super::fit::Fit;
use super::record::Record;
use super::search::Best;
use super::target::{EXACT, Target};
use fracdiff::Seconds;
use haptic_tissue::{FullHistory, SampledModel};
use nalgebra::{DMatrix, DVector};

/// A fit that leaves more than this share of the stress is not that of a rendered record.
const NEAR: f64 = 0.1;
/// Largest distance of the rendered parameters, in ln V and α, from the fitted ones. Two elements with one order can be exchanged
/// without end, and would make nearly any stress.
const BESIDE: f64 = 0.1;
/// Times are even within this share of the sample time.
const EVEN: f64 = 1e-3;

/// True if the record is what a loop renders of the model of a fit.
pub(super) fn is_rendered(
    record: &Record,
    target: &Target<'_>,
    candidate: Candidate,
    best: &Best,
    fit: &Fit,
) -> bool {
    let left = libm::sqrt(best.sum / target.len() as f64);
    if !(record.is_own_log && left > EXACT && left < NEAR) {
        return false;
    }
    let Some(stresses) = rendered(record, fit) else {
        return false;
    };
    let chosen = target.chosen();
    let mut residuals = DVector::zeros(chosen.len());
    let mut slopes = DMatrix::zeros(chosen.len(), best.free.len());
    target.residuals(candidate, &best.elements, |n, _, slope| {
        let sample = chosen[n];
        residuals[n] = (stresses[sample] - record.second[sample]) / target.scale;
        for (k, &variable) in best.free.iter().enumerate() {
            slopes[(n, k)] = slope.by[variable];
        }
    });
    let parts = slopes.qr();
    let unit = parts.q();
    let made = unit.tr_mul(&residuals);
    residuals -= &unit * &made;
    let moved = parts.r().solve_upper_triangular(&made);
    let is_beside = moved.is_some_and(|moved| moved.amax() <= BESIDE);
    is_beside && residuals.norm() <= EXACT * libm::sqrt(chosen.len() as f64)
}

/// The target of a creep without what rendering the fitted model does to it.
pub(super) fn without_rendering<'a>(
    record: &Record,
    target: &Target<'a>,
    candidate: Candidate,
    (best, fit): (&Best, &Fit),
) -> Option<Target<'a>> {
    let strains = rendered_creep(record, fit)?;
    let chosen = target.chosen();
    let mut wanted = vec![0.0; target.len()];
    target.residuals(candidate, &best.elements, |n, _, slope| {
        let model = slope.value + target.wanted(n);
        let rendered = if record.is_absolute() {
            strains[chosen[n]] / target.scale
        } else {
            libm::log(strains[chosen[n]])
        };
        wanted[n] = target.wanted(n) + model - rendered;
    });
    Some(target.with_values(wanted))
}

/// The stresses of a fitted model over a plain motion with even times, as they are rendered.
fn rendered(record: &Record, fit: &Fit) -> Option<Vec<f64>> {
    let [motion] = &record.motions[..] else {
        return None;
    };
    let is_plain = motion.map.is_none()
        && motion.way.is_none()
        && record.nuisance.is_empty()
        && record.bounded.is_empty();
    let (times, strains) = (&record.x, &record.first);
    let sample_time = even(times).filter(|_| is_plain)?;
    let sampled = SampledModel::new(&fit.to_model().ok()?, Seconds(sample_time)).ok()?;
    let mut history = FullHistory::new(&sampled, times.len()).ok()?;
    let stresses = strains
        .iter()
        .map(|strain| history.step(strain - strains[0]));
    Some(stresses.collect())
}

/// The strains of a fitted model under the steps of a creep whose samples have even times from the first step on, as they are rendered.
fn rendered_creep(record: &Record, fit: &Fit) -> Option<Vec<f64>> {
    let sample_time = even(&record.x)?;
    let is_whole = (record.x[0] - sample_time).abs() <= EVEN * sample_time;
    if !is_whole {
        return None;
    }
    let sampled = SampledModel::new(&fit.to_model().ok()?, Seconds(sample_time)).ok()?;
    let mut history = FullHistory::new(&sampled, record.x.len() + 1).ok()?;
    let strains = std::iter::once(&0.0).chain(&record.x).map(|time| {
        let steps = record.steps.iter();
        let begun = steps.filter(|step| step[0] <= time + EVEN * sample_time);
        let stress: f64 = begun.map(|step| step[1]).sum();
        let strain = (stress - history.past()) / history.gain();
        history.advance(strain);
        strain
    });
    Some(strains.skip(1).collect())
}

/// The distance of times that are even.
fn even(times: &[f64]) -> Option<f64> {
    let sample_time = (times.last()? - times[0]) / (times.len() - 1) as f64;
    let mut all = times.iter().enumerate();
    let is_even = all.all(|(n, time)| {
        let expected = times[0] + n as f64 * sample_time;
        (time - expected).abs() <= EVEN * sample_time
    });
    is_even.then_some(sample_time)
}
