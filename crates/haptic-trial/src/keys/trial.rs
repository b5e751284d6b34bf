//! Keys of a device that hits a wall and is pushed into it.

use haptic_document::{
    Named, parameters,
    parameters::{
        PUSH_BY, Parameter, SCHEME, TRIAL_DURATION,
        range::{DURATIONS, FORCE_LIMITS, FORCE_RATES, FORCES_ABOVE_0, IMPACTS, REACHES_ABOVE_0},
    },
};

parameters! {
    /// Impact of a trial, m/s.
    IMPACT = number("impact_m_per_s", 0.1, "", IMPACTS,
        "Speed at which the device hits the wall, m/s [default: 0.1; a serial device is only pushed]");
    /// Push of a trial, N.
    PUSH = number("push_n", 1.0, "1N", FORCES_ABOVE_0, "Constant push into the wall");
    /// Window of a trial, s.
    WINDOW = number("window_s", 0.4, "0.4s", DURATIONS, "Time at the end that is judged");
    CRITERION = text("criterion", "settling", "Rule by which the wall counts as stable");
    /// Threshold of the dissertation's rule, m.
    THRESHOLD = number("threshold_m", 1e-4, "0.1mm", REACHES_ABOVE_0,
        "Largest standard deviation of the position by the criterion dissertation");
    /// Force limit of a trial, N.
    TRIAL_FORCE_LIMIT = number("force_limit_n", 100.0, "100N", FORCE_LIMITS, "Largest force of the actuator");
    /// Rate limit of a trial, N/s.
    TRIAL_FORCE_RATE_LIMIT = optional("force_rate_limit_n_per_s", FORCE_RATES,
        "Largest rate of change of the force [default: that of a serial device, none on the simulated one]");
}

/// Keys of the safety chain and the operator in a trial.
pub const TRIAL_LOOP: &[Parameter] = &[TRIAL_FORCE_LIMIT, TRIAL_FORCE_RATE_LIMIT, SCHEME];

/// Keys of a push and its judgement.
pub const TRIAL: &[Parameter] = &[
    IMPACT,
    PUSH,
    PUSH_BY,
    TRIAL_DURATION,
    WINDOW,
    CRITERION,
    THRESHOLD,
];

/// Source of the push that tries a law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PushBy {
    /// Somebody, a hung weight or the simulated hand.
    Hand,
    /// The device's own motor, behind the law and within its limits.
    Device,
    /// A second device, that of a `[drive]`.
    Second,
}

impl Named for PushBy {
    const CHOICES: &'static [(Self, &'static str, &'static str)] = &[
        (
            Self::Hand,
            "hand",
            "Somebody, a hung weight, or the simulated hand",
        ),
        (
            Self::Device,
            "device",
            "The device's own motor, behind the law and within its limits",
        ),
    ];

    fn name(self) -> &'static str {
        match self {
            Self::Hand => "hand",
            Self::Device => "device",
            // No choice of this key: `[drive]` is.
            Self::Second => "second_device",
        }
    }
}
