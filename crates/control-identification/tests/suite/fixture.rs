//! Records searched, beside the words of `testkit`, which the tests share.

use control_identification::model_search::{Found, InputOutput, Wanted, candidates, identify};
use fracdiff::Seconds;
use fractional_control::ControlError;
pub(crate) use testkit::control::*;

/// The functions that are found for a record of a held input, whatever its dead time or behind a known one.
pub(crate) fn searched(
    record: &InputOutput,
    dead_time: Option<Seconds>,
) -> Result<Vec<Found>, ControlError> {
    let guesses = candidates(record, true, dead_time, Wanted::default());
    identify(record, &guesses, true, Wanted::default(), &|_| ())
}
