//! The law that is felt: how long it remembers, how it becomes another, and when it may not be felt.

use crate::{
    in_hand::{fading::Fading, place::Placed},
    preflight::PreflightVerdict,
};
use fracdiff::{Operator, Seconds};
use haptic_document::{Failure, bad_input};
use haptic_loop::{Pushing, Wall};
use haptic_quantity::digits;

/// A tissue or wall behind its surface: the law of `[wall]`.
pub type Felt = Placed<Pushing<Wall<f64, Operator<f64>>>>;

/// Samples for which the memory of a law is made: 2.8 hours at 1 kHz.
pub const HORIZON: u64 = 10_000_000;
/// Time in which one law goes over into the next, s.
const FADE_S: f64 = 0.2;
/// Ticks of a time, rounded.
#[must_use]
pub fn ticks(time_s: f64, sample_time: Seconds) -> usize {
    (time_s / sample_time.0).round() as usize
}

/// Two laws that become one another: the first is felt alone.
#[must_use]
pub fn fading(law: &Felt, sample_time: Seconds) -> Fading<Felt> {
    Fading::new(law.clone(), ticks(FADE_S, sample_time) as u32)
}

/// Refuses a law that would be unstable in a loop, with how much of it would not.
///
/// # Errors
/// The verdict, in a sentence.
pub fn refuse_unstable(verdict: &PreflightVerdict) -> Result<(), Failure> {
    if verdict.stable {
        return Ok(());
    }
    let advice = match verdict.margin {
        // Rounded down, so that what is proposed is accepted.
        Some(factor) => format!("use at most {} of K and B", digits(rounded_down(factor), 2)),
        None => "use another order, or a heavier or more damped device".to_owned(),
    };
    Err(bad_input!(
        "this would be unstable (alpha {:.3}, beta {:.3}, delta {:.3}): {advice}",
        verdict.alpha,
        verdict.beta,
        verdict.delta
    ))
}

/// The largest number of two digits that is not above this one.
#[must_use]
pub fn rounded_down(number: f64) -> f64 {
    let digit = libm::exp10(libm::log10(number).floor() - 1.0);
    (number / digit).floor() * digit
}
