//! Of analyses: a loop with units or without, where it is looked at, and two hands over a line.

use crate::document::parameters::kind::parameters;
use crate::document::parameters::range::{
    ANGULAR_FREQUENCIES, DELAY_SAMPLES as SAMPLES, DELTAS, FREQUENCIES_HZ, WALL_NUMBERS,
    WALL_ORDERS,
};
use crate::document::parameters::{
    AREA, COUPLER_DISSIPATION, COUPLER_STIFFNESS, CURRENT_LAG, DAMPING, DELAY, DEVICE_MODEL,
    HAND_STIFFNESS, LIBRARY, MASS, Parameter, SAMPLE_TIME, SCHEME, THICKNESS, TISSUE,
};
use crate::experiment::teleoperation::{
    ARCHITECTURE, HAND_COUPLER_DISSIPATION, HAND_COUPLER_ORDER, HAND_COUPLER_STIFFNESS, LINE_DELAY,
    SLAVE_DAMPING, SLAVE_MASS, WAVE_IMPEDANCE,
};
use crate::experiment::wall::{DISSIPATION, ORDER, STIFFNESS};

parameters! {
    /// Operator of an analysis.
    ANALYSED_SCHEME = text("scheme", "exact", SCHEME.help);
    /// Order of a coupler that is analysed.
    COUPLING_ORDER = optional("order", WALL_ORDERS, "Order of the coupler: 1 a spring beside a damper, below 1 the spring creeps");
    /// α.
    ALPHA = optional("alpha", WALL_NUMBERS, "Without units: stiffness K T^2/m");
    /// β.
    BETA = optional("beta", WALL_NUMBERS, "Without units: dissipation B T^(2-mu)/m");
    /// δ.
    DELTA = optional("delta", DELTAS, "Without units: damping of the device b T/m [default: 0]");
    /// γ.
    GAMMA = optional("gamma", WALL_NUMBERS, "Without units: stiffness of the hand k T^2/m [default: 0]");
    /// Delay, samples.
    DELAY_SAMPLES = optional("delay_samples", SAMPLES, "The delay in samples, whole or not");
    /// Lowest frequency, rad/s.
    OMEGA_MIN = optional("omega_min_rad_s", ANGULAR_FREQUENCIES, "Lowest frequency [default: a thousandth of the highest]");
    /// Highest frequency, rad/s.
    OMEGA_MAX = optional("omega_max_rad_s", ANGULAR_FREQUENCIES, "Highest frequency [default: pi/T]");
    /// Number of frequencies.
    POINTS = count("points", 200, "200", "Number of frequencies");
    /// Number of frequencies of a sensitivity.
    SENSITIVITY_POINTS = count("points", 400, "400", "Number of frequencies");
    /// Lowest frequency of a remote tissue, Hz.
    FELT_LOW = number("low_hz", 0.5, "0.5Hz", FREQUENCIES_HZ, "Lowest frequency at which the tissue should feel right");
    /// Highest frequency of a remote tissue, Hz.
    FELT_HIGH = number("high_hz", 5.0, "5Hz", FREQUENCIES_HZ, "Highest frequency at which the tissue should feel right");
    /// Number of frequencies of a remote tissue.
    FELT_POINTS = count("points", 20, "20", "Number of frequencies");
    /// Playout of waves, samples.
    PLAYOUT_SAMPLES = count("playout", 2, "2", "Samples over which waves are played out");
    /// Search for the best coupler.
    BEST = flag("best", "Find the best coupler of each order, or the best wave impedance");
}

/// Mass of a device that is analysed.
pub const ANALYSED_MASS: Parameter = MASS.without_default();
/// Its damping.
pub const ANALYSED_DAMPING: Parameter = DAMPING.without_default();
/// The hand on it.
pub const ANALYSED_HAND: Parameter = HAND_STIFFNESS.without_default();
/// Sample time of what is analysed.
pub const ANALYSED_SAMPLE_TIME: Parameter = SAMPLE_TIME.without_default();
/// Delay of what is analysed.
pub const ANALYSED_DELAY: Parameter = DELAY.without_default();
/// Current lag of what is analysed.
pub const ANALYSED_LAG: Parameter = CURRENT_LAG.without_default();

/// A wall on a device.
pub const LOOP: &[&Parameter] = &[
    &ORDER,
    &ANALYSED_SCHEME,
    &DEVICE_MODEL,
    &ANALYSED_MASS,
    &ANALYSED_DAMPING,
    &ANALYSED_HAND,
    &ANALYSED_SAMPLE_TIME,
    &STIFFNESS,
    &DISSIPATION,
    &ANALYSED_DELAY,
    &ANALYSED_LAG,
];
/// The same without units.
pub const LOOP_WITHOUT_UNITS: &[&Parameter] = &[&ALPHA, &BETA, &DELTA, &GAMMA, &DELAY_SAMPLES];
/// A wall and frequencies.
pub const ENVIRONMENT: &[&Parameter] = &[
    &ORDER,
    &ANALYSED_SCHEME,
    &STIFFNESS,
    &DISSIPATION,
    &ANALYSED_SAMPLE_TIME,
    &OMEGA_MIN,
    &OMEGA_MAX,
    &POINTS,
];
/// The device that it is on.
pub const TRANSPARENCY: &[&Parameter] = &[
    &DEVICE_MODEL,
    &ANALYSED_MASS,
    &ANALYSED_DAMPING,
    &ANALYSED_DELAY,
    &ANALYSED_LAG,
    &DELAY_SAMPLES,
];
/// A virtual coupler.
pub const COUPLING: &[&Parameter] = &[
    &COUPLING_ORDER,
    &ANALYSED_SCHEME,
    &COUPLER_STIFFNESS,
    &COUPLER_DISSIPATION,
    &ANALYSED_SAMPLE_TIME,
    &ANALYSED_DAMPING,
];
/// Two hands over a line.
pub const HANDS: &[&Parameter] = &[
    &ARCHITECTURE,
    &LINE_DELAY,
    &HAND_COUPLER_STIFFNESS,
    &HAND_COUPLER_DISSIPATION,
    &HAND_COUPLER_ORDER,
    &WAVE_IMPEDANCE,
    &PLAYOUT_SAMPLES,
    &BEST,
    &TISSUE,
    &FELT_LOW,
    &FELT_HIGH,
    &FELT_POINTS,
];
/// Their devices, and the tissue.
pub const HANDS_ON: &[&Parameter] = &[
    &MASS,
    &DAMPING,
    &SLAVE_MASS,
    &SLAVE_DAMPING,
    &SAMPLE_TIME,
    &LIBRARY,
    &AREA,
    &THICKNESS,
];
