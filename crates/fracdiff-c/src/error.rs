//! Operators and names that give no header.

use fracdiff::parameter::Shown;

/// Why no header was written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HeaderError {
    /// A name that C does not take, or one that with `_t` is a type of the system.
    #[error(
        "name \"{0}\" is not a C identifier of 1 to 24 letters, digits and underscores that begins with a letter, and \
         not a keyword or, with _t, a type of the system"
    )]
    Name(String),
    /// A list of coefficients that no operator has.
    #[error(
        "{count} coefficients with an integer part of {integer} are not what this form of operator has: use the list \
         of an operator"
    )]
    List {
        /// Number of values in the list.
        count: usize,
        /// Differences (> 0) or sums (< 0) around them.
        integer: i8,
    },
    /// A stiffness or dissipation of a law that is negative or not finite.
    #[error("stiffness or dissipation {} must be finite and at least 0", Shown(*value))]
    Law {
        /// The value as it was given, for the message.
        value: f64,
    },
    /// A number of a map of the depth that is negative or not finite, or a scale of 0.
    #[error("a number of {} in a map of the depth is not finite and at least 0, its scale above 0", Shown(*value))]
    DepthMap {
        /// The value as it was given, for the message.
        value: f64,
    },
    /// A coefficient that is not finite.
    #[error("coefficient {index} is {}, which is not finite", Shown(*value))]
    Value {
        /// Its place in the list.
        index: usize,
        /// The value as it was given, for the message.
        value: f64,
    },
}
