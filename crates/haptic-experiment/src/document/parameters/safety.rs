//! Of every table: the safety chain.

use super::kind::{Parameter, parameters};
use super::range::{
    DAMPINGS_ABOVE_0, DEVICE_TIMES, FORCES, MASSES, PLACES, REACHES, Range, SAFETY_TIMES,
    SENSOR_STEPS, SPEEDS,
};
use haptic_loop::Limits;

parameters! {
    /// Passivity guard.
    GUARD = text("guard", "off", "Keep the loop from feeding the device energy");
    /// Low end of the workspace, m.
    WORKSPACE_LOW = optional("workspace_low_m", PLACES, "Lowest position; below it a fault ends the run");
    /// High end of the workspace, m.
    WORKSPACE_HIGH = optional("workspace_high_m", PLACES, "Highest position; above it a fault ends the run");
    /// Speed limit, m/s.
    SPEED_LIMIT = optional("speed_limit_m_per_s", SPEEDS, "How fast the device may move; beyond it a fault ends the run");
    /// Rise time, s.
    RISE_TIME = optional("rise_time_s", SAFETY_TIMES, "Let the force rise in this time from the start on");
    /// Braking, N·s/m.
    BRAKING = optional("braking_n_s_per_m", DAMPINGS_ABOVE_0,
        "Brake with this damping near workspace and speed limit, and after a fault or stop");
    /// Stop time, s.
    STOP_TIME = optional("stop_time_s", Range::Within(Limits::STOP_TIME_S[0], Limits::STOP_TIME_S[1]),
        "Time within which the force falls to zero after a fault, a stop or the end, 1ms to 1s [default: 0.1s]");
    /// Brake force, N.
    BRAKE_FORCE = optional("brake_force_n", Range::Within(0.0, Limits::BRAKE_FORCE_MAX_N),
        "Largest force of the braking meanwhile, 0N to 10N [default: 2N]");
    /// Stuck sensor, N.
    STUCK_FORCE = optional("stuck_force_n", FORCES,
        "Fault if the force rises by this much while the position stands still; 0 for off [default: 3N on a \
         serial device, else never]");
    /// Stuck sensor, s.
    STUCK_TIME = optional("stuck_time_s", Range::Within(1e-3, 10.0),
        "Time that the position has to stand still for that [default: 0.1s]");
    /// Jump of a sensor, m.
    JUMP = optional("jump_m", REACHES,
        "A position that moves in a sample by this more than the speed limit allows is a fault; 0 for never \
         [default: 1mm on a serial device, else never]");
    /// Mass of a real device, kg.
    DEVICE_MASS = optional("device_mass_kg", MASSES, "Mass of a real device, for the guard observer, braking and the pre-flight");
    /// Damping of a real device, N·s/m.
    DEVICE_DAMPING = optional("device_damping_n_s_per_m", DAMPINGS_ABOVE_0,
        "Damping of a real device, for the guard energy-bounding and the pre-flight");
    /// Least delay of a real device, s.
    DEVICE_DELAY_LEAST = optional("device_delay_least_s", DEVICE_TIMES,
        "Least delay of a real device from a measurement to the effect of its force, for the guard energy-bounding");
    /// Largest delay of a real device, s.
    DEVICE_DELAY_MOST = optional("device_delay_most_s", DEVICE_TIMES, "Largest delay; equal to the least if it is known exactly");
    /// Lag of a real device, s.
    DEVICE_LAG = optional("device_lag_s", DEVICE_TIMES,
        "Time constant with which the force of a real device follows, for the guard energy-bounding");
    /// Noise of a real device, m.
    DEVICE_NOISE = optional("device_noise_m", SENSOR_STEPS,
        "Standard deviation of the noise of a real device's position, for the guard energy-bounding [default: 0.29 \
         of its resolution]");
}

/// Of the safety chain, for every experiment.
pub const SAFETY: &[Parameter] = &[
    GUARD,
    WORKSPACE_LOW,
    WORKSPACE_HIGH,
    SPEED_LIMIT,
    RISE_TIME,
    BRAKING,
    STOP_TIME,
    BRAKE_FORCE,
    STUCK_FORCE,
    STUCK_TIME,
    JUMP,
    DEVICE_MASS,
    DEVICE_DAMPING,
    DEVICE_DELAY_LEAST,
    DEVICE_DELAY_MOST,
    DEVICE_LAG,
    DEVICE_NOISE,
];
