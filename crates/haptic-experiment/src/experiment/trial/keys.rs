//! Keys of a trial, in `[wall]` and `[coupler]`.

use crate::document::parameters::kind::{Parameter, parameters};
use crate::document::parameters::range::{
    DURATIONS, FORCE_LIMITS, FORCE_RATES, FORCES_ABOVE_0, IMPACTS,
};
use crate::document::parameters::{SCHEME, TRIAL_DURATION};

parameters! {
    /// Impact of a trial, m/s.
    IMPACT = number("impact_m_per_s", 0.1, "", IMPACTS,
        "Speed at which the device hits the wall, m/s [default: 0.1, and 0 where it is only pushed]");
    /// Push of a trial, N.
    PUSH = number("push_n", 1.0, "1N", FORCES_ABOVE_0, "Constant push into the wall");
    /// Window of a trial, s.
    WINDOW = number("window_s", 0.4, "0.4s", DURATIONS, "Window at the end to judge");
    /// Force limit of a trial, N.
    TRIAL_FORCE_LIMIT = number("force_limit_n", 100.0, "100N", FORCE_LIMITS, "Largest force of the actuator");
    /// Rate limit of a trial, N/s.
    TRIAL_FORCE_RATE_LIMIT = optional("force_rate_limit_n_per_s", FORCE_RATES,
        "Largest rate of change of the force [default: that of a serial device, none on the simulated one]");
}

/// Of the safety chain and the operator in a trial.
pub(crate) const TRIAL_LOOP: &[Parameter] = &[TRIAL_FORCE_LIMIT, TRIAL_FORCE_RATE_LIMIT, SCHEME];

/// Of a trial.
pub(crate) const TRIAL: &[Parameter] = &[IMPACT, PUSH, TRIAL_DURATION, WINDOW];
