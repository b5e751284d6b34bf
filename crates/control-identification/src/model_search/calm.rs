//! Functions that do not grow in place of those that do, and slow lags in place of integrators.
//!
//! ```text
//! a record may grow:   span of y behind > e·span of y before·max(1, the same ratio of u, of ∫u), from where u first moves, halved
//! ```
//! A plant that neither grows nor adds up twice moves no more behind than its input and one integral of that, but for the time of its lags. So
//! no function that grows is a candidate otherwise.

use super::found::{DECISIVE, Found};
use super::record::{InputOutput, rounding};
use super::rest::{STANDS, order_at_rest, rests};
use super::search::Search;
use crate::DeadTime;
use crate::identify::Free;
use core::f64::consts::E;
use fracdiff::{Seconds, roots};
use fractional_control::whole_orders::{coefficients, of_coefficients};
use fractional_control::{FractionalTransferFunction, Term};
use num_complex::Complex;

/// Time constants over the length of the record that a lag is tried with.
const LAGS: [f64; 3] = [0.3, 0.1, 0.03];

/// Lags of either sign, of some time constants, for a record of this length.
pub(super) fn lags(length_s: f64) -> impl Iterator<Item = FractionalTransferFunction> {
    let lags = LAGS
        .into_iter()
        .flat_map(move |share| [1.0, -1.0].map(|gain| lag(gain, share * length_s)));
    lags.flatten()
}

fn lag(gain: f64, time_constant_s: f64) -> Option<FractionalTransferFunction> {
    let below = [Term::new(time_constant_s, 1.0), Term::new(1.0, 0.0)];
    FractionalTransferFunction::new(&[Term::new(gain, 0.0)], &below).ok()
}

/// True if the output keeps moving as no plant does that neither grows nor adds up twice.
fn may_grow(record: &InputOutput) -> bool {
    let begin = record.changes().next().unwrap_or(0);
    let input = &record.input[begin..];
    let mut sum = 0.0;
    let sums = input.iter().map(|u| {
        sum += u - record.input_before;
        sum
    });
    let sums: Vec<f64> = sums.collect();
    let span = |signal: &[f64]| {
        let most = signal.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        most - signal.iter().copied().fold(f64::INFINITY, f64::min)
    };
    let more = |signal: &[f64]| {
        let (before, behind) = signal.split_at(signal.len() / 2);
        span(behind) / span(before)
    };
    let expected = more(input).max(more(&sums)).max(1.0);
    more(&record.output[begin..]) > E * expected
}

/// Takes what grows from a record that does not, if anything is left. An input that changes from row to row may be that of a loop, which keeps a
/// plant that grows from showing it: there what is calm must not leave so much more.
pub(super) fn drop_what_grows(found: &mut Vec<Found>, record: &InputOutput) {
    let is_calm = |candidate: &Found| !grows(&candidate.identified.function, record);
    let least = |is_one: &dyn Fn(&Found) -> bool| {
        let left = found
            .iter()
            .filter(|candidate| is_one(candidate))
            .map(|candidate| candidate.news(record));
        left.fold(f64::INFINITY, f64::min)
    };
    let (calm, any) = (least(&is_calm), least(&|_| true));
    let may_be_held = 2 * record.changes().count() > record.input.len();
    let is_enough =
        calm.is_finite() && (!may_be_held || calm <= MORE_LEFT * any.max(rounding(record)));
    if !may_grow(record) && is_enough {
        found.retain(is_calm);
    }
}

/// A function that grows, or adds up twice, yields to one that does neither, with at most this many more numbers and a residual larger by at most
/// this factor: only a record that grows itself is so decisive.
const MORE_NUMBERS: usize = 2;
const MORE_LEFT: f64 = 2.0;

/// The best of those that replace the first, if that grows. Where the record itself may grow, the criterion must not speak very strongly against it.
pub(super) fn calm_instead(found: &[Found], record: &InputOutput) -> Option<usize> {
    let first = found
        .first()
        .filter(|first| grows(&first.identified.function, record))?;
    let most = MORE_LEFT * first.news(record).max(rounding(record));
    let worst = if may_grow(record) {
        first.bic + DECISIVE
    } else {
        f64::INFINITY
    };
    found.iter().position(|candidate| {
        candidate.news(record) <= most
            && candidate.bic <= worst
            && candidate.numbers() <= first.numbers() + MORE_NUMBERS
            && !grows(&candidate.identified.function, record)
    })
}

/// True of a function with a pole that grows, or one and a half integrators and more; what stands within the record adds up there.
fn grows(function: &FractionalTransferFunction, record: &InputOutput) -> bool {
    if order_at_rest(function) >= 1.5 {
        return true;
    }
    if !function.is_whole() {
        return function.unstable_poles().is_some_and(|poles| poles > 0);
    }
    let below = coefficients(function.denominator());
    let integrators = function.denominator().lowest() as usize;
    let poles = roots(&below[integrators..]);
    let stands = |pole: &&Complex<f64>| pole.norm() * record.length_s() <= STANDS;
    let standing = poles.iter().filter(stands).count();
    integrators + standing > 1 || poles.iter().any(|pole| pole.re > 1e-9 * pole.norm())
}

/// A difference of the criterion that is strong evidence (R. E. Kass, A. E. Raftery, *Bayes factors*, 1995, section 3.2).
const STRONG: f64 = 6.0;

/// Share by which the innovations may be larger and count as equal, for any number of samples: no plant is a function to 1 % of its noise.
pub(super) const ALIKE: f64 = 0.02;

/// The plainest function that the record, in autocorrelated noise, does not decisively exclude: that with the fewest features that imitate such
/// noise (growth, poles and zeros at rest, zeros of the right half-plane), then the fewest numbers, unless another has strong evidence.
pub(super) fn plainest(found: &[Found], record: &InputOutput) -> Option<usize> {
    let least = |among: &[(usize, &Found)]| {
        let all = among.iter().map(|(_, candidate)| candidate.bic);
        all.fold(f64::INFINITY, f64::min)
    };
    // A first lag as slow as the record was put there for an integrator.
    let first = found.first()?.identified.function;
    let draws = |candidate: &Found| {
        let function = &candidate.identified.function;
        let zeros = || roots(&coefficients(function.numerator()));
        [
            grows(function, record),
            !candidate.settles() || !(rests(function, record) || *function == first),
            candidate.is_whole() && zeros().iter().any(|zero| zero.re > 0.0),
        ]
    };
    let mut near: Vec<(usize, &Found)> = found.iter().enumerate().collect();
    let best = least(&near);
    let news: Vec<f64> = found
        .iter()
        .map(|candidate| candidate.news(record))
        .collect();
    let most = (1.0 + ALIKE) * news.iter().copied().fold(f64::INFINITY, f64::min);
    near.retain(|(place, candidate)| candidate.bic <= best + DECISIVE || news[*place] <= most);
    let fewest = near.iter().map(|(_, candidate)| draws(candidate)).min()?;
    near.retain(|(_, candidate)| draws(candidate) == fewest);
    let best = least(&near);
    near.retain(|(_, candidate)| candidate.bic <= best + STRONG);
    let simplest = near.iter().min_by(|(_, a), (_, b)| {
        let numbers = |candidate: &Found| (candidate.numbers(), !candidate.is_whole());
        (numbers(a).cmp(&numbers(b))).then(a.bic.total_cmp(&b.bic))
    });
    simplest.map(|(place, _)| *place)
}

/// Adds lags and integrators, if the best grows: their fits find the way by themselves.
pub(super) fn calm_down(found: &mut Vec<Found>, search: &Search<'_>) {
    let best = found.iter().min_by(|a, b| a.bic.total_cmp(&b.bic));
    let Some(best) = best.filter(|best| grows(&best.identified.function, search.record)) else {
        return;
    };
    let dead_times = again(best, search);
    let adds = "1/s".parse().ok();
    for function in lags(search.record.length_s()).chain(adds) {
        let fits = dead_times.iter();
        found.extend(fits.filter_map(|late| search.coefficients(&function, *late)));
    }
}

/// A dead time over the length of the record, to begin from.
const LATE: f64 = 0.1;

/// Dead times to try with a simpler function: the given one, or 0, that of the other function, and a share of the record.
fn again(other: &Found, search: &Search<'_>) -> Vec<DeadTime> {
    let late = other.identified.dead_time;
    if search.dead_time_is_known {
        return vec![late];
    }
    let share = LATE * search.record.length_s();
    let begins = [late.seconds(), share].map(|late| DeadTime::From(Seconds(late)));
    [DeadTime::NONE].into_iter().chain(begins).collect()
}

/// Time constants over the length of the record, of lags that are too slow for it.
const SLOWER: [f64; 5] = [1.0, 2.0, 4.0, 8.0, 16.0];
/// A share of the output's variance that is nothing.
const NOTHING: f64 = 0.001;

/// The function with a pole of this time constant in place of its integrator.
fn slowed(
    function: &FractionalTransferFunction,
    time_constant_s: f64,
) -> Option<FractionalTransferFunction> {
    let mut below = coefficients(function.denominator());
    let adds_up = function.is_whole() && (order_at_rest(function) - 1.0).abs() <= 0.0;
    let slope = *below.get(1).filter(|_| adds_up)?;
    // A(s)/s·(s + 1/τ)
    for k in 0..below.len() - 1 {
        below[k] += below[k + 1] / time_constant_s;
    }
    let above = coefficients(function.numerator());
    (slope != 0.0).then(|| of_coefficients(&above, &below))?
}

/// Puts a lag before a first function that does not settle, or a slow pole in place of its integrator: a record that does not speak very strongly
/// against one that settles as fast as the record is long has not shown that its plant adds up. The pole is held, since a record that cannot tell it
/// from rest lets a fit carry it past 0; of those that are slower the fastest is taken that explains as much as the slowest.
pub(super) fn slow_instead(found: &mut Vec<Found>, search: &Search<'_>) {
    let Some(first) = found.first().filter(|first| !first.settles()) else {
        return;
    };
    let length_s = search.record.length_s();
    let as_slow = |times: f64, late: DeadTime, is_lag: bool| {
        let slow = if is_lag {
            lag(1.0, times * length_s)
        } else {
            slowed(&first.identified.function, times * length_s)
        };
        search.fitted(&slow?, late, Free::Above).ok()
    };
    let dead_times = again(first, search).into_iter().map(|late| (late, true));
    let kinds = dead_times.chain([(first.identified.dead_time, false)]);
    let fits = kinds.filter_map(|(late, is_lag)| Some((as_slow(1.0, late, is_lag)?, is_lag)));
    let nearest = fits.min_by(|a, b| a.0.bic.total_cmp(&b.0.bic));
    let is_near = |other: &Found| other.bic <= first.bic + DECISIVE;
    let is_lag = |other: &Found| {
        let below = other.identified.function.denominator().terms();
        let [lag, rest] = below else {
            return false;
        };
        let time_s = lag.coefficient / rest.coefficient;
        other.is_whole()
            && lag.order <= 1.0
            && rest.order <= 0.0
            && time_s > 0.0
            && time_s <= length_s
    };
    let faster = found.iter().enumerate();
    let faster = faster.filter(|(_, other)| is_lag(other) && is_near(other));
    let faster = faster.min_by(|(_, a), (_, b)| a.bic.total_cmp(&b.bic));
    let is_better = |candidate: &Found| faster.is_none_or(|(_, other)| candidate.bic < other.bic);
    if let Some((nearest, is_lag)) =
        nearest.filter(|(nearest, _)| is_near(nearest) && is_better(nearest))
    {
        let late = nearest.identified.dead_time;
        let slower = SLOWER.into_iter();
        let slower = slower.filter_map(|times| as_slow(times, late, is_lag));
        let slower: Vec<Found> = slower.collect();
        let most = slower.iter().map(|candidate| candidate.identified.fit);
        let most = most.fold(nearest.identified.fit, f64::max);
        let enough = |candidate: &Found| candidate.identified.fit >= most - NOTHING;
        let chosen = slower.into_iter().find(enough).unwrap_or(nearest);
        found.insert(0, chosen);
    } else if let Some((place, _)) = faster {
        found[..=place].rotate_right(1);
    }
}
