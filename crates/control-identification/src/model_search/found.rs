//! A function that was fitted, and how good it is beside others.

use super::record::{self, InputOutput, neighbours, rounding};
use crate::autoregression::Autoregression;
use crate::identify::{Free, projected, run_alone, solved};
use crate::{DeadTime, FreeNumber, Identified, InputOutputRecord, StartState};
use core::iter;
use nalgebra::{DMatrix, DVector};

/// A function that was fitted.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Found {
    /// The function, its output, and how sure its numbers are in the noise that it leaves.
    pub identified: Identified,
    /// Bayesian information criterion with the numbers of the noise: less is better. Anything smaller than a model can resolve
    /// counts as zero.
    pub bic: f64,
    /// Correlation of neighbouring samples of what the filter of the noise leaves: near 0 of white noise, near 1 of a model that lacks something.
    pub neighbours: f64,
    /// The stretch with the largest residual, if that is a large part of the output there and is
    /// not noise.
    pub unexplained: Option<Unexplained>,
    pub(super) freedom: Free,
}

impl Found {
    /// True if the record shows a response to its input: a test at the level of 0.1 %, each side in the noise that it leaves.
    /// ```text
    /// (1 − q/n)·(D(y − X·b) − D(y − ŷ)) > χ²(q; 0.999), q·ln n, and q more than with any shifted input,   D(x) = deviance of x + order·ln n,   q = numbers + 2
    /// X:   1, s, Δs, Δ²s, … of the step response s, which hold every free motion and the answer to a constant, as a drift is;
    ///      or the start that fits best without an input: of a plant that moves, a constant that acts within the dead time among it
    /// ```
    /// q·ln n is the price of a function that was chosen among many (G. Schwarz, *Estimating the dimension of a model*, 1978).
    /// Shifted around the record the input answers to nothing, so the same function explains by it as much as chance does, whatever the noise; those
    /// shifts count whose answer is not that of the true input again, as of a period. An input that hardly changes has a course that a free motion can
    /// have too; then the function is compared with the mean alone, in the noise that the function leaves.
    #[must_use]
    pub fn shows_a_response(&self, record: &InputOutput) -> bool {
        let (identified, samples) = (&self.identified, record.output.len());
        let ones = vec![1.0; samples];
        let ran = |input: &[f64], dead_time| {
            let alone = InputOutputRecord {
                input,
                time_s: &[],
                start: StartState::Rest,
                ..record.as_record(true, dead_time)
            };
            run_alone(&identified.parts, &alone).map(DVector::from_vec)
        };
        let count = (self.numbers() + identified.start_numbers + 2) as f64;
        let enough = chance(count).max(count * libm::log(samples as f64));
        let zeros = vec![0.0; samples];
        let began = InputOutputRecord {
            input: &zeros,
            start: StartState::Moving,
            ..record.as_record(true, identified.dead_time)
        };
        let began = run_alone(&identified.parts, &began).map(|began| record::left(record, &began));
        let floor = rounding(record);
        let left = record::left(record, &identified.model);
        let wanted = DVector::from_column_slice(&record.output);
        let ones = DVector::from_vec(ones);
        // What acts only at the end of a record acts there.
        let acting = record.as_record(true, identified.dead_time).now();
        if hardly_changes(&acting) {
            let noise = Autoregression::of(&[&left]);
            let power =
                |signal: &[f64]| -> f64 { noise.whitened(signal).iter().map(|x| x * x).sum() };
            let around = wanted.add_scalar(-wanted.mean());
            let began = began.filter(|_| record.tells_before());
            let alone = began.iter().map(|began| power(began));
            let alone = alone.fold(power(around.as_slice()), f64::min);
            let won = (samples as f64 - count) * libm::log(alone / power(&left));
            return won > enough;
        }
        let step = ran(ones.as_slice(), DeadTime::NONE);
        let modes = libm::ceil(identified.function.denominator().degree()) as usize;
        let mut motions = vec![ones];
        motions.extend(iter::successors(step, |last| Some(differences(last))).take(modes));
        let alone = drawn(&motions, &wanted, floor);
        let began = began.map_or(f64::INFINITY, |began| noise_of(&began, floor));
        let alone = alone.min(began);
        let won = |other: f64| (1.0 - count / samples as f64) * (alone - other);
        let own_won = won(noise_of(&left, floor));
        if own_won <= enough {
            return false;
        }
        let answer = ran(&record.input, identified.dead_time);
        let shifts = (1..=SHIFTS).map(|k| k * samples / (SHIFTS + 1));
        let by_chance = shifts.filter(|shift| *shift > 0).filter_map(|shift| {
            let mut input = record.input.clone();
            input.rotate_right(shift);
            let other = ran(&input, identified.dead_time)?;
            if like(&motions, &other, answer.as_ref()?) > LIKE {
                return None;
            }
            let with = [&motions[..], &[other]].concat();
            Some(won(drawn(&with, &wanted, floor)))
        });
        let by_chance = by_chance.fold(0.0, f64::max);
        own_won > by_chance + count
    }

    /// Root mean square of the whitened residual: of the innovations.
    pub(super) fn news(&self, record: &InputOutput) -> f64 {
        let model = &self.identified;
        let white = model.noise.whitened(&record::left(record, &model.model));
        libm::sqrt(white.iter().map(|x| x * x).sum::<f64>() / white.len() as f64)
    }

    /// The numbers that were found with the function: a dead time that was chosen among whole samples too.
    pub(super) fn numbers(&self) -> usize {
        let is_chosen = matches!(self.identified.dead_time, DeadTime::JustAfter(_));
        self.identified.standard_errors.len() + usize::from(is_chosen)
    }

    /// True if the function settles by itself.
    pub(super) fn settles(&self) -> bool {
        self.identified.function.unstable_poles() == Some(0)
    }

    pub(super) fn is_sum(&self) -> bool {
        self.identified.parts.len() > 1
    }

    /// True of one function of whole orders: the parts of a sum stay as they are.
    pub(super) fn is_whole(&self) -> bool {
        self.identified.function.is_whole() && !self.is_sum()
    }

    /// The orders above and below.
    pub(super) fn poles_and_zeros(&self) -> f64 {
        let function = &self.identified.function;
        function.numerator().degree() + function.denominator().degree()
    }

    /// Standard error of the dead time, s, if that is one of the numbers.
    pub(super) fn dead_time_error(&self) -> Option<f64> {
        let last = self.identified.standard_errors.last();
        last.filter(|last| last.0 == FreeNumber::DeadTime)
            .map(|last| last.1)
    }

    pub(super) fn dead_time_is_loose(&self) -> bool {
        let error = self.dead_time_error();
        error.is_some_and(|error| error > LOOSE * self.identified.dead_time.seconds())
    }
}

/// A coefficient whose standard error is above this share of it is tried without.
pub(super) const LOOSE: f64 = 0.5;
/// A difference of the criterion that speaks very strongly (A. E. Raftery, *Bayesian model selection in social research*, 1995, Table 6).
pub(super) const DECISIVE: f64 = 10.0;
/// A difference of the criterion that says nothing.
pub(super) const AS_GOOD: f64 = 2.0;

/// Changes of an input from which on no free motion follows its course.
const CHANGES: usize = 5;
/// Those that count beside the largest: (Σ Δ²)²/Σ Δ⁴, which is their number where they are alike.
const LARGE: f64 = 2.5;

/// Shifts of an input around its record, and how much like the true answer another one may be.
const SHIFTS: usize = 39;
const LIKE: f64 = 0.5;
/// Rounds of least squares through the filter of the noise.
const ROUNDS: usize = 2;

/// χ² with `numbers` degrees of freedom that chance stays below in 99.9 %: E. B. Wilson, M. M. Hilferty, *The distribution of chi-square*, 1931.
fn chance(numbers: f64) -> f64 {
    let small = 2.0 / (9.0 * numbers);
    let root = 1.0 - small + 3.09 * libm::sqrt(small);
    numbers * root * root * root
}

/// The deviance of a residual in its own noise, with the numbers of that.
fn noise_of(left: &[f64], floor: f64) -> f64 {
    let noise = Autoregression::of(&[left]);
    let numbers = noise.order() as f64 * libm::log(left.len() as f64);
    noise.deviance(&[left], floor) + numbers
}

/// The cosine of the angle between two signals without these motions.
fn like(motions: &[DVector<f64>], a: &DVector<f64>, b: &DVector<f64>) -> f64 {
    let motions: Vec<Vec<f64>> = motions
        .iter()
        .map(|motion| motion.as_slice().to_vec())
        .collect();
    let [a, b] = [a, b].map(|signal| {
        let shares = projected(&motions, signal.as_slice().to_vec());
        let pairs = motions.iter().zip(shares);
        pairs.fold(signal.clone(), |left, (motion, share)| {
            left - DVector::from_column_slice(motion) * share
        })
    });
    (a.dot(&b) / (a.norm() * b.norm())).abs()
}

/// True of few changes, or of few large ones.
fn hardly_changes(input: &[f64]) -> bool {
    let changes = input
        .windows(2)
        .map(|pair| (pair[1] - pair[0]) * (pair[1] - pair[0]));
    let changes: Vec<f64> = changes.filter(|square| *square > 0.0).collect();
    let sum: f64 = changes.iter().sum();
    let squares: f64 = changes.iter().map(|square| square * square).sum();
    changes.len() < CHANGES || sum * sum < LARGE * squares
}

/// Least noise of the residual after the first columns, for any number of them, through the filter of that noise: nearly parallel columns
/// are no evidence against those before them.
fn drawn(columns: &[DVector<f64>], wanted: &DVector<f64>, floor: f64) -> f64 {
    let fits = (1..=columns.len()).flat_map(|count| {
        let mut noise = Autoregression::WHITE;
        let rounds = (0..ROUNDS).map_while(move |_| {
            let white =
                |signal: &DVector<f64>| DVector::from_vec(noise.whitened(signal.as_slice()));
            let white_columns: Vec<_> = columns[..count].iter().map(white).collect();
            let found = solved(DMatrix::from_columns(&white_columns), white(wanted))?;
            let left = wanted - DMatrix::from_columns(&columns[..count]) * found;
            noise = Autoregression::of(&[left.as_slice()]);
            Some(noise_of(left.as_slice(), floor))
        });
        rounds.collect::<Vec<f64>>()
    });
    fits.fold(f64::INFINITY, f64::min)
}

fn differences(signal: &DVector<f64>) -> DVector<f64> {
    let mut differences = signal.clone();
    for n in 1..signal.len() {
        differences[n] -= signal[n - 1];
    }
    differences
}

/// A stretch of a record where the residual is too regular to be noise, so the function misses
/// something.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Unexplained {
    /// The time at which the stretch begins, s.
    pub from_s: f64,
    /// The time at which the stretch ends, s.
    pub to_s: f64,
    /// Root mean square of the residual, divided by that of the output there.
    pub share: f64,
}

/// Blocks of a record, and their samples at least.
const BLOCKS: usize = 50;
const SAMPLES: usize = 20;
/// Autocorrelation in a block from which on the residual is not white noise.
const ALIKE: f64 = 0.8;
/// That of a whole record, which scatters less.
const ALIKE_ALL: f64 = 0.3;
/// Share of the output of a block from which on a residual is large.
const MUCH: f64 = 0.05;

/// The block with the largest residual, if that is large and not noise. A record that grows is small at its beginning, so a misfit there is
/// negligible beside the end.
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
