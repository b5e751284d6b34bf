//! Judging a trial: does a device that hits a wall and is pushed into it come to rest?
//!
//! ```text
//! over the last window (0.4 s of 5 s), std = standard deviation:
//! std of the position ≤ max(2 q, 1 % of push/(K + k))      q: encoder step, m
//! std of the force    ≤ max(min(B·q·T^(−μ), 25 % of the push), 5 % of the push)
//!                                                B·q·T^(−μ): one encoder step through the operator
//! largest − least force ≤ the push
//! force at its limit in more than 1 % of all samples: saturated, whatever the rest says
//! ```
//! - A buzzing wall moves a stiff device by little and its force by much, so both are judged. A threshold
//!   for the position alone, like the dissertation's 0.1 mm, is half the deflection of a wall of 5 kN/m and
//!   ten times that of one of 100 kN/m: a wall that buzzes against the force limit passes it.
//! - *One encoder step* through the operator is the least force that such a wall can change by, so a wall at
//!   rest may vary by it; but by at most a quarter of the push. A wall whose own step is larger shakes the hand,
//!   whatever the encoder has to do with it: it is stable only if it hardly makes such a step.
//! - *A standard deviation hides rare swings*: a force that swings by more than the push from end to end lets go of the
//!   device now and then, however small its deviation.
//! - *Noise* of the sensor counts as an encoder whose steps have the same rms: q = √12·σ.
//! - *Without a spring* (K + k = 0) the device gives way for ever, and the force alone is judged.
//! - *[`Criterion::Dissertation`]* is the old rule: the position alone against one threshold.
//!
//! Source of the old rule: O. Tokatlı, *Fractional Order Control in Haptics*, section 4.4, figure 4.3.

mod criterion;
mod judge;
#[cfg(test)]
mod tests;
mod verdict;

pub use criterion::Criterion;
pub(crate) use criterion::{Scales, Tolerance};
pub(crate) use judge::Judge;
pub use verdict::{Settling, TrialVerdict};
