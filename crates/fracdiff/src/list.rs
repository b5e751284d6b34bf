//! Lists of values that are to be an operator: their forms, and why one is refused.

use crate::Real;

/// The meaning of a list of values. Exhaustive on purpose: who runs lists must know every form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Form {
    /// A finite impulse response, of which the newest samples are all that counts.
    Taps,
    /// Recent taps and decaying modes.
    Modes,
    /// A recursive filter: forward and backward coefficients by turns.
    Recursion,
}

/// Why a list does not describe an operator.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ListError {
    /// The integer part is not in −2 to 2, or not 0 for [`Form::Taps`].
    #[error("integer part {0} must be in [-2, 2], and 0 for a list of taps")]
    IntegerPart(i8),
    /// Not a number of values that this form can have, or more than there is room for.
    #[error(
        "{count} coefficients do not fit this form of operator, or exceed the {most} there is room for"
    )]
    Count {
        /// Number of values in the list.
        count: usize,
        /// Number of values that this operator has room for, in this form.
        most: usize,
    },
    /// A value that is not finite.
    #[error("coefficient {index} is {value}, which is not finite")]
    Value {
        /// Its place in the list.
        index: usize,
        /// The value, which is NaN or infinite.
        value: f64,
    },
    /// A decay outside (0, 1].
    #[error("coefficient {index} is a decay of {value:e}, which is not in (0, 1]")]
    Decay {
        /// Its place in the list.
        index: usize,
        /// The value, outside (0, 1].
        value: f64,
    },
}

/// A decay of a low-pass must lie in (0, 1], or its state would grow.
pub(crate) fn check_decay<F: Real>(decay: F, index: usize) -> Result<F, ListError> {
    if decay > F::ZERO && decay <= F::ONE {
        Ok(decay)
    } else {
        Err(ListError::Decay {
            index,
            value: decay.to_f64(),
        })
    }
}

/// Accepts −2 to 2.
pub(crate) fn check_integer(integer: i8) -> Result<i32, ListError> {
    if (-2..=2).contains(&integer) {
        Ok(i32::from(integer))
    } else {
        Err(ListError::IntegerPart(integer))
    }
}

/// Accepts values that are all finite.
pub(crate) fn check_finite<F: Real>(values: &[F]) -> Result<(), ListError> {
    match values.iter().position(|value| !value.is_finite()) {
        None => Ok(()),
        Some(index) => Err(ListError::Value {
            index,
            value: values[index].to_f64(),
        }),
    }
}
