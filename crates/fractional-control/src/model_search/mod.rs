//! A transfer function from a record: first guesses, fits, and which of them the record asks for.

pub use self::dead_time::{DeadTimeEvidence, dead_time_evidence};
use self::dead_time::{dead_times, gain};
use self::found::{AS_GOOD, LOOSE, less_sure};
pub use self::found::{Found, Unexplained};
pub use self::record::{Guess, InputOutput};
use self::record::{bic, left, neighbours, resolved, rounding};
use self::start::{Begin, OfShape, at_once, part, powers, starts, whole_orders};
use crate::identify::{answers_at_once, identify_above};
use crate::{
    ControlError, DeadTime, FractionalTransferFunction, FreeNumber, Identified, Start, Term,
    WholeShape, identify_coefficients,
};
use fracdiff::{Seconds, roots};
use num_complex::Complex;
use rayon::prelude::*;
use std::collections::VecDeque;
use std::vec;
use std::vec::Vec;

mod dead_time;
mod found;
mod record;
mod start;

/// For a first function that does not settle on its own: another that does, within the record, and
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

/// Guesses of whole orders that are fitted: the most promising.
const FITTED: usize = 8;
const SWING: WholeShape = WholeShape {
    poles: 2,
    zeros: 0,
    integrators: 0,
};

/// First guesses: of whole orders up to four poles, two of them integrators, those that leave least; of one and of two powers of s with free
/// orders; a gain. Behind a dead time that is known, or `None`: then behind those that the record suggests, and behind none. `held` as in
/// [`Record`](crate::Record).
#[must_use]
pub fn candidates(record: &InputOutput, held: bool, dead_time: Option<Seconds>) -> Vec<Guess> {
    let record = &record.for_guesses();
    let dead_times = dead_times(record, held, dead_time);
    // Without a change of the input what passes at once is an offset.
    let mut whole = whole_orders(record, held, &dead_times, moves(record));
    whole.sort_by(|a, b| a.bic.total_cmp(&b.bic));
    // Where those of free orders begin.
    let slower = |guess: &&OfShape| !answers_at_once(&guess.guess.function);
    let first = whole.iter().find(slower).map(|best| best.guess.dead_time);
    let first = first.or(dead_times.first().copied());
    let first = first.unwrap_or(DeadTime::NONE);
    // A swing whose orders may be others too.
    let swing = whole.iter().find(|guess| guess.shape == SWING);
    let swing = swing.map(|swing| swing.guess.function);
    whole.truncate(FITTED);
    let mut guesses: Vec<Guess> = whole.into_iter().map(|whole| whole.guess).collect();
    guesses.extend(gain(record, held, dead_time));
    let powers = powers(record, first.seconds());
    guesses.extend(swing.into_iter().chain(powers).map(|function| Guess {
        function,
        has_free_orders: true,
        dead_time: first,
    }));
    guesses
}

/// Guesses of one function with free orders, behind each dead time as in [`candidates`]; one that answers at once behind whole samples, read with
/// the new input of a row and just before it, its own orders too if they are whole.
#[must_use]
pub fn candidates_of(
    function: FractionalTransferFunction,
    record: &InputOutput,
    held: bool,
    dead_time: Option<Seconds>,
) -> Vec<Guess> {
    let dead_times = dead_times(&record.for_guesses(), held, dead_time);
    let guesses = |dead_times: Vec<DeadTime>, has_free_orders| {
        let dead_times = dead_times.into_iter();
        dead_times.map(move |dead_time| Guess {
            function,
            has_free_orders,
            dead_time,
        })
    };
    if !answers_at_once(&function) {
        return guesses(dead_times, true).collect();
    }
    let dead_times = at_once(record.sample_time_s(), &dead_times);
    let own = guesses(dead_times.clone(), false).filter(|_| function.is_whole());
    own.chain(guesses(dead_times, true)).collect()
}

/// Samples of a record at most that tell where its plant began, and functions that are fitted for it.
const OF_START: usize = 250;
const FITTED_FOR_START: usize = 3;
/// An output that begins further from 0 than so many times what is left does not begin at rest there.
const BEGINS_ELSEWHERE: f64 = 4.0;

/// Time constants over the length of the record that a lag is tried with.
const LAGS: [f64; 3] = [0.3, 0.1, 0.03];

/// Finds where the plant was when the record begins, by functions of whole orders: at rest unless
/// another [`Start`] has a criterion that is better by 10, and the output begins elsewhere than at
/// 0. An input that never moves does not reveal its value before the record, nor what moves beside it.
pub fn find_start(record: &mut InputOutput, held: bool, dead_time: Option<Seconds>) {
    let part = part(record, held, OF_START).unwrap_or_else(|| record.clone());
    let first = |signal: &[f64]| signal.first().copied().unwrap_or(0.0);
    let [input, output] = [&part.input, &part.output].map(|signal| first(signal));
    let starts: &[Start] = match (output != 0.0, moves(&part)) {
        (false, _) => &[Start::Rest],
        (true, false) => &[Start::Rest, Start::Offset],
        (true, true) => &[Start::Rest, Start::Offset, Start::Settled, Start::Moving],
    };
    let beginning = |start: Start| {
        let from = |own: f64, is_open: bool| if is_open { own } else { 0.0 };
        InputOutput {
            start,
            offset: from(output, start != Start::Rest),
            input_before: from(input, matches!(start, Start::Settled | Start::Moving)),
            ..part.clone()
        }
    };
    // The last knows of all the others, so its guesses do for them; lags find their way by themselves.
    let open = starts.last().map_or(Start::Rest, |last| *last);
    let own = beginning(open).for_guesses();
    let dead_times = dead_times(&own, held, dead_time);
    let mut guesses = whole_orders(&own, held, &dead_times, moves(&part));
    guesses.sort_by(|a, b| a.bic.total_cmp(&b.bic));
    let guesses = guesses.iter().take(FITTED_FOR_START).map(|own| own.guess);
    let guesses = guesses.map(|guess| (guess.function, guess.dead_time));
    let late = dead_times.first().copied().unwrap_or(DeadTime::NONE);
    let guesses: Vec<_> = guesses
        .chain(lags(length_s(&part)).map(|lag| (lag, late)))
        .collect();
    let fitted = |start: &Start| -> Option<(f64, Identified)> {
        let own = beginning(*start);
        let fits = guesses.iter().filter_map(|(function, dead_time)| {
            identify_coefficients(function, &own.as_record(held, *dead_time)).ok()
        });
        let begins_there = |fit: &Identified| {
            matches!(start, Start::Rest | Start::Moving)
                || output.abs() > BEGINS_ELSEWHERE * fit.rms_residual
        };
        let found = fits.filter(begins_there);
        let found = found.map(|fit| (judged(fit.clone(), &own).bic, fit));
        found.min_by(|a, b| a.0.total_cmp(&b.0))
    };
    let fits: Vec<_> = starts.par_iter().map(fitted).collect();
    let mut best = f64::INFINITY;
    for (start, fit) in starts.iter().zip(fits) {
        if let Some((bic, fit)) = fit.filter(|(bic, _)| *bic < best - DECISIVE) {
            best = bic;
            (record.start, record.offset, record.input_before) = match start {
                Start::Moving => (*start, output, input),
                Start::Rest | Start::Offset | Start::Settled => {
                    (*start, fit.offset, fit.input_before)
                }
            };
        }
    }
}

/// True if the input changes: only then does it reveal what it was before.
fn moves(record: &InputOutput) -> bool {
    record
        .input
        .windows(2)
        .any(|pair| (pair[1] - pair[0]).abs() > 0.0)
}

/// Lags of either sign, of some time constants, for a record of this length.
fn lags(length_s: f64) -> impl Iterator<Item = FractionalTransferFunction> {
    let lags = LAGS.into_iter().flat_map(move |share| {
        let below = [Term::new(share * length_s, 1.0), Term::new(1.0, 0.0)];
        let both = [1.0, -1.0].map(|gain| [Term::new(gain, 0.0)]);
        both.map(|gain| FractionalTransferFunction::new(&gain, &below).ok())
    });
    lags.flatten()
}

/// Functions that are kept at most: the best.
const KEPT: usize = 6;
/// A difference of the criterion that speaks very strongly, by the same table.
const DECISIVE: f64 = 10.0;

/// Fits each guess, on all cores; the best first, of those that fit at all, six at most. `held` as in [`Record`](crate::Record).
///
/// `done` is told of guesses that are done, as many as there are, and of fits that begin from them again.
///
/// # Errors
/// The first guess's error, if none fits.
pub fn identify(
    record: &InputOutput,
    guesses: &[Guess],
    held: bool,
    done: &(dyn Fn(usize) + Sync),
) -> Result<Vec<Found>, ControlError> {
    let (whole, _) = guesses
        .iter()
        .copied()
        .partition::<Vec<Guess>, _>(|own| !own.has_free_orders);
    let (mut found, mut refused) = fitted_of_whole_orders(record, &whole, held);
    done(whole.len());
    // What leaves nothing is not bettered by as many numbers.
    let enough = |found: &[Found]| {
        // As good as exact, or with nothing left but noise.
        let white = 2.0 / libm::sqrt(record.output.len() as f64);
        let exact = |found: &&Found| {
            let is_white = found.is_whole() && found.neighbours.abs() <= white;
            is_white || found.identified.rms_residual <= resolved(record)
        };
        let numbers = |found: &Found| found.numbers();
        found.iter().filter(exact).map(numbers).min()
    };
    let most = enough(&found).unwrap_or(usize::MAX);
    let mut starts: VecDeque<Begin> = starts(record, guesses, held, most).into();
    let free = guesses.iter().filter(|guess| guess.has_free_orders);
    done(free.count() - starts.len());
    while let Some(numbers) = starts.front().map(|start| start.numbers) {
        let is_enough = |found: &[Found]| enough(found).is_some_and(|most| numbers >= most);
        // Those of as many numbers together, of which one may make the rest superfluous.
        let alike = starts.iter().take_while(|start| start.numbers == numbers);
        let alike: Vec<Begin> = starts.drain(..alike.count()).collect();
        if is_enough(&found) {
            done(alike.len());
            continue;
        }
        // A long record is not run through by what leaves more of its part than others leave of all of it.
        let least = found.iter().map(|own| own.identified.rms_residual);
        let least = least.fold(f64::INFINITY, f64::min);
        let promising = |start: &&Begin| start.rms_residual().is_none_or(|left| left < least);
        let promising = alike.iter().filter(promising).cloned();
        let (before, alike) = (alike.len(), promising.collect::<Vec<Begin>>());
        done(before - alike.len());
        let fitted = alike.par_iter().map(|start| {
            let fitted = fitted_from(start, record, held);
            done(1);
            fitted
        });
        let fitted: Vec<_> = fitted.collect();
        for (start, fitted) in alike.iter().zip(fitted) {
            if is_enough(&found) {
                break;
            }
            match fitted {
                Ok((own, prompt)) => {
                    starts.extend(start.doubted(&own.identified, resolved(record)));
                    found.extend(prompt.into_iter().chain([own]));
                }
                Err(error) => {
                    starts.extend(start.first());
                    refused = refused.or(Some(error));
                }
            }
        }
    }
    cancel(&mut found, record, held);
    put_to_rest(&mut found, record, held);
    to_their_limits(&mut found, record, held);
    let told = !guesses.iter().any(|guess| guess.dead_time.is_free());
    calm_down(&mut found, record, held, told);
    resolve_finer(&mut found, record);
    found.sort_by(|a, b| a.bic.total_cmp(&b.bic));
    // Two guesses that end in one function.
    found.dedup_by(|a, b| {
        let numbers = |found: &Found| found.numbers();
        numbers(a) == numbers(b) && (a.bic - b.bic).abs() < 1e-6 * b.bic.abs()
    });
    if let Some(place) = simplest_as_good(&found) {
        found[..=place].rotate_right(1);
    }
    if let Some(place) = simplest_at_rest(&found) {
        found[..=place].rotate_right(1);
    }
    if let Some(place) = calm_instead(&found, record) {
        found[..=place].rotate_right(1);
    }
    slow_down(&mut found, record, held, told);
    if let Some(place) = lag_instead(&found, record) {
        found[..=place].rotate_right(1);
    }
    found.truncate(KEPT);
    match refused {
        Some(error) if found.is_empty() => Err(error),
        _ => Ok(found),
    }
}

/// Samples from which on a record is long, and functions of its part that are fitted to all of it.
const LONG: usize = 2000;
const POLISHED: usize = 4;

/// The functions of whole orders, and the first error. Of a long record they are chosen by a part of it, unless that has lost what is fast.
fn fitted_of_whole_orders(
    record: &InputOutput,
    guesses: &[Guess],
    held: bool,
) -> (Vec<Found>, Option<ControlError>) {
    let fitted = |guesses: &[Guess], record: &InputOutput| {
        let fits = guesses.par_iter();
        let fits: Vec<_> = fits.map(|guess| with_fewer(guess, record, held)).collect();
        let (mut found, mut refused) = (Vec::new(), None);
        for fit in fits {
            match fit {
                Ok(fit) => found.extend(fit),
                Err(error) => refused = refused.or(Some(error)),
            }
        }
        (found, refused)
    };
    if let Some(part) = part(record, held, LONG) {
        let (mut of_part, _) = fitted(guesses, &part);
        of_part.sort_by(|a, b| a.bic.total_cmp(&b.bic));
        let best = of_part.first().map(|best| best.identified.rms_residual);
        let of_part = of_part.iter().take(POLISHED).map(|own| Guess {
            function: own.identified.function,
            has_free_orders: false,
            dead_time: own.identified.dead_time,
        });
        let whole = fitted(&of_part.collect::<Vec<_>>(), record);
        let least = whole.0.iter().map(|own| own.identified.rms_residual);
        let least = least.fold(f64::INFINITY, f64::min);
        if best.is_some_and(|best| least <= AS_MUCH * best.max(resolved(record))) {
            return whole;
        }
    }
    fitted(guesses, record)
}

/// A function that grows, or adds up twice, gives way to one that does neither, of at most so many more numbers, that leaves at most so many times as
/// much: only a record that grows itself speaks so clearly.
const MORE_NUMBERS: usize = 2;
const MORE_LEFT: f64 = 2.0;

/// The best of those that replace the first, if that grows.
fn calm_instead(found: &[Found], record: &InputOutput) -> Option<usize> {
    let first = found
        .first()
        .filter(|first| grows(&first.identified.function, record))?;
    let most = MORE_LEFT * first.identified.rms_residual.max(rounding(record));
    found.iter().position(|own| {
        own.identified.rms_residual <= most
            && own.numbers() <= first.numbers() + MORE_NUMBERS
            && !grows(&own.identified.function, record)
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
    let below = coefficients(function.denominator().terms());
    let integrators = function.denominator().lowest() as usize;
    let poles = roots(&below[integrators..]);
    let stands = |pole: &&Complex<f64>| pole.norm() * length_s(record) <= STANDS;
    let standing = poles.iter().filter(stands).count();
    integrators + standing > 1 || poles.iter().any(|pole| pole.re > 1e-9 * pole.norm())
}

/// Adds lags and integrators, if the best grows: their fits find the way by themselves.
fn calm_down(found: &mut Vec<Found>, record: &InputOutput, held: bool, told: bool) {
    let best = found.iter().min_by(|a, b| a.bic.total_cmp(&b.bic));
    let Some(best) = best.filter(|best| grows(&best.identified.function, record)) else {
        return;
    };
    let dead_times = again(best, record, told);
    let adds = "1/s".parse().ok();
    let functions: Vec<_> = lags(length_s(record)).chain(adds).collect();
    let pairs = functions
        .iter()
        .flat_map(|own| dead_times.iter().map(move |late| (own, *late)));
    let fits = pairs.filter_map(|(function, late)| {
        identify_coefficients(function, &record.as_record(held, late)).ok()
    });
    let fits: Vec<Found> = fits.map(|fit| judged(fit, record)).collect();
    found.extend(fits);
}

/// The dead times that a simpler function is tried behind: the one that was told, or none, that of the other function, and a share of the record.
fn again(other: &Found, record: &InputOutput, told: bool) -> Vec<DeadTime> {
    let late = other.identified.dead_time;
    if told {
        return vec![late];
    }
    let share = LATE * length_s(record);
    let begins = [late.seconds(), share].map(|late| DeadTime::From(Seconds(late)));
    [DeadTime::NONE].into_iter().chain(begins).collect()
}

/// Adds lags as slow as the record is long, if the first does not settle. Their pole is held: a record that cannot tell it from rest lets a fit carry
/// it past 0.
fn slow_down(found: &mut Vec<Found>, record: &InputOutput, held: bool, told: bool) {
    let Some(first) = found.first().filter(|first| !first.settles()) else {
        return;
    };
    let dead_times = again(first, record, told);
    let length_s = length_s(record);
    let below = [Term::new(length_s, 1.0), Term::new(1.0, 0.0)];
    let lag = FractionalTransferFunction::new(&[Term::new(1.0, 0.0)], &below);
    let fits = dead_times.into_iter().filter_map(|late| {
        let behind = record.as_record(held, late);
        identify_above(lag.as_ref().ok()?, &behind).ok()
    });
    let fits = fits.map(|fit| judged(fit, record));
    found.extend(fits.min_by(|a, b| a.bic.total_cmp(&b.bic)));
}

/// The lag that comes before a first function that does not settle: a record that does not speak very strongly against one that settles as fast as the
/// record is long has not shown that its plant adds up. A lag that is slower is as good as an integrator, which has a number less.
fn lag_instead(found: &[Found], record: &InputOutput) -> Option<usize> {
    let first = found.first().filter(|first| !first.settles())?;
    let lags = found.iter().enumerate().filter(|(_, own)| {
        let below = own.identified.function.denominator();
        own.is_whole() && own.settles() && below.degree() <= 1.0 && own.bic <= first.bic + DECISIVE
    });
    let slowest = length_s(record) * (1.0 + 1e-9);
    let lags = lags.filter(|(_, own)| {
        let below = own.identified.function.denominator().terms();
        below
            .first()
            .is_some_and(|term| term.order > 0.0 && term.coefficient <= slowest)
    });
    let best = lags.min_by(|(_, a), (_, b)| a.bic.total_cmp(&b.bic));
    best.map(|(place, _)| place)
}

/// A dead time over the length of the record, to begin from.
const LATE: f64 = 0.1;

/// A number whose standard error is so many times its size has gone to its limit.
const FAR: f64 = 10.0;

/// Adds the best function of free orders without its last or first term below, where that leaves as little: of 7.5e13/(1.5e13s^1.19 + 1) that is
/// 5/s^1.19, which says the same.
fn to_their_limits(found: &mut Vec<Found>, record: &InputOutput, held: bool) {
    let others = found.iter().filter(|own| !own.is_whole());
    let Some(best) = others.min_by(|a, b| a.bic.total_cmp(&b.bic)) else {
        return;
    };
    let own = &best.identified;
    let far = own.standard_errors.iter().any(|(_, error)| *error > FAR);
    let (above, below) = (
        own.function.numerator().terms(),
        own.function.denominator().terms(),
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
        let fit = crate::identify(&fewer, &record.as_record(held, own.dead_time)).ok()?;
        Some(judged(fit, record)).filter(|fewer| fewer.bic <= best.bic)
    });
    let fewer: Vec<Found> = fewer.collect();
    found.extend(fewer);
}

/// The function from this start, and the same without a dead time that the record does not determine.
fn fitted_from(
    start: &Begin,
    record: &InputOutput,
    held: bool,
) -> Result<(Found, Option<Found>), ControlError> {
    let own = crate::identify(&start.function, &record.as_record(held, start.dead_time))?;
    let own = judged(own, record);
    let prompt = own.dead_time_is_loose().then(|| {
        let prompt = record.as_record(held, DeadTime::NONE);
        crate::identify(&own.identified.function, &prompt).ok()
    });
    let prompt = prompt.flatten().map(|prompt| judged(prompt, record));
    Ok((own, prompt))
}

/// Of the functions that are as good as the best the simplest: of whole orders, which run exactly, then of the fewest numbers, then of the fewest poles
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

/// Of the functions of no more poles against which the record does not speak very strongly the simplest, by its numbers or by whole orders, comes before the first, the
/// best, if it has another pole at rest.
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

/// Puts functions in which a zero cancels a pole in place of those that leave as little without both: where both are at rest, or are one
/// within their errors and the record does not speak very strongly for them.
fn cancel(found: &mut [Found], record: &InputOutput, held: bool) {
    let floor = rounding(record);
    let mut place = 0;
    while let Some(own) = found.get(place) {
        let behind = record.as_record(held, own.identified.dead_time);
        let fitted = |fewer: FractionalTransferFunction| {
            let fewer = identify_coefficients(&fewer, &behind).ok()?;
            Some(judged(fewer, record))
        };
        let left = AS_MUCH * own.identified.rms_residual.max(floor);
        let at_rest = || {
            let fewer = fitted(cancelled(&own.identified.function, record)?)?;
            Some(fewer).filter(|fewer| fewer.identified.rms_residual <= left)
        };
        let as_one = || {
            let fewer = fitted(without_pair(own)?)?;
            Some(fewer).filter(|fewer| fewer.bic <= own.bic + DECISIVE)
        };
        let whole = own.is_whole().then(|| at_rest().or_else(as_one));
        match whole.flatten() {
            // Looked at again: there may be two of them.
            Some(fewer) => found[place] = fewer,
            None => place += 1,
        }
    }
}

/// Adds the functions with an integrator in place of a pole that is at rest.
fn put_to_rest(found: &mut Vec<Found>, record: &InputOutput, held: bool) {
    let whole = found.iter().filter(|found| found.is_whole());
    let integrating = whole.filter_map(|found| {
        let own = &found.identified;
        Some((integrating(&own.function, record)?, own.dead_time))
    });
    let fitted: Vec<Found> = integrating
        .filter_map(|(function, dead_time)| {
            identify_coefficients(&function, &record.as_record(held, dead_time)).ok()
        })
        .map(|identified| judged(identified, record))
        .collect();
    found.extend(fitted);
}

/// The coefficients of a function, and those of the functions that are left without what the record does not determine, one by one.
fn with_fewer(guess: &Guess, record: &InputOutput, held: bool) -> Result<Vec<Found>, ControlError> {
    let mut found: Vec<Found> = Vec::new();
    let mut left = vec![(guess.function, guess.dead_time)];
    while let Some((function, dead_time)) = left.pop() {
        match identify_coefficients(&function, &record.as_record(held, dead_time)) {
            Ok(identified) => {
                let coarser = (resolved(record) / identified.rms_residual).max(1.0);
                let judged = judged(identified, record);
                left.extend(without_the_loosest(
                    &judged,
                    coarser,
                    record.sample_time_s(),
                ));
                found.push(judged);
            }
            Err(error) if found.is_empty() => return Err(error),
            Err(_) => {}
        }
    }
    Ok(found)
}

/// The functions without the number that the record determines least, if it does not determine it; standard errors count so many times. A dead time may
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
    let share = |(number, error): &(FreeNumber, f64)| match *number == FreeNumber::DeadTime {
        true => error / dead_time.seconds(),
        false => *error,
    };
    let loose = standard_errors
        .iter()
        .filter(|own| share(own) * times > LOOSE);
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
    // A plant that answers at once does so at a sample: its dead time is not told apart from less of it.
    let late = match dead_time {
        DeadTime::From(late) if !is_slower => {
            DeadTime::JustAfter(Seconds(libm::floor(late.0 / t) * t))
        }
        DeadTime::From(_) | DeadTime::Known(_) | DeadTime::JustAfter(_) => dead_time,
    };
    Some((fewer, late))
}

/// Functions of whole orders run exactly, so among themselves they are told apart by all that is above rounding: where a record grows, all that a
/// function lacks may be far below what a rule resolves of its end. Not so where a function of other orders, which that rule runs, is the best.
fn resolve_finer(found: &mut [Found], record: &InputOutput) {
    let floor = rounding(record);
    let fine = |found: &Found| {
        let numbers = (found.numbers() + found.identified.start_numbers) as f64;
        bic(record, found.identified.rms_residual, numbers, floor)
    };
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

fn judged(mut identified: Identified, record: &InputOutput) -> Found {
    let left = left(record, &identified.model);
    let neighbours = neighbours(&left);
    let less_sure = less_sure(neighbours, left.len());
    let errors = identified.standard_errors.iter_mut();
    errors.for_each(|(_, error)| *error *= less_sure);
    let mut found = Found {
        bic: 0.0,
        neighbours,
        unexplained: unexplained(record, &left),
        identified,
    };
    let own = &found.identified;
    let numbers = (found.numbers() + own.start_numbers) as f64;
    found.bic = bic(record, own.rms_residual, numbers, resolved(record));
    found
}

/// Blocks of a record, and their samples at least.
const BLOCKS: usize = 50;
const SAMPLES: usize = 20;
/// Neighbouring samples of a block that are so much alike are no white noise.
const ALIKE: f64 = 0.8;
/// The same of a whole record, where chance is less.
const ALIKE_ALL: f64 = 0.3;
/// A share of the output of a block that is much.
const MUCH: f64 = 0.05;

/// The block of which most is left, if that is much and no noise. A record that grows is small where it begins, so that what a function
/// lacks there is nothing beside its end.
pub(super) fn unexplained(record: &InputOutput, left: &[f64]) -> Option<Unexplained> {
    if neighbours(left) < ALIKE_ALL {
        return None;
    }
    let samples = (left.len() / BLOCKS).max(SAMPLES);
    let blocks = left
        .chunks_exact(samples)
        .zip(record.output.chunks_exact(samples))
        .zip(record.time_s.chunks_exact(samples));
    let judged = blocks.map(|((left, output), time)| {
        let power = |signal: &[f64]| signal.iter().map(|x| x * x).sum::<f64>();
        let found = Unexplained {
            from_s: time[0],
            to_s: time[samples - 1],
            share: libm::sqrt(power(left) / power(output)),
        };
        (found, neighbours(left))
    });
    judged
        .filter(|(found, alike)| found.share > MUCH && found.share.is_finite() && *alike > ALIKE)
        .map(|(found, _)| found)
        .max_by(|a, b| a.share.total_cmp(&b.share))
}

/// A pole or zero that moves by less than this over the whole record is at rest.
const AT_REST: f64 = 0.3;
/// A pole that moves by less than this is as good as an integrator, whatever follows the record.
const STANDS: f64 = 0.03;
/// What is left may grow by this factor where a pole at rest is cancelled.
pub(super) const AS_MUCH: f64 = 2.0;

/// Order of the pole at s = 0: 1 of an integrator.
pub(super) fn order_at_rest(function: &FractionalTransferFunction) -> f64 {
    function.denominator().lowest() - function.numerator().lowest()
}

/// A function of whole orders without a pole and a zero, or a pair of each, that are at rest: within the record the one cancels the other.
pub(super) fn cancelled(
    function: &FractionalTransferFunction,
    record: &InputOutput,
) -> Option<FractionalTransferFunction> {
    let above = coefficients(function.numerator().terms());
    let mut below = coefficients(function.denominator().terms());
    let zero = at_rest(&above, record)?;
    let poles = if zero.im == 0.0 { 1 } else { 2 };
    for _ in 0..poles {
        let pole = at_rest(&below, record).filter(|pole| pole.im == 0.0)?;
        below = without(&below, pole);
    }
    of_coefficients(&without(&above, zero), &below)
}

/// A relative error of a coefficient above which it says nothing of a root.
const CLOSE: f64 = 0.02;

/// The function without the pole and the zero that are nearest to each other, if they are one within twice their errors.
fn without_pair(found: &Found) -> Option<FractionalTransferFunction> {
    let own = &found.identified;
    let (above, below) = (own.function.numerator(), own.function.denominator());
    let [above, below] = [above, below].map(|side| coefficients(side.terms()));
    let errors = own.standard_errors.iter();
    let errors = errors.filter(|(number, _)| *number != FreeNumber::DeadTime);
    let error = errors.fold(0.0, |most: f64, (_, error)| most.max(*error));
    let poles: Vec<_> = roots(&below)
        .into_iter()
        .filter(|p| p.norm() > 0.0)
        .collect();
    let zeros = roots(&above);
    let pairs = zeros
        .iter()
        .flat_map(|zero| poles.iter().map(move |pole| (*zero, *pole)));
    let apart = |(zero, pole): &(Complex<f64>, Complex<f64>)| (zero / pole - 1.0).norm();
    let (zero, pole) = pairs.min_by(|a, b| apart(a).total_cmp(&apart(b)))?;
    let alike = apart(&(zero, pole)) <= 2.0 * error.min(CLOSE);
    let alike = alike && (zero.im == 0.0) == (pole.im == 0.0);
    alike.then(|| of_coefficients(&without(&above, zero), &without(&below, pole)))?
}

/// True if a function that settles shows some of that within the record: the last coefficient below acts beside the one before.
pub(super) fn comes_to_rest(function: &FractionalTransferFunction, record: &InputOutput) -> bool {
    let below = function.denominator().terms();
    let Some([next, last]) = below.last_chunk::<2>() else {
        return true;
    };
    let moved = libm::pow(length_s(record), next.order - last.order);
    (last.coefficient / next.coefficient * moved).abs() > STANDS
}

/// A function of whole orders whose slowest pole that moves is at rest within the record, with that pole at s = 0.
pub(super) fn integrating(
    function: &FractionalTransferFunction,
    record: &InputOutput,
) -> Option<FractionalTransferFunction> {
    let below = coefficients(function.denominator().terms());
    let integrators = below.iter().position(|c| *c != 0.0)?;
    let faster = without_rest(&below[integrators..], record)?;
    let below = [vec![0.0; integrators + 1], faster].concat();
    of_coefficients(&coefficients(function.numerator().terms()), &below)
}

/// The function whose lowest coefficient below is 1 or −1: a fit leaves it so.
fn of_coefficients(above: &[f64], below: &[f64]) -> Option<FractionalTransferFunction> {
    let unit = below.iter().find(|c| **c != 0.0)?.abs();
    let terms = |all: &[f64]| terms(&all.iter().map(|c| c / unit).collect::<Vec<f64>>());
    FractionalTransferFunction::new(&terms(above), &terms(below)).ok()
}

fn length_s(record: &InputOutput) -> f64 {
    record.sample_time_s() * record.time_s.len() as f64
}

fn coefficients(terms: &[Term]) -> Vec<f64> {
    let degree = terms.first().map_or(0.0, |term| term.order);
    let mut all = vec![0.0; degree as usize + 1];
    for term in terms {
        all[term.order as usize] = term.coefficient;
    }
    all
}

fn terms(coefficients: &[f64]) -> Vec<Term> {
    let terms = coefficients.iter().enumerate().filter(|(_, c)| **c != 0.0);
    terms.map(|(k, c)| Term::new(*c, k as f64)).collect()
}

/// The polynomial without its slowest root, if that is real and at rest.
fn without_rest(coefficients: &[f64], record: &InputOutput) -> Option<Vec<f64>> {
    let root = at_rest(coefficients, record).filter(|root| root.im == 0.0)?;
    Some(without(coefficients, root))
}

/// The slowest root of a polynomial, if it is at rest.
fn at_rest(coefficients: &[f64], record: &InputOutput) -> Option<Complex<f64>> {
    let root = roots(coefficients).into_iter().next();
    root.filter(|root| root.norm() * length_s(record) <= AT_REST)
}

/// A polynomial without a root, and without the conjugate one.
fn without(coefficients: &[f64], root: Complex<f64>) -> Vec<f64> {
    let mut left: Vec<Complex<f64>> = coefficients.iter().map(|c| (*c).into()).collect();
    let times = if root.im == 0.0 { 1 } else { 2 };
    for root in [root, root.conj()].into_iter().take(times) {
        // Horner's rule from above; what is left of the lowest is the remainder.
        for k in (0..left.len().saturating_sub(1)).rev() {
            let above = left[k + 1];
            left[k] += root * above;
        }
        left.remove(0);
    }
    left.iter().map(|c| c.re).collect()
}
