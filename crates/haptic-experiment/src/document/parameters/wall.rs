//! Of `[wall]`: device, wall and trial.

use super::device::DEVICE_MODEL;
use super::experiment::{ENCODER_RESOLUTION, SAMPLE_TIME, SCHEME, SEED, SENSOR_NOISE};
use super::kind::{Parameter, joined, parameters};
use super::range::{
    DAMPINGS, DEVICE_TIMES, DISSIPATIONS, DURATIONS, FORCE_LIMITS, FORCE_RATES, FORCES,
    FORCES_ABOVE_0, IMPACTS, MASSES, STIFFNESSES, WALL_ORDERS,
};

parameters! {
    /// Mass of a simulated device, kg.
    MASS = number("mass_kg", 0.065, "65g", MASSES, "Mass of the device");
    /// Damping of a simulated device, N·s/m.
    DAMPING = number("damping_n_s_per_m", 3.5, "3.5", DAMPINGS, "Viscous damping of the device");
    /// Stiffness of the hand, N/m.
    HAND_STIFFNESS = number("hand_stiffness_n_per_m", 0.0, "0", STIFFNESSES, "Stiffness of the hand that holds it; 0 without a hand");
    /// Delay of a simulated device, s.
    DELAY = number("delay_s", 0.0, "0", DEVICE_TIMES, "Delay from a measurement to the force that answers it, beside the hold");
    /// Friction of a simulated device, N.
    FRICTION = number("friction_n", 0.0, "0", FORCES, "Coulomb friction");
    /// Current lag of a simulated device, s.
    CURRENT_LAG = number("current_lag_s", 0.0, "0", DEVICE_TIMES, "Time constant of the actuator's current");
    /// Order of a wall.
    ORDER = optional("order", WALL_ORDERS, "Order of the dissipation: 0 a spring, 1 a damper");
    /// Stiffness of a wall, N/m.
    STIFFNESS = optional("stiffness_n_per_m", STIFFNESSES, "Stiffness K of the wall");
    /// Dissipation of a wall, N·s^μ/m.
    DISSIPATION = optional("dissipation_n_s_mu_per_m", DISSIPATIONS, "Dissipation B of the wall, N·s^μ/m");
    /// True if a wall only pushes.
    ONE_SIDED = flag("one_sided", "A wall that pushes but never pulls; without this it is linear, as the theory assumes");
    /// Impact of a trial, m/s.
    IMPACT = number("impact_m_per_s", 0.1, "", IMPACTS,
        "Speed at which the device hits the wall, m/s [default: 0.1, and 0 where it is only pushed]");
    /// Push of a trial, N.
    PUSH = number("push_n", 1.0, "1N", FORCES_ABOVE_0, "Constant push into the wall");
    /// Length of a trial, s.
    TRIAL_DURATION = number("duration_s", 5.0, "5s", DURATIONS, "Length of a run");
    /// Window of a trial, s.
    WINDOW = number("window_s", 0.4, "0.4s", DURATIONS, "Window at the end that is judged");
    /// Force limit of a trial, N.
    TRIAL_FORCE_LIMIT = number("force_limit_n", 100.0, "100N", FORCE_LIMITS, "Largest force of the actuator");
    /// Rate limit of a trial, N/s.
    TRIAL_FORCE_RATE_LIMIT = optional("force_rate_limit_n_per_s", FORCE_RATES,
        "Largest rate at which the force may change [default: that of a serial device, none on the simulated one]");
    /// True if an unstable wall is a failure.
    MUST_BE_STABLE = flag("must_be_stable", "A wall that is not stable by trial and analysis is a failure");
}

/// Of `[wall]` that have to be given in a file.
pub const WALL_REQUIRED: &[Parameter] =
    &[MASS, DAMPING, SAMPLE_TIME, ORDER, STIFFNESS, DISSIPATION];
/// Of a simulated device that is less than ideal.
pub(crate) const LESS_THAN_IDEAL: &[Parameter] = &[
    DELAY,
    FRICTION,
    CURRENT_LAG,
    ENCODER_RESOLUTION,
    SENSOR_NOISE,
    SEED,
];
/// Of the safety chain and the operator in a trial.
pub(super) const TRIAL_LOOP: &[Parameter] = &[TRIAL_FORCE_LIMIT, TRIAL_FORCE_RATE_LIMIT, SCHEME];
/// Of a trial.
pub(super) const TRIAL: &[Parameter] = &[IMPACT, PUSH, TRIAL_DURATION, WINDOW];
/// Of `[wall]`, with defaults.
pub const WALL: &[Parameter] = &joined::<17>(&[
    &[DEVICE_MODEL, HAND_STIFFNESS],
    LESS_THAN_IDEAL,
    TRIAL_LOOP,
    &[ONE_SIDED],
    TRIAL,
    &[MUST_BE_STABLE],
]);
