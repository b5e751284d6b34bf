//! Records made and searched, beside the words of `testkit`, which the tests share.

use control_identification::model_search::{
    Found, InputOutput, Wanted, candidates, find_start, identify,
};
use fracdiff::Seconds;
use fractional_control::ControlError;
use testkit::Random;
pub(crate) use testkit::control::*;

/// Rows this far apart, s.
pub(crate) fn record(t: f64, input: Vec<f64>, output: Vec<f64>) -> InputOutput {
    InputOutput {
        time_s: (0..input.len()).map(|n| t * n as f64).collect(),
        input,
        output,
        ..InputOutput::default()
    }
}

/// Noise of standard deviation 1.
pub(crate) fn normal(random: &mut Random) -> f64 {
    (0..12).map(|_| random.between(-0.5, 0.5)).sum()
}

/// Functions found for a record with the start that the record shows.
pub(crate) fn begun(record: &mut InputOutput) -> Result<Vec<Found>, ControlError> {
    find_start(record, true, None);
    searched(record, None)
}

/// The functions that are found for a record of a held input, whatever its dead time or behind a known one.
pub(crate) fn searched(
    record: &InputOutput,
    dead_time: Option<Seconds>,
) -> Result<Vec<Found>, ControlError> {
    let guesses = candidates(record, true, dead_time, Wanted::default());
    identify(record, &guesses, true, Wanted::default(), &|_| ())
}
