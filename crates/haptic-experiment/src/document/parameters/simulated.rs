//! Keys of a simulated device.

use crate::document::parameters::kind::{Parameter, parameters};
use crate::document::parameters::range::{
    DAMPINGS, DEVICE_TIMES, FORCES, MASSES, SENSOR_STEPS, STIFFNESSES,
};

parameters! {
    /// Encoder of a simulated device, m.
    ENCODER_RESOLUTION = number("encoder_resolution_m", 0.0, "0", SENSOR_STEPS,
        "Encoder resolution per count; 0 = ideal");
    /// Noise of a simulated sensor, m.
    SENSOR_NOISE = number("sensor_noise_m", 0.0, "0", SENSOR_STEPS, "Standard deviation of the sensor noise; 0 = none");
    /// Seed of the noise.
    SEED = count("seed", 1, "1", "Noise seed: the same seed gives the same run, bit for bit");
    /// Mass of a simulated device, kg.
    MASS = number("mass_kg", 0.065, "65g", MASSES, "Mass of the device");
    /// Damping of a simulated device, N·s/m.
    DAMPING = number("damping_n_s_per_m", 3.5, "3.5", DAMPINGS, "Viscous damping of the device");
    /// Stiffness of the hand, N/m.
    HAND_STIFFNESS = number("hand_stiffness_n_per_m", 0.0, "0", STIFFNESSES, "Stiffness of the hand that holds it; 0 without a hand");
    /// Delay of a simulated device, s.
    DELAY = number("delay_s", 0.0, "0", DEVICE_TIMES, "Delay from a measurement to its force, beyond the hold");
    /// Friction of a simulated device, N.
    FRICTION = number("friction_n", 0.0, "0", FORCES, "Coulomb friction");
    /// Current lag of a simulated device, s.
    CURRENT_LAG = number("current_lag_s", 0.0, "0", DEVICE_TIMES, "Time constant of the actuator's current");
}

/// Of a simulated device that is less than ideal.
pub(crate) const LESS_THAN_IDEAL: &[Parameter] = &[
    DELAY,
    FRICTION,
    CURRENT_LAG,
    ENCODER_RESOLUTION,
    SENSOR_NOISE,
    SEED,
];
