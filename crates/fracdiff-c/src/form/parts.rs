//! What every form is made of.

/// A member of the struct: zero at rest.
pub(crate) enum Field {
    /// A number.
    Real(&'static str),
    /// So many numbers.
    Reals(&'static str, usize),
    /// A place in an array.
    Index(&'static str),
}

/// The core of an operator in C.
pub(crate) struct Core {
    /// Constants.
    pub(crate) tables: String,
    /// Its part of the history.
    pub(crate) fields: Vec<Field>,
    /// Functions that the step calls.
    pub(crate) functions: String,
    /// From `u` to `past`, without an input in between.
    pub(crate) step: String,
    /// g, a literal.
    pub(crate) direct: String,
    /// What the numbers mean, for the comment.
    pub(crate) words: String,
}
