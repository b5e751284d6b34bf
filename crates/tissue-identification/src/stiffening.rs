//! Stiffening of tissue beside its memory: b of e(ε)·(exp(bε) − 1)/(bε).
//! ```text
//! S(b) = min of S over the memory at b          b at the least S(b);  its 95 % interval: S(b) ≤ S·(1 + t²/ν),  t of Student, 97.5 %
//! another parameter at such a b: its interval there, narrowed to √(1 − ζ²/t²),  ζ² = (S(b) − S)·ν/S;  then all of these together
//! ```
//! That is the profile of the likelihood for b, and for another parameter where S is a parabola in the rest: a valley along which
//! one depth exchanges b for the modulus is as long as it is. b is looked for from 0 to 100, and up to bε = 16 of the largest
//! strain, on a grid of factors of 2, then by parabolas until a step is below 1e-6 of that range, for each candidate by itself:
//! on the grid alone a b that is nearly right is no match for one more element.
//!
//! *Cost*: some 25 fits of the memory for each candidate.
//! *Source*: Y. C. Fung, *Biomechanics*, 1981 (the law); S. S. Wilks, *The large-sample distribution of the likelihood ratio*,
//! Annals of Mathematical Statistics 9, 1938 (the interval).

use super::advice;
use super::candidates::{Identification, choose, identified, noisy, richest};
use super::elements::Candidate;
use super::error::{IdentifyError, sorted};
use super::fit::{AS_GOOD, Estimate, Fit, fit, student};
use super::options::{self, Options, target_of};
use super::record::Record;
use super::record::digits;
use super::search::{Best, next_place, polished, search};
use super::target::Target;
use super::whitened;
use crate::keys::{BOOTSTRAP, FROM, KIND, STIFFENING};
use fracdiff::parameter::Shown;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// A strain to the other side of less than this share of the largest is noise around rest.
const ONE_SIDED: f64 = 0.01;
/// The search for b ends where bε of the largest strain is this.
const STEEPEST: f64 = 16.0;
/// Factors of 2 of the grid.
const OCTAVES: i32 = 7;
/// Starts on the grid, at most.
const FEW_STARTS: usize = 10;
/// Fits for a minimum and for an end, at most.
const ROUNDS: usize = 40;
const ROUNDS_OF_END: usize = 12;
/// A step over the range of b that ends a search for the minimum.
const STEP: f64 = 1e-6;
/// Change of ζ that ends a search for an end.
const NEAR: f64 = 0.02;
/// Width of an interval over b up to which the record settles b.
const SETTLED: f64 = 0.5;
/// Points between two fits of an interval.
const BETWEEN: usize = 10;

/// The memory at one b.
struct Point {
    b: f64,
    best: Best,
    /// Fit with the intervals of its standard errors.
    fit: Fit,
}

/// One candidate at several b, in order of b.
struct Valley<'a> {
    search: &'a Search<'a>,
    candidate: Candidate,
    points: Vec<Point>,
}

struct Search<'a> {
    record: &'a Record,
    options: &'a Options,
    stop: &'a AtomicBool,
    /// b is looked for from one to the other.
    least: f64,
    most: f64,
}

/// Identifies as [`identified`] does, with b as a last parameter of each fit. A candidate that has no minimum at any b is left out, with a warning.
pub(super) fn stiffened(
    record: &Record,
    options: &Options,
    stop: &AtomicBool,
) -> Result<Identification, IdentifyError> {
    let wrong = |reason: String| Err(IdentifyError::Record(reason));
    if options.bootstrap > 0 {
        return wrong(format!(
            "the intervals of a stiffening need no bootstrap: omit {BOOTSTRAP}"
        ));
    }
    if !record.can_stiffen() {
        return wrong(format!(
            "a stiffening shows only if the strain grows with the depth, as it does not under a cone: give {}, or omit {STIFFENING}",
            KIND.set_to("record")
        ));
    }
    if record.first.iter().sum::<f64>() < 0.0 {
        return stiffened(&record.turned(), options, stop);
    }
    let [least, steepest] =
        [f64::min, f64::max].map(|end| record.first.iter().copied().fold(0.0, end));
    if least < -ONE_SIDED * steepest {
        return wrong(format!(
            "a stiffening needs a motion to one side, but the strain goes from {} to {}: cut the record with {FROM}, or omit {STIFFENING}",
            Shown(least),
            Shown(steepest)
        ));
    }
    let candidates = options::candidates(options, record)?;
    let (low, high) = options::stiffening(options);
    let search = |record| Search {
        record,
        options,
        stop,
        least: low,
        most: high.min((STEEPEST / steepest).max(low)),
    };
    let record = &noisy(record, |record| {
        let search = search(record);
        let rich: Vec<Candidate> = richest(&candidates).collect();
        let valleys = search.valleys(&rich).into_iter().flatten();
        let least = valleys.min_by(|a, b| a.lowest().best.sum.total_cmp(&b.lowest().best.sum))?;
        Some((least.lowest().fit.clone(), search.target(least.lowest().b)))
    });
    let search = search(record);
    let (mut valleys, failed) = sorted(search.valleys(&candidates));
    valleys.par_iter_mut().for_each(Valley::whiten);
    valleys.sort_by(|a, b| a.lowest().fit.by_bic(&b.lowest().fit));
    let chosen = choose(valleys.iter().map(|one| &one.lowest().fit), options.chosen);
    let Some(chosen) = chosen else {
        return Err(failed.into_iter().next().unwrap_or(IdentifyError::Stopped));
    };
    let mut valley = valleys.remove(chosen);
    let (kind, b) = (valley.candidate.kind(), valley.lowest().b);
    let single = Options {
        candidates: vec![kind],
        chosen: Some(kind),
        ..options.clone()
    };
    let mut found = identified(&record.stiffened(b), &single, stop, &|_| ())?;
    let limit = valley.limit();
    let mut low = valley.end(b, &limit, false);
    let mut high = valley.end(b, &limit, true);
    if options.held.iter().any(|held| held.name == STIFFENING.0) {
        (low, high) = (low.or(Some(search.least)), high.or(Some(search.most)));
    }
    let fit = &mut found.fits[0];
    // As all of them are compared: each by its own noise.
    let lowest = &valley.lowest().fit;
    (fit.aic, fit.bic) = (lowest.aic, lowest.bic);
    valley.widen(fit, &limit);
    let error = (low.zip(high)).map(|(low, high)| (high - low) / (2.0 * limit.student));
    fit.parameters.push(Estimate {
        standard_error: error,
        low_95: low.or((b < search.most).then_some(0.0)),
        high_95: high,
        held: search.least >= search.most,
        ..alone(b)
    });
    found.fits.extend(valleys.iter().map(|other| {
        let lowest = other.lowest();
        let mut fit = lowest.fit.clone();
        fit.parameters.push(alone(lowest.b));
        fit
    }));
    let best = &found.fits[0];
    (found.warnings).extend(failed.iter().map(ToString::to_string));
    found.warnings.extend(advice::simpler(best, &found.fits));
    let linear = valley.points.first().filter(|point| point.b <= 0.0);
    let linear = linear.map(|point| {
        let (alone, target) = (valley.candidate.with_nuisance(0), search.target(point.b));
        let [_, bic] = whitened::criteria(alone, &target, &point.best);
        (point.fit.rms, bic)
    });
    found.warnings.extend(warning(record, best, linear));
    if stop.load(Ordering::Relaxed) {
        Err(IdentifyError::Stopped)
    } else {
        Ok(found)
    }
}

const fn alone(b: f64) -> Estimate {
    Estimate {
        standard_error: None,
        low_95: None,
        high_95: None,
        ..Estimate::of_line(STIFFENING.0, "", b, 0.0, 0.0)
    }
}

/// Warning if the record does not settle b, or does not distinguish it from 0.
fn warning(record: &Record, best: &Fit, linear: Option<(f64, f64)>) -> Option<String> {
    let b = best.stiffening()?;
    let low = b.low_95.unwrap_or(0.0);
    if (b.high_95).is_some_and(|high| low > 0.0 && high - low <= SETTLED * b.value) {
        return None;
    }
    let high = (b.high_95).map_or("any".to_owned(), |high| Shown(digits(high)).to_string());
    let interval = format!("{} to {high} at 95 %", Shown(digits(low)));
    let what = match linear.filter(|_| low <= 0.0) {
        None => format!("the record hardly tells the stiffening from the modulus, b is {interval}"),
        Some((linear_rms, linear_bic)) => {
            let [linear_pa, rms_pa] = [linear_rms, best.rms].map(|rms| Shown(digits(rms)));
            let left = format!("rms residual {linear_pa} Pa against {rms_pa} Pa");
            if linear_bic <= best.bic + AS_GOOD {
                format!("tissue that does not stiffen is as good ({left}), b is {interval}")
            } else {
                format!(
                    "tissue that does not stiffen fits worse ({left}), yet residuals are so alike that b is only known to be {interval}"
                )
            }
        }
    };
    let remedy = match record.motions.len() {
        1 => "give records of several depths",
        _ => "give records of more and larger depths",
    };
    Some(format!("{what}: {remedy}"))
}

struct Limit {
    sum: f64,
    freedom: f64,
    /// The largest ζ: 97.5 % point of Student's t.
    student: f64,
}

impl Limit {
    fn square(&self, point: &Point) -> f64 {
        ((point.best.sum / self.sum - 1.0) * self.freedom).max(0.0)
    }
}

impl<'a> Search<'a> {
    fn target(&self, b: f64) -> Target<'a> {
        target_of(&self.record.stiffened(b), self.options, self.stop)
    }

    /// These candidates on the grid, then each to its least sum.
    fn valleys(&self, candidates: &[Candidate]) -> Vec<Result<Valley<'_>, IdentifyError>> {
        let width = self.most - self.least;
        let steps = if width > 0.0 { OCTAVES } else { 0 };
        let grid = (0..=steps).map(|n| match n {
            0 => self.least,
            n => self.least + width * libm::exp2(f64::from(n - OCTAVES)),
        });
        let targets = grid.map(|b| {
            let target = self.target(b);
            (b, target.compressed(), target)
        });
        let targets: Vec<(f64, Target<'_>, Target<'_>)> = targets.collect();
        // Each candidate is separate: the result does not depend on the threads.
        let valleys = candidates.par_iter().map(|&candidate| {
            let mut valley = Valley {
                search: self,
                candidate,
                points: Vec::new(),
            };
            let mut failed = IdentifyError::Stopped;
            for (b, compressed, target) in &targets {
                let starts = self.options.starts.clamp(1, FEW_STARTS);
                match search(candidate, compressed, starts) {
                    Ok(best) => valley.points.push(valley.point(*b, target, best)),
                    Err(error) => failed = error,
                }
            }
            valley.refine();
            if valley.points.is_empty() {
                Err(failed)
            } else {
                Ok(valley)
            }
        });
        valleys.collect()
    }
}

impl Valley<'_> {
    fn point(&self, b: f64, target: &Target<'_>, best: Best) -> Point {
        Point {
            b,
            fit: fit(self.candidate, target, &best).0,
            best,
        }
    }

    fn place(&self) -> usize {
        let sums = self.points.iter().map(|point| point.best.sum).enumerate();
        let least = sums.min_by(|a, b| a.1.total_cmp(&b.1));
        least.map_or(0, |least| least.0)
    }

    /// Point with the smallest sum.
    fn lowest(&self) -> &Point {
        &self.points[self.place()]
    }

    /// Compares the lowest by filtered residuals, as fits of tissue that does not stiffen are.
    fn whiten(&mut self) {
        let place = self.place();
        let Point { b, best, fit } = &mut self.points[place];
        let target = self.search.target(*b);
        [fit.aic, fit.bic] = whitened::criteria(self.candidate, &target, best);
    }

    fn limit(&self) -> Limit {
        let Point { fit, best, .. } = self.lowest();
        let freedom = (fit.independent - self.candidate.parameters() as f64).max(1.0);
        Limit {
            sum: best.sum,
            freedom,
            student: student(freedom),
        }
    }

    /// Adds one more b, from the memories on both sides of it; its index, or `None` without a minimum.
    fn add(&mut self, b: f64) -> Option<usize> {
        let target = self.search.target(b);
        let index = self.points.partition_point(|point| point.b < b);
        let sides = &self.points[index.max(1) - 1..self.points.len().min(index + 1)];
        let both = sides.iter().filter_map(|side| {
            let start = side.best.elements.variables(self.candidate.joint());
            polished(self.candidate, &target, [start].iter()).ok()
        });
        let best = both.min_by(|a, b| a.sum.total_cmp(&b.sum))?;
        let point = self.point(b, &target, best);
        self.points.insert(index, point);
        Some(index)
    }

    /// Adds points until the least sum is found.
    fn refine(&mut self) {
        let range = [self.search.least, self.search.most];
        let near = STEP * (range[1] - range[0]);
        for round in 1..=ROUNDS {
            let points: Vec<[f64; 2]> = self
                .points
                .iter()
                .map(|one| [one.b, one.best.sum])
                .collect();
            let next = next_place(&points, range, near, round);
            if next.and_then(|b| self.add(b)).is_none() {
                return;
            }
        }
    }

    /// End of the interval of b above or below it, where ζ is Student's t; `None` if it stays below t to the end of the range.
    fn end(&mut self, b: f64, limit: &Limit, above: bool) -> Option<f64> {
        let most = limit.student;
        let zeta = |point: &Point| (point.b, libm::sqrt(limit.square(point)));
        let side = |point: &&Point| if above { point.b > b } else { point.b < b };
        let mut outwards: Vec<(f64, f64)> = self.points.iter().filter(side).map(zeta).collect();
        if !above {
            outwards.reverse();
        }
        let outside = outwards.iter().position(|point| point.1 > most)?;
        let mut outer = outwards[outside];
        let mut inner = outwards[..outside].last().copied().unwrap_or((b, 0.0));
        for _ in 0..ROUNDS_OF_END {
            let part = (most - inner.1) / (outer.1 - inner.1);
            let next = inner.0 + part.clamp(0.1, 0.9) * (outer.0 - inner.0);
            let Some(index) = self.add(next) else { break };
            let found = zeta(&self.points[index]);
            if found.1 > most {
                outer = found;
            } else {
                inner = found;
            }
            if (found.1 - most).abs() < NEAR {
                break;
            }
        }
        let part = (most - inner.1) / (outer.1 - inner.1);
        Some(inner.0 + part.clamp(0.0, 1.0) * (outer.0 - inner.0))
    }

    /// The intervals of the memory over all b that the record does not refuse.
    fn widen(&self, fit: &mut Fit, limit: &Limit) {
        let most = limit.student;
        for (parameter, estimate) in fit.parameters.iter_mut().enumerate() {
            let is_order = estimate.is_order();
            let scale = |value: f64| if is_order { value } else { libm::log(value) };
            // Value, low and high end, and ζ, at each b.
            let points = self.points.iter().map(|point| {
                let one = &point.fit.parameters[parameter];
                let [low, high] = [one.low_95, one.high_95].map(|end| end.map(scale));
                let low = low.unwrap_or(f64::NEG_INFINITY);
                let high = high.unwrap_or(f64::INFINITY);
                [scale(one.value), low, high, libm::sqrt(limit.square(point))]
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
                let end = |end: f64| {
                    if is_order {
                        Some(end.clamp(0.0, 1.0))
                    } else {
                        Some(libm::exp(end)).filter(|end| *end > 0.0 && end.is_finite())
                    }
                };
                (estimate.low_95, estimate.high_95) = (end(low), end(high));
                let half = (high - low) / (2.0 * most);
                let error = if is_order { 1.0 } else { estimate.value } * half;
                estimate.standard_error = Some(error).filter(|error| error.is_finite());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptic_tissue::{Model, ModelKind};

    /// Eight samples with noise.
    fn short() -> Record {
        let noise = [0.0, 1.0, -1.0, 0.4, -0.2, -0.9, 1.2, -0.6, 0.1];
        noisy_record(160, &noise)
    }

    /// 160 samples with a drift.
    fn drifting() -> Record {
        let mut random = testkit::Random(7);
        let mut drift = 0.0;
        let noise = (0..=160).map(|_| {
            drift = 0.95 * drift + 0.3 * random.between(-1.0, 1.0);
            drift
        });
        noisy_record(8, &noise.collect::<Vec<f64>>())
    }

    /// Two ramps and holds to two strains of tissue with b = 8, with 2 % of noise, which is known: a fit to each candidate would find another.
    fn noisy_record(every: usize, noise: &[f64]) -> Record {
        let gel = Model::from_parameters(ModelKind::SpringPot, &[1000.0, 0.2]).expect("valid");
        let records = [0.1, 0.3].map(|depth| {
            let fine: Vec<f64> = (0..=1280).map(|n| f64::from(n) / 160.0).collect();
            let strain = |t: f64| depth * t.min(1.0);
            let seen = fine.iter().map(|t| libm::expm1(8.0 * strain(*t)) / 8.0);
            let stress = gel.stress(&fine, &seen.collect::<Vec<_>>());
            let times: Vec<f64> = fine.iter().copied().step_by(every).collect();
            let most = stress.iter().copied().fold(0.0, f64::max);
            let noisy = (stress.iter().step_by(every)).zip(noise);
            let stress = noisy.map(|(stress, noise)| stress + 0.02 * most * noise);
            let strain = times.iter().map(|t| strain(*t)).collect();
            Record::history(times.clone(), strain, stress.collect()).expect("valid")
        });
        let mut record = Record::together(records.into()).expect("valid");
        let stresses = record.second.chunks(record.second.len() / 2);
        for (motion, stress) in record.motions.iter_mut().zip(stresses) {
            motion.noise = Some(0.02 * stress.iter().copied().fold(0.0, f64::max));
        }
        record
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
        let stop = AtomicBool::new(false);
        let sum = |b: f64| {
            let target = Target::new(&record.stiffened(b), options.weighting, &stop);
            search(Candidate::of(ModelKind::SpringPot), &target, 10)
                .expect("converges")
                .sum
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

    /// k = p + 2 in n·ln(S/n) + k·ln n + 2k(k + 1)/(n − k − 1) of every candidate, and the order of a filter of residuals.
    #[test]
    fn all_candidates_pay_for_the_stiffening() {
        for (record, orders) in [(short(), 0.0..=0.0), (drifting(), 1.0..=8.0)] {
            let search = found(
                &record,
                &[ModelKind::SpringPot, ModelKind::FractionalMaxwell],
            );
            let found = search.expect("converges");
            assert!(found.fits.len() > 1);
            let n = found.measured.len() as f64;
            for fit in &found.fits {
                let b = fit.stiffening().expect("looked for").value;
                let (stop, candidate) = (AtomicBool::new(false), Candidate::of(fit.kind));
                let target = target_of(&record.stiffened(b), &Options::default(), &stop);
                let best = crate::search::search(candidate, &target, 40);
                let alone = whitened::criteria(candidate, &target, &best.expect("converges"));
                let [aic, bic] = [fit.aic - alone[0], fit.bic - alone[1]];
                // A spring-pot was drawn: nothing settles the second element of the other, along whose level valley a filter changes a little.
                let level = fit.kind == ModelKind::FractionalMaxwell && *orders.end() > 0.0;
                let within = if level { 1e-3 } else { 1e-6 };
                assert!((aic - 2.0).abs() < within, "{}: {aic}", fit.kind);
                let small = |k: f64| 2.0 * k * (k + 1.0) / (n - 1.0 - k);
                let k = candidate.parameters() as f64 + 1.0;
                let more = |order: f64| libm::log(n) + small(k + 1.0 + order) - small(k + order);
                let [least, most] = [orders.start(), orders.end()].map(|order| more(*order));
                let paid = least - within..=most + within;
                assert!(paid.contains(&bic), "{}: {bic} of {paid:?}", fit.kind);
            }
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
