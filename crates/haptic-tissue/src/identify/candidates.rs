//! The candidates of a record, fitted and in order.

use super::elements::Candidate;
use super::error::IdentifyError;
use super::fit::{AS_GOOD, Certainty, Estimate, Fit, REFUSED, criteria, fit as fitted_to};
use super::noise::of_motions;
use super::options::{Options, candidates, target_of};
use super::record::digits;
use super::record::{Record, RecordKind};
use super::reference::{Misfit, Reference};
use super::search::{Best, polished, search};
use super::target::Target;
use super::{advice, bootstrap, profile, rendered, whitened};
use crate::model::ModelKind;
use fracdiff::parameter::Shown;
use rayon::prelude::*;
use std::sync::atomic::AtomicBool;
/// Models fitted to a record, best first.
#[derive(Clone, Debug, PartialEq)]
pub struct Identification {
    /// The kind of the record.
    pub kind: RecordKind,
    /// Samples of the whole record; of a long motion fewer are compared, which `warnings` says.
    pub samples: usize,
    /// Fits that converged, the chosen one first, the others by BIC.
    pub fits: Vec<Fit>,
    /// Times in s, or angular frequencies in rad/s, of the values that were fitted. For an
    /// oscillation each appears twice.
    pub x: Vec<f64>,
    /// The values: moduli, compliances, all storage and then all loss moduli, or stresses; for a
    /// long history a selection.
    pub measured: Vec<f64>,
    /// Contact point and baseline of the chosen fit, if they were looked for.
    pub placement: Vec<Estimate>,
    /// True if residuals are differences in the unit of the values, as of a motion; false if they are those of logarithms.
    pub is_absolute: bool,
    /// True of a creep under more than one step of stress, as with a recovery.
    pub is_staircase: bool,
    /// False of a motion without times, of which `x` are the numbers of the samples.
    pub is_timed: bool,
    /// Sentences that a user should know.
    pub warnings: Vec<String>,
}

impl Identification {
    /// The residual of each value, model minus record: a share of the value, or a difference in its unit.
    #[must_use]
    pub fn residuals(&self, fit: &Fit) -> Vec<f64> {
        let both = fit.predicted.iter().zip(&self.measured);
        both.map(|(model, measured)| match self.is_absolute {
            true => model - measured,
            false => relative(libm::log(model / measured)),
        })
        .collect()
    }
}

/// A residual r of a logarithm as a share of the value: e^r − 1, never below −1.
#[must_use]
pub fn relative(residual: f64) -> f64 {
    libm::expm1(residual)
}

/// Fits of a rendered creep record, each without the rendering that the fit before predicts.
const RENDERINGS: usize = 3;
const FAR_LESS: f64 = 0.25;
/// Starts and parameters of a model that suffice to choose how to read a record.
const FEW_STARTS: usize = 10;
const FEW_PARAMETERS: usize = 4;

/// As [`identified`], of a record that may be read in several ways: by that whose best fit makes the record most likely.
pub(super) fn read(
    record: &Record,
    options: &Options,
    stop: &AtomicBool,
    progress: &(dyn Fn(usize) + Sync),
) -> Result<Identification, IdentifyError> {
    let mut readings = record.readings();
    if readings.len() > 1 {
        // Two elements are enough to see of what kind the noise is.
        let wanted = options.candidates.iter().copied();
        let few = wanted.filter(|kind| kind.parameters().len() <= FEW_PARAMETERS);
        let plain = Options {
            candidates: match options.chosen {
                Some(kind) => vec![kind],
                None => few.collect(),
            },
            starts: options.starts.min(FEW_STARTS),
            ..options.clone()
        };
        let best = readings.drain(..).filter_map(|one| {
            let candidates = candidates(&plain, &one).ok()?;
            let target = target_of(&one, &plain, stop);
            let evidence = candidates.par_iter().filter_map(|&candidate| {
                let best = search(candidate, &target, plain.starts).ok()?;
                let fit = fitted_to(candidate, &target, &best).0;
                let count = fit.predicted.len() as f64;
                let numbers = fit.parameters.len() as f64;
                let left = 2.0 * count * libm::log(fit.rms.max(f64::MIN_POSITIVE));
                Some(left + target.ln_sizes() + numbers * libm::log(count))
            });
            Some((evidence.min_by(f64::total_cmp)?, one))
        });
        let best: Option<(f64, Record)> = best.min_by(|a, b| a.0.total_cmp(&b.0));
        readings.extend(best.map(|best| best.1));
    }
    let record = readings.first().unwrap_or(record);
    identified(record, options, stop, progress)
}

/// Fits the candidates, without stiffening.
pub(super) fn identified(
    record: &Record,
    options: &Options,
    stop: &AtomicBool,
    progress: &(dyn Fn(usize) + Sync),
) -> Result<Identification, IdentifyError> {
    let candidates = candidates(options, record)?;
    let record = &noisy(record, |record| {
        let target = target_of(record, options, stop);
        let compressed = target.compressed();
        let fits = richest(&candidates).filter_map(|candidate| {
            let best = search(candidate, &compressed, options.starts.max(1)).ok()?;
            Some(fitted_to(candidate, &target, &best).0)
        });
        let least = fits.min_by(Fit::by_bic)?;
        Some((least, target))
    });
    let target = target_of(record, options, stop);
    let compressed = target.compressed();
    let (mut fitted, mut failed) = (Vec::new(), Vec::new());
    // Each by itself: the result does not depend on the threads.
    let all = candidates.par_iter();
    let all =
        all.map(|&candidate| tried(candidate, record, [&target, &compressed], options.starts));
    let all: Vec<Result<_, IdentifyError>> = all.collect();
    for (one, candidate) in all.into_iter().zip(candidates) {
        match one {
            Ok(one) => fitted.push(one),
            Err(error) if options.chosen == Some(candidate.kind()) => return Err(error),
            Err(error) => failed.push(error),
        }
    }
    let reference = compare(&mut fitted, &target, record.is_own_log);
    fitted.sort_by(|a, b| a.fit.by_bic(&b.fit));
    let misfit = |index: usize| fitted[index].misfit(reference.as_ref()?);
    let fits = || fitted.iter().map(|fitted| &fitted.fit);
    let Some(index) = chosen(fits(), options.chosen, &|index| misfit(index).is_some()) else {
        // The error of the model with the fewest parameters.
        return Err(failed.into_iter().next().unwrap_or_else(|| {
            IdentifyError::Record("there is no model to fit: give at least one".to_owned())
        }));
    };
    let misfit = misfit(index);
    let first = fitted.remove(index);
    fitted.insert(0, first);
    let mut warnings = record.warnings.clone();
    warnings.extend(failed.iter().map(ToString::to_string));
    let bics = fitted.iter().map(|fitted| fitted.fit.bic);
    let refused = bics.fold(f64::INFINITY, f64::min) + REFUSED;
    for (index, tried) in fitted.iter_mut().enumerate() {
        let (fit, candidate, best) = (&mut tried.fit, tried.candidate, &tried.best);
        let independent = fit.independent;
        let compressed = tried.unrendered.as_ref().unwrap_or(&compressed);
        let (records, seed) = (options.bootstrap, options.seed);
        let ends = if index == 0 && records > 0 {
            let (ends, fitted) = bootstrap::intervals(
                candidate,
                &target,
                best,
                independent,
                records,
                seed,
                progress,
            );
            let lost = records - fitted;
            if lost > 0 {
                warnings.push(format!(
                    "{lost} of {records} records of the bootstrap could not be fitted and are left out"
                ));
            }
            ends
        } else if index == 0 || fit.bic <= refused {
            profile::intervals(candidate, compressed, best, &tried.certainty)
        } else {
            continue;
        };
        for (estimate, (low, high)) in fit.parameters.iter_mut().zip(ends) {
            estimate.low_95 = Some(low).filter(|x| x.is_finite());
            estimate.high_95 = Some(high).filter(|x| x.is_finite());
        }
    }
    if let Some(sentence) = advice::about_length(target.samples(), record) {
        warnings.push(sentence);
    }
    let mut fits: Vec<Fit> = fitted.into_iter().map(|tried| tried.fit).collect();
    if !(record.nuisance.is_empty() && record.bounded.is_empty()) {
        fits.iter_mut()
            .for_each(|fit| as_measured(fit, record, &target));
    }
    warnings.extend(advice::about(
        &fits,
        record.is_absolute(),
        misfit,
        options.chosen,
    ));
    let (x, measured) = target.values(record);
    Ok(Identification {
        kind: record.kind(),
        samples: record.samples(),
        fits,
        x,
        measured,
        placement: Vec::new(),
        is_absolute: record.is_absolute(),
        is_staircase: record.steps.len() > 1,
        is_timed: record.untimed.is_none(),
        warnings,
    })
}

/// The model with what is fitted beside it, as the record has both.
pub(super) fn as_measured(fit: &mut Fit, record: &Record, target: &Target<'_>) {
    let measured = target.values(record).1;
    for (n, (predicted, measured)) in fit.predicted.iter_mut().zip(measured).enumerate() {
        *predicted += measured - target.wanted(n) * target.scale;
    }
}

/// A fit, the model it is of, and the minimum with its certainty.
struct Tried<'a> {
    fit: Fit,
    candidate: Candidate,
    best: Best,
    certainty: Certainty,
    /// The record without what rendering did to it.
    unrendered: Option<Target<'a>>,
    /// The residual comes from the rendering: it holds no noise to compare by.
    is_rendered: bool,
    /// The minimum through the filter of the noise.
    whitened: Option<Best>,
}

impl Tried<'_> {
    /// Misfit beyond that of the reference, if it is no chance.
    fn misfit(&self, reference: &Reference<'_>) -> Option<Misfit> {
        reference.misfit(self.candidate, self.whitened.as_ref()?)
    }
}

/// Compares fits through the noise of the reference: through its own, one that misses the record would have its misfit excused. A log of our
/// own, which a loop may have rendered, has the noise of the closest.
fn compare<'a>(
    fitted: &mut [Tried<'_>],
    target: &Target<'a>,
    is_own_log: bool,
) -> Option<Reference<'a>> {
    let noisy = fitted.iter().filter(|tried| !tried.is_rendered);
    let closest = noisy.min_by(|a, b| a.fit.rms.total_cmp(&b.fit.rms))?;
    let (candidate, best) = (closest.candidate, &closest.best);
    let reference = (!is_own_log).then(|| Reference::of(target, candidate, best));
    let reference = reference.flatten();
    let noise = match &reference {
        Some(reference) => reference.noise(),
        None => whitened::noise(candidate, target, best),
    };
    let noisy = fitted.par_iter_mut().filter(|tried| !tried.is_rendered);
    noisy.for_each(|tried| {
        let (criteria, best) = whitened::through(noise, tried.candidate, target, &tried.best);
        [tried.fit.aic, tried.fit.bic] = criteria;
        tried.whitened = Some(best);
    });
    reference
}

/// Fits a candidate to a record, whole and compressed.
fn tried<'a>(
    candidate: Candidate,
    record: &Record,
    [target, compressed]: [&Target<'a>; 2],
    starts: usize,
) -> Result<Tried<'a>, IdentifyError> {
    let mut best = search(candidate, compressed, starts.max(1))?;
    let (mut fit, mut certainty) = fitted_to(candidate, target, &best);
    let mut is_rendered = rendered::is_rendered(record, target, candidate, &best, &fit);
    let mut unrendered = None;
    if let Some((to, closer)) = without_rendering(record, target, candidate, (&best, &fit)) {
        (fit, certainty) = fitted_to(candidate, &to, &closer);
        (best, unrendered, is_rendered) = (closer, Some(to), true);
    }
    if is_rendered {
        let numbers = candidate.parameters() + target.nuisance;
        [fit.aic, fit.bic] = criteria(target, 0.0, numbers);
    }
    Ok(Tried {
        fit,
        candidate,
        best,
        certainty,
        unrendered,
        is_rendered,
        whitened: None,
    })
}

/// A creep without what rendering makes of the model of a fit, and the minimum there, if that leaves far less.
fn without_rendering<'a>(
    record: &Record,
    target: &Target<'a>,
    candidate: Candidate,
    (best, fit): (&Best, &Fit),
) -> Option<(Target<'a>, Best)> {
    if !(record.is_own_log && record.has_steps()) {
        return None;
    }
    let (mut fit, mut closer) = (fit.clone(), best.clone());
    let mut unrendered = target.clone();
    for _ in 0..RENDERINGS {
        unrendered = rendered::without_rendering(record, target, candidate, (&closer, &fit))?;
        let start = closer.elements.variables(candidate.joint());
        closer = polished(candidate, &unrendered, [start].iter()).ok()?;
        fit = fitted_to(candidate, &unrendered, &closer).0;
    }
    (closer.sum < FAR_LESS * best.sum).then_some((unrendered, closer))
}

/// Those with the most parameters, which leave the least but noise.
pub(super) fn richest(candidates: &[Candidate]) -> impl Iterator<Item = Candidate> {
    let count = |candidate: &Candidate| candidate.parameters();
    let most = candidates.iter().map(count).max();
    let all = candidates.iter().copied();
    all.filter(move |candidate| Some(count(candidate)) == most)
}

/// A record of several motions with the noise of each, from the residuals of a first fit, and a note on which noise was assumed.
pub(super) fn noisy<'r, 's>(
    record: &'r Record,
    first: impl FnOnce(&'r Record) -> Option<(Fit, Target<'s>)>,
) -> Record {
    let is_known = record.motions.iter().any(|motion| motion.noise.is_some());
    let first = match record.motions.len() < 2 || is_known {
        true => None,
        false => first(record),
    };
    let mut record = record.clone();
    let Some((fit, target)) = first else {
        return record;
    };
    let stress_pa = target.values(&record).1;
    let pairs = fit.predicted.iter().zip(&stress_pa);
    let residuals: Vec<f64> = pairs.map(|(model, stress)| model - stress).collect();
    let [residuals, stresses] = [&residuals, &stress_pa].map(|all| target.of_motions(&record, all));
    let noise = of_motions(&residuals, &stresses, fit.parameters.len());
    let shown: Vec<String> = noise
        .iter()
        .map(|one| Shown(digits(*one)).to_string())
        .collect();
    let shown = shown.join(", ");
    record.warnings.push(match noise.len() {
        1 => format!("all motions are taken to have the same noise, {shown} Pa"),
        _ => format!("the noise of the motions differs: each counts by its own, {shown} Pa"),
    });
    for (motion, noise) in record.motions.iter_mut().zip(noise.iter().cycle()) {
        motion.noise = Some(*noise);
    }
    record
}

/// As [`chosen`], without a reference.
pub(super) fn choose<'a>(
    fits: impl Iterator<Item = &'a Fit> + Clone,
    wanted: Option<ModelKind>,
) -> Option<usize> {
    chosen(fits, wanted, &|_| false)
}

/// Index of the wanted model in fits sorted by BIC; else of the one with the fewest parameters within [`AS_GOOD`] of the best that leaves no
/// more than the reference, of all if each leaves more.
fn chosen<'a>(
    fits: impl Iterator<Item = &'a Fit> + Clone,
    wanted: Option<ModelKind>,
    leaves_more: &dyn Fn(usize) -> bool,
) -> Option<usize> {
    let mut places = fits.enumerate();
    if let Some(wanted) = wanted {
        return places.position(|(_, fit)| fit.kind == wanted);
    }
    // A fit that has degenerated to a simpler model, or is not settled, makes no tissue; it is chosen only if there is no other.
    let sound = |fit: &Fit| fit.is_settled() && fit.to_model().is_ok();
    let any = places.clone().any(|(_, fit)| sound(fit));
    let places = places.filter(|(_, fit)| !any || sound(fit));
    let near = places.clone().find(|(index, _)| !leaves_more(*index));
    let is_refused = near.is_none();
    let good = near.or_else(|| places.clone().next())?.1.bic + AS_GOOD;
    let mut good: Vec<(usize, &Fit)> = places.filter(|(_, fit)| fit.bic <= good).collect();
    good.sort_by_key(|(_, fit)| fit.parameters.len());
    let found = good
        .iter()
        .find(|(index, _)| is_refused || !leaves_more(*index));
    found.map(|(index, _)| *index)
}
