//! A dead time that nobody knows: where its search begins, how sure it is, and what else it might be.
//!
//! ```text
//! y = e^(−Ls)·B/A·u,   SSE(L) = least Σ(y − ŷ)² over A and B:   scanned in whole samples, then L is one more number of the fit
//! ```
//! Between samples the switch of a held input parts the integral, so ŷ is exact for every L. A plant rests until its dead time is over, so no L
//! can be right before whose end the record has more power than the best function leaves: there the scan ends.
//!
//! - *Cost*: some three passes over 400 samples at most for each of them and each of four shapes. *Source*: of the profile, G. H. Golub, V. Pereyra,
//!   *The differentiation of pseudo-inverses and nonlinear least squares problems whose variables separate*, SIAM Journal on Numerical Analysis 10(2), 1973.

use super::found::{AS_GOOD, Found};
use super::record::{Guess, InputOutput, resolved, rounding};
use super::start::{noise_of, part};
use crate::identify::{Free, least_residual, next_guess};
use crate::{DeadTime, InputOutputRecord, StartState, WholeGuess, WholeShape, whole_guess};
use fracdiff::Seconds;
use fractional_control::{FractionalTransferFunction, Term};
use rayon::prelude::*;

/// Samples that are scanned, about; of a plant that moves by itself, whose dead time nothing bounds, fewer.
const SCANNED: usize = 400;
const SCANNED_MOVING: usize = 150;
/// Poles and zeros of the functions that are run behind each dead time.
const SHAPES: [WholeShape; 4] = [shape(1, 0), shape(2, 0), shape(2, 1), shape(3, 2)];
/// Divisor that gives the part of the record that is scanned for a plant that moves by itself.
const MOVING: usize = 6;
/// Number of samples after which the poles are found afresh, and not through those before.
const AFRESH: usize = 8;
/// Dead times that a scan suggests, at most.
const SUGGESTED: usize = 6;

/// The dead times to begin from: those that the record suggests, and none; or the one that is known. With `whitens` those too that it suggests through
/// the filter of the noise that the closest function leaves.
pub(super) fn dead_times(
    record: &InputOutput,
    held: bool,
    known: Option<Seconds>,
    whitens: bool,
) -> Vec<DeadTime> {
    if let Some(known) = known {
        return vec![DeadTime::Known(known)];
    }
    let scanned_samples = match record.start {
        StartState::Rest | StartState::Offset => SCANNED,
        StartState::Settled | StartState::Moving => SCANNED_MOVING,
    };
    let mut part = part(record, held, scanned_samples).unwrap_or_else(|| record.clone());
    let mut found = scanned(&part, held);
    let closest = whitens.then(|| closest(&part, held, &found)).flatten();
    part.noise = closest.map_or(part.noise, |guess| noise_of(&part, held, &guess));
    if part.noise.order() > 0 {
        // In noise that is alike both places count: that which draws it, and that of the filter.
        let apart = |a: &DeadTime, b: &DeadTime| {
            (a.seconds() - b.seconds()).abs() > 0.5 * part.sample_time_s()
        };
        let others = scanned(&part, held);
        found.retain(|candidate| others.iter().all(|other| apart(candidate, other)));
        found.splice(0..0, others);
    }
    found.push(DeadTime::NONE);
    found
}

/// The guess of the scanned shapes and these dead times that leaves least.
fn closest(record: &InputOutput, held: bool, dead_times: &[DeadTime]) -> Option<Guess> {
    let pairs = SHAPES
        .iter()
        .flat_map(|shape| dead_times.iter().map(move |late| (*shape, *late)));
    let guesses = pairs.filter_map(|(shape, late)| {
        let guess = whole_guess(&record.as_record(held, late), shape)?;
        Some((guess, late))
    });
    let least = guesses.min_by(|a, b| a.0.rms_residual.total_cmp(&b.0.rms_residual));
    least.map(|(guess, dead_time)| Guess {
        parts: vec![],
        function: guess.function,
        has_free_orders: false,
        dead_time,
    })
}

/// The local minima of SSE of each shape, the two lowest.
fn scanned(record: &InputOutput, held: bool) -> Vec<DeadTime> {
    let t = record.sample_time_s();
    let Some(first) = record.input.iter().position(|u| *u != 0.0) else {
        return Vec::new();
    };
    let mut least = f64::INFINITY;
    let mut rests = 0.0;
    let mut profiles: [Vec<Option<WholeGuess>>; SHAPES.len()] = Default::default();
    for (samples, y) in record.output[first..].iter().enumerate() {
        // A sample of grace: the plant may answer within it. A plant that moves by itself does not show its dead time.
        let is_over = match record.start {
            StartState::Rest | StartState::Offset => rests > least,
            StartState::Settled | StartState::Moving => samples > record.output.len() / MOVING,
        };
        if is_over {
            break;
        }
        rests += y * y;
        let behind = DeadTime::Known(Seconds(samples as f64 * t));
        let behind = record.as_record(held, behind);
        (SHAPES.par_iter().zip(&mut profiles)).for_each(|(shape, profile)| {
            let last = profile.last().copied().flatten();
            let near = last.and_then(|last| next_guess(&behind, *shape, &last));
            let afresh = (samples % AFRESH == 0 || near.is_none())
                .then(|| whole_guess(&behind, *shape))
                .flatten();
            let best = if rms(&afresh) < rms(&near) {
                afresh
            } else {
                near
            };
            profile.push(best);
        });
        for best in profiles.iter().filter_map(|profile| profile.last()) {
            least = least.min(rms(best) * rms(best) * record.output.len() as f64);
        }
    }
    let places = SHAPES.iter().zip(&profiles).flat_map(|(shape, profile)| {
        let places = lowest(profile).into_iter();
        places.map(move |place| (*shape, profile[place], place as f64))
    });
    let places: Vec<_> = places.collect();
    let minima = places.into_par_iter();
    let minima = minima.map(|(shape, guess, late)| between(record, held, shape, guess, late));
    let mut minima: Vec<(f64, f64)> = minima.collect();
    minima.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut found: Vec<f64> = Vec::new();
    for (_, late) in minima {
        let is_new = found.iter().all(|other| (other - late).abs() > 0.5);
        if is_new && found.len() < SUGGESTED {
            found.push(late);
        }
    }
    // Not from 0, where the search would end at once.
    let begin = |late: f64| DeadTime::From(Seconds(late.max(0.5) * t));
    found.into_iter().map(begin).collect()
}

const fn shape(poles: usize, zeros: usize) -> WholeShape {
    WholeShape {
        poles,
        zeros,
        integrators: 0,
    }
}

fn rms(guess: &Option<WholeGuess>) -> f64 {
    guess.map_or(f64::INFINITY, |guess| guess.rms_residual)
}

/// Places of the two lowest minima.
fn lowest(profile: &[Option<WholeGuess>]) -> Vec<usize> {
    let at = |n: usize| profile.get(n).map_or(f64::INFINITY, rms);
    let is_least = |n: &usize| at(*n) <= at(n + 1) && (*n == 0 || at(*n) <= at(n - 1));
    let mut minima: Vec<usize> = (0..profile.len()).filter(is_least).collect();
    minima.sort_by(|a, b| at(*a).total_cmp(&at(*b)));
    minima.truncate(2);
    minima
}

/// Halvings of an interval by the golden section: to a fiftieth of a sample.
const SECTIONS: usize = 9;

/// The residual, and the dead time in samples, at the minimum within a sample of `late`. The record of a growing plant in a loop determines its
/// pole to many digits for each dead time: a fit of both that starts a sample away does not converge.
fn between(
    record: &InputOutput,
    held: bool,
    shape: WholeShape,
    guess: Option<WholeGuess>,
    late: f64,
) -> (f64, f64) {
    let t = record.sample_time_s();
    let at = |late: f64| {
        let behind = record.as_record(held, DeadTime::Known(Seconds(late * t)));
        (
            rms(&guess.and_then(|guess| next_guess(&behind, shape, &guess))),
            late,
        )
    };
    let share = 0.5 * (libm::sqrt(5.0) - 1.0);
    let (mut low, mut high) = ((late - 1.0).max(0.0), late + 1.0);
    let (mut left, mut right) = (
        at(high - share * (high - low)),
        at(low + share * (high - low)),
    );
    for _ in 0..SECTIONS {
        if left.0 <= right.0 {
            (high, right) = (right.1, left);
            left = at(high - share * (high - low));
        } else {
            (low, left) = (left.1, right);
            right = at(low + share * (high - low));
        }
    }
    let middle = (rms(&guess), late);
    let all = [left, right, middle];
    all.into_iter()
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .unwrap_or(middle)
}

/// A gain alone, if its output is not that of a pole. If held, it only shows between which samples its dead time ends.
pub(super) fn gain(record: &InputOutput, held: bool, known: Option<Seconds>) -> Option<Guess> {
    let t = record.sample_time_s();
    let explained = |late: f64| {
        let input = record.as_record(held, DeadTime::Known(Seconds(late * t)));
        let input: Vec<f64> = input.now();
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (energy, both) = (product(&input, &input), product(&input, &record.output));
        (both * both / energy, both / energy, late)
    };
    let best = match known {
        Some(known) => explained(known.0 / t),
        None => {
            let delays = (0..record.input.len()).map(|samples| match (samples, held) {
                (0, _) | (_, false) => samples as f64,
                _ => samples as f64 - 0.5,
            });
            let explains = |a: &(f64, f64, f64), b: &(f64, f64, f64)| a.0.total_cmp(&b.0);
            delays
                .map(explained)
                .filter(|gain| gain.0.is_finite())
                .max_by(explains)?
        }
    };
    let (_, gain, late) = best;
    let one = [Term::new(1.0, 0.0)];
    Some(Guess {
        parts: vec![],
        function: FractionalTransferFunction::new(&[Term::new(gain, 0.0)], &one).ok()?,
        has_free_orders: false,
        dead_time: DeadTime::Known(Seconds(late * t)),
    })
}

/// χ² of one number that 95 % stay below.
const LIKELY: f64 = 3.841;
/// Fits to each side of a dead time, at most; √ of the profile within this share of its wish is there.
const TRIED: usize = 12;
const NEAR: f64 = 0.05;

/// A dead time is determined whose interval ends within this share of it, or half a sample.
const DETERMINED: f64 = 0.05;

/// Evidence in a record about a dead time.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct DeadTimeEvidence<'a> {
    /// Smallest and largest dead time that the record does not exclude, s: those of the first function, and of all that fit equally well.
    pub interval_s: [f64; 2],
    /// True if both ends are within 5 % or half a sample of the dead time that was found.
    pub is_determined: bool,
    /// A function that fits equally well with a dead time outside the interval of the first function alone by
    /// more than half a sample: it replaces part of the dead time by poles, or the reverse.
    pub instead: Option<&'a Found>,
}

/// Evidence in the record about the dead time of the first of these functions, `None` without any: 95 % by the profile of the likelihood, with
/// the other numbers refitted for each dead time; for functions that fit equally well by their standard errors.
/// ```text
/// n·ln(SSE(L)/SSE) ≤ 3.84,   of what the filter of the noise leaves
/// ```
/// *Source*: D. M. Bates, D. G. Watts, *Nonlinear regression analysis and its applications*,
/// 1988, section 6.1.
#[must_use]
pub fn dead_time_evidence<'a>(
    found: &'a [Found],
    record: &InputOutput,
    held: bool,
) -> Option<DeadTimeEvidence<'a>> {
    let (first, others) = found.split_first()?;
    let interval = profile_interval_s(first, record, held);
    let apart = 0.5 * record.sample_time_s();
    let best = found
        .iter()
        .map(|found| found.bic)
        .fold(f64::INFINITY, f64::min);
    let as_good = others.iter().filter(|other| other.bic <= best + AS_GOOD);
    let is_outside = |other: &&Found| {
        let dead_time_s = other.identified.dead_time.seconds();
        dead_time_s < interval[0] - apart || dead_time_s > interval[1] + apart
    };
    let interval_s = as_good.clone().fold(interval, |[least, most], other| {
        let dead_time_s = other.identified.dead_time.seconds();
        let error = other.dead_time_error().filter(|error| error.is_finite());
        let room = libm::sqrt(LIKELY) * error.unwrap_or(0.0);
        [
            least.min((dead_time_s - room).max(0.0)),
            most.max(dead_time_s + room),
        ]
    });
    let dead_time_s = first.identified.dead_time.seconds();
    let near = (DETERMINED * dead_time_s).max(apart) * (1.0 + 1e-9);
    Some(DeadTimeEvidence {
        is_determined: interval_s
            .iter()
            .all(|end| (end - dead_time_s).abs() <= near),
        interval_s,
        instead: as_good.into_iter().find(is_outside),
    })
}

fn profile_interval_s(found: &Found, record: &InputOutput, held: bool) -> [f64; 2] {
    let (t, model) = (record.sample_time_s(), &found.identified);
    let best = model.dead_time.seconds();
    if model.function.denominator().degree() == 0.0 && held {
        let last = libm::ceil(best / t);
        return [(last - 1.0).max(0.0) * t, last * t];
    }
    let (floor, freedom) = if found.is_whole() {
        (rounding(record), Free::Coefficients)
    } else {
        (resolved(record), Free::All)
    };
    let samples = record.output.len() as f64;
    let least = found.news(record);
    // √ of what the profile has risen by, over what it may.
    let risen = |dead_time_s: f64| -> f64 {
        let behind = InputOutputRecord {
            noise: model.noise,
            ..record.as_record(held, DeadTime::Known(Seconds(dead_time_s)))
        };
        let left = least_residual(&model.function, &behind, freedom).unwrap_or(f64::INFINITY);
        let deviance = 2.0 * samples * libm::log(left.max(floor) / least.max(floor));
        libm::sqrt(deviance.max(0.0) / LIKELY)
    };
    let usual = found.dead_time_error().filter(|error| error.is_finite());
    let usual = usual.map_or(0.25 * t, |error| libm::sqrt(LIKELY) * error);
    let usual = usual.clamp(1e-6 * t, samples * t);
    let edge = |way: f64| {
        let (mut step, mut inside, mut outside) = (usual, 0.0, f64::INFINITY);
        for _ in 0..TRIED {
            let at = (best + way * step).clamp(0.0, (samples - 1.0) * t);
            let risen = risen(at);
            if (risen - 1.0).abs() < NEAR {
                break;
            }
            if risen < 1.0 {
                inside = step;
                if at == 0.0 {
                    break;
                }
            } else {
                outside = step;
            }
            let next = step / risen.clamp(0.25, 4.0);
            let is_between = next > inside && next < outside;
            step = if is_between {
                next
            } else {
                0.5 * (inside + outside)
            };
        }
        (best + way * step).max(0.0)
    };
    let (least, most) = rayon::join(|| edge(-1.0), || edge(1.0));
    [least, most]
}
