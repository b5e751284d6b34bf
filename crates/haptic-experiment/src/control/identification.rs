//! A transfer function from a record: first guesses, fits, and which of them the record asks for.

use fracdiff::Seconds;
use fracdiff::parameter::{RangeError, not_negative};
use fractional_control::{
    ControlError, FractionalTransferFunction, Identified, Memory, Record, Rule, Term, respond,
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
    /// The function and how sure its numbers are.
    pub identified: Identified,
    /// Bayesian information criterion: less is better.
    pub bic: f64,
    /// Its output for the input of the record.
    pub model: Vec<f64>,
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

/// First guesses of one and of two powers of s, with the gain and the time constant of the record.
#[must_use]
pub fn candidates(record: &InputOutput) -> Vec<FractionalTransferFunction> {
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

/// Fits each guess; the best first, of those that fit at all. `held` as in [`Record`].
///
/// # Errors
/// That of the first guess, if none fits.
pub fn identify(
    record: &InputOutput,
    guesses: &[FractionalTransferFunction],
    held: bool,
) -> Result<Vec<Found>, ControlError> {
    let sample_time = Seconds(record.sample_time_s());
    let data = Record {
        sample_time,
        input: &record.input,
        output: &record.output,
        held,
    };
    let (mut found, mut refused) = (Vec::new(), None);
    for guess in guesses {
        match fractional_control::identify(guess, &data) {
            Ok(identified) => found.push(judged(identified, record, held)?),
            Err(error) => refused = refused.or(Some(error)),
        }
    }
    found.sort_by(|a, b| a.bic.total_cmp(&b.bic));
    // Two guesses that end in one function.
    found.dedup_by(|a, b| {
        let numbers = |found: &Found| found.identified.standard_errors.len();
        numbers(a) == numbers(b) && (a.bic - b.bic).abs() < 1e-6 * b.bic.abs()
    });
    match refused {
        Some(error) if found.is_empty() => Err(error),
        _ => Ok(found),
    }
}

fn judged(identified: Identified, record: &InputOutput, held: bool) -> Result<Found, ControlError> {
    let samples = record.output.len() as f64;
    let largest = record
        .output
        .iter()
        .fold(0.0, |most: f64, y| most.max(y.abs()));
    // A model runs no better than this itself: what is less says nothing for one of them.
    let rms = identified.rms_residual.max(EXACT * largest);
    let numbers = identified.standard_errors.len() as f64;
    let t = record.sample_time_s();
    let mut input = record.input.clone();
    if held {
        // A hold is seen as the mean of its ends.
        for n in (0..input.len()).rev() {
            let last = if n > 0 { record.input[n - 1] } else { 0.0 };
            input[n] = 0.5 * (record.input[n] + last);
        }
    }
    let memory = Memory::new(Rule::Bdf2, 1e-7, samples * t)?;
    let model = respond(&identified.function, memory, Seconds(t), &input)?;
    Ok(Found {
        bic: 2.0 * samples * libm::log(rms) + numbers * libm::log(samples),
        identified,
        model,
    })
}
