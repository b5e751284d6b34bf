//! A transfer function from a record: first guesses, fits, and which of them the record asks for.

use self::calm::{ALIKE, calm_down, calm_instead, drop_what_grows, lags, plainest, slow_instead};
pub use self::dead_time::{DeadTimeEvidence, dead_time_evidence};
use self::dead_time::{dead_times, gain};
use self::found::{AS_GOOD, DECISIVE, LOOSE};
pub use self::found::{Found, Unexplained};
pub use self::record::{Guess, InputOutput};
use self::record::{left, resolved, rounding};
use self::rest::{cancelled, comes_to_rest, integrating, order_at_rest, without_pair};
use self::search::Search;
use self::start::{Begin, OfShape, at_once, part, powers, starts, stretch, whole_orders};
use self::sums::sums;
use crate::identify::{Free, UNFIT, answers_at_once, run_alone};
use crate::{DeadTime, FreeNumber, Identified, StartState, WholeShape};
use fracdiff::Seconds;
use fractional_control::{ControlError, FractionalTransferFunction, SumOfParts, Term};
use rayon::prelude::*;
use std::collections::VecDeque;

mod calm;
mod dead_time;
mod found;
mod record;
pub(crate) mod rest;
mod search;
mod start;
mod sums;

/// Another function for a first one that does not settle on its own: one that does, within the record, and
/// that the record does not speak very strongly against: a criterion at most 10 above (A. E.
/// Raftery, *Bayesian model selection in social research*, 1995, Table 6), or that of one number.
#[must_use]
pub fn settles_as_well<'a>(found: &'a [Found], record: &InputOutput) -> Option<&'a Found> {
    let first = found.first().filter(|first| !first.settles())?;
    let one_number = libm::log(record.output.len() as f64);
    let near = |other: &&Found| other.bic <= first.bic + one_number.max(DECISIVE);
    let mut others = found.iter().filter(|other| other.settles()).filter(near);
    others.find(|other| comes_to_rest(&other.identified.function, record))
}

/// A function beside another record than that it was found from.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Validation {
    /// Its output for the input of that record.
    pub model: Vec<f64>,
    /// Root mean square of the residual, in the unit of y.
    pub rms_residual: f64,
    /// 1 less the residual's share of the variance of y; negative for a function worse than a constant.
    pub fit: f64,
}

/// Share by which two functions differ, in the error of a simulation and in their gains at rest, where a person is asked to choose.
const APART: f64 = 0.1;

/// The function that follows a record better than the first in simulation, by a tenth of its root mean square, and has another gain at rest by a
/// tenth; with what the first leaves and what this one does. The first is chosen by the next sample, in the noise that it leaves: where that is slow,
/// a wrong gain costs it little.
///
/// The record is `other`, where there is one (see [`validate`]), else their own: there each number has the price of Schwarz's criterion in white
/// noise, and what adds up is no other, for so it follows a drift.
#[must_use]
pub fn nearer_in_simulation<'a>(
    found: &'a [Found],
    record: &InputOutput,
    other: Option<&InputOutput>,
    held: bool,
) -> Option<(&'a Found, [f64; 2])> {
    let samples = record.output.len() as f64;
    let gain = |found: &Found| found.identified.function.gain_at_rest();
    let tried = |found: &Found| match other {
        Some(other) => {
            let left = validate(found, record.start, other, held)?.rms_residual;
            Some((left, libm::log(left)))
        }
        None => {
            let left = found.identified.rms_residual;
            let price = 0.5 * found.numbers() as f64 * libm::log(samples) / samples;
            Some((left, libm::log(left) + price))
        }
    };
    let first = found.first()?;
    let (of_first, most) = tried(first)?;
    let is_other = |instead: &&Found| {
        let [gain, instead] = [gain(first), gain(instead)];
        let is_alike = gain.total_cmp(&instead).is_eq() || (instead / gain - 1.0).abs() <= APART;
        !is_alike && (other.is_some() || instead.is_finite())
    };
    let others = found.iter().filter(is_other);
    let others = others.filter_map(|found| Some((found, tried(found)?)));
    let nearest = others.min_by(|(_, (_, a)), (_, (_, b))| a.total_cmp(b));
    let nearest =
        nearest.filter(|(_, (left, price))| (1.0 + APART) * left < of_first && *price < most);
    nearest.map(|(nearest, (left, _))| (nearest, [of_first, left]))
}

/// Runs a function over another record, its coefficients and dead time as they are. Where the plant is when that begins is found again, unless both
/// begin at rest; `None` if it does not run.
#[must_use]
pub fn validate(
    found: &Found,
    first: StartState,
    other: &InputOutput,
    held: bool,
) -> Option<Validation> {
    let model = &found.identified;
    let dead_time = match model.dead_time {
        DeadTime::From(late) => DeadTime::Known(late),
        known @ (DeadTime::Known(_) | DeadTime::JustAfter(_)) => known,
    };
    let start = match first {
        StartState::Rest => StartState::Rest,
        StartState::Offset | StartState::Settled | StartState::Moving => StartState::Moving,
    };
    let record = crate::InputOutputRecord {
        start,
        noise: model.noise,
        ..other.as_record(held, dead_time)
    };
    let model = run_alone(&model.parts, &record)?;
    let power = |values: &[f64]| values.iter().map(|x| x * x).sum::<f64>();
    let mean = other.output.iter().sum::<f64>() / other.output.len() as f64;
    let around: Vec<f64> = other.output.iter().map(|y| y - mean).collect();
    let left = power(&left(other, &model));
    Some(Validation {
        rms_residual: libm::sqrt(left / other.output.len() as f64),
        fit: 1.0 - left / power(&around),
        model,
    })
}

/// Guesses of whole orders that are fitted: the most promising, and the best of each smaller number of poles than the first has.
const FITTED: usize = 8;
const SWING: WholeShape = WholeShape {
    poles: 2,
    zeros: 0,
    integrators: 0,
};

/// First guesses: of whole orders up to four poles, two of them integrators, those that leave least; of one and of two powers of s with free
/// orders; a gain. Behind a dead time that is known, or `None`: then behind those that the record suggests, and behind none. `held` as in
/// [`InputOutputRecord`](crate::InputOutputRecord).
/// Of a number of poles that is wanted all shapes, and nothing else.
#[must_use]
pub fn candidates(
    record: &InputOutput,
    held: bool,
    dead_time: Option<Seconds>,
    wanted: Wanted,
) -> Vec<Guess> {
    let record = &record.for_guesses();
    let dead_times = dead_times(record, held, dead_time, true);
    // Without a change of the input what passes at once is an offset.
    let mut whole = whole_orders(record, held, &dead_times, record.moves(), POLES, true);
    whole.sort_by(|a, b| a.bic.total_cmp(&b.bic));
    if let Some(poles) = wanted.poles {
        let guesses = whole.into_iter();
        let guesses = guesses.filter(|guess| guess.shape.poles == poles);
        return guesses.map(|guess| guess.guess).collect();
    }
    // Dead time from which fits of free orders start.
    let slower = |guess: &&OfShape| !answers_at_once(&guess.guess.function);
    let first = whole.iter().find(slower).map(|best| best.guess.dead_time);
    let first = first.or(dead_times.first().copied());
    let first = first.unwrap_or(DeadTime::NONE);
    // A swing whose orders may be others too.
    let swing = whole.iter().find(|guess| guess.shape == SWING);
    let swing = swing.map(|swing| swing.guess.function);
    let most = whole.first().map_or(0, |best| best.shape.poles);
    let best = |poles: usize| whole.iter().position(|guess| guess.shape.poles == poles);
    let simpler = (1..most).filter_map(best).filter(|place| *place >= FITTED);
    // Lags alone behind a dead time, which a record in slow noise hides behind what draws that.
    let shapes = [(1, 0), (2, 0), (2, 1), (3, 0)].into_iter();
    let lags = shapes.filter_map(|(poles, zeros)| {
        let shape = WholeShape {
            poles,
            zeros,
            integrators: 0,
        };
        let is_wanted = |guess: &OfShape| guess.shape == shape && guess.guess.dead_time.is_free();
        whole.iter().position(is_wanted)
    });
    let mut places: Vec<usize> = (0..FITTED.min(whole.len())).collect();
    for place in simpler.chain(lags) {
        if !places.contains(&place) {
            places.push(place);
        }
    }
    let mut guesses: Vec<Guess> = places
        .iter()
        .map(|place| whole[*place].guess.clone())
        .collect();
    let best = &whole[..FITTED.min(whole.len())];
    guesses.extend(sums(record, held, dead_time, best));
    guesses.extend(gain(record, held, dead_time));
    let powers = powers(record, first.seconds());
    guesses.extend(swing.into_iter().chain(powers).map(|function| Guess {
        parts: vec![],
        function,
        has_free_orders: true,
        dead_time: first,
    }));
    guesses
}

/// Guesses of one function with free orders, behind each dead time as in [`candidates`] and the first value of one, s, that is not known; one that answers at once behind whole samples, read with
/// the new input of a row and just before it, its own orders too if they are whole.
#[must_use]
pub fn candidates_of(
    sum: &SumOfParts,
    record: &InputOutput,
    held: bool,
    dead_time: Option<Seconds>,
    first: Option<Seconds>,
) -> Vec<Guess> {
    let mut dead_times = dead_times(&record.for_guesses(), held, dead_time, true);
    let first = first.filter(|first| dead_time.is_none() && first.0 < record.length_s());
    dead_times.extend(first.map(DeadTime::From));
    let function = sum.function();
    let parts = match sum.parts() {
        [_] => &[],
        parts => parts,
    };
    let guesses = |dead_times: Vec<DeadTime>, has_free_orders| {
        let dead_times = dead_times.into_iter();
        dead_times.map(move |dead_time| Guess {
            function,
            parts: parts.to_vec(),
            has_free_orders,
            dead_time,
        })
    };
    if !answers_at_once(&function) {
        return guesses(dead_times, true).collect();
    }
    let dead_times = at_once(record.sample_time_s(), &dead_times);
    let prompt = guesses(dead_times.clone(), false);
    let prompt = prompt.filter(|_| function.is_whole() && parts.is_empty());
    prompt.chain(guesses(dead_times, true)).collect()
}

/// Largest number of samples from which the start of the plant is found, and of functions fitted for it.
const OF_START: usize = 250;
const FITTED_FOR_START: usize = 3;
/// Poles of a guess at most, and of those for a start alone.
const POLES: usize = 4;
const POLES_FOR_START: usize = 3;
/// An output that begins further from 0 than this many times the residual does not begin at rest there.
const BEGINS_ELSEWHERE: f64 = 4.0;

/// Finds where the plant was when the record begins, by functions of whole orders: at rest unless
/// another [`StartState`] has a criterion that is better by 10, and the output begins elsewhere than at
/// 0. An input that never moves, or only at the beginning, does not reveal its value before the record, nor what moves beside it: it
/// was 0, or, if it moves, what it is in the first row, unless the output tells them apart. From that value it is counted then.
pub fn find_start(record: &mut InputOutput, held: bool, dead_time: Option<Seconds>) {
    let part = part(record, held, OF_START).unwrap_or_else(|| record.clone());
    let first = |signal: &[f64]| signal.first().copied().unwrap_or(0.0);
    let [input, output] = [&part.input, &part.output].map(|signal| first(signal));
    // Each with what the input is counted from.
    let mut starts = vec![(StartState::Rest, 0.0)];
    if output != 0.0 {
        let zero = first(&record.input);
        if zero != 0.0 && record.moves() && !record.tells_before() {
            starts.insert(0, (StartState::Offset, zero));
        }
        starts.push((StartState::Offset, 0.0));
        if record.tells_before() {
            starts.push((StartState::Settled, 0.0));
            starts.extend((!record.begins_flat()).then_some((StartState::Moving, 0.0)));
        }
    }
    let beginning = |(start, zero): (StartState, f64)| {
        let from = |value: f64, is_open: bool| if is_open { value } else { 0.0 };
        InputOutput {
            start,
            offset: from(output, start != StartState::Rest),
            input_before: from(
                input,
                matches!(start, StartState::Settled | StartState::Moving),
            ),
            ..part.clone().counted_from(zero)
        }
    };
    // The last knows of all the others, so its dead times do for them, and its guesses stand beside theirs; lags find their way by themselves.
    let open = starts.last().map_or((StartState::Rest, 0.0), |last| *last);
    let dead_times = dead_times(&beginning(open).for_guesses(), held, dead_time, false);
    let guesses =
        |start: (StartState, f64), poles: usize| -> Vec<(FractionalTransferFunction, DeadTime)> {
            let options = beginning(start).for_guesses();
            let mut guesses = whole_orders(&options, held, &dead_times, part.moves(), poles, false);
            guesses.sort_by(|a, b| a.bic.total_cmp(&b.bic));
            let guesses = guesses
                .iter()
                .take(FITTED_FOR_START)
                .map(|guess| (guess.guess.function, guess.guess.dead_time));
            guesses.collect()
        };
    let late = dead_times.first().copied().unwrap_or(DeadTime::NONE);
    let mut shared = guesses(open, POLES);
    shared.extend(lags(part.length_s()).map(|lag| (lag, late)));
    let fitted = |start: &(StartState, f64)| -> Vec<Found> {
        let options = beginning(*start);
        let search = Search::new(&options, held, dead_time.is_some());
        let simple = if *start == open {
            vec![]
        } else {
            guesses(*start, POLES_FOR_START)
        };
        let fits = shared.iter().chain(&simple);
        let fits = fits.filter_map(|(function, late)| search.coefficients(function, *late));
        let begins_there = |candidate: &Found| {
            matches!(start.0, StartState::Rest | StartState::Moving)
                || output.abs() > BEGINS_ELSEWHERE * candidate.identified.rms_residual
        };
        fits.filter(begins_there).collect()
    };
    let mut fits: Vec<Vec<Found>> = starts.par_iter().map(fitted).collect();
    let search = Search::new(&part, held, dead_time.is_some());
    if search.leaves_alike(fits.iter().flatten()) {
        let pairs = starts.par_iter().zip(&mut fits);
        pairs.for_each(|(start, fits)| {
            Search::new(&beginning(*start), held, dead_time.is_some()).whiten(fits);
        });
    }
    let mut best = f64::INFINITY;
    let mut zero = 0.0;
    for ((start, from), fits) in starts.into_iter().zip(fits) {
        let least = fits.into_iter().min_by(|a, b| a.bic.total_cmp(&b.bic));
        if let Some(candidate) = least.filter(|candidate| candidate.bic < best - DECISIVE) {
            let fit = candidate.identified;
            (best, zero) = (candidate.bic, from);
            (record.start, record.offset, record.input_before) = match start {
                StartState::Moving => (start, output, input),
                StartState::Rest | StartState::Offset | StartState::Settled => {
                    (start, fit.offset, fit.input_before)
                }
            };
        }
    }
    *record = std::mem::take(record).counted_from(zero);
}

/// Conditions on a function, besides a good fit to the record.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wanted {
    /// Whole orders and this number of poles, integrators included: 1 to 4.
    pub poles: Option<usize>,
    /// Stable: no pole grows or stays.
    pub is_stable: bool,
}

impl Wanted {
    fn allows(&self, function: &FractionalTransferFunction) -> bool {
        let is_of = |poles: usize| {
            let degree = function.denominator().degree();
            function.is_whole() && (degree - poles as f64).abs() < 0.5
        };
        self.poles.is_none_or(is_of) && (!self.is_stable || function.unstable_poles() == Some(0))
    }
}

/// Functions that are kept at most: the best.
const KEPT: usize = 6;
/// Fits each guess, on all cores; returns those that fit and meet `wanted`, the best first, six at most. `held` as in
/// [`InputOutputRecord`](crate::InputOutputRecord).
///
/// `done` receives the number of guesses that are done, and of the fits that start from them again.
///
/// # Errors
/// The first guess's error, or that nothing fits, if nothing does that is wanted.
pub fn identify(
    record: &InputOutput,
    guesses: &[Guess],
    held: bool,
    wanted: Wanted,
    done: &(dyn Fn(usize) + Sync),
) -> Result<Vec<Found>, ControlError> {
    let (sums, guesses): (Vec<Guess>, Vec<Guess>) =
        (guesses.iter().cloned()).partition(|guess| !guess.parts.is_empty());
    let guesses = &guesses[..];
    let whole = guesses.iter().filter(|guess| !guess.has_free_orders);
    let whole: Vec<Guess> = whole.cloned().collect();
    let mut all = guesses.iter().chain(&sums);
    let is_known = !all.any(|guess| guess.dead_time.is_free());
    let mut search = Search::new(record, held, is_known);
    let (mut found, mut refused) = fitted_of_whole_orders(&search, &whole, done);
    // A function without a residual cannot be improved with as many numbers.
    let enough = |found: &[Found]| {
        // Practically exact, or with white noise as residual.
        let white = 2.0 / libm::sqrt(record.output.len() as f64);
        let exact = |found: &&Found| {
            let is_white = found.is_whole() && found.neighbours.abs() <= white;
            is_white || search.is_exact(&found.identified)
        };
        let numbers = |found: &Found| found.numbers();
        found.iter().filter(exact).map(numbers).min()
    };
    let most = enough(&found).unwrap_or(usize::MAX);
    let mut starts: VecDeque<Begin> = starts(record, guesses, held, most).into();
    refused = refused.or(fit_sums(&mut found, &sums, &search, most, done));
    let free = guesses.iter().filter(|guess| guess.has_free_orders);
    done(free.count() - starts.len());
    while let Some(numbers) = starts.front().map(|start| start.numbers) {
        let is_enough = |found: &[Found]| enough(found).is_some_and(|most| numbers >= most);
        // Starts of equal number of parameters together, one of which may make the rest superfluous.
        let alike = starts.iter().take_while(|start| start.numbers == numbers);
        let alike: Vec<Begin> = starts.drain(..alike.count()).collect();
        if is_enough(&found) {
            done(alike.len());
            continue;
        }
        // A long record is not run through by what leaves more of its part than others leave of all of it.
        let least = found
            .iter()
            .map(|candidate| candidate.identified.rms_residual);
        let least = least.fold(f64::INFINITY, f64::min);
        let promising = |start: &&Begin| start.rms_residual().is_none_or(|left| left < least);
        let promising = alike.iter().filter(promising).cloned();
        let (before, alike) = (alike.len(), promising.collect::<Vec<Begin>>());
        done(before - alike.len());
        let fitted = alike.par_iter().map(|start| {
            let fitted = fitted_from(start, &search);
            done(1);
            fitted
        });
        let fitted: Vec<_> = fitted.collect();
        for (start, fitted) in alike.iter().zip(fitted) {
            if is_enough(&found) {
                break;
            }
            match fitted {
                Ok((single, prompt)) => {
                    starts.extend(start.doubted(&single.identified, resolved(record)));
                    found.extend(prompt.into_iter().chain([single]));
                }
                Err(error) => {
                    starts.extend(start.first());
                    refused = refused.or(Some(error));
                }
            }
        }
    }
    put_in_order(&mut found, &mut search, wanted);
    found.truncate(KEPT);
    match refused {
        Some(error) if found.is_empty() => Err(error),
        None if found.is_empty() => Err(UNFIT),
        _ => Ok(found),
    }
}

/// Largest order of a part of an impedance, with what noise adds to 1.
const PASSIVE: f64 = 1.1;

fn is_passive(parts: &[FractionalTransferFunction]) -> bool {
    let degrees = parts.iter().map(|part| part.denominator().degree());
    degrees.fold(0.0, f64::max) <= PASSIVE
}

/// Adds sums of fewer than `most` numbers, those of the fewest first, until one leaves white noise; those of more numbers only in the reading that
/// fits best so far. The first error.
fn fit_sums(
    found: &mut Vec<Found>,
    sums: &[Guess],
    search: &Search<'_>,
    most: usize,
    done: &(dyn Fn(usize) + Sync),
) -> Option<ControlError> {
    let white = 2.0 / libm::sqrt(search.record.output.len() as f64);
    let is_named = found.is_empty();
    let mut refused = None;
    for alike in sums.chunk_by(|a, b| a.numbers() == b.numbers()) {
        done(alike.len());
        let best = found.iter().filter(|candidate| candidate.is_sum());
        let best = best.min_by(|a, b| a.bic.total_cmp(&b.bic));
        let is_white = best.is_some_and(|best| best.neighbours.abs() <= white);
        let reading = best.map(|best| best.identified.dead_time);
        let fits = alike.par_iter().filter(|guess| {
            let is_read = reading.is_none_or(|reading| reading == guess.dead_time);
            is_read && !is_white && guess.numbers() < most
        });
        let fits = fits.map(|guess| search.sum_fitted(&guess.parts, guess.dead_time, Free::All));
        for fit in fits.collect::<Vec<_>>() {
            match fit {
                Ok(fit) if !is_named && !is_passive(&fit.identified.parts) => {}
                Ok(fit) => found.push(fit),
                Err(error) => refused = refused.or(Some(error)),
            }
        }
    }
    refused
}

/// Betters what was found, drops what is not wanted, and puts the best first: the simplest of those that are as good.
fn put_in_order(found: &mut Vec<Found>, search: &mut Search<'_>, wanted: Wanted) {
    let is_alike = search.leaves_alike(found.iter());
    if is_alike {
        each_once(found);
        search.whiten(found);
        each_once(found);
        drop_what_is_loose(found, search);
        each_once(found);
    }
    cancel(found, search);
    put_to_rest(found, search);
    to_their_limits(found, search);
    calm_down(found, search);
    found.retain(|candidate| wanted.allows(&candidate.identified.function));
    drop_what_grows(found, search.record);
    resolve_finer(found, search);
    each_once(found);
    to_the_front(found, simplest_as_good);
    to_the_front(found, simplest_at_rest);
    to_the_front(found, |found| calm_instead(found, search.record));
    slow_instead(found, search);
    found.retain(|candidate| wanted.allows(&candidate.identified.function));
    if is_alike {
        to_the_front(found, |found| plainest(found, search.record));
        late_by_whole_samples(found, search);
    }
}

fn to_the_front(found: &mut [Found], place: impl Fn(&[Found]) -> Option<usize>) {
    if let Some(place) = place(found) {
        found[..=place].rotate_right(1);
    }
}

/// The best first, and of guesses that end in one function one.
fn each_once(found: &mut Vec<Found>) {
    found.sort_by(|a, b| a.bic.total_cmp(&b.bic));
    found.dedup_by(|a, b| {
        let numbers = |found: &Found| found.numbers();
        numbers(a) == numbers(b) && (a.bic - b.bic).abs() < 1e-6 * b.bic.abs()
    });
}

/// Factor by which the residual may grow when a pole at rest is cancelled.
const AS_MUCH: f64 = 2.0;
/// Samples from which on a record is long, and functions of its part that are fitted to all of it.
const LONG: usize = 2000;
const POLISHED: usize = 4;

/// The functions of whole orders, and the first error. Of a long record they are chosen by a part of it, unless that has lost what is fast.
fn fitted_of_whole_orders(
    search: &Search<'_>,
    guesses: &[Guess],
    done: &(dyn Fn(usize) + Sync),
) -> (Vec<Found>, Option<ControlError>) {
    let Search { record, held, .. } = *search;
    let fitted = |guesses: &[Guess], search: &Search<'_>, first: bool| {
        let fits = guesses.par_iter().map(|guess| {
            let fitted = with_fewer(guess, search);
            done(usize::from(first));
            fitted
        });
        let fits: Vec<_> = fits.collect();
        let (mut found, mut refused) = (Vec::new(), None);
        for fit in fits {
            match fit {
                Ok(fit) => found.extend(fit),
                Err(error) => refused = refused.or(Some(error)),
            }
        }
        (found, refused)
    };
    let part = stretch(record, held, LONG);
    if let Some(part) = &part {
        let mut of_this = Search::new(part, held, search.dead_time_is_known);
        let (mut of_part, _) = fitted(guesses, &of_this, true);
        if of_this.leaves_alike(of_part.iter()) {
            of_this.whiten(&mut of_part);
            drop_what_is_loose(&mut of_part, &of_this);
        }
        of_part.sort_by(|a, b| a.bic.total_cmp(&b.bic));
        let best = of_part.first().map(|best| best.identified.rms_residual);
        let of_part = of_part.iter().take(POLISHED).map(|guess| Guess {
            function: guess.identified.function,
            parts: vec![],
            has_free_orders: false,
            dead_time: guess.identified.dead_time,
        });
        let whole = fitted(&of_part.collect::<Vec<_>>(), search, false);
        let least = whole
            .0
            .iter()
            .map(|candidate| candidate.identified.rms_residual);
        let least = least.fold(f64::INFINITY, f64::min);
        if best.is_some_and(|best| least <= AS_MUCH * best.max(resolved(record))) {
            return whole;
        }
    }
    fitted(guesses, search, part.is_none())
}

/// A number whose standard error is this many times its size has gone to its limit.
const FAR: f64 = 10.0;

/// Adds the best function of free orders without its last or first term below, where that leaves as little: of 7.5e13/(1.5e13s^1.19 + 1) that is
/// 5/s^1.19, which says the same.
fn to_their_limits(found: &mut Vec<Found>, search: &Search<'_>) {
    let others = found
        .iter()
        .filter(|candidate| !candidate.is_whole() && !candidate.is_sum());
    let Some(best) = others.min_by(|a, b| a.bic.total_cmp(&b.bic)) else {
        return;
    };
    let model = &best.identified;
    let far = model.standard_errors.iter().any(|(_, error)| *error > FAR);
    let (above, below) = (
        model.function.numerator().terms(),
        model.function.denominator().terms(),
    );
    if !far || below.len() < 2 {
        return;
    }
    let (last, first) = (&below[..below.len() - 1], &below[1..]);
    let fewer = [last, first].into_iter().filter_map(|below| {
        let unit = below.last()?.coefficient.abs();
        let scaled = |terms: &[Term]| -> Vec<Term> {
            let scaled = terms
                .iter()
                .map(|term| Term::new(term.coefficient / unit, term.order));
            scaled.collect()
        };
        let fewer = FractionalTransferFunction::new(&scaled(above), &scaled(below)).ok()?;
        let fewer = search.fitted(&fewer, model.dead_time, Free::All).ok();
        fewer.filter(|fewer| fewer.bic <= best.bic)
    });
    let fewer: Vec<Found> = fewer.collect();
    found.extend(fewer);
}

/// The function from this start, and the same without a dead time that the record does not determine.
fn fitted_from(start: &Begin, search: &Search<'_>) -> Result<(Found, Option<Found>), ControlError> {
    let fitted = search.fitted(&start.function, start.dead_time, Free::All)?;
    let prompt = fitted.dead_time_is_loose().then(|| {
        let prompt = search.fitted(&fitted.identified.function, DeadTime::NONE, Free::All);
        prompt.ok()
    });
    Ok((fitted, prompt.flatten()))
}

/// The simplest of the functions equivalent to the best: of whole orders, which run exactly, then of the fewest numbers, then of the fewest poles
/// and zeros: a dead time is likelier than a zero of the right half-plane or a fast pole in its place.
fn simplest_as_good(found: &[Found]) -> Option<usize> {
    let best = found.first()?;
    let all = found.iter().enumerate();
    let as_good = all.filter(|(_, other)| other.bic <= best.bic + AS_GOOD);
    let simplest = as_good.min_by(|(_, a), (_, b)| {
        let numbers = |found: &Found| (!found.is_whole(), found.numbers());
        let (poles_and_zeros, bic) = (Found::poles_and_zeros, |found: &Found| found.bic);
        (numbers(a).cmp(&numbers(b)))
            .then(poles_and_zeros(a).total_cmp(&poles_and_zeros(b)))
            .then(bic(a).total_cmp(&bic(b)))
    });
    simplest.map(|(place, _)| place)
}

/// Place of the simplest function, by its numbers or by whole orders, of those with no more poles against which the record does not speak very
/// strongly. It comes before the first, the best, if it has another pole at rest.
fn simplest_at_rest(found: &[Found]) -> Option<usize> {
    let numbers = |found: &Found| (found.numbers(), !found.is_whole());
    let order = |found: &Found| order_at_rest(&found.identified.function);
    let best = found.first()?;
    let all = found.iter().enumerate();
    let degree = |found: &Found| found.identified.function.denominator().degree();
    let near =
        all.filter(|(_, other)| other.bic <= best.bic + DECISIVE && degree(other) <= degree(best));
    let simplest = near.min_by_key(|(_, other)| numbers(other));
    let simplest = simplest.filter(|(_, other)| (order(other) - order(best)).abs() > 0.0);
    simplest.map(|(place, _)| place)
}

/// Puts functions without a zero and the pole that it cancels in place of those with both: where both are at rest and as little is left, or where
/// they are one within their errors.
fn cancel(found: &mut [Found], search: &Search<'_>) {
    let floor = rounding(search.record);
    let mut place = 0;
    while let Some(candidate) = found.get(place) {
        let fitted = |fewer: Option<FractionalTransferFunction>| {
            search.coefficients(&fewer?, candidate.identified.dead_time)
        };
        let left = AS_MUCH * candidate.identified.rms_residual.max(floor);
        let at_rest = || {
            let fewer = fitted(cancelled(&candidate.identified.function, search.record));
            fewer.filter(|fewer| fewer.identified.rms_residual <= left)
        };
        let as_one = || fitted(without_pair(&candidate.identified, search.record));
        let whole = candidate.is_whole().then(|| at_rest().or_else(as_one));
        match whole.flatten() {
            // Check again: there may be two of them.
            Some(fewer) => found[place] = fewer,
            None => place += 1,
        }
    }
}

/// Adds the functions with an integrator in place of a pole that is at rest.
fn put_to_rest(found: &mut Vec<Found>, search: &Search<'_>) {
    let whole = found.iter().filter(|found| found.is_whole());
    let fitted = whole.filter_map(|found| {
        let model = &found.identified;
        let function = integrating(&model.function, search.record)?;
        search.coefficients(&function, model.dead_time)
    });
    let fitted: Vec<Found> = fitted.collect();
    found.extend(fitted);
}

/// A dead time within this share of a sample of whole ones.
const WHOLE: f64 = 0.1;

/// Puts a function behind whole samples before a first one of about that dead time, if it fits as closely: in autocorrelated noise no record shows a
/// tenth of a sample, and a plant that is driven by the clock of its log is late by whole ones.
fn late_by_whole_samples(found: &mut Vec<Found>, search: &Search<'_>) {
    let Some(first) = found.first() else {
        return;
    };
    let (model, t) = (&first.identified, search.record.sample_time_s());
    let late = model.dead_time.seconds() / t;
    let whole = libm::round(late);
    let is_near = whole > 0.0 && (late - whole).abs() <= WHOLE;
    if !is_near || !model.dead_time.is_free() || !search.record.is_even() {
        return;
    }
    let behind = DeadTime::Known(Seconds(whole * t));
    let most = (1.0 + ALIKE) * first.news(search.record);
    let fit = search.sum_fitted(&model.parts, behind, first.freedom).ok();
    if let Some(mut fit) = fit.filter(|fit| fit.news(search.record) <= most) {
        // It was chosen, so it counts.
        fit.bic += libm::log(search.record.output.len() as f64);
        found.insert(0, fit);
    }
}

/// Adds the functions of whole orders without what the record does not determine in its noise.
fn drop_what_is_loose(found: &mut Vec<Found>, search: &Search<'_>) {
    let whole = found.par_iter().filter(|candidate| candidate.is_whole());
    let fewer = whole.flat_map_iter(|candidate| {
        let identified = &candidate.identified;
        let guess = Guess {
            parts: vec![],
            function: identified.function,
            has_free_orders: false,
            dead_time: identified.dead_time,
        };
        with_fewer(&guess, search).unwrap_or_default()
    });
    let fewer: Vec<Found> = fewer.collect();
    found.extend(fewer);
}

/// The coefficients of a function, and those of the functions that are left without what the record does not determine, one by one.
fn with_fewer(guess: &Guess, search: &Search<'_>) -> Result<Vec<Found>, ControlError> {
    let mut found: Vec<Found> = Vec::new();
    let mut left = vec![(guess.function, guess.dead_time)];
    while let Some((function, dead_time)) = left.pop() {
        match search.fitted(&function, dead_time, Free::Coefficients) {
            Ok(judged) => {
                let unexplained = judged.identified.rms_residual;
                let coarser = (resolved(search.record) / unexplained).max(1.0);
                left.extend(without_the_loosest(
                    &judged,
                    coarser,
                    search.record.sample_time_s(),
                ));
                found.push(judged);
            }
            Err(error) if found.is_empty() => return Err(error),
            Err(_) => {}
        }
    }
    Ok(found)
}

/// The functions without the number that the record determines least, if it does not determine it; `times` scales standard errors. A dead time may
/// be loose because poles and zeros are there in place of some of it: then also without the loosest of these.
fn without_the_loosest(
    found: &Found,
    times: f64,
    t: f64,
) -> Vec<(FractionalTransferFunction, DeadTime)> {
    let Identified {
        function,
        dead_time,
        standard_errors,
        ..
    } = &found.identified;
    let share = |(number, error): &(FreeNumber, f64)| {
        if *number == FreeNumber::DeadTime {
            error / dead_time.seconds()
        } else {
            *error
        }
    };
    let loose = standard_errors
        .iter()
        .filter(|candidate| share(candidate) * times > LOOSE);
    let mut loose: Vec<&(FreeNumber, f64)> = loose.collect();
    loose.sort_by(|a, b| share(b).total_cmp(&share(a)));
    let is_late = loose
        .first()
        .is_some_and(|first| first.0 == FreeNumber::DeadTime);
    // The next where a function without the loosest would answer at once.
    let without = loose.into_iter();
    without
        .filter_map(|(number, _)| without_number(function, *dead_time, *number, t))
        .take(if is_late { 2 } else { 1 })
        .collect()
}

fn without_number(
    function: &FractionalTransferFunction,
    dead_time: DeadTime,
    number: FreeNumber,
    t: f64,
) -> Option<(FractionalTransferFunction, DeadTime)> {
    let mut above = function.numerator().terms().to_vec();
    let mut below = function.denominator().terms().to_vec();
    match number {
        FreeNumber::NumeratorCoefficient(n) => above.remove(n),
        FreeNumber::DenominatorCoefficient(n) => below.remove(n),
        FreeNumber::DeadTime => return Some((*function, DeadTime::NONE)),
        FreeNumber::NumeratorOrder(_) | FreeNumber::DenominatorOrder(_) => return None,
    };
    let fewer = FractionalTransferFunction::new(&above, &below).ok()?;
    let is_slower = fewer.numerator().degree() < fewer.denominator().degree();
    // A plant that answers at once does so at a sample: its dead time cannot be separated from a shorter one.
    let late = match dead_time {
        DeadTime::From(late) if !is_slower => {
            DeadTime::JustAfter(Seconds(libm::floor(late.0 / t) * t))
        }
        DeadTime::From(_) | DeadTime::Known(_) | DeadTime::JustAfter(_) => dead_time,
    };
    Some((fewer, late))
}

/// Functions of whole orders run exactly, so differences above rounding distinguish them: where a record grows, a misfit may be far below what
/// a rule resolves at its end. Not so if a function of other orders, which that rule runs, is the best.
fn resolve_finer(found: &mut [Found], search: &Search<'_>) {
    let fine = |found: &Found| search.bic(found, rounding(search.record));
    let whole = found.iter().filter(|found| found.is_whole());
    let best = whole.min_by(|a, b| fine(a).total_cmp(&fine(b)));
    let others = found.iter().filter(|found| !found.is_whole());
    let other = others.map(|found| found.bic).min_by(f64::total_cmp);
    let fair = best.is_some_and(|best| other.is_none_or(|other| best.bic <= other + AS_GOOD));
    if fair {
        let whole = found.iter_mut().filter(|found| found.is_whole());
        whole.for_each(|found| found.bic = fine(found));
    }
}
