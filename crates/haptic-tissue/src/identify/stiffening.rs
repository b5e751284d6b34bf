//! How tissue stiffens, beside its memory: b of e(ε)·(exp(bε) − 1)/(bε).
//! ```text
//! S(b) = min of S over the memory at b          b at the least S(b);  its 95 % interval: S(b) ≤ S·(1 + t²/ν),  t of Student, 97.5 %
//! another parameter at such a b: its interval there, narrowed to √(1 − ζ²/t²),  ζ² = (S(b) − S)·ν/S;  then all of these together
//! ```
//! That is the profile of the likelihood for b, and for another parameter where S is a parabola in the rest: a valley along which
//! one depth exchanges b for the modulus is as long as it is. b is looked for from 0 to 100, and up to bε = 16 of the largest
//! strain, on a grid of factors of 2, then by parabolas.
//!
//! *Cost*: some 25 fits of the memory.
//! *Source*: Y. C. Fung, *Biomechanics*, 1981 (the law); S. S. Wilks, *The large-sample distribution of the likelihood ratio*,
//! Annals of Mathematical Statistics 9, 1938 (the interval).

use super::candidates::{Identification, Options, choose, identified};
use super::elements::Candidate;
use super::error::IdentifyError;
use super::fit::{Estimate, Fit, fit, student};
use super::record::Record;
use super::search::search;
use super::target::Target;
use crate::identify::keys::{BOOTSTRAP, FROM, KIND, STIFFENING};
use crate::model::ModelKind;
use fracdiff::parameter::Shown;
use haptic_loop::Specimen;
use std::sync::atomic::{AtomicBool, Ordering};

/// A strain to the other side of less than this share of the largest is noise around rest.
const ONE_SIDED: f64 = 0.01;
/// Largest bε.
const STEEPEST: f64 = 16.0;
/// Factors of 2 of the grid.
const OCTAVES: i32 = 7;
/// Starts on the grid, at most.
const FEW_STARTS: usize = 10;
/// Fits for a minimum or an end, at most.
const ROUNDS: usize = 12;
/// Change of ζ² or ζ that ends a search.
const NEAR: f64 = 0.02;
/// Rise of ζ² up to which a sum is near a parabola.
const STEEP: f64 = 77.0;
/// Width of an interval over b up to which the record tells b.
const SETTLED: f64 = 0.5;
/// Points between two fits of an interval.
const BETWEEN: usize = 10;

/// Fits of one candidate at several b, in order of b.
type Valley = Vec<(f64, Fit)>;

struct Search<'a> {
    record: &'a Record,
    options: &'a Options,
    stop: &'a AtomicBool,
    /// Numbers that are compared.
    numbers: f64,
}

/// As [`identified`], with b as a last parameter of the chosen fit. A candidate that converges at some b only is left out, and told.
pub(super) fn stiffened(
    record: &Record,
    options: &Options,
    stop: &AtomicBool,
) -> Result<Identification, IdentifyError> {
    let mut options = options.clone();
    let mut left_out = Vec::new();
    loop {
        match of_candidates(record, &options, stop) {
            Err(error @ IdentifyError::NotConverged { model })
                if options.chosen.is_none() && options.candidates.len() > 1 =>
            {
                options.candidates.retain(|kind| kind.name() != model);
                left_out.push(error.to_string());
            }
            found => {
                return found.map(|mut found| {
                    found.warnings.append(&mut left_out);
                    found
                });
            }
        }
    }
}

fn of_candidates(
    record: &Record,
    options: &Options,
    stop: &AtomicBool,
) -> Result<Identification, IdentifyError> {
    let wrong = |reason: String| Err(IdentifyError::Record(reason));
    if options.bootstrap > 0 {
        return wrong(format!(
            "the intervals of a stiffening are profiles: omit {BOOTSTRAP}"
        ));
    }
    if !record.can_stiffen() {
        return wrong(format!(
            "a stiffening is seen in a motion whose strain grows with the depth, none under a cone: give {}, or omit {STIFFENING}",
            KIND.set_to("record")
        ));
    }
    if record.first.iter().sum::<f64>() <= 0.0 {
        return wrong(
            "tissue stiffens by a strain above 0: change the sign of both columns".to_owned(),
        );
    }
    let [least, steepest] =
        [f64::min, f64::max].map(|end| record.first.iter().copied().fold(0.0, end));
    if least < -ONE_SIDED * steepest {
        return wrong(format!(
            "a stiffening is that of a motion to one side, and the strain goes from {} to {}: cut the record with {FROM}, or omit {STIFFENING}",
            Shown(least),
            Shown(steepest)
        ));
    }
    let most = Specimen::STIFFENING_MAX.min(STEEPEST / steepest);
    let mut search = Search {
        record,
        options,
        stop,
        numbers: 0.0,
    };
    let mut valleys: Vec<(ModelKind, Valley)> = Vec::new();
    let grid = (0..=OCTAVES).map(|n| match n {
        0 => 0.0,
        n => most * libm::exp2(f64::from(n - OCTAVES)),
    });
    let mut refused = None;
    for b in grid {
        for (kind, fit) in options
            .candidates
            .iter()
            .zip(search.at(b, &options.candidates)?)
        {
            match (fit, valleys.iter_mut().find(|valley| valley.0 == *kind)) {
                (Ok(fit), Some(valley)) => valley.1.push((b, fit)),
                (Ok(fit), None) => valleys.push((*kind, vec![(b, fit)])),
                (Err(error), _) => refused = Some(error),
            }
        }
    }
    search.numbers = (valleys.first()).map_or(0.0, |valley| valley.1[0].1.predicted.len() as f64);
    // The chosen one may be another where b is right.
    let mut refined: Vec<ModelKind> = Vec::new();
    let (kind, mut valley) = loop {
        let lowest = |valley: &Valley| valley[search.lowest(valley)].1.clone();
        let mut fits: Vec<Fit> = valleys.iter().map(|valley| lowest(&valley.1)).collect();
        fits.sort_by(|a, b| a.bic.total_cmp(&b.bic));
        let place = choose(fits.iter(), options.chosen);
        let Some(kind) = place.map(|place| fits[place].kind) else {
            return Err(refused.unwrap_or(IdentifyError::Stopped));
        };
        // It, and what is simpler: on the grid alone a b that is nearly right is no match for one more element.
        let size = kind.parameters().len();
        let open = |own: ModelKind| {
            !refined.contains(&own) && (own == kind || own.parameters().len() < size)
        };
        let Some((kind, valley)) = valleys.iter_mut().find(|valley| open(valley.0)) else {
            let valley = valleys.into_iter().find(|valley| valley.0 == kind);
            break valley.ok_or(IdentifyError::Stopped)?;
        };
        let kind = *kind;
        search.refine(kind, valley)?;
        refined.push(kind);
    };
    let lowest = valley[search.lowest(&valley)].clone();
    let b = lowest.0;
    let there = Options {
        chosen: Some(kind),
        ..options.clone()
    };
    let mut found = identified(&record.stiffened(b), &there, stop, &|_| ())?;
    let limit = search.limit(&lowest.1);
    let low = search.end(kind, &mut valley, b, &limit, 0.0)?;
    let high = search.end(kind, &mut valley, b, &limit, most)?;
    let fit = &mut found.fits[0];
    widen(fit, &valley, &limit);
    let error = (low.zip(high)).map(|(low, high)| (high - low) / (2.0 * limit.student));
    fit.parameters.push(Estimate {
        name: STIFFENING.0,
        unit: "",
        value: b,
        standard_error: error,
        low_95: low.or((b < most).then_some(0.0)),
        high_95: high,
    });
    // All are fitted at this b.
    for fit in &mut found.fits {
        fit.aic += 2.0;
        fit.bic += libm::log(search.numbers);
    }
    found.warnings.extend(said(record, low, b, high));
    Ok(found)
}

/// What the interval of b says.
fn said(record: &Record, low: Option<f64>, b: f64, high: Option<f64>) -> Option<String> {
    let low = low.unwrap_or(0.0);
    if high.is_some_and(|high| low > 0.0 && high - low <= SETTLED * b) {
        return None;
    }
    let what = match low {
        0.0 => "tissue that does not stiffen is as good",
        _ => "the record hardly tells the stiffening from the modulus",
    };
    let remedy = match record.motions.len() {
        1 => "give records of several depths",
        _ => "give records of more and larger depths",
    };
    let high = high.map_or("any".to_owned(), |high| Shown(rounded(high)).to_string());
    let low = Shown(rounded(low));
    Some(format!("{what}, b is {low} to {high} at 95 %: {remedy}"))
}

/// Three digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

/// ζ² of a fit.
struct Limit {
    sum: f64,
    freedom: f64,
    /// The largest ζ: 97.5 % point of Student's t.
    student: f64,
    numbers: f64,
}

impl Limit {
    fn square(&self, fit: &Fit) -> f64 {
        ((sum(fit, self.numbers) / self.sum - 1.0) * self.freedom).max(0.0)
    }
}

/// S, weights in, by the criterion that it made.
fn sum(fit: &Fit, numbers: f64) -> f64 {
    let parameters = (fit.kind.parameters().len() + 1) as f64;
    numbers * libm::exp((fit.bic - parameters * libm::log(numbers)) / numbers)
}

impl Search<'_> {
    /// The memory at b, with the intervals of its standard errors.
    fn at(
        &self,
        b: f64,
        candidates: &[ModelKind],
    ) -> Result<Vec<Result<Fit, IdentifyError>>, IdentifyError> {
        let record = self.record.stiffened(b);
        let target = Target::new(&record, self.options.weighting, self.stop);
        let starts = self.options.starts.clamp(1, FEW_STARTS);
        let fits = candidates.iter().map(|&kind| {
            let candidate = Candidate::of(kind)?;
            let best = search(candidate, &target, starts)?;
            Ok(fit(candidate, &target, &best).0)
        });
        let fits = fits.collect();
        match self.stop.load(Ordering::Relaxed) {
            true => Err(IdentifyError::Stopped),
            false => Ok(fits),
        }
    }

    /// Place of the least sum.
    fn lowest(&self, valley: &Valley) -> usize {
        let sums = valley.iter().map(|own| own.1.bic);
        let least = sums.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
        least.map_or(0, |least| least.0)
    }

    fn limit(&self, best: &Fit) -> Limit {
        let freedom = (best.independent - best.kind.parameters().len() as f64 - 1.0).max(1.0);
        Limit {
            sum: sum(best, self.numbers),
            freedom,
            student: student(freedom),
            numbers: self.numbers,
        }
    }

    /// Fits one candidate at one more b.
    fn add(&self, kind: ModelKind, valley: &mut Valley, b: f64) -> Result<Fit, IdentifyError> {
        let fit = self.at(b, &[kind])?.remove(0)?;
        let place = valley.partition_point(|own| own.0 < b);
        valley.insert(place, (b, fit.clone()));
        Ok(fit)
    }

    /// To the least sum, by the vertex of the parabola through the lowest three neighbours.
    fn refine(&self, kind: ModelKind, valley: &mut Valley) -> Result<(), IdentifyError> {
        for _ in 0..ROUNDS {
            let lowest = self.lowest(valley);
            if valley.len() < 3 || lowest + 1 == valley.len() {
                return Ok(());
            }
            let limit = self.limit(&valley[lowest].1);
            let first = lowest.max(1) - 1;
            let [a, m, z] = [0, 1, 2].map(|n| valley[first + n].0);
            let [fa, fm, fz] = [0, 1, 2]
                .map(|n| sum(&valley[first + n].1, self.numbers) / limit.sum * limit.freedom);
            // Newton's form: f = fa + s·(b − a) + c·(b − a)(b − m).
            let s = (fm - fa) / (m - a);
            let c = ((fz - fm) / (z - m) - s) / (z - a);
            let vertex = (0.5 * (a + m) - 0.5 * s / c).clamp(a, z);
            let gain = |b: f64| valley.iter().all(|own| (own.0 - b).abs() > 1e-3 * (z - a));
            let next = if c > 0.0 && gain(vertex) {
                vertex
            } else if z - m > m - a {
                0.5 * (m + z)
            } else {
                0.5 * (a + m)
            };
            let value = |b: f64| fa + s * (b - a) + c * (b - a) * (b - m);
            let least = value(valley[lowest].0);
            if c > 0.0 && least - value(vertex) < NEAR && fa.max(fz) - least < STEEP {
                return Ok(());
            }
            self.add(kind, valley, next)?;
        }
        Ok(())
    }

    /// Where ζ is Student's t between b and the end of its range; none if it stays below.
    fn end(
        &self,
        kind: ModelKind,
        valley: &mut Valley,
        b: f64,
        limit: &Limit,
        range: f64,
    ) -> Result<Option<f64>, IdentifyError> {
        let (side, most) = (range - b, limit.student);
        if side == 0.0 {
            return Ok(None);
        }
        let beyond = |own: &&(f64, Fit)| (own.0 - b) * side > 0.0;
        let distance = |own: &(f64, Fit)| (own.0 - b).abs();
        let outside = (valley.iter().filter(beyond))
            .filter(|own| limit.square(&own.1) > most * most)
            .min_by(|one, other| distance(one).total_cmp(&distance(other)));
        let Some(outside) = outside else {
            return Ok(None);
        };
        let mut outer = (outside.0, libm::sqrt(limit.square(&outside.1)));
        let inside = (valley.iter().filter(beyond))
            .filter(|own| distance(own) < (outer.0 - b).abs())
            .max_by(|one, other| distance(one).total_cmp(&distance(other)));
        let mut inner = inside.map_or((b, 0.0), |own| (own.0, libm::sqrt(limit.square(&own.1))));
        for _ in 0..ROUNDS {
            let part = (most - inner.1) / (outer.1 - inner.1);
            let next = inner.0 + part.clamp(0.1, 0.9) * (outer.0 - inner.0);
            let distance = libm::sqrt(limit.square(&self.add(kind, valley, next)?));
            if distance > most {
                outer = (next, distance);
            } else {
                inner = (next, distance);
            }
            if (distance - most).abs() < NEAR {
                break;
            }
        }
        let part = (most - inner.1) / (outer.1 - inner.1);
        Ok(Some(inner.0 + part.clamp(0.0, 1.0) * (outer.0 - inner.0)))
    }
}

/// The intervals of the memory over all b that the record does not refuse.
fn widen(fit: &mut Fit, valley: &Valley, limit: &Limit) {
    let most = limit.student;
    for (place, estimate) in fit.parameters.iter_mut().enumerate() {
        let is_order = estimate.unit.is_empty();
        let scale = |value: f64| if is_order { value } else { libm::log(value) };
        // Value, low and high end, and ζ, at each b.
        let points = valley.iter().map(|(_, fit)| {
            let own = &fit.parameters[place];
            let [low, high] = [own.low_95, own.high_95].map(|end| end.map(scale));
            let low = low.unwrap_or(f64::NEG_INFINITY);
            let high = high.unwrap_or(f64::INFINITY);
            [scale(own.value), low, high, libm::sqrt(limit.square(fit))]
        });
        let points: Vec<[f64; 4]> = points.collect();
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for pair in points.windows(2) {
            for step in 0..=BETWEEN {
                let share = step as f64 / BETWEEN as f64;
                let at = |n: usize| (1.0 - share) * pair[0][n] + share * pair[1][n];
                // ζ, not its square, is nearly straight.
                let distance = at(3);
                if distance <= most {
                    let part = libm::sqrt(1.0 - distance * distance / (most * most));
                    low = low.min(at(0) + part * (at(1) - at(0)));
                    high = high.max(at(0) + part * (at(2) - at(0)));
                }
            }
        }
        if low < high {
            let end = |end: f64| match is_order {
                true => Some(end.clamp(0.0, 1.0)),
                false => Some(libm::exp(end)).filter(|end| *end > 0.0 && end.is_finite()),
            };
            (estimate.low_95, estimate.high_95) = (end(low), end(high));
            let half = (high - low) / (2.0 * most);
            let error = if is_order {
                half
            } else {
                estimate.value * half
            };
            estimate.standard_error = Some(error).filter(|error| error.is_finite());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Model;

    /// Two ramps and holds to two strains of tissue with b = 8, with 8 samples each and 2 % of noise.
    fn short() -> Record {
        let gel = Model::from_parameters(ModelKind::SpringPot, &[1000.0, 0.2]).expect("valid");
        let records = [0.1, 0.3].map(|depth| {
            let fine: Vec<f64> = (0..=1280).map(|n| f64::from(n) / 160.0).collect();
            let strain = |t: f64| depth * t.min(1.0);
            let seen = fine.iter().map(|t| libm::expm1(8.0 * strain(*t)) / 8.0);
            let stress = gel.stress(&fine, &seen.collect::<Vec<_>>());
            let times: Vec<f64> = fine.iter().copied().step_by(160).collect();
            let most = stress.iter().copied().fold(0.0, f64::max);
            let noise = [0.0, 1.0, -1.0, 0.4, -0.2, -0.9, 1.2, -0.6, 0.1];
            let noisy = (stress.iter().step_by(160)).zip(noise);
            let stress = noisy.map(|(stress, noise)| stress + 0.02 * most * noise);
            let strain = times.iter().map(|t| strain(*t)).collect();
            Record::history(times.clone(), strain, stress.collect()).expect("valid")
        });
        Record::together(records.into()).expect("valid")
    }

    fn found(record: &Record, candidates: &[ModelKind]) -> Result<Identification, IdentifyError> {
        let options = Options {
            candidates: candidates.to_vec(),
            stiffening: true,
            ..Options::default()
        };
        stiffened(record, &options, &AtomicBool::new(false))
    }

    /// 16 stresses in 3 parameters: t = 2.1604 of 13 degrees of freedom.
    #[test]
    fn an_interval_ends_where_the_sum_meets_students_t() {
        let (record, options) = (short(), Options::default());
        let found = found(&record, &[ModelKind::SpringPot]).expect("converges");
        let fit = &found.fits[0];
        assert_eq!(
            (fit.predicted.len(), fit.independent.to_bits()),
            (16, 16.0_f64.to_bits())
        );
        let b = fit.stiffening().expect("looked for");
        let search = Search {
            record: &record,
            options: &options,
            stop: &AtomicBool::new(false),
            numbers: 16.0,
        };
        let sum = |b: f64| {
            let mut fits = search.at(b, &[ModelKind::SpringPot]).expect("goes on");
            sum(&fits.remove(0).expect("converges"), 16.0)
        };
        let least = sum(b.value);
        for end in [b.low_95, b.high_95] {
            let end = end.expect("an end");
            let distance = libm::sqrt((sum(end) / least - 1.0) * 13.0);
            assert!((distance - 2.1604).abs() < 0.02, "{end}: {distance}");
        }
        let width = b
            .high_95
            .zip(b.low_95)
            .map_or(0.0, |(high, low)| high - low);
        let error = b.standard_error.expect("two ends");
        assert!((width / (2.0 * error) - 2.1604).abs() < 1e-3, "{b:?}");
    }

    /// n·ln(S/n) + (p + 2)·ln n of every candidate.
    #[test]
    fn all_candidates_pay_for_the_stiffening() {
        let record = short();
        let search = found(
            &record,
            &[ModelKind::SpringPot, ModelKind::FractionalMaxwell],
        );
        let found = search.expect("converges");
        assert!(found.fits.len() > 1);
        let b = found.fits[0].stiffening().expect("looked for").value;
        for fit in &found.fits {
            let options = Options {
                candidates: vec![fit.kind],
                ..Options::default()
            };
            let alone = identified(
                &record.stiffened(b),
                &options,
                &AtomicBool::new(false),
                &|_| (),
            );
            let alone = &alone.expect("converges").fits[0];
            let [aic, bic] = [fit.aic - alone.aic, fit.bic - alone.bic];
            assert!((aic - 2.0).abs() < 1e-6, "{}: {aic}", fit.kind);
            assert!((bic - libm::log(16.0)).abs() < 1e-6, "{}: {bic}", fit.kind);
        }
    }

    #[test]
    fn a_motion_to_both_sides_is_refused() {
        let times: Vec<f64> = (0..40).map(|n| 0.1 * f64::from(n)).collect();
        let strain: Vec<f64> = times.iter().map(|t| 0.1 * libm::sin(*t)).collect();
        let stress = strain.iter().map(|strain| 1000.0 * strain).collect();
        let record = Record::history(times, strain, stress).expect("valid");
        let refused = found(&record, &[ModelKind::SpringPot]).expect_err("two sides");
        let refused = refused.to_string();
        assert!(refused.contains("a motion to one side"), "{refused}");
    }
}
