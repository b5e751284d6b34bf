//! Contact point of an indenter, and the baseline of its force.
//! ```text
//! f = f₀ + f₁·(t − t₁) + F(δ − δ₀)     F = 0 for δ ≤ δ₀, the law of the model above; t₁ the time of the first sample
//! S(δ₀) = min of S over the memory, f₀ and f₁ at δ₀     δ₀ at the least S(δ₀)
//! ```
//! f₀ and f₁ are linear and leave with every evaluation, see [`history`](super::history): samples before the contact, where F is 0,
//! determine f₀ alone, and the others refine it. δ₀ is looked for on a grid with a spring-pot, then for each candidate by
//! parabolas through the lowest three points until a step is below 1e-5 of the depth. There −∂F/∂δ₀ is one more column beside the
//! model's stress, so that the intervals of all parameters know that δ₀ is fitted too; its own is that of the linear problem.
//!
//! A record whose contact point was not asked for is fitted with a free one and with a baseline too, with the chosen model and with a
//! spring-pot. A warning is given if the least BIC is lower by more than 10 and the modulus at any frequency of the record differs by more
//! than 3 %.
//!
//! *Cost*: some 30 fits of a spring-pot to 200 samples, then some 10 of each candidate to 2000 samples at most.
//! *Errors*: a record of no single motion, or without an indenter where a contact point is looked for.

use super::candidates::{Identification, as_measured, choose, identified};
use super::elements::Candidate;
use super::error::{IdentifyError, sorted};
use super::fit::{Estimate, Fit, REFUSED, fit, parameters, student};
use super::keys::{BASELINE, CONTACT_POINT, KIND, REPLICATES, STIFFENING};
use super::options::{Options, candidates, target_of};
use super::record::digits;
use super::record::{Baseline, ContactPoint, REST_OF_FIT, Record, RecordKind, Touch, area};
use super::search::{next_place, polished, search};
use super::target::Target;
use super::whitened;
use fracdiff::parameter::Shown;
use haptic_tissue::{Model, ModelKind};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use spring_pots::Elements;
use std::sync::atomic::AtomicBool;

/// Samples on the grid, of a record that is only checked, and of a fit.
const FEW: usize = 200;
const CHECKED: usize = 300;
const MOST: usize = 2000;
/// Points of the grid, and of the finer one between two of its neighbours.
const GRID: usize = 12;
/// Starts where δ₀ is not known yet, and where it is nearly.
const STARTS: [usize; 2] = [2, 10];
/// The contact is no higher above the record, and no deeper in it, than these shares of its depths.
const BEFORE: f64 = 0.8 * REST_OF_FIT;
const DEEPEST: f64 = 0.9;
/// A step over the range of depths that ends a search, and one for a slope.
const STEP: f64 = 1e-5;
const SLOPE: f64 = 1e-3;
/// Fits of a search, at most.
const ROUNDS: usize = 30;
/// Frequencies at which the moduli of a record are compared, less one.
const FREQUENCIES: usize = 8;
/// A change of the modulus that is worth a sentence.
const MATTERS: f64 = 0.03;

/// A candidate fitted with the contact at one depth.
#[derive(Clone, Debug)]
struct Place {
    candidate: Candidate,
    contact_m: f64,
    sum: f64,
    elements: Elements,
    /// The variables that are not at an end of their range.
    free: Vec<usize>,
    unit_s: f64,
    bic: f64,
}

/// The record at any contact point, as every fit of the search takes it.
struct Search<'a> {
    record: &'a Record,
    touch: Option<&'a Touch>,
    baseline: Option<Baseline>,
    options: &'a Options,
    stop: &'a AtomicBool,
}

/// True if the contact point or a baseline is to be fitted.
pub(super) fn is_sought(record: &Record, options: &Options) -> bool {
    options.baseline.is_some() || is_fitted(record)
}

fn is_fitted(record: &Record) -> bool {
    let touch = record.touch.as_ref();
    touch.is_some_and(|touch| touch.contact == ContactPoint::Fitted)
}

/// Identifies as [`identified`] does, with the contact point and the baseline.
pub(super) fn touched(
    record: &Record,
    options: &Options,
    stop: &AtomicBool,
    progress: &(dyn Fn(usize) + Sync),
) -> Result<Identification, IdentifyError> {
    let sought = if is_fitted(record) {
        CONTACT_POINT
    } else {
        BASELINE
    };
    let wrong = |reason: String| Err(IdentifyError::Record(reason));
    if record.kind != RecordKind::History {
        let kind = record.kind.name();
        return wrong(format!(
            "{sought} is of a motion and its force, and the record is of kind {kind}: omit it, or give {}",
            KIND.set_to("record")
        ));
    }
    if options.stiffening {
        return wrong(format!(
            "{sought} is not fitted together with {STIFFENING}: omit one, or give the contact point as a length"
        ));
    }
    if record.motions.len() > 1 {
        return wrong(format!(
            "{sought} is fitted to one motion, and there are {}: give them one by one, or {REPLICATES}",
            record.motions.len()
        ));
    }
    let touch = record.touch.as_ref().filter(|_| is_fitted(record));
    let thinned = touch.map(|touch| touch.thinned(MOST));
    let search = Search {
        record,
        touch: thinned.as_ref(),
        baseline: options.baseline,
        options,
        stop,
    };
    let near = search.near()?;
    let candidates = candidates(options, record)?;
    // Each candidate is separate: the result does not depend on the threads.
    let places: Vec<Result<(Record, Fit, Place), IdentifyError>> = (candidates.par_iter())
        .map(|&candidate| {
            let place = search.lowest(candidate, near)?;
            let record = search.linear(&place)?;
            let target = target_of(&record, options, stop);
            let best = polished(candidate, &target, [place.start(&target)].iter())?;
            let mut fit = fit(candidate, &target, &best).0;
            as_measured(&mut fit, &record, &target);
            [fit.aic, fit.bic] = whitened::criteria(candidate, &target, &best);
            Ok((record, fit, place))
        })
        .collect();
    let (mut fitted, mut failed) = sorted(places);
    fitted.sort_by(|a, b| a.1.by_bic(&b.1));
    let Some(chosen) = choose(fitted.iter().map(|one| &one.1), options.chosen) else {
        return Err(failed.pop().unwrap_or(IdentifyError::Stopped));
    };
    let (linear, fit, place) = fitted.remove(chosen);
    let single = Options {
        candidates: vec![fit.kind],
        chosen: Some(fit.kind),
        ..options.clone()
    };
    let mut found = identified(&linear, &single, stop, progress)?;
    (found.fits[0].aic, found.fits[0].bic) = (fit.aic, fit.bic);
    found.placement = search.placement(&linear, &found.fits[0], &place)?;
    found.fits.extend(fitted.into_iter().map(|(_, fit, _)| fit));
    found.samples = record.samples();
    let (kept, all) = (linear.samples(), record.samples());
    found.warnings.extend((kept < all).then(|| {
        format!(
            "of {all} samples {kept} are compared, and the depth is taken as straight between them"
        )
    }));
    (found.warnings).extend(failed.iter().map(ToString::to_string));
    Ok(found)
}

/// A sentence about a record that a contact point or a baseline would change.
pub(super) fn missed(
    record: &Record,
    options: &Options,
    found: &Identification,
    stop: &AtomicBool,
) -> Option<String> {
    let touch = record.touch.as_ref();
    let touch = touch
        .filter(|touch| touch.contact == ContactPoint::Zero)?
        .thinned(CHECKED);
    let chosen = found.fits.first()?;
    let pot = Some(ModelKind::SpringPot).filter(|_| record.untimed.is_none());
    let mut kinds: Vec<ModelKind> = [chosen.kind].into_iter().chain(pot).collect();
    kinds.dedup();
    let both = Options {
        candidates: kinds,
        chosen: None,
        ..options.clone()
    };
    let place = |candidate: Candidate, is_free: bool, baseline: Option<Baseline>| {
        let search = Search {
            record,
            touch: Some(&touch),
            baseline,
            options,
            stop,
        };
        let place = if is_free {
            search.lowest(candidate, [0.0, 0.1 * search.range()[1]])
        } else {
            search.place(candidate, 0.0, None)
        };
        let mut place = place.ok()?;
        place.bic += f64::from(u8::from(is_free)) * libm::log(touch.time_s.len() as f64);
        Some((place, is_free, baseline))
    };
    let constant = Some(Baseline::Constant);
    let ways = [
        (false, None),
        (true, None),
        (false, constant),
        (true, constant),
    ];
    let candidates = candidates(&both, record).ok()?;
    let candidates = candidates.iter();
    let all =
        candidates.flat_map(|one| ways.map(|(is_free, baseline)| place(*one, is_free, baseline)));
    let is_plain = |one: &(Place, bool, Option<Baseline>)| !one.1 && one.2.is_none();
    let both: (Vec<_>, Vec<_>) = all.flatten().partition(is_plain);
    let least = |some: Vec<(Place, bool, Option<Baseline>)>| {
        some.into_iter().min_by(|a, b| a.0.bic.total_cmp(&b.0.bic))
    };
    let (plain, better) = (least(both.0)?, least(both.1)?);
    let (change, omega_rad_s) = largest_change(&touch.time_s, [&plain.0, &better.0])?;
    let gain = plain.0.bic - better.0.bic;
    if gain <= REFUSED || change.abs() <= MATTERS {
        return None;
    }
    let place_mm = 1e3 * (better.0.contact_m + touch.zero_m);
    let touches = format!("an indenter that touches at {place_mm:.4} mm");
    let offset = "a force that is not 0 without contact";
    let (fit, constant) = (CONTACT_POINT.set_to("fit"), BASELINE.set_to("constant"));
    let [what, remedy] = match (better.1, better.2) {
        (true, None) => [touches, fit],
        (false, _) => [offset.to_owned(), constant],
        (true, Some(_)) => [
            format!("{touches} and {offset}"),
            format!("{fit} and {constant}"),
        ],
    };
    let side = if change < 0.0 { "lower" } else { "higher" };
    Some(format!(
        "the record fits better with {what} (BIC lower by {gain:.0}), and the modulus at {} rad/s is then {:.1} % {side}: give {remedy}",
        Shown(digits(omega_rad_s)),
        100.0 * change.abs()
    ))
}

/// The largest change of |M(iω)| from one place to another over the frequencies of these times, as a share, and its ω.
fn largest_change(time_s: &[f64], places: [&Place; 2]) -> Option<(f64, f64)> {
    let models = places.map(|place| {
        let values = parameters(place.candidate, &place.elements, place.unit_s);
        Model::from_parameters(place.candidate.kind(), &values).ok()
    });
    let [from, to] = models;
    let (from, to) = (from?, to?);
    let steps = time_s.windows(2).map(|pair| pair[1] - pair[0]);
    let (least, whole) = (
        steps.fold(f64::INFINITY, f64::min),
        time_s.last()? - time_s[0],
    );
    let changes = (0..=FREQUENCIES).map(|n| {
        let omega = libm::pow(whole / least, n as f64 / FREQUENCIES as f64) / whole;
        let [from, to] = [&from, &to].map(|model| model.complex_modulus(omega).norm());
        (to / from - 1.0, omega)
    });
    changes.max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))
}

impl Place {
    /// Its variables in the unit of time of another target.
    fn start(&self, target: &Target<'_>) -> Vec<f64> {
        let mut elements = self.elements;
        let shift = libm::log(self.unit_s / target.unit_s);
        for (modulus, order) in elements.ln_modulus.iter_mut().zip(elements.order) {
            *modulus += order * shift;
        }
        elements.variables(self.candidate.joint())
    }
}

impl Search<'_> {
    /// Depths between which the contact is, m.
    fn range(&self) -> [f64; 2] {
        let depths = || self.touch.iter().flat_map(|touch| &touch.depth_m).copied();
        let low = depths().fold(f64::INFINITY, f64::min);
        let width = depths().fold(0.0, f64::max) - low;
        [low - BEFORE * width, low + DEEPEST * width]
    }

    /// The record with the contact at this depth, and the columns of its baseline.
    fn record(&self, contact_m: f64) -> Result<Record, IdentifyError> {
        let mut record = match self.touch {
            Some(touch) => Record::touching(touch, contact_m, REST_OF_FIT)?,
            None => self.record.clone(),
        };
        let since = record.x.iter().map(|time| time - record.x[0]).collect();
        let columns = [vec![1.0; record.x.len()], since].into_iter();
        record.nuisance = match self.baseline {
            None => Vec::new(),
            Some(Baseline::Constant) => columns.take(1).collect(),
            Some(Baseline::Linear) => columns.collect(),
        };
        Ok(record)
    }

    /// A candidate with the contact at this depth, from a place nearby or from anywhere.
    fn place(
        &self,
        candidate: Candidate,
        contact_m: f64,
        near: Option<&Place>,
    ) -> Result<Place, IdentifyError> {
        let record = self.record(contact_m)?;
        let target = target_of(&record, self.options, self.stop);
        let best = match near {
            Some(near) => polished(candidate, &target, [near.start(&target)].iter())?,
            None => search(candidate, &target, self.options.starts.clamp(1, STARTS[1]))?,
        };
        Ok(Place {
            candidate,
            contact_m,
            sum: best.sum,
            bic: fit(candidate, &target, &best).0.bic,
            elements: best.elements,
            free: best.free,
            unit_s: target.unit_s,
        })
    }

    /// A depth near the contact, by a spring-pot, and how near.
    fn near(&self) -> Result<[f64; 2], IdentifyError> {
        let Some(touch) = self.touch else {
            return Ok([0.0; 2]);
        };
        let thinned = touch.thinned(FEW);
        let few = Search {
            touch: Some(&thinned),
            ..*self
        };
        let candidate = Candidate::of(ModelKind::SpringPot);
        let [mut low, mut high] = self.range();
        let (mut near, mut step) = (0.0, 0.0);
        for _ in 0..2 {
            step = (high - low) / GRID as f64;
            let depths: Vec<f64> = (0..GRID).map(|n| low + (n as f64 + 0.5) * step).collect();
            let sums = depths.par_iter().map(|&depth| {
                let record = few.record(depth).ok()?;
                let target = target_of(&record, self.options, self.stop);
                let best = search(candidate, &target, STARTS[0]).ok()?;
                Some((depth, best.sum))
            });
            let sums: Vec<(f64, f64)> = sums.collect::<Vec<_>>().into_iter().flatten().collect();
            let least = sums.iter().min_by(|a, b| a.1.total_cmp(&b.1));
            let model = ModelKind::SpringPot.name();
            (near, _) = *least.ok_or(IdentifyError::NotConverged { model })?;
            (low, high) = (near - step, near + step);
        }
        Ok([near, step])
    }

    /// The least sum of a candidate, from a depth that is as near as said.
    fn lowest(
        &self,
        candidate: Candidate,
        [near, width]: [f64; 2],
    ) -> Result<Place, IdentifyError> {
        let first = self.place(candidate, near, None)?;
        if self.touch.is_none() {
            return Ok(first);
        }
        let [low, high] = self.range();
        let close = STEP * (high - low);
        let mut points = vec![first];
        for depth in [(near - width).max(low), (near + width).min(high)] {
            let place = self.place(candidate, depth, points.first());
            points.extend(place.ok());
        }
        for round in 1..=ROUNDS {
            points.sort_by(|a, b| a.contact_m.total_cmp(&b.contact_m));
            points.dedup_by(|a, b| a.contact_m - b.contact_m < 0.1 * close);
            let places = points.iter().map(|place| [place.contact_m, place.sum]);
            let places: Vec<[f64; 2]> = places.collect();
            let next = next_place(&places, [low, high], close, round);
            let here = points.iter().min_by(|a, b| a.sum.total_cmp(&b.sum));
            let next = next.map(|depth| self.place(candidate, depth, here));
            let Some(Ok(place)) = next else { break };
            points.push(place);
        }
        let least = points.into_iter().min_by(|a, b| a.sum.total_cmp(&b.sum));
        least.ok_or(IdentifyError::Stopped)
    }

    /// The record at a place, with how the stress changes with the contact point as one more column.
    fn linear(&self, place: &Place) -> Result<Record, IdentifyError> {
        let mut record = self.record(place.contact_m)?;
        if self.touch.is_none() {
            return Ok(record);
        }
        let [low, high] = self.range();
        let step = SLOPE * (high - low);
        let plain = Self {
            baseline: None,
            ..*self
        };
        let mut slope = vec![0.0; record.x.len()];
        for side in [-1.0, 1.0] {
            let moved = plain.record(place.contact_m + side * step)?;
            let target = target_of(&moved, self.options, self.stop);
            let elements = Elements::from_variables(&place.start(&target));
            target.model(place.candidate, &elements, |n, stress| {
                slope[n + 1] += side * stress.value * target.scale / (2.0 * step);
            });
        }
        record.nuisance.push(slope);
        Ok(record)
    }

    /// The contact point and the baseline with their errors, of the linear problem at the best fit.
    fn placement(
        &self,
        record: &Record,
        fit: &Fit,
        place: &Place,
    ) -> Result<Vec<Estimate>, IdentifyError> {
        let mut plain = record.clone();
        plain.nuisance.clear();
        plain.bounded.clear();
        let target = target_of(&plain, self.options, self.stop);
        let elements = Elements::from_variables(&place.start(&target));
        let (rows, memory) = (target.len(), place.free.len());
        let columns = memory + record.nuisance.len();
        let mut matrix = DMatrix::zeros(rows, columns);
        let mut right = DVector::zeros(rows);
        let chosen = target.chosen();
        target.residuals(place.candidate, &elements, |n, root, slope| {
            right[n] = -root * slope.value * target.scale;
            for (k, &variable) in place.free.iter().enumerate() {
                matrix[(n, k)] = root * slope.by[variable] * target.scale;
            }
            for (k, column) in record.nuisance.iter().enumerate() {
                matrix[(n, memory + k)] = root * column[chosen[n]];
            }
        });
        // With columns of length 1; one of 0 has no part.
        let sizes = matrix.column_iter().map(|column| column.norm());
        let sizes: Vec<f64> = sizes.map(|size| size.max(f64::MIN_POSITIVE)).collect();
        for (mut column, size) in matrix.column_iter_mut().zip(&sizes) {
            column /= *size;
        }
        let inverse = matrix.pseudo_inverse(SINGULAR);
        let inverse = inverse.unwrap_or_else(|_| DMatrix::zeros(columns, rows));
        let solved = &inverse * right;
        let freedom = (fit.independent - columns as f64).max(1.0);
        let deviation = fit.weighted * libm::sqrt(rows as f64 / freedom);
        let t = student(freedom);
        // N/Pa, if the stress was made of the force of an indenter.
        let touch = self.record.touch.as_ref();
        let area = touch.map(|touch| area(&touch.specimen));
        let mut names = match (self.baseline, area.is_some()) {
            (None, _) => Vec::new(),
            (Some(_), true) => vec![("baseline_n", "N"), ("baseline_drift_n_per_s", "N/s")],
            (Some(_), false) => vec![("baseline_pa", "Pa"), ("baseline_drift_pa_per_s", "Pa/s")],
        };
        names.truncate(record.nuisance.len() - usize::from(self.touch.is_some()));
        names.extend(self.touch.map(|_| ("contact_point_m", "m")));
        let named = names.into_iter().enumerate().map(|(k, (name, unit))| {
            let (column, is_contact) = (memory + k, unit == "m");
            let scale = area.filter(|_| !is_contact).unwrap_or(1.0) / sizes[column];
            let begin = self.touch.filter(|_| is_contact);
            let begin = begin.map_or(0.0, |touch| touch.zero_m + place.contact_m);
            let value = begin + scale * solved[column];
            let error = scale * deviation * inverse.row(column).norm();
            Estimate::of_line(name, unit, value, error, t)
        });
        Ok(named.collect())
    }
}

/// A singular value over the largest that is one of rounding.
const SINGULAR: f64 = 1e-10;
