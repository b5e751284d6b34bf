//! Operators and names that give no header.

use fracdiff::parameter::Shown;
use std::fmt;

/// Why there is no header.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum HeaderError {
    /// A name that C does not take, or one that with `_t` is a type of the system.
    Name(String),
    /// A list of coefficients that no operator has.
    List {
        /// Number of values.
        count: usize,
        /// Differences (> 0) or sums (< 0) around them.
        integer: i8,
    },
    /// A controller of a kind that is not written yet.
    Controller,
    /// A stiffness or dissipation of a law that is negative or not finite.
    Law {
        /// The value.
        value: f64,
    },
    /// A number of a map of the depth that is negative or not finite, or a scale of 0.
    DepthMap {
        /// The value.
        value: f64,
    },
    /// A coefficient that is not finite.
    Value {
        /// Its place in the list.
        index: usize,
        /// The value.
        value: f64,
    },
}

impl fmt::Display for HeaderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Name(name) => write!(
                f,
                "name \"{name}\" is not a C identifier of 1 to 24 letters, digits and underscores that begins with a \
                 letter, and not a keyword or, with _t, a type of the system"
            ),
            Self::List { count, integer } => write!(
                f,
                "{count} coefficients with an integer part of {integer} are not what this form of operator has: take \
                 the list of an operator"
            ),
            Self::Controller => f.write_str(
                "a controller of this kind has no C: take a PI^λD^μ, a TID, a CRONE controller or a lead–lag",
            ),
            Self::Law { value } => write!(
                f,
                "a stiffness or dissipation of {} is not finite and at least 0",
                Shown(*value)
            ),
            Self::DepthMap { value } => write!(
                f,
                "a number of {} in a map of the depth is not finite and at least 0, its scale above 0",
                Shown(*value)
            ),
            Self::Value { index, value } => {
                let value = Shown(*value);
                write!(f, "coefficient {index} is {value}, which is not finite")
            }
        }
    }
}

impl std::error::Error for HeaderError {}
