//! The candidates of a record, fitted and in order.

use super::elements::Candidate;
use super::error::IdentifyError;
use super::fit::{AS_GOOD, Certainty, Estimate, Fit, REFUSED, criteria, fit as fitted_to};
use super::noise::of_motions;
use super::options::{Options, candidates, sums_wanted, target_of};
use super::record::digits;
use super::record::{Record, RecordKind};
use super::reference::{LEAST, Misfit, Reference};
use super::search::{Best, polished, search};
use super::sums::{self, Found};
use super::target::Target;
use super::{advice, bootstrap, instants, profile, rendered, whitened};
use fracdiff::parameter::Shown;
use haptic_tissue::ModelKind;
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
        both.map(|(model, measured)| {
            if self.is_absolute {
                model - measured
            } else {
                relative(libm::log(model / measured))
            }
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

/// Identifies as [`identified`] does, a record that may be read in several ways: by that whose best fit makes the record most likely.
pub(super) fn read(
    record: &Record,
    options: &Options,
    stop: &AtomicBool,
    progress: &(dyn Fn(usize) + Sync),
) -> Result<Identification, IdentifyError> {
    let mut readings = record.readings();
    let open = readings.par_iter_mut();
    let open = open.filter(|one| one.has_open_instants());
    open.for_each(|one| *one = instants::found(one, options, stop));
    if readings.len() > 1 {
        let spectra = readings.par_iter().map(|one| {
            let target = target_of(one, options, stop);
            Some(Reference::of(&target, None)?.evidence(&target))
        });
        let spectra: Option<Vec<f64>> = spectra.collect();
        let evidence = spectra.unwrap_or_else(|| {
            let few = readings.iter();
            few.map(|one| by_few(one, options, stop)).collect()
        });
        let best = evidence.into_iter().zip(readings.drain(..));
        let best = best.min_by(|a, b| a.0.total_cmp(&b.0));
        readings.extend(best.map(|best| best.1));
    }
    let record = readings.first().unwrap_or(record);
    identified(record, options, stop, progress)
}

/// −2·ln of the likelihood of a record too short for a spectrum: two elements are enough to see of what kind the noise is.
fn by_few(record: &Record, options: &Options, stop: &AtomicBool) -> f64 {
    let wanted = match options.chosen {
        Some(kind) => vec![kind],
        None => options.candidates.clone(),
    };
    let few =
        |kind: &ModelKind| options.chosen.is_some() || kind.parameters().len() <= FEW_PARAMETERS;
    let plain = Options {
        candidates: wanted.into_iter().filter(few).collect(),
        starts: options.starts.min(FEW_STARTS),
        ..options.clone()
    };
    let target = target_of(record, &plain, stop);
    let candidates = candidates(&plain, record).unwrap_or_default();
    let evidence = candidates.par_iter().filter_map(|&candidate| {
        let best = search(candidate, &target, plain.starts).ok()?;
        let fit = fitted_to(candidate, &target, &best).0;
        let count = fit.predicted.len() as f64;
        let numbers = fit.parameters.len() as f64;
        let left = 2.0 * count * libm::log(fit.weighted.max(f64::MIN_POSITIVE));
        Some(left + target.ln_sizes() + numbers * libm::log(count))
    });
    evidence.min_by(f64::total_cmp).unwrap_or(f64::INFINITY)
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
    let wanted = sums_wanted(options, record);
    if let Some(reference) = reference.as_ref().filter(|_| !wanted.is_empty()) {
        let sums = sums::found(&wanted, &target, reference).into_iter();
        fitted.extend(sums.map(|Found { fit, misfit }| Tried {
            fit,
            by: By::Modes(misfit),
        }));
    }
    fitted.sort_by(|a, b| a.fit.by_bic(&b.fit));
    let misfit = |index: usize| fitted[index].misfit(reference.as_ref()?);
    let fits = || fitted.iter().map(|fitted| &fitted.fit);
    let Some(index) = chosen(fits(), options.chosen, &|index| misfit(index).is_some()) else {
        let sum = options.chosen.or(options.candidates.first().copied());
        let no_sum = sum.filter(|kind| kind.is_sum()).map(|kind| {
            IdentifyError::Record(format!(
                "the record shows no {kind}, which needs {LEAST} numbers, modes within the record, nothing held, and is not fitted to a log of our own: give another model"
            ))
        });
        // The error of the model with the fewest parameters.
        return Err(no_sum.or(failed.into_iter().next()).unwrap_or_else(|| {
            IdentifyError::Record("there is no model to fit: give at least one".to_owned())
        }));
    };
    let misfit = misfit(index);
    let first = fitted.remove(index);
    fitted.insert(0, first);
    let mut warnings = record.warnings.clone();
    warnings.extend(failed.iter().map(ToString::to_string));
    warnings.extend(advice::about_errors(&fitted[0].fit, &target));
    let bics = fitted.iter().map(|fitted| fitted.fit.bic);
    let refused = bics.fold(f64::INFINITY, f64::min) + REFUSED;
    for (index, tried) in fitted.iter_mut().enumerate() {
        let fit = &mut tried.fit;
        let independent = fit.independent;
        let (records, seed) = (options.bootstrap, options.seed);
        let By::Elements(by) = &tried.by else {
            if index == 0 && records > 0 {
                warnings.push(format!(
                    "the intervals of a {} are those of its standard errors, not of a bootstrap",
                    fit.kind
                ));
            }
            continue;
        };
        let (candidate, best) = (by.candidate, &by.best);
        let compressed = by.unrendered.as_ref().unwrap_or(&compressed);
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
            profile::intervals(candidate, compressed, best, &by.certainty)
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
    let is_motion = record.kind == RecordKind::History;
    if is_motion && !(record.nuisance.is_empty() && record.bounded.is_empty()) {
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

/// A fit, and how it was found.
struct Tried<'a> {
    fit: Fit,
    by: By<'a>,
}

enum By<'a> {
    Elements(Box<Minimum<'a>>),
    /// A sum, with its misfit.
    Modes(Option<Misfit>),
}

/// The minimum with its certainty.
struct Minimum<'a> {
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

impl<'a> Tried<'a> {
    /// Misfit beyond that of the reference, if it is no chance.
    fn misfit(&self, reference: &Reference<'_>) -> Option<Misfit> {
        match &self.by {
            By::Elements(by) => reference.misfit_of(by.candidate, by.whitened.as_ref()?),
            By::Modes(misfit) => *misfit,
        }
    }

    /// The minimum of one whose residual is noise.
    fn noisy(&mut self) -> Option<(&mut Fit, &mut Minimum<'a>)> {
        match &mut self.by {
            By::Elements(by) if !by.is_rendered => Some((&mut self.fit, by)),
            By::Elements(_) | By::Modes(_) => None,
        }
    }
}

/// Compares fits through the noise of the reference: through its own, one that misses the record would have its misfit excused. A log of our
/// own, which a loop may have rendered, has the noise of the closest.
fn compare<'a>(
    fitted: &mut [Tried<'_>],
    target: &Target<'a>,
    is_own_log: bool,
) -> Option<Reference<'a>> {
    let closest = fitted.iter_mut().filter_map(Tried::noisy);
    let closest = closest.min_by(|a, b| a.0.weighted.total_cmp(&b.0.weighted));
    let closest = closest.map(|(_, by)| (by.candidate, &by.best));
    let reference = (!is_own_log).then(|| Reference::of(target, closest));
    let reference = reference.flatten();
    let noise = match (&reference, closest) {
        (Some(reference), _) => reference.noise(),
        (None, Some((candidate, best))) => whitened::noise(candidate, target, best),
        (None, None) => return None,
    };
    let noisy = fitted.par_iter_mut().filter_map(Tried::noisy);
    noisy.for_each(|(fit, by)| {
        let (criteria, best) = whitened::through(noise, by.candidate, target, &by.best);
        [fit.aic, fit.bic] = criteria;
        by.whitened = Some(best);
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
    let by = By::Elements(Box::new(Minimum {
        candidate,
        best,
        certainty,
        unrendered,
        is_rendered,
        whitened: None,
    }));
    Ok(Tried { fit, by })
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
    let is_known =
        !record.errors.is_empty() || record.motions.iter().any(|motion| motion.noise.is_some());
    let first = if record.motions.len() < 2 || is_known {
        None
    } else {
        first(record)
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

/// Index as by [`chosen`], without a reference.
pub(super) fn choose<'a>(
    fits: impl Iterator<Item = &'a Fit> + Clone,
    wanted: Option<ModelKind>,
) -> Option<usize> {
    chosen(fits, wanted, &|_| false)
}

/// Factor on what a series leaves: so much a model with fewer numbers may leave without being missed.
const LITTLE: f64 = 1.25;

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
    // Nor does a series of modes that the record does not tell apart.
    let is_known = |one: &Estimate| {
        one.standard_error
            .is_some_and(|error| error < 0.5 * one.value)
    };
    let is_series = |fit: &Fit| fit.kind == ModelKind::Prony;
    let is_told = |fit: &Fit| !is_series(fit) || fit.parameters.iter().all(is_known);
    let sound = |fit: &Fit| fit.is_settled() && fit.to_model().is_ok() && is_told(fit);
    let any = places.clone().any(|(_, fit)| sound(fit));
    let places = places.filter(|(_, fit)| !any || sound(fit));
    // A series leaves no more by what it is: it is no choice beside a model with fewer numbers that leaves little more than it.
    let all = places.clone();
    let is_needless = |series: &Fit| {
        let few = |fit: &Fit| {
            fit.parameters.len() < series.parameters.len()
                && fit.weighted <= LITTLE * series.weighted
        };
        all.clone().any(|(_, fit)| !is_series(fit) && few(fit))
    };
    let places = places.filter(|(_, fit)| !is_series(fit) || !is_needless(fit));
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
