//! Of every table: the safety chain.

use super::kind::parameters;
use super::range::{
    DAMPINGS_ABOVE_0, DEVICE_TIMES, FORCES, MASSES, PLACES, REACHES, Range, SAFETY_TIMES,
    SENSOR_STEPS, SPEEDS,
};
use haptic_loop::Limits;

parameters! {
    /// Of the safety chain, for every experiment.
    all SAFETY;
    /// Passivity guard.
    GUARD = text("guard", "off", "Keep the loop from feeding the device energy");
    /// Low end of the workspace, m.
    WORKSPACE_LOW = optional("workspace_low_m", PLACES, "Lowest position; below it a fault ends the run");
    /// High end of the workspace, m.
    WORKSPACE_HIGH = optional("workspace_high_m", PLACES, "Highest position; above it a fault ends the run");
    /// Speed limit, m/s.
    SPEED_LIMIT = optional("speed_limit_m_per_s", SPEEDS, "Largest speed; above it a fault ends the run");
    /// Rise time, s.
    RISE_TIME = optional("rise_time_s", SAFETY_TIMES, "Ramp the force up over this time at the start");
    /// Braking, N·s/m.
    BRAKING = optional("braking_n_s_per_m", DAMPINGS_ABOVE_0,
        "Damping that brakes near workspace and speed limits, and after a fault or stop");
    /// Stop time, s.
    STOP_TIME = optional("stop_time_s", Range::Within(Limits::STOP_TIME_S[0], Limits::STOP_TIME_S[1]),
        "Time to zero force after a fault, a stop or the end, 1ms to 1s [default: 0.1s]");
    /// Brake force, N.
    BRAKE_FORCE = optional("brake_force_n", Range::Within(0.0, Limits::BRAKE_FORCE_MAX_N),
        "Largest braking force during that time, 0N to 10N [default: 2N]");
    /// Stuck sensor, N.
    STUCK_FORCE = optional("stuck_force_n", FORCES,
        "Fault if the force rises by this much while the position is frozen; 0 = off [default: 3N on a \
         serial device, else never]");
    /// Stuck sensor, s.
    STUCK_TIME = optional("stuck_time_s", Range::Within(1e-3, 10.0),
        "Time for which the position must be frozen [default: 0.1s]");
    /// Jump of a sensor, m.
    JUMP = optional("jump_m", REACHES,
        "Fault if the position moves in one sample by this much more than the speed limit allows; 0 = off \
         [default: 1mm on a serial device, else never]");
    /// Mass of a real device, kg.
    DEVICE_MASS = optional("device_mass_kg", MASSES, "Mass of a real device, for guard observer, braking and pre-flight");
    /// Damping of a real device, N·s/m.
    DEVICE_DAMPING = optional("device_damping_n_s_per_m", DAMPINGS_ABOVE_0,
        "Damping of a real device, for guard energy-bounding and pre-flight");
    /// Least delay of a real device, s.
    DEVICE_DELAY_LEAST = optional("device_delay_least_s", DEVICE_TIMES,
        "Least delay of a real device from a measurement to the effect of its force, for guard energy-bounding");
    /// Largest delay of a real device, s.
    DEVICE_DELAY_MOST = optional("device_delay_most_s", DEVICE_TIMES, "Largest delay; equal to the least if known exactly");
    /// Lag of a real device, s.
    DEVICE_LAG = optional("device_lag_s", DEVICE_TIMES,
        "Time constant of the force of a real device, for guard energy-bounding");
    /// Noise of a real device, m.
    DEVICE_NOISE = optional("device_noise_m", SENSOR_STEPS,
        "Standard deviation of a real device's position noise, for guard energy-bounding [default: 0.29 \
         of its resolution]");
}
