//! A function that was fitted, and how good it is beside others.

use super::record::{InputOutput, left, neighbours};
use crate::identify::{run_alone, solved};
use crate::{DeadTime, FreeNumber, Identified, Record, Start};
use core::iter;
use nalgebra::{DMatrix, DVector};
use std::vec;
use std::vec::Vec;

/// A function that was fitted.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Found {
    /// The function, its output, and how sure its numbers are: less so where neighbouring samples of what is left are alike.
    pub identified: Identified,
    /// Bayesian information criterion: less is better. Anything smaller than a model can resolve
    /// counts as zero.
    pub bic: f64,
    /// Correlation of neighbouring samples of what is left: near 0 of white noise, near 1 of a model that lacks something.
    pub neighbours: f64,
    /// The stretch with the largest residual, if that is a large part of the output there and is
    /// not noise.
    pub unexplained: Option<Unexplained>,
}

impl Found {
    /// True if the record shows a response to its input: this function explains more of it than the same function does without that input, around
    /// a constant and a drift and with noise whose neighbouring samples may be alike, beyond what so many numbers and two choices among n dead times
    /// win by chance. An input that hardly changes has a course that a free motion can have too; then it is compared with the constant alone.
    /// ```text
    /// n·ln(E(y − X·b)/E(y − ŷ)) > (numbers + 2)·ln n,   E(x) = Σ(x_n − ρ·x_(n−1))², n ≥ 1,   ρ = Σ x_n·x_(n−1)/Σ x_n² from 0 to 1
    /// X:   1; of an input that changes also t, and s, Δs, Δ²s, … of the step response s, which hold every free motion
    /// ```
    #[must_use]
    pub fn shows_a_response(&self, record: &InputOutput) -> bool {
        let (own, ones) = (&self.identified, vec![1.0; record.output.len()]);
        let samples = ones.len() as f64;
        let alone = Record {
            input: &ones,
            time_s: &[],
            start: Start::Rest,
            ..record.as_record(true, DeadTime::NONE)
        };
        let changes = record
            .input
            .windows(2)
            .filter(|pair| (pair[1] - pair[0]).abs() > 0.0);
        let mut motions = vec![ones.clone()];
        if changes.count() >= CHANGES {
            motions.push((0..ones.len()).map(|n| n as f64).collect());
            let step = run_alone(&own.function, &alone);
            let modes = libm::ceil(own.function.denominator().degree()) as usize;
            motions.extend(iter::successors(step, |last| Some(news(last, 1.0))).take(modes));
        }
        let mean = record.output.iter().sum::<f64>() / samples;
        let around: Vec<f64> = record.output.iter().map(|y| y - mean).collect();
        let left = left(record, &own.model);
        let power = |noise: &[f64], alike: f64| -> f64 {
            news(noise, alike).iter().skip(1).map(|x| x * x).sum()
        };
        let without = |alike: f64| {
            let columns = motions
                .iter()
                .map(|motion| DVector::from_vec(news(motion, alike)));
            let columns = DMatrix::from_columns(&columns.collect::<Vec<_>>()).remove_row(0);
            let noise = DVector::from_vec(news(&around, alike)).remove_row(0);
            // Each of the first so many: columns that are nearly one say nothing of those before them.
            let fits = (1..=motions.len()).filter_map(|count| {
                let columns = columns.columns(0, count).into_owned();
                let found = solved(columns.clone(), noise.clone())?;
                Some((columns * found - &noise).norm_squared())
            });
            fits.fold(power(&around, alike), f64::min)
        };
        let [alike, drifting] = [&left, &around].map(|noise| neighbours(noise).clamp(0.0, 1.0));
        let won = without(alike).min(without(drifting)) / power(&left, alike);
        let numbers = self.numbers() + own.start_numbers + 2;
        samples * libm::log(won) > numbers as f64 * libm::log(samples)
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

    pub(super) fn is_whole(&self) -> bool {
        self.identified.function.is_whole()
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

/// Standard errors of white noise are to be multiplied by this: neighbours that are alike count as fewer samples.
/// ```text
/// √((1 + ρ)/(1 − ρ)),   √n at most
/// ```
pub(super) fn less_sure(neighbours: f64, samples: usize) -> f64 {
    let alike = neighbours.clamp(0.0, 1.0);
    libm::sqrt(((1.0 + alike) / (1.0 - alike)).min(samples as f64))
}

/// Changes of an input from which on no free motion follows its course.
const CHANGES: usize = 5;

/// What each sample of a signal has that its neighbour does not tell: `x_n − ρ·x_(n−1)`, from 0.
fn news(signal: &[f64], alike: f64) -> Vec<f64> {
    let before = iter::once(&0.0).chain(signal);
    let pairs = signal.iter().zip(before);
    pairs.map(|(now, before)| now - alike * before).collect()
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
