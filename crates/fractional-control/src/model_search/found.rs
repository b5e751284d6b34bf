//! A function that was fitted, and how good it is beside others.

use super::record::{InputOutput, left, neighbours};
use crate::{FreeNumber, Identified};
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
    /// True if the record shows a response to its input: this function explains more of it than noise around a constant does, whose neighbouring
    /// samples may be alike, beyond what so many numbers and two choices among n dead times win by chance.
    /// ```text
    /// n·ln(E(y − mean of y)/E(y − ŷ)) > (numbers + 2)·ln n,   E(x) = Σ(x_n − ρ·x_(n−1))²,   ρ = Σ x_n·x_(n−1)/Σ x_n² from 0 to 1
    /// ```
    #[must_use]
    pub fn shows_a_response(&self, record: &InputOutput) -> bool {
        let samples = record.output.len() as f64;
        let mean = record.output.iter().sum::<f64>() / samples;
        let noise: Vec<f64> = record.output.iter().map(|y| y - mean).collect();
        let left = left(record, &self.identified.model);
        let won = samples * libm::log(innovations(&noise) / innovations(&left));
        won > (self.identified.standard_errors.len() as f64 + 2.0) * libm::log(samples)
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

/// What each sample of a noise has that its neighbour does not tell: `Σ(x_n − ρ·x_(n−1))²`.
fn innovations(noise: &[f64]) -> f64 {
    let alike = neighbours(noise).clamp(0.0, 1.0);
    let before = core::iter::once(&0.0).chain(noise);
    let news = noise
        .iter()
        .zip(before)
        .map(|(now, before)| now - alike * before);
    news.map(|news| news * news).sum()
}

/// A stretch of a record that a function does not explain, though what it leaves there is no noise.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Unexplained {
    /// From here on, s.
    pub from_s: f64,
    /// To here, s.
    pub to_s: f64,
    /// Root mean square of what is left, over that of the output there.
    pub share: f64,
}
