//! The refusals of this crate.

use core::fmt;
use fracdiff::{full_memory::DesignError, parameter::RangeError};

/// Input that is not a valid transfer function, controller or question. Prints as one line: the
/// value, the range, the remedy.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ControlError {
    /// A quantity outside its range.
    #[error(transparent)]
    Range(#[from] RangeError),
    /// Order or sample time of an operator.
    #[error(transparent)]
    Operator(#[from] fracdiff::ParameterError),
    /// A full memory that cannot be had.
    #[error(transparent)]
    Design(#[from] DesignError),
    /// The numerator grows faster than the denominator.
    #[error(
        "the numerator's order {numerator} exceeds the denominator's order {denominator}: add a faster pole"
    )]
    Improper {
        /// Order of the numerator.
        numerator: f64,
        /// Order of the denominator.
        denominator: f64,
    },
    /// A term whose coefficient is zero: written so, or because two terms cancel.
    #[error("the coefficient of s^{order} is 0, or cancels: leave the term out")]
    ZeroCoefficient {
        /// The order of the term.
        order: f64,
    },
    /// Numerator and denominator both have this power of s as a factor.
    #[error("numerator and denominator share the factor s^{order}: divide both by it")]
    CommonOrder {
        /// The power of s that they share.
        order: f64,
    },
    /// A numerator, a denominator or a sum without any term.
    #[error("the {what} has no term: give one that is not 0")]
    Empty {
        /// `numerator` or `denominator`.
        what: &'static str,
    },
    /// More terms than there is room for.
    #[error("{count} terms are more than the largest number, {most}: use fewer orders")]
    TooManyTerms {
        /// Number of terms asked for.
        count: usize,
        /// Largest number of terms that there is room for.
        most: usize,
    },
    /// Text that is not in the notation.
    #[error(
        "character {at} of the transfer function should be {expected}, as in 1/(0.8s^2.2+0.5s^0.9+1)"
    )]
    Notation {
        /// Place of the first character that does not fit, from 0.
        at: usize,
        /// Words for what may stand there.
        expected: &'static str,
    },
    /// A factor that only a plant has, in a controller or in a model to be fitted.
    #[error(
        "{what} {value} stands only in a plant: write powers of s, as in 1/(0.8s^2.2+0.5s^0.9+1)"
    )]
    OnlyInPlant {
        /// The factor in words, up to its number.
        what: &'static str,
        /// Power of a bracket, or number before the root of diffusion.
        value: f64,
    },
    /// A plant whose function grows with frequency, or jumps, beside powers of brackets that do not fall as fast.
    #[error(
        "order {numerator} above and {denominator} below: beside a power of a bracket the plant must fall faster with frequency: add a pole, as in 1/(0.01s+1)"
    )]
    BesideFactors {
        /// Order of the numerator, with its brackets.
        numerator: f64,
        /// Order of the denominator, with its brackets.
        denominator: f64,
    },
    /// Orders without a common divisor that is large enough.
    #[error(
        "the orders have no common divisor, or one that gives degree {degree}, above 200: round them"
    )]
    NotCommensurate {
        /// The degree that would be needed, or more.
        degree: usize,
    },
    /// A plant that is not stable by itself was to be shown without a controller.
    #[error(fmt = unstable_plant)]
    UnstablePlant {
        /// Its poles in the right half-plane, or on its edge.
        poles: usize,
    },
    /// A measured response was to be run: it can only be tuned for.
    #[error("a measured response can be tuned for, not run: give a transfer function or matrices")]
    Measured,
    /// Two wishes that no controller can meet together.
    #[error("`{first}` {first_value} contradicts `{second}` {second_value}: {remedy}")]
    Contradiction {
        /// The key of one of the wishes.
        first: &'static str,
        /// The value that was asked for.
        first_value: f64,
        /// The key of the wish that contradicts it.
        second: &'static str,
        /// The value that was asked for there.
        second_value: f64,
        /// The change that makes them agree.
        remedy: &'static str,
    },
    /// A search that ended without an answer.
    #[error("{what} was not found: {why}")]
    NotFound {
        /// The thing that was searched for, as the message names it.
        what: &'static str,
        /// The reason, and the remedy.
        why: &'static str,
    },
}

fn unstable_plant(poles: &usize, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    match poles {
        1 => f.write_str("the plant has a pole that does not decay"),
        poles => write!(f, "the plant has {poles} poles that do not decay"),
    }?;
    f.write_str(": close the loop with a controller first")
}
