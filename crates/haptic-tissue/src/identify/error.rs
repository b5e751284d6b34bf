//! Records that give no model.

use std::fmt;

/// A record that cannot be used or fitted, in one line with the remedy.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum IdentifyError {
    /// A sample that is wrong, counted from 0 in what the constructor got.
    Sample {
        /// Its number.
        index: usize,
        /// The mistake and the remedy.
        reason: String,
    },
    /// A cell or line of a table that is wrong, counted from 1.
    Line {
        /// The line.
        line: u64,
        /// The column's name, if it is one column.
        column: Option<String>,
        /// The mistake and the remedy.
        reason: String,
    },
    /// A record that is wrong as a whole.
    Record(String),
    /// Not enough numbers for a model.
    TooFew {
        /// Name of the model.
        model: &'static str,
        /// Numbers in the record.
        numbers: usize,
        /// Parameters of the model.
        parameters: usize,
    },
    /// It was told to stop.
    Stopped,
    /// No start led to a minimum.
    NotConverged {
        /// Name of the model.
        model: &'static str,
    },
}

impl fmt::Display for IdentifyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sample { index, reason } => write!(f, "sample {}: {reason}", index + 1),
            Self::Line {
                line,
                column: Some(column),
                reason,
            } => write!(f, "line {line}, column {column}: {reason}"),
            Self::Line { line, reason, .. } => write!(f, "line {line}: {reason}"),
            Self::Record(reason) => f.write_str(reason),
            Self::Stopped => f.write_str("interrupted"),
            Self::TooFew {
                model,
                numbers,
                parameters,
            } => write!(
                f,
                "{numbers} numbers are too few for the {parameters} parameters of {model}: give at least {}",
                parameters + 1
            ),
            Self::NotConverged { model } => write!(
                f,
                "the fit of {model} found no minimum from any start: give another model"
            ),
        }
    }
}

impl std::error::Error for IdentifyError {}
