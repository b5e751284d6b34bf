//! A transfer function from a record: first guesses, fits, and which of them the record asks for.

mod left;
mod powers;
mod record;
mod rest;
mod start;

pub use self::left::Unexplained;
pub use self::record::{Guess, InputOutput, shifted};

use self::powers::powers;
use self::record::{bic, resolved, rounding};
use self::start::{Start, starts, whole_orders};
use crate::{
    ControlError, FractionalTransferFunction, FreeNumber, Identified, WholeShape,
    identify_coefficients,
};
use std::collections::VecDeque;
use std::vec::Vec;

/// A function that was fitted.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Found {
    /// The function, its output, and how sure its numbers are: less so where neighbouring samples of what is left are alike.
    pub identified: Identified,
    /// Bayesian information criterion: less is better. What is less than a model can resolve counts as nothing.
    pub bic: f64,
    /// Correlation of neighbouring samples of what is left: near 0 of white noise, near 1 of a model that lacks something.
    pub neighbours: f64,
    /// Where the function leaves most, if that is much of the output there and no noise.
    pub unexplained: Option<Unexplained>,
}

impl Found {
    /// True if the function settles by itself.
    fn settles(&self) -> bool {
        self.identified.function.unstable_poles() == Some(0)
    }

    fn is_whole(&self) -> bool {
        self.identified.function.is_whole()
    }
}

/// Of a first function that does not settle by itself: another that does, within the record, and that the record does not speak very strongly
/// against: a criterion at most 10 above (A. E. Raftery, *Bayesian model selection in social research*, 1995, Table 6), or that of one number.
#[must_use]
pub fn settles_as_well<'a>(found: &'a [Found], record: &InputOutput) -> Option<&'a Found> {
    let first = found.first().filter(|first| !first.settles())?;
    let one_number = libm::log(record.output.len() as f64);
    let near = |other: &&Found| other.bic <= first.bic + one_number.max(DECISIVE);
    let mut others = found.iter().filter(|other| other.settles()).filter(near);
    others.find(|other| rest::comes_to_rest(&other.identified.function, record))
}

/// Guesses of whole orders that are fitted: the most promising.
const FITTED: usize = 6;
const SWING: WholeShape = WholeShape {
    poles: 2,
    zeros: 0,
    integrators: 0,
};

/// First guesses: of whole orders up to four poles, two of them integrators, those that leave least; of one and of two powers of s with free
/// orders. `held` as in [`Record`](crate::Record).
#[must_use]
pub fn candidates(record: &InputOutput, held: bool) -> Vec<Guess> {
    let mut whole = whole_orders(record, held);
    // A swing whose orders may be others too.
    let swing = whole.iter().find(|guess| guess.shape == SWING);
    let swing = swing.map(|guess| guess.function);
    whole.sort_by(|a, b| a.bic.total_cmp(&b.bic));
    whole.truncate(FITTED);
    let whole = whole.into_iter().map(|guess| guess.function);
    let mut guesses: Vec<Guess> = whole.map(Guess::Coefficients).collect();
    guesses.extend(swing.into_iter().chain(powers(record)).map(Guess::Orders));
    guesses
}

/// Functions that are kept at most: the best.
const KEPT: usize = 6;
/// A difference of the criterion that says nothing.
const AS_GOOD: f64 = 2.0;
/// A difference of the criterion that speaks very strongly, by the same table.
const DECISIVE: f64 = 10.0;
/// A coefficient whose standard error is above this share of it is tried without.
const LOOSE: f64 = 0.5;

/// Fits each guess; the best first, of those that fit at all, six at most. `held` as in [`Record`](crate::Record).
///
/// # Errors
/// That of the first guess, if none fits.
pub fn identify(
    record: &InputOutput,
    guesses: &[Guess],
    held: bool,
) -> Result<Vec<Found>, ControlError> {
    let (mut found, mut refused) = (Vec::new(), None);
    let coefficients = guesses.iter().filter_map(|guess| match guess {
        Guess::Coefficients(function) => Some(*function),
        Guess::Orders(_) => None,
    });
    for function in coefficients {
        match with_fewer(&function, record, held) {
            Ok(fitted) => found.extend(fitted),
            Err(error) => refused = refused.or(Some(error)),
        }
    }
    // What leaves nothing is not bettered by as many numbers.
    let enough = |found: &[Found]| {
        let exact = |found: &&Found| found.identified.rms_residual <= resolved(record);
        let numbers = |found: &Found| found.identified.standard_errors.len();
        found.iter().filter(exact).map(numbers).min()
    };
    let most = enough(&found).unwrap_or(usize::MAX);
    let mut starts: VecDeque<Start> = starts(record, guesses, (held, most)).into();
    while let Some(start) = starts.pop_front() {
        if enough(&found).is_some_and(|most| start.numbers >= most) {
            continue;
        }
        match crate::identify(&start.function, &record.as_record(held)) {
            Ok(identified) => {
                starts.extend(start.doubted(&identified, resolved(record)));
                found.push(judged(identified, record));
            }
            Err(error) => {
                starts.extend(start.first());
                refused = refused.or(Some(error));
            }
        }
    }
    cancel(&mut found, record, held);
    put_to_rest(&mut found, record, held);
    resolve_finer(&mut found, record);
    found.sort_by(|a, b| a.bic.total_cmp(&b.bic));
    // Two guesses that end in one function.
    found.dedup_by(|a, b| {
        let numbers = |found: &Found| found.identified.standard_errors.len();
        numbers(a) == numbers(b) && (a.bic - b.bic).abs() < 1e-6 * b.bic.abs()
    });
    // Whole orders run exactly: of two that are as good they come first.
    let best = found.first().map_or(0.0, |found| found.bic);
    let whole = |found: &Found| found.is_whole() && found.bic <= best + AS_GOOD;
    if let Some(place) = found.iter().position(whole) {
        found[..=place].rotate_right(1);
    }
    if let Some(place) = simplest_at_rest(&found) {
        found[..=place].rotate_right(1);
    }
    found.truncate(KEPT);
    match refused {
        Some(error) if found.is_empty() => Err(error),
        _ => Ok(found),
    }
}

/// Of the functions against which the record does not speak very strongly the simplest, by its numbers or by whole orders, comes before the first, the
/// best, if it has another pole at rest.
fn simplest_at_rest(found: &[Found]) -> Option<usize> {
    let numbers = |found: &Found| (found.identified.standard_errors.len(), !found.is_whole());
    let order = |found: &Found| rest::order_at_rest(&found.identified.function);
    let best = found.first()?;
    let all = found.iter().enumerate();
    let near = all.filter(|(_, other)| other.bic <= best.bic + DECISIVE);
    let simplest = near.min_by_key(|(_, other)| numbers(other));
    let simplest = simplest.filter(|(_, other)| (order(other) - order(best)).abs() > 0.0);
    simplest.map(|(place, _)| place)
}

/// Puts functions in which a zero cancels a pole at rest in place of those that leave as little without both.
fn cancel(found: &mut [Found], record: &InputOutput, held: bool) {
    let floor = rounding(record);
    let mut place = 0;
    while let Some(own) = found.get(place) {
        let function = Some(own.identified.function).filter(|_| own.is_whole());
        let fewer = function.and_then(|own| rest::cancelled(&own, record));
        let fewer = fewer
            .and_then(|fewer| identify_coefficients(&fewer, &record.as_record(held)).ok())
            .filter(|fewer| {
                fewer.rms_residual <= rest::AS_MUCH * own.identified.rms_residual.max(floor)
            });
        match fewer {
            // Looked at again: there may be two of them.
            Some(fewer) => found[place] = judged(fewer, record),
            None => place += 1,
        }
    }
}

/// Adds the functions with an integrator in place of a pole that is at rest.
fn put_to_rest(found: &mut Vec<Found>, record: &InputOutput, held: bool) {
    let whole = found.iter().filter(|found| found.is_whole());
    let integrating =
        whole.filter_map(|found| rest::integrating(&found.identified.function, record));
    let fitted: Vec<Found> = integrating
        .filter_map(|function| identify_coefficients(&function, &record.as_record(held)).ok())
        .map(|identified| judged(identified, record))
        .collect();
    found.extend(fitted);
}

/// The coefficients of a function, and those of the functions that are left without what the record does not determine, one by one.
fn with_fewer(
    function: &FractionalTransferFunction,
    record: &InputOutput,
    held: bool,
) -> Result<Vec<Found>, ControlError> {
    let mut found = Vec::new();
    let mut next = Some(*function);
    while let Some(function) = next.take() {
        match identify_coefficients(&function, &record.as_record(held)) {
            Ok(identified) => {
                let coarser = (resolved(record) / identified.rms_residual).max(1.0);
                next = without_the_loosest(&identified, coarser);
                found.push(judged(identified, record));
            }
            Err(error) if found.is_empty() => return Err(error),
            Err(_) => {}
        }
    }
    Ok(found)
}

/// The function without the coefficient that the record determines least, if it does not determine it; standard errors count so many
/// times.
fn without_the_loosest(identified: &Identified, times: f64) -> Option<FractionalTransferFunction> {
    let function = &identified.function;
    let errors = identified.standard_errors.iter();
    let (number, error) = errors.max_by(|a, b| a.1.total_cmp(&b.1))?;
    if error * times <= LOOSE {
        return None;
    }
    let mut above = function.numerator().terms().to_vec();
    let mut below = function.denominator().terms().to_vec();
    match *number {
        FreeNumber::NumeratorCoefficient(n) => above.remove(n),
        FreeNumber::DenominatorCoefficient(n) => below.remove(n),
        _ => return None,
    };
    let fewer = FractionalTransferFunction::new(&above, &below).ok()?;
    // As many zeros as poles would answer at once.
    (fewer.numerator().degree() < fewer.denominator().degree()).then_some(fewer)
}

/// Functions of whole orders run exactly, so among themselves they are told apart by all that is above rounding: where a record grows, all that a
/// function lacks may be far below what a rule resolves of its end. Not so where a function of other orders, which that rule runs, is the best.
fn resolve_finer(found: &mut [Found], record: &InputOutput) {
    let floor = rounding(record);
    let fine = |found: &Found| {
        let numbers = found.identified.standard_errors.len() as f64;
        bic(record, found.identified.rms_residual, (numbers, floor))
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
    let left = left::left(record, &identified.model);
    let neighbours = left::neighbours(&left);
    let less_sure = left::less_sure(neighbours, left.len());
    let errors = identified.standard_errors.iter_mut();
    errors.for_each(|(_, error)| *error *= less_sure);
    let numbers = identified.standard_errors.len() as f64;
    Found {
        bic: bic(record, identified.rms_residual, (numbers, resolved(record))),
        neighbours,
        unexplained: left::unexplained(record, &left),
        identified,
    }
}
