//! Parameters of analyses, besides those of experiments: a loop without units, its frequencies, and two hands over a line.

use crate::document::parameters::SCHEME;
use crate::document::parameters::kind::parameters;
use crate::document::parameters::range::{
    ANGULAR_FREQUENCIES, DELAY_SAMPLES as SAMPLES, DELTAS, FREQUENCIES_HZ, WALL_NUMBERS,
    WALL_ORDERS,
};

parameters! {
    ANALYSED_SCHEME = text("scheme", "exact", SCHEME.help);
    /// Order of a coupler that is analysed.
    COUPLING_ORDER = optional("order", WALL_ORDERS, "Order of the coupler: 1 a spring beside a damper, below 1 the spring creeps");
    ALPHA = optional("alpha", WALL_NUMBERS, "Without units: stiffness K T^2/m");
    BETA = optional("beta", WALL_NUMBERS, "Without units: dissipation B T^(2-mu)/m");
    DELTA = optional("delta", DELTAS, "Without units: damping of the device b T/m [default: 0]");
    GAMMA = optional("gamma", WALL_NUMBERS, "Without units: stiffness of the hand k T^2/m [default: 0]");
    DELAY_SAMPLES = optional("delay_samples", SAMPLES, "The delay in samples, whole or not");
    OMEGA_MIN = optional("omega_min_rad_s", ANGULAR_FREQUENCIES, "Lowest frequency [default: a thousandth of the highest]");
    OMEGA_MAX = optional("omega_max_rad_s", ANGULAR_FREQUENCIES, "Highest frequency [default: pi/T]");
    POINTS = count("points", 200, "200", "Number of frequencies");
    /// Number of frequencies of a sensitivity.
    SENSITIVITY_POINTS = count("points", 400, "400", "Number of frequencies");
    /// Lowest frequency of a remote tissue, Hz.
    FELT_LOW = number("low_hz", 0.5, "0.5Hz", FREQUENCIES_HZ, "Lowest frequency at which the tissue should feel right");
    /// Highest frequency of a remote tissue, Hz.
    FELT_HIGH = number("high_hz", 5.0, "5Hz", FREQUENCIES_HZ, "Highest frequency at which the tissue should feel right");
    /// Number of frequencies of a remote tissue.
    FELT_POINTS = count("points", 20, "20", "Number of frequencies");
    PLAYOUT_SAMPLES = count("playout", 2, "2", "Samples over which waves are played out");
    /// Search for the best coupler.
    BEST = flag("best", "Find the best coupler of each order, or the best wave impedance");
}
