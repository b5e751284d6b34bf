//! Keys of a device that moves: its virtual body, the robot below it, and the hands that push it.

use haptic_document::parameters;
use haptic_document::parameters::range::{
    DAMPINGS, DEVICE_TIMES, DISSIPATIONS, FREQUENCIES_HZ, OBJECT_MASSES, Range, STIFFNESSES,
    WALL_ORDERS,
};
use haptic_document::parameters::{Parameter, SCHEME};

parameters! {
    /// α of the body.
    BODY_ORDER = number("body_order", 1.0, "1", WALL_ORDERS, "Order alpha of the virtual body m*D^alpha + b, from velocity to force: 1 a mass, 0 a damper");
    /// m of the body, N·s^(1+α)/m.
    BODY_INERTANCE = optional("body_inertance_n_s_mu_per_m", DISSIPATIONS, "m of the body, in N s^(1+alpha)/m: kg at order 1");
    /// b of the body, N·s/m.
    BODY_DAMPING = optional("body_damping_n_s_per_m", DAMPINGS, "b of the body");
    /// Lag of a lagged mass, s.
    BODY_LAG = optional("body_lag_s", DEVICE_TIMES, "Lag of a mass: the body is m*s/(1 + lag*s) + b, at order 1");
    /// Scheme of the body's operator.
    BODY_SCHEME = text("body_scheme", "exact", SCHEME.help);
    /// Natural frequency of the robot's velocity loop, Hz.
    ROBOT_BANDWIDTH = optional("bandwidth_hz", FREQUENCIES_HZ, "Natural frequency of the robot's own velocity loop");
    /// Damping ratio of that loop.
    ROBOT_DAMPING = number("damping_ratio", 0.8, "0.8", Range::Within(0.05, 10.0), "Damping ratio of that loop");
    /// Dead time of that loop, s.
    ROBOT_DEAD_TIME = optional("dead_time_s", DEVICE_TIMES, "Dead time between a command and the robot's motion");
    /// Corner of the force filter, Hz.
    FORCE_CUTOFF = optional("force_cutoff_hz", FREQUENCIES_HZ, "Corner frequency of each lag of the force sensor [default: it has none]");
    /// Lags of the force filter.
    FORCE_LAGS = count("force_lags", 2, "2", "Number of these lags, 1 to 4");
    /// Mass of the tool, kg.
    TOOL_MASS = number("tool_mass_kg", 0.0, "0", OBJECT_MASSES, "Mass between force sensor and hand");
    /// Least and largest mass of the hand, kg.
    HANDS_MASS = list_of("hand_mass_kg", "0.5,3", OBJECT_MASSES, "Least and largest mass of the hand, or one for both");
    /// Least and largest damping of the hand, N·s/m.
    HANDS_DAMPING = list_of("hand_damping_n_s_per_m", "5,60", DAMPINGS, "Least and largest damping of the hand, or one for both");
    /// Least and largest stiffness of the hand, N/m.
    HANDS_STIFFNESS = list_of("hand_stiffness_n_per_m", "0,400", STIFFNESSES, "Least and largest stiffness of the hand and of what the handle touches in it, or one for both");
}

/// Keys of a virtual body.
pub const BODY: &[Parameter] = &[
    BODY_ORDER,
    BODY_INERTANCE,
    BODY_DAMPING,
    BODY_LAG,
    BODY_SCHEME,
];
/// Keys of a robot that takes a velocity.
pub const ROBOT: &[Parameter] = &[
    ROBOT_BANDWIDTH,
    ROBOT_DAMPING,
    ROBOT_DEAD_TIME,
    FORCE_CUTOFF,
    FORCE_LAGS,
    TOOL_MASS,
];
/// Keys of the hands that push it.
pub const PUSHING_HANDS: &[Parameter] = &[HANDS_MASS, HANDS_DAMPING, HANDS_STIFFNESS];
