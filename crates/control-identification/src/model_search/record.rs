//! A record that a transfer function is to explain, and what a model of it is measured by.

use crate::autoregression::Autoregression;
use crate::identify::{Free, free_numbers};
use crate::largest;
use crate::{DeadTime, InputOutputRecord, StartState};
use fracdiff::Seconds;
use fractional_control::FractionalTransferFunction;

/// A residual over the largest output below which a model is practically exact.
const EXACT: f64 = 1e-5;
/// Steps of time may differ by this share, and be even.
const EVEN: f64 = 1e-3;
/// Least number of rows of an input that rests at first, and their share of the record, one in `LEAST_SHARE`.
const LEAST_ROWS: usize = 20;
const LEAST_SHARE: usize = 50;
/// The beginning is the first of this many parts of the rows.
const BEGINNING: usize = 20;
/// Roundings of a sample, with those of the record.
const ROUNDINGS: f64 = 16.0;

/// A record of input and output.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InputOutput {
    /// Time of each sample, s, each after the one before.
    pub time_s: Vec<f64>,
    /// u, the input of the plant at each of these times.
    pub input: Vec<f64>,
    /// y, the output of the plant at each of these times.
    pub output: Vec<f64>,
    /// State of the plant when the record begins.
    pub start: StartState,
    /// Estimate of c of that start.
    pub offset: f64,
    /// Estimate of `u_p` of that start.
    pub input_before: f64,
    /// Value that was subtracted from each input, in its unit: that of the first row, at which a plant had settled before its input
    /// changed once; else 0.
    pub input_zero: f64,
    /// The noise of the output, as far as it is known; white unless given.
    pub noise: Autoregression,
}

/// A function to begin from.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Guess {
    /// The function, which sets the terms and the signs of a fit.
    pub function: FractionalTransferFunction,
    /// Its parts, of a sum, each of which keeps its terms; nothing of any other function.
    pub parts: Vec<FractionalTransferFunction>,
    /// True if its orders are fitted with its coefficients; false if they stay.
    pub has_free_orders: bool,
    /// The dead time in front of the function.
    pub dead_time: DeadTime,
}

impl Guess {
    /// Free numbers of its parts.
    pub(super) fn numbers(&self) -> usize {
        let numbers = self
            .parts
            .iter()
            .map(|part| free_numbers(part, Free::All).len());
        numbers.sum()
    }
}

impl InputOutput {
    /// T, s: the length of the record over the number of its steps, which differ where they are not even.
    #[must_use]
    pub fn sample_time_s(&self) -> f64 {
        let ends = self.time_s.first().zip(self.time_s.last());
        let length = ends.map_or(0.0, |(first, last)| last - first);
        length / (self.time_s.len().max(2) - 1) as f64
    }

    pub(super) fn length_s(&self) -> f64 {
        self.sample_time_s() * self.time_s.len() as f64
    }

    /// True if the input changes: only then does it reveal what it was before.
    pub(super) fn moves(&self) -> bool {
        self.changes().next().is_some()
    }

    /// The rows whose input is another than that of the row before.
    pub(super) fn changes(&self) -> impl Iterator<Item = usize> {
        let pairs = self.input.windows(2).zip(1..);
        pairs.filter_map(|(pair, row)| ((pair[1] - pair[0]).abs() > 0.0).then_some(row))
    }

    /// Counts the input from this value.
    pub(super) fn counted_from(mut self, zero: f64) -> Self {
        self.input.iter_mut().for_each(|u| *u -= zero);
        self.input_zero += zero;
        self
    }

    /// Counts the input from 0 again, as it was recorded.
    #[must_use]
    pub fn as_recorded(self) -> Self {
        let zero = self.input_zero;
        self.counted_from(-zero)
    }

    /// True if the input changes again, or after the beginning: an answer to one change at the beginning is as what moved before.
    pub(super) fn tells_before(&self) -> bool {
        let rows = self.input.len();
        let mut changes = self.changes();
        let first = changes.next();
        changes.next().is_some() || first.is_some_and(|first| first * BEGINNING > rows)
    }

    /// True if the input rests at first, long enough to see that the output does too: a plant that was moving then would be seen to move.
    pub(super) fn begins_flat(&self) -> bool {
        let rows = self.changes().next().unwrap_or(self.input.len());
        if rows < LEAST_ROWS || rows * LEAST_SHARE < self.input.len() {
            return false;
        }
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
        let output = &self.output[..rows];
        let all = mean(output);
        let around: Vec<f64> = output.iter().map(|y| y - all).collect();
        let deviation = libm::sqrt(mean(&around.iter().map(|x| x * x).collect::<Vec<f64>>()));
        let [before, behind] = [&around[..rows / 2], &around[rows / 2..]].map(mean);
        let error = 2.0 / libm::sqrt(rows as f64);
        neighbours(&around) <= error && (behind - before).abs() <= 2.0 * error * deviation
    }

    /// Distance of the smallest and the largest of 0 and the inputs.
    pub(super) fn input_span(&self) -> f64 {
        let inputs = || self.input.iter().copied();
        inputs().fold(0.0, f64::max) - inputs().fold(0.0, f64::min)
    }

    /// True if no step differs from T by more than a thousandth of it.
    #[must_use]
    pub fn is_even(&self) -> bool {
        let t = self.sample_time_s();
        let pairs = self.time_s.windows(2);
        pairs
            .map(|pair| pair[1] - pair[0])
            .all(|step| (step - t).abs() <= EVEN * t)
    }

    pub(super) fn as_record(&self, held: bool, dead_time: DeadTime) -> InputOutputRecord<'_> {
        InputOutputRecord {
            sample_time: Seconds(self.sample_time_s()),
            time_s: if self.is_even() { &[] } else { &self.time_s },
            input: &self.input,
            output: &self.output,
            held,
            dead_time,
            start: self.start,
            noise: self.noise,
        }
    }

    /// Subtracts the first values from input and output.
    pub fn subtract_start(&mut self) {
        for signal in [&mut self.input, &mut self.output] {
            let first = signal.first().copied().unwrap_or(0.0);
            signal.iter_mut().for_each(|value| *value -= first);
        }
    }

    /// The record for first guesses: relative to its approximate start, in even steps, with straight lines between its outputs.
    pub(super) fn for_guesses(&self) -> Self {
        let counted = |signal: &[f64], from: f64| signal.iter().map(|value| value - from).collect();
        let input: Vec<f64> = counted(&self.input, self.input_before);
        let output: Vec<f64> = counted(&self.output, self.offset);
        let (start, noise) = (self.start, self.noise);
        let begin = self.time_s.first().filter(|_| !self.is_even());
        let Some(begin) = begin else {
            let time_s = self.time_s.clone();
            return Self {
                time_s,
                input,
                output,
                start,
                noise,
                ..Self::default()
            };
        };
        let t = self.sample_time_s();
        let time_s: Vec<f64> = (0..self.time_s.len())
            .map(|n| begin + t * n as f64)
            .collect();
        let at = |t: &f64, signal: &[f64], is_line: bool| {
            let next = self.time_s.partition_point(|stamp| stamp <= t);
            let last = next.saturating_sub(1);
            match signal.get(next).filter(|_| is_line) {
                Some(later) => {
                    let share = (t - self.time_s[last]) / (self.time_s[next] - self.time_s[last]);
                    signal[last] + share * (later - signal[last])
                }
                None => signal[last],
            }
        };
        // Its middle: half of the time that a step is too long or too short acts on either side.
        let middle = |now: &f64| at(&(now + 0.5 * t), &input, false);
        Self {
            input: time_s.iter().map(middle).collect(),
            output: time_s.iter().map(|t| at(t, &output, true)).collect(),
            time_s,
            start,
            noise,
            ..Self::default()
        }
    }
}

/// The Bayesian information criterion of a first guess with `numbers` free numbers, those of the start included; residuals below the floor count
/// as the floor.
pub(super) fn bic(samples: f64, rms_residual: f64, numbers: f64, floor: f64) -> f64 {
    2.0 * samples * libm::log(rms_residual.max(floor)) + numbers * libm::log(samples)
}

pub(super) fn left(record: &InputOutput, model: &[f64]) -> Vec<f64> {
    let pairs = record.output.iter().zip(model);
    pairs.map(|(y, model)| y - model).collect()
}

pub(super) fn neighbours(left: &[f64]) -> f64 {
    let shifted = left.get(1..).unwrap_or_default();
    let product = |other: &[f64]| -> f64 { left.iter().zip(other).map(|(a, b)| a * b).sum() };
    let alike = product(shifted) / product(left);
    if alike.is_finite() { alike } else { 0.0 }
}

/// A model by a rule runs no better than this itself, nor is the record better than its rounding: what is less says nothing for one of them.
pub(super) fn resolved(record: &InputOutput) -> f64 {
    rounding(record).max(EXACT * largest(&record.output))
}

/// A model of whole orders runs exactly, but for some roundings of each sample, the last digit of the record, and the count of its sensor: what is
/// less says nothing for one of those.
pub(super) fn rounding(record: &InputOutput) -> f64 {
    let largest = largest(&record.output);
    let rounding = ROUNDINGS * f64::EPSILON * record.output.len() as f64 * largest;
    let digit = last_digit(&record.output).min(LEAST_DIGITS * largest);
    rounding
        .max(digit)
        .max(count_of(&record.output) / libm::sqrt(12.0))
}

/// Rows for each value of a sensor, of which a record in counts has few.
const ROWS_OF_A_VALUE: usize = 4;
/// Distance from whole counts, in counts: of a table that has some digits of each.
const OF_A_COUNT: f64 = 0.1;

/// q of a record in counts: rounding adds q/√12 (B. Widrow, *A study of rough amplitude quantization by means of Nyquist
/// sampling theory*, 1956), which a model would have to draw. 0 where there are many values, or they are not as far apart.
pub(super) fn count_of(signal: &[f64]) -> f64 {
    let mut values = signal.to_vec();
    values.sort_by(f64::total_cmp);
    values.dedup_by(|next, value| next.total_cmp(value).is_eq());
    if values.len() * ROWS_OF_A_VALUE > signal.len() {
        return 0.0;
    }
    let steps = || values.windows(2).map(|pair| pair[1] - pair[0]);
    let count = steps().fold(f64::INFINITY, f64::min);
    let is_whole = |step: f64| {
        let counts = step / count;
        (counts - libm::round(counts)).abs() <= OF_A_COUNT
    };
    if count.is_finite() && steps().all(is_whole) {
        count
    } else {
        0.0
    }
}

/// Largest number of decimal digits of a rounded record; a record with more is not rounded.
const MOST_DIGITS: i32 = 12;
/// Largest unit of a record's last digit, over its largest value.
const LEAST_DIGITS: f64 = 1e-3;

/// Largest rounding error of a sample at the last decimal, as of all samples while the plant rests; 0 where a signal has all its digits.
fn last_digit(signal: &[f64]) -> f64 {
    let highest = libm::floor(libm::log10(largest(signal))) as i32;
    let units = (0..MOST_DIGITS).map(|digits| libm::pow(10.0, f64::from(highest - digits)));
    let is_multiple = |value: f64, unit: f64| {
        let times = value / unit;
        (times - libm::round(times)).abs() <= 4.0 * f64::EPSILON * times.abs()
    };
    let mut units = units.filter(|unit| signal.iter().all(|value| is_multiple(*value, *unit)));
    units.next().map_or(0.0, |unit| 0.5 * unit)
}
