//! Keys of the device of a question.

use crate::document::parameters::kind::{Parameter, joined};
use crate::document::parameters::{
    DAMPING, DEVICE_MODEL, HAND_STIFFNESS, LESS_THAN_IDEAL, MASS, SAMPLE_TIME,
};
use crate::experiment::trial::TRIAL_FORCE_LIMIT;

/// Of a simulated one.
pub(crate) const SIMULATED: &[Parameter] = &joined::<10>(&[
    &[DEVICE_MODEL, MASS, DAMPING, HAND_STIFFNESS],
    LESS_THAN_IDEAL,
]);

/// The device of both.
pub const BENCH: &[Parameter] = &joined::<12>(&[&[SAMPLE_TIME, TRIAL_FORCE_LIMIT], SIMULATED]);
