//! Tables that give no columns.

use super::keys::SKIP_BAD_ROWS;

/// A table that cannot be used, in one line with the remedy.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TableError {
    /// A cell or line that is wrong, counted from 1.
    #[error("line {line}{}: {reason}", in_column(.column))]
    Line {
        /// The line in the file, from 1, with those before the header.
        line: u64,
        /// The column's name, if it is one column.
        column: Option<String>,
        /// The mistake and the remedy.
        reason: String,
    },
    /// A table that is wrong as a whole.
    #[error("{0}")]
    Whole(String),
}

impl TableError {
    /// Error with the remedy to leave out rows that are no sample, if that mends it.
    #[must_use]
    pub fn or_skip(mut self) -> Self {
        if let Self::Line { reason, .. } = &mut self {
            *reason += &format!(", or give {SKIP_BAD_ROWS}");
        }
        self
    }
}

fn in_column(name: &Option<String>) -> String {
    let named = |name: &String| format!(", column {name}");
    name.as_ref().map_or(String::new(), named)
}
