//! Records that give no model.

use measured_table::TableError;

/// A record that cannot be used or fitted, in one line with the remedy.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum IdentifyError {
    /// A sample that is wrong, counted from 0 in what the constructor got.
    #[error("sample {}: {reason}", index + 1)]
    Sample {
        /// Its number, from 0; the message counts from 1.
        index: usize,
        /// The mistake and the remedy.
        reason: String,
    },
    /// A table that cannot be read as a record.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A record that is wrong as a whole.
    #[error("{0}")]
    Record(String),
    /// Not enough numbers for a model.
    #[error(
        "{numbers} numbers are too few for {model}: give at least {}",
        parameters + 3
    )]
    TooFew {
        /// Its name as on the command line.
        model: &'static str,
        /// Numbers in the record: two for each sample of an oscillation.
        numbers: usize,
        /// Parameters of the model; three more numbers are needed to judge the fit.
        parameters: usize,
    },
    /// The caller stopped the fit.
    #[error("interrupted")]
    Stopped,
    /// No start led to a minimum.
    #[error("the fit of {model} found no minimum from any start: give another model")]
    NotConverged {
        /// Name of the model that was fitted.
        model: &'static str,
    },
}

/// Separates the results from the errors.
pub(super) fn sorted<T>(all: Vec<Result<T, IdentifyError>>) -> (Vec<T>, Vec<IdentifyError>) {
    let (mut well, mut failed) = (Vec::new(), Vec::new());
    for one in all {
        match one {
            Ok(one) => well.push(one),
            Err(error) => failed.push(error),
        }
    }
    (well, failed)
}
