//! A transfer function from a record: first guesses, fits, and which of them the record asks for.

mod powers;
mod start;

use self::powers::powers;
use self::start::{Start, starts, whole_orders};
use fracdiff::Seconds;
use fracdiff::parameter::{RangeError, not_negative};
use fractional_control::{
    ControlError, FractionalTransferFunction, FreeNumber, Identified, Record, WholeShape,
    identify_coefficients,
};
use std::collections::VecDeque;

/// A residual over the largest output below which a model is as good as exact.
const EXACT: f64 = 1e-5;
/// Steps of time may differ by this share.
const EVEN: f64 = 1e-3;

/// A record of input and output that begins at rest, in equal steps of time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InputOutput {
    /// Time, s.
    pub time_s: Vec<f64>,
    /// u.
    pub input: Vec<f64>,
    /// y.
    pub output: Vec<f64>,
    /// The input acts so much later, s: less than a sample, as [`shifted`] leaves it.
    pub late_s: f64,
}

/// A function that was fitted.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Found {
    /// The function, its output, and how sure its numbers are.
    pub identified: Identified,
    /// Bayesian information criterion: less is better.
    pub bic: f64,
    /// Correlation of neighbouring samples of what is left: near 0 of white noise, near 1 of a model that lacks something.
    pub neighbours: f64,
}

impl Found {
    fn is_whole(&self) -> bool {
        let function = &self.identified.function;
        let (above, below) = (function.numerator().terms(), function.denominator().terms());
        let mut terms = above.iter().chain(below);
        terms.all(|term| (term.order - term.order.round()).abs() == 0.0)
    }
}

/// A function to begin from.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Guess {
    /// Coefficients and orders are fitted.
    Orders(FractionalTransferFunction),
    /// The orders stay.
    Coefficients(FractionalTransferFunction),
}

impl InputOutput {
    /// T, s.
    #[must_use]
    pub fn sample_time_s(&self) -> f64 {
        let ends = self.time_s.first().zip(self.time_s.last());
        let length = ends.map_or(0.0, |(first, last)| last - first);
        length / (self.time_s.len().max(2) - 1) as f64
    }

    /// Refuses times that do not run in equal steps.
    ///
    /// # Errors
    /// With the line, the header being the first.
    pub fn check_times(&self) -> Result<(), String> {
        let mut steps: Vec<f64> = self
            .time_s
            .windows(2)
            .map(|pair| pair[1] - pair[0])
            .collect();
        steps.sort_by(f64::total_cmp);
        // The step in the middle: one that is wrong does not move it.
        let middle = steps.get(steps.len().max(1).div_ceil(2) - 1).copied();
        let t = middle.unwrap_or(0.0);
        if t <= 0.0 {
            return Err("the time does not grow: give at least two rows in order".to_owned());
        }
        let uneven = |pair: &[f64]| ((pair[1] - pair[0]) / t - 1.0).abs() > EVEN;
        match self.time_s.windows(2).position(uneven) {
            None => Ok(()),
            Some(row) => Err(format!(
                "line {}: a step of {} s among steps of {t} s: put the record on equal steps first",
                row + 3,
                self.time_s[row + 1] - self.time_s[row]
            )),
        }
    }

    fn as_record(&self, held: bool) -> Record<'_> {
        Record {
            sample_time: Seconds(self.sample_time_s()),
            input: &self.input,
            output: &self.output,
            held,
            late: Seconds(self.late_s),
        }
    }

    /// Counts input and output from their first values.
    pub fn subtract_start(&mut self) {
        for signal in [&mut self.input, &mut self.output] {
            let first = signal.first().copied().unwrap_or(0.0);
            signal.iter_mut().for_each(|value| *value -= first);
        }
    }
}

/// The record with its input so much later: what is left to fit without the dead time. Whole samples are moved; the rest is
/// [`late_s`](InputOutput::late_s), for the fit to know where in a sample a held input switches.
///
/// # Errors
/// A negative dead time, or one that is longer than the record.
pub fn shifted(record: &InputOutput, delay_s: f64) -> Result<InputOutput, ControlError> {
    let t = record.sample_time_s();
    let samples = not_negative("dead time", delay_s, "s")? / t;
    if samples >= record.input.len() as f64 {
        let error = RangeError::new("dead time", delay_s, "shorter than the record", "s");
        return Err(error.into());
    }
    let nearest = libm::round(samples);
    let is_whole = (samples - nearest).abs() < 1e-9;
    let (whole, part) = match is_whole {
        true => (nearest, 0.0),
        false => (libm::floor(samples), samples - libm::floor(samples)),
    };
    let whole = whole as usize;
    let early = record.input.iter().take(record.input.len() - whole);
    let input = core::iter::repeat_n(&0.0, whole).chain(early);
    Ok(InputOutput {
        input: input.copied().collect(),
        late_s: part * t,
        ..record.clone()
    })
}

/// Guesses of whole orders that are fitted: the most promising.
const FITTED: usize = 6;
const SWING: WholeShape = WholeShape {
    poles: 2,
    zeros: 0,
    integrators: 0,
};

/// First guesses: of whole orders up to four poles, two of them integrators, those that leave least; of one and of two powers of s with free
/// orders. `held` as in [`Record`].
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
/// A coefficient whose standard error is above this share of it is tried without.
const LOOSE: f64 = 0.5;

/// Fits each guess; the best first, of those that fit at all, six at most. `held` as in [`Record`].
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
        match fractional_control::identify(&start.function, &record.as_record(held)) {
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
    found.sort_by(|a, b| a.bic.total_cmp(&b.bic));
    // Two guesses that end in one function.
    found.dedup_by(|a, b| {
        let numbers = |found: &Found| found.identified.standard_errors.len();
        numbers(a) == numbers(b) && (a.bic - b.bic).abs() < 1e-6 * b.bic.abs()
    });
    found.truncate(KEPT);
    // Whole orders run exactly: of two that are as good they come first.
    let best = found.first().map_or(0.0, |found| found.bic);
    let whole = |found: &Found| found.is_whole() && found.bic <= best + AS_GOOD;
    if let Some(place) = found.iter().position(whole) {
        found[..=place].rotate_right(1);
    }
    match refused {
        Some(error) if found.is_empty() => Err(error),
        _ => Ok(found),
    }
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

/// The Bayesian information criterion of so many free numbers.
fn bic(record: &InputOutput, rms_residual: f64, numbers: f64) -> f64 {
    let samples = record.output.len() as f64;
    2.0 * samples * libm::log(rms_residual.max(resolved(record))) + numbers * libm::log(samples)
}

/// A model runs no better than this itself: what is less says nothing for one of them.
fn resolved(record: &InputOutput) -> f64 {
    let sizes = record.output.iter().map(|y| y.abs());
    EXACT * sizes.fold(0.0, f64::max)
}

fn judged(identified: Identified, record: &InputOutput) -> Found {
    let pairs = record.output.iter().zip(&identified.model);
    let left: Vec<f64> = pairs.map(|(y, model)| y - model).collect();
    let product = |lag: usize| -> f64 { left.iter().zip(&left[lag..]).map(|(a, b)| a * b).sum() };
    let alike = product(1) / product(0);
    let numbers = identified.standard_errors.len() as f64;
    Found {
        bic: bic(record, identified.rms_residual, numbers),
        neighbours: if alike.is_finite() { alike } else { 0.0 },
        identified,
    }
}
