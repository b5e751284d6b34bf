//! The lag of a force sensor, taken off by delaying the strain as the sensor delays its force.
//! ```text
//! shown = H·σ     H(s) = 1/(1 + τs)     H·(∫ M dε) = ∫ M d(H·ε)        so nothing is differentiated
//! left open:  Σ cₖ·(shown(t − k·h) − shown(t))     k from 1 to 5, h = 1 ms, cₖ normal with deviation 2
//! ```
//! τ has the least BIC per sample of the models with up to four parameters, on a grid of h, then of its halves and quarters: a delayed motion has
//! more corners, of which fewer samples are compared. A lag that is off, or of another shape, such as a dead time or a mean over many readings,
//! is a sum of what the best model makes at other times: columns that may be in the stress of any model. So neither buys an element, and the
//! intervals of all parameters know both.
//!
//! *Cost*: a search of few models for each place of the grid, then some ten operations a sample.

use super::instants::nearest;
use super::options::Options;
use super::record::Record;
use super::stiffening::stiffened;
use super::target::EXACT;
use fracdiff::parameter::Shown;
use haptic_tissue::Model;
use std::sync::atomic::AtomicBool;

/// h, s, the step of the grid of lags.
const STEP: f64 = 1e-3;
/// Number of the cₖ, and their deviation.
const TAPS: u8 = 5;
const OPEN: f64 = 2.0;
/// Times that the step between two lags is halved.
const HALVINGS: usize = 2;
/// Starts and parameters of a model that suffice to find the lag.
const STARTS: usize = 6;
const PARAMETERS: usize = 4;

/// The record with its strain delayed as its stress is, and what of the lag is left open; unchanged if no model fits it.
pub(super) fn taken_off(
    record: &Record,
    [least_s, most_s]: [f64; 2],
    options: &Options,
    stop: &AtomicBool,
) -> Record {
    let mut plain = record.clone();
    plain.lag_s = None;
    let few = |parameters: usize| Options {
        candidates: match options.chosen {
            Some(kind) => vec![kind],
            None => (options.candidates.iter().copied())
                .filter(|kind| kind.parameters().len() <= parameters)
                .collect(),
        },
        starts: options.starts.min(STARTS),
        bootstrap: 0,
        ..options.clone()
    };
    // A lag is found as well at a stiffening that is nearly right.
    let stiffens = options.stiffening.then(|| {
        let found = stiffened(&plain, &few(2), stop).ok()?;
        found.fits[0].stiffening().map(|b| b.value)
    });
    let shaped = match stiffens {
        Some(None) => return plain,
        Some(Some(b)) => plain.stiffened(b),
        None => plain.clone(),
    };
    let few = few(PARAMETERS);
    let at = |lag_s: f64| {
        let late = delayed(&shaped, lag_s);
        let (bic, model) = nearest(&late, &few, stop)?;
        Some((bic, lag_s, late, model))
    };
    let steps = libm::ceil((most_s - least_s) / STEP);
    let mut step_s = (most_s - least_s) / steps.max(1.0);
    let mut places: Vec<f64> = (0..=steps as usize)
        .map(|n| least_s + step_s * n as f64)
        .collect();
    let mut least = None;
    for _ in 0..=HALVINGS {
        let tried = places.drain(..).filter_map(at).chain(least);
        least = tried.min_by(|a, b| a.0.total_cmp(&b.0));
        step_s *= 0.5;
        let sides = least
            .iter()
            .flat_map(|one| [-step_s, step_s].map(|by_s| one.1 + by_s));
        places.extend(sides.filter(|lag_s| *lag_s > least_s && *lag_s < most_s));
    }
    let Some((_, lag_s, mut late, mut model)) = least else {
        return plain;
    };
    // A model that missed the lag's shape has it in its parameters: the columns are those of one beside columns.
    for is_last in [false, true] {
        late.bounded.clone_from(&plain.bounded);
        let columns = open(&shaped, &late, lag_s, &model);
        late.bounded.extend(columns);
        if !is_last && let Some((_, better)) = nearest(&late, &few, stop) {
            model = better;
        }
    }
    (plain.first, plain.touch, plain.bounded) = (late.first, late.touch, late.bounded);
    if lag_s > 0.0 {
        plain.warnings.push(format!(
            "the force sensor is taken to lag by {} ms",
            Shown(super::record::digits(1e3 * lag_s))
        ));
    }
    plain
}

/// The columns of what this model makes of a record, shown by a sensor with this lag.
fn open(record: &Record, late: &Record, lag_s: f64, model: &Model) -> Vec<Vec<f64>> {
    let map = record.motions[0].map;
    let shown = each_motion(late, |range| {
        let strain = record.first[range.clone()].iter();
        let strain = strain.map(|strain| map.map_or(*strain, |map| map.at(*strain)));
        let (times, strain) = (&record.x[range], strain.collect::<Vec<f64>>());
        let mut stress = model.stress(times, &strain);
        // Of a damper it is infinite at a step, as of a handle that begins a count deep: no sample of that instant is compared.
        for stress in stress.iter_mut().filter(|stress| !stress.is_finite()) {
            *stress = 0.0;
        }
        lagging(times, &stress, lag_s)
    });
    let square = late.second.iter().map(|x| x * x).sum::<f64>() / late.second.len() as f64;
    // At least the accuracy of any record.
    let size = OPEN / sensor_noise(&late.second).max(EXACT * libm::sqrt(square));
    let columns = (1..=TAPS).map(|tap| {
        let before = each_motion(late, |range| {
            earlier(&late.x[range.clone()], &shown[range], f64::from(tap) * STEP)
        });
        let pairs = before.iter().zip(&shown);
        pairs.map(|(before, now)| size * (before - now)).collect()
    });
    columns.collect()
}

/// The record with its strain later.
fn delayed(record: &Record, lag_s: f64) -> Record {
    let mut late = record.clone();
    late.first = each_motion(record, |range| {
        lagging(&record.x[range.clone()], &record.first[range], lag_s)
    });
    if let Some(touch) = &mut late.touch {
        touch.depth_m = lagging(&touch.time_s, &touch.depth_m, lag_s);
    }
    late
}

/// Numbers of all motions, by the samples of each.
fn each_motion(record: &Record, of: impl Fn(core::ops::Range<usize>) -> Vec<f64>) -> Vec<f64> {
    let mut begin = 0;
    let parts = record.motions.iter().map(|motion| {
        begin += motion.samples;
        of(begin - motion.samples..begin)
    });
    parts.collect::<Vec<_>>().concat()
}

/// y ← y + (1 − e^(−Δ/τ))·(x − y), from rest at the first value.
fn lagging(time_s: &[f64], values: &[f64], lag_s: f64) -> Vec<f64> {
    let mut late = values.first().copied().unwrap_or_default();
    let mut before_s = time_s.first().copied().unwrap_or_default();
    let pairs = time_s.iter().zip(values);
    let all = pairs.map(|(&time_s, value)| {
        // 1 without a lag.
        let share = -libm::expm1((before_s - time_s) / lag_s.max(f64::MIN_POSITIVE));
        before_s = time_s;
        late += share * (value - late);
        late
    });
    all.collect()
}

/// Values at times that are earlier, straight between samples and at rest before the first.
fn earlier(time_s: &[f64], values: &[f64], by_s: f64) -> Vec<f64> {
    if time_s.len() < 2 {
        return values.to_vec();
    }
    let mut next = 1;
    let all = time_s.iter().map(|now_s| {
        let at = now_s - by_s;
        while next + 1 < time_s.len() && time_s[next] < at {
            next += 1;
        }
        let [from, to] = [time_s[next - 1], time_s[next]];
        let share = ((at - from) / (to - from)).clamp(0.0, 1.0);
        values[next - 1] + share * (values[next] - values[next - 1])
    });
    all.collect()
}

/// [`white_noise`] of a sensor, and at least q/√12 of one that shows steps q: it may show the same for most of a hold. Steps are seen where values
/// are few, a quarter of the samples at most.
#[must_use]
pub fn sensor_noise(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let range = sorted.last().zip(sorted.first());
    let range = range.map_or(0.0, |(last, first)| last - first);
    // Single precision spreads one value over some.
    let steps =
        (sorted.windows(2).map(|pair| pair[1] - pair[0])).filter(|step| *step > 1e-6 * range);
    let (count, least) = steps.fold((1, f64::INFINITY), |(count, least), step| {
        (count + 1, step.min(least))
    });
    let is_stepped = least.is_finite() && 4 * count <= values.len();
    let step = if is_stepped { least } else { 0.0 };
    white_noise(values).max(step / libm::sqrt(12.0))
}

/// Standard deviation of white noise about a smooth curve, by the median of |x₋ − 2x + x₊|, whose σ is √6 times as large: of a normal
/// distribution the median is at 0.6745 σ, and at the corners of a curve it is not. 0 of fewer than three values.
#[must_use]
pub fn white_noise(values: &[f64]) -> f64 {
    let bends = values.windows(3);
    let mut bends: Vec<f64> = bends
        .map(|three| (three[0] - 2.0 * three[1] + three[2]).abs())
        .collect();
    bends.sort_by(f64::total_cmp);
    let median = bends.get(bends.len() / 2).copied().unwrap_or_default();
    median / (0.6745 * libm::sqrt(6.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elements::Candidate;
    use crate::identify;
    use crate::target::Target;
    use crate::target::Weighting;
    use haptic_tissue::ModelKind;
    use spring_pots::Elements;

    const TRUTH: [f64; 2] = [5000.0, 0.4];
    const T: f64 = 1e-3;

    /// A ramp of 0.1 s to a strain of 0.1, and a hold, with the true stress between its samples too.
    fn pressed(finer: usize) -> [Vec<f64>; 3] {
        let times: Vec<f64> = (0..1500 * finer)
            .map(|n| T * n as f64 / finer as f64)
            .collect();
        let strain: Vec<f64> = times.iter().map(|time| time.min(0.1)).collect();
        let model = Model::from_parameters(ModelKind::SpringPot, &TRUTH).expect("a model");
        let stress = model.stress(&times, &strain);
        [times, strain, stress]
    }

    /// Delays as sensors have them: a dead time, the mean of their last readings, a filter. Each adds no model element.
    #[test]
    fn a_lag_of_any_shape_is_no_element_and_the_intervals_hold_the_truth() {
        let finer = 20;
        let [times, strain, stress] = pressed(finer);
        let late = |n: usize, by: usize| stress[n.saturating_sub(by)];
        let dead = |n: usize| late(n, 46);
        let mean = |n: usize| (0..5).map(|k| late(n, k * finer)).sum::<f64>() / 5.0;
        let filtered = lagging(&times, &stress, 3.4e-3);
        let shapes: [&dyn Fn(usize) -> f64; 4] = [&|n| late(n, 0), &dead, &mean, &|n| filtered[n]];
        for (case, shape) in shapes.into_iter().enumerate() {
            let mut random = testkit::Random(case as u64);
            let mut noise = || (0..12).map(|_| random.between(-0.5, 0.5)).sum::<f64>();
            let samples = || (0..times.len()).step_by(finer);
            let record = Record::history(
                samples().map(|n| times[n]).collect(),
                samples().map(|n| strain[n]).collect(),
                samples().map(|n| shape(n) + noise()).collect(),
            );
            let record = record
                .expect("valid")
                .with_doubts(Vec::new(), Some([0.0, 5e-3]), None);
            let options = Options {
                starts: 6,
                ..Options::default()
            };
            let found = identify(&record, &options, &|_| ()).expect("a fit");
            let fit = &found.fits[0];
            assert_eq!(
                fit.kind,
                ModelKind::SpringPot,
                "{case}: {:?}",
                found.warnings
            );
            for (estimate, truth) in fit.parameters.iter().zip(TRUTH) {
                let ends = estimate.low_95.zip(estimate.high_95).expect("an interval");
                // Of four shapes at 95 %, with room for one that just misses.
                let room = 0.3 * (ends.1 - ends.0);
                assert!(
                    (ends.0 - room..ends.1 + room).contains(&truth),
                    "{case}: {estimate:?}"
                );
                assert!(ends.1 - ends.0 < 0.02 * truth, "{case}: {estimate:?}");
            }
        }
    }

    /// A damper's stress at the step of a count with which a handle begins is infinite, which once made a search endless.
    #[test]
    fn a_damper_that_begins_a_count_deep_is_found_behind_a_lag() {
        let [times, mut strain, _] = pressed(1);
        strain
            .iter_mut()
            .for_each(|strain| *strain = strain.max(8e-4));
        let model = Model::from_parameters(ModelKind::KelvinVoigt, &[1e4, 100.0]).expect("a model");
        let mut stress = model.stress(&times, &strain);
        stress[0] = 0.0;
        let record = Record::history(times, strain, stress).expect("valid");
        let record = record.with_doubts(Vec::new(), Some([0.0, 2e-3]), None);
        let options = Options {
            chosen: Some(ModelKind::KelvinVoigt),
            ..Options::default()
        };
        let found = identify(&record, &options, &|_| ()).expect("a fit");
        for (estimate, truth) in found.fits[0].parameters.iter().zip([1e4, 100.0]) {
            // What a lag may do is left open.
            assert!((estimate.value / truth - 1.0).abs() < 0.05, "{estimate:?}");
        }
    }

    /// A cell of 12 bits over 40 N under a hold: most of its differences are 0.
    #[test]
    fn a_sensor_that_shows_steps_has_their_noise_at_least() {
        let step = 40.0 / 4096.0;
        let held = |noise: f64| {
            let mut random = testkit::Random(3);
            let all = (0..3000).map(|n| {
                let force = 0.5 - 0.2 * libm::exp(-1e-3 * f64::from(n));
                let noise = noise * (0..12).map(|_| random.between(-0.5, 0.5)).sum::<f64>();
                f64::from((((force + noise) / step).round() * step) as f32)
            });
            sensor_noise(&all.collect::<Vec<f64>>())
        };
        let least = step / libm::sqrt(12.0);
        assert!((held(1e-4) / least - 1.0).abs() < 1e-3, "{}", held(1e-4));
        assert!((held(0.1) / 0.1 - 1.0).abs() < 0.1, "{}", held(0.1));
        // Nothing is stepped where all values differ.
        let smooth: Vec<f64> = (0..100).map(|n| libm::sin(0.1 * f64::from(n))).collect();
        assert!((sensor_noise(&smooth) - white_noise(&smooth)).abs() <= 0.0);
    }

    /// min over d of |r + c·d|² + d² is |r|² − (c·r)²/(1 + |c|²).
    #[test]
    fn a_column_of_known_size_leaves_what_the_best_share_of_it_leaves() {
        let [times, strain, stress] = pressed(1);
        let never = AtomicBool::new(false);
        let plain = Record::history(times, strain, stress).expect("valid");
        let candidate = Candidate::of(ModelKind::SpringPot);
        let left = |record: &Record| {
            let target = Target::new(record, Weighting::Equal, &never);
            let mut left = vec![0.0; target.len()];
            let elements = Elements::from_variables(&[8.4, 0.3]);
            target.residuals(candidate, &elements, |n, _, slope| left[n] = slope.value);
            (target.chosen(), left)
        };
        let (chosen, r) = left(&plain);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        for size in [1e-3, 0.03, 1.0, 100.0] {
            let column: Vec<f64> = (0..plain.samples())
                .map(|n| size * libm::sin(0.01 * n as f64))
                .collect();
            let c: Vec<f64> = chosen.iter().map(|&n| column[n]).collect();
            let doubted = plain.clone().with_doubts(vec![column], None, None);
            let (_, left) = left(&doubted);
            let want = dot(&r, &r) - dot(&c, &r).powi(2) / (1.0 + dot(&c, &c));
            assert!((dot(&left, &left) / want - 1.0).abs() < 1e-9, "{size}");
        }
    }
}
