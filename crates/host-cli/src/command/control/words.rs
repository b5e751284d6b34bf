//! Refusals of the library.

use fractional_control::ControlError;
use haptic_experiment::Failure;
use haptic_experiment::control::in_degrees;

/// A refusal of the library: bad input, or a search that ended with nothing.
pub(crate) fn refused(error: ControlError) -> Failure {
    let text = in_degrees(&error);
    if matches!(error, ControlError::NotFound { .. }) {
        return Failure::run(format_args!("{text}"));
    }
    Failure::bad_input(text)
}
