//! A transfer function from a record: first guesses, fits, and which of them the record asks for.

use fracdiff::Seconds;
use fracdiff::parameter::{RangeError, not_negative};
use fractional_control::{
    ControlError, FractionalTransferFunction, FreeNumber, Identified, Record, Term, WholeShape,
    identify_coefficients, whole_guess,
};

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

/// The record with its input so much later, straight lines between samples: what is left to fit without the dead time.
///
/// # Errors
/// A negative dead time, or one that is longer than the record.
pub fn shifted(record: &InputOutput, delay_s: f64) -> Result<InputOutput, ControlError> {
    let samples = not_negative("dead time", delay_s, "s")? / record.sample_time_s();
    if samples >= record.input.len() as f64 {
        let error = RangeError::new("dead time", delay_s, "shorter than the record", "s");
        return Err(error.into());
    }
    let whole = libm::floor(samples + 1e-9);
    let share = (samples - whole).max(0.0);
    let at = |n: usize| {
        let lag = |more: usize| {
            let place = n.checked_sub(whole as usize + more);
            place
                .and_then(|n| record.input.get(n))
                .copied()
                .unwrap_or(0.0)
        };
        (1.0 - share) * lag(0) + share * lag(1)
    };
    Ok(InputOutput {
        input: (0..record.input.len()).map(at).collect(),
        ..record.clone()
    })
}

/// Guesses of whole orders that are fitted: the most promising.
const FITTED: usize = 6;

/// First guesses: of whole orders up to four poles, two of them integrators, those that leave least; of one and of two powers of s with free
/// orders. `held` as in [`Record`].
#[must_use]
pub fn candidates(record: &InputOutput, held: bool) -> Vec<Guess> {
    let mut whole: Vec<(f64, FractionalTransferFunction)> = Vec::new();
    // A swing whose orders may be others too.
    let mut swing = None;
    for (poles, zeros) in (1..=4).flat_map(|poles| (0..poles).map(move |zeros| (poles, zeros))) {
        for integrators in 0..=poles.min(2) {
            let shape = WholeShape {
                poles,
                zeros,
                integrators,
            };
            if let Some(guess) = whole_guess(&record.as_record(held), shape) {
                if (poles, zeros, integrators) == (2, 0, 0) {
                    swing = Some(guess.function);
                }
                let numbers = (poles + zeros + 1 - integrators) as f64;
                whole.push((bic(record, guess.rms_residual, numbers), guess.function));
            }
        }
    }
    whole.sort_by(|a, b| a.0.total_cmp(&b.0));
    whole.truncate(FITTED);
    let whole = whole.into_iter().map(|(_, function)| function);
    let mut guesses: Vec<Guess> = whole.map(Guess::Coefficients).collect();
    guesses.extend(swing.into_iter().chain(powers(record)).map(Guess::Orders));
    guesses
}

/// One and two powers of s, with the gain and the time constant of the record.
fn powers(record: &InputOutput) -> Vec<FractionalTransferFunction> {
    let last = |signal: &[f64]| {
        let tail = &signal[signal.len() - (signal.len() / 20).max(1)..];
        tail.iter().sum::<f64>() / tail.len() as f64
    };
    let (input, output) = (last(&record.input), last(&record.output));
    let gain = output / input;
    let t = record.sample_time_s();
    // The time that the output lacks, of one that would follow at once: ∫(1 − y/y∞) for a step.
    let lag: f64 = record
        .input
        .iter()
        .zip(&record.output)
        .map(|(u, y)| (u - y / gain) * t)
        .sum();
    let length = t * record.time_s.len() as f64;
    let usable = gain.is_finite() && gain != 0.0;
    let gain = if usable { gain } else { 1.0 };
    let lag = (lag / input).abs();
    let lag = if lag.is_finite() {
        lag.min(0.5 * length).max(2.0 * t)
    } else {
        0.1 * length
    };
    let one = Term::new(1.0, 0.0);
    let power = |order: f64, share: f64| Term::new(libm::pow(share * lag, order), order);
    let shapes: [Vec<Term>; 3] = [
        vec![power(0.9, 1.0), one],
        vec![power(1.4, 0.7), power(0.7, 0.7), one],
        vec![power(2.0, 0.5), power(1.0, 1.0), one],
    ];
    let functions = shapes
        .iter()
        .map(|below| FractionalTransferFunction::new(&[Term::new(gain, 0.0)], below));
    let mut functions: Vec<_> = functions.filter_map(Result::ok).collect();
    if moves_on(record) {
        functions.extend(growing(record));
    }
    functions
}

/// Parts of a record that are compared with each other.
const PARTS: usize = 10;
/// An output that goes on by more than this share of its largest value in a tenth of the record is not at rest, nor is such an input.
const MOVES: f64 = 0.02;

/// True if the output is still on its way at the end, though the input rests: the plant is slow for this record, or it adds up, or grows.
fn moves_on(record: &InputOutput) -> bool {
    let moves = |signal: &[f64]| {
        let largest = signal.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let tenth = (signal.len() / PARTS).max(1);
        let end = signal.last().zip(signal.iter().rev().nth(tenth));
        end.is_some_and(|(last, before)| (last - before).abs() > MOVES * largest)
    };
    moves(&record.output) && !moves(&record.input)
}

/// First guesses of plants that do not come to rest: y ≈ k·∫u, the same behind a lag, and a pole that grows as the end of the record does.
fn growing(record: &InputOutput) -> Vec<FractionalTransferFunction> {
    let t = record.sample_time_s();
    let length = t * record.time_s.len() as f64;
    let Some((end, sum)) = record
        .output
        .last()
        .map(|end| (*end, record.input.iter().sum::<f64>() * t))
    else {
        return Vec::new();
    };
    let mut guesses = Vec::new();
    let mut guess = |gain: f64, below: &[Term]| {
        let function = FractionalTransferFunction::new(&[Term::new(gain, 0.0)], below);
        guesses.extend(function.ok());
    };
    let rate = end / sum;
    guess(rate, &[Term::new(1.0, 0.95)]);
    guess(rate, &[Term::new(0.1 * length, 1.95), Term::new(1.0, 0.95)]);
    // e^(rt) grows by e^(rh) from one piece of h to the next.
    let piece = record.output.len() / 4;
    let back = |pieces: usize| record.output.iter().rev().nth(pieces * piece);
    if let (Some(last), Some(middle), Some(first)) = (back(0), back(1), back(2)) {
        let grows = libm::log((last - middle) / (middle - first)) / (piece as f64 * t);
        if grows * length > 0.5 {
            // k·u·(e^(rt) − 1) of a step.
            let gain = grows * end / libm::expm1(grows * length) * length / sum;
            let one = Term::new(-1.0, 0.0);
            guess(gain / grows, &[Term::new(1.0 / grows, 1.0), one]);
            let second = Term::new(0.1 / (grows * grows), 2.0);
            guess(gain / grows, &[second, Term::new(0.9 / grows, 1.0), one]);
        }
    }
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
    let data = record.as_record(held);
    let (mut found, mut refused) = (Vec::new(), None);
    for guess in guesses {
        let mut next = Some(*guess);
        while let Some(guess) = next.take() {
            let fitted = match guess {
                Guess::Orders(function) => fractional_control::identify(&function, &data),
                Guess::Coefficients(function) => identify_coefficients(&function, &data),
            };
            match fitted {
                Ok(identified) => {
                    if matches!(guess, Guess::Coefficients(_)) {
                        let coarser = (resolved(record) / identified.rms_residual).max(1.0);
                        next = without_the_loosest(&identified, coarser).map(Guess::Coefficients);
                    }
                    found.push(judged(identified, record));
                }
                Err(error) => refused = refused.or(Some(error)),
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
