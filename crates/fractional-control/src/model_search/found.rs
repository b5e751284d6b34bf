//! A function that was fitted, and how good it is beside others.

use crate::{FreeNumber, Identified};

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
    pub(super) fn settles(&self) -> bool {
        self.identified.function.unstable_poles() == Some(0)
    }

    pub(super) fn is_whole(&self) -> bool {
        self.identified.function.is_whole()
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
