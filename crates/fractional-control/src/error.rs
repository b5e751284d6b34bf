//! The refusals of this crate.

use core::fmt;
use fracdiff::full_memory::DesignError;
use fracdiff::parameter::RangeError;

/// Input that is no transfer function, no controller or no question. Prints as one line: the value, the range, the remedy.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ControlError {
    /// A quantity outside its range.
    Range(RangeError),
    /// Order or sample time of an operator.
    Operator(fracdiff::ParameterError),
    /// A full memory that cannot be had.
    Design(DesignError),
    /// The numerator grows faster than the denominator.
    Improper {
        /// Order of the numerator.
        numerator: f64,
        /// Order of the denominator.
        denominator: f64,
    },
    /// A term whose coefficient is zero: written so, or because two terms cancel.
    ZeroCoefficient {
        /// Its order.
        order: f64,
    },
    /// Numerator and denominator both have this power of s as a factor.
    CommonOrder {
        /// The power.
        order: f64,
    },
    /// No term at all.
    Empty {
        /// `numerator` or `denominator`.
        what: &'static str,
    },
    /// More terms than there is room for.
    TooManyTerms {
        /// Terms needed.
        count: usize,
        /// Room.
        most: usize,
    },
    /// Text that is not in the notation.
    Notation {
        /// Place of the first character that does not fit, from 0.
        at: usize,
        /// Words for what may stand there.
        expected: &'static str,
    },
    /// Orders without a common divisor that is large enough.
    NotCommensurate {
        /// The degree that would be needed, or more.
        degree: usize,
    },
    /// A plant that is not stable by itself was to be shown without a controller.
    UnstablePlant {
        /// Its poles in the right half-plane, or on its edge.
        poles: usize,
    },
    /// A measured response was to be run: it can only be tuned for.
    Measured,
    /// Two wishes that no controller can meet together.
    Contradiction {
        /// The first.
        first: &'static str,
        /// Its value.
        first_value: f64,
        /// The second.
        second: &'static str,
        /// Its value.
        second_value: f64,
        /// The remedy.
        remedy: &'static str,
    },
    /// A search that ended without an answer.
    NotFound {
        /// The thing searched.
        what: &'static str,
        /// The reason, and the remedy.
        why: &'static str,
    },
}

impl From<RangeError> for ControlError {
    fn from(error: RangeError) -> Self {
        Self::Range(error)
    }
}

impl From<fracdiff::ParameterError> for ControlError {
    fn from(error: fracdiff::ParameterError) -> Self {
        Self::Operator(error)
    }
}

impl From<DesignError> for ControlError {
    fn from(error: DesignError) -> Self {
        match error {
            DesignError::Parameter(error) => Self::Operator(error),
            error => Self::Design(error),
        }
    }
}

impl fmt::Display for ControlError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Range(error) => error.fmt(f),
            Self::Operator(error) => error.fmt(f),
            Self::Design(error) => error.fmt(f),
            Self::Improper {
                numerator,
                denominator,
            } => write!(
                f,
                "order {numerator} of the numerator is above {denominator}, that of the denominator: add a faster pole"
            ),
            Self::ZeroCoefficient { order } => write!(
                f,
                "the coefficient of s^{order} is 0, or cancels: leave the term out"
            ),
            Self::CommonOrder { order } => write!(
                f,
                "numerator and denominator share the factor s^{order}: divide both by it"
            ),
            Self::Empty { what } => write!(f, "the {what} has no term: give one that is not 0"),
            Self::TooManyTerms { count, most } => write!(
                f,
                "{count} terms are more than the largest number, {most}: take fewer orders"
            ),
            Self::Notation { at, expected } => write!(
                f,
                "character {at} of the transfer function should be {expected}, as in 1/(0.8s^2.2+0.5s^0.9+1)"
            ),
            Self::NotCommensurate { degree } => write!(
                f,
                "the orders have no common divisor, or one that gives degree {degree}, above 200: round them"
            ),
            Self::UnstablePlant { poles: 1 } => f.write_str(
                "the plant has a pole that does not decay: close the loop with a controller first",
            ),
            Self::UnstablePlant { poles } => write!(
                f,
                "the plant has {poles} poles that do not decay: close the loop with a controller first"
            ),
            Self::Measured => f.write_str(
                "a measured response can be tuned for, not run: give a transfer function or matrices",
            ),
            Self::Contradiction {
                first,
                first_value,
                second,
                second_value,
                remedy,
            } => write!(
                f,
                "`{first}` {first_value} contradicts `{second}` {second_value}: {remedy}"
            ),
            Self::NotFound { what, why } => write!(f, "{what} was not found: {why}"),
        }
    }
}

impl core::error::Error for ControlError {}
