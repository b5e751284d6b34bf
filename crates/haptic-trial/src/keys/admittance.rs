//! Keys of a device that moves: its virtual body, the robot below it, and the hands that push it.

use haptic_document::{
    parameters,
    parameters::{
        Parameter, SCHEME, joined,
        range::{
            ACCELERATIONS, DAMPINGS, DEVICE_TIMES, DISSIPATIONS, FORCES, FORCES_ABOVE_0,
            FREQUENCIES_HZ, MOTION_SPEEDS, OBJECT_MASSES, Range, STIFFNESSES, WALL_ORDERS,
            WORKSPACES,
        },
    },
};

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
    /// Largest speed of the command, m/s.
    MOTION_SPEED = number("motion_limit_m_per_s", 0.5, "0.5m/s", MOTION_SPEEDS, "Largest speed of the command");
    /// Largest change of the command, m/s².
    MOTION_ACCELERATION = number("motion_limit_m_per_s2", 20.0, "20m/s^2", ACCELERATIONS, "Largest acceleration of the command, and that with which it comes to rest after a fault or stop");
    /// Low end of the command's way, m.
    MOTION_LOW = number("motion_low_m", -0.3, "-30cm", WORKSPACES, "Lowest position of the command, which brakes before it");
    /// High end of the command's way, m.
    MOTION_HIGH = number("motion_high_m", 0.3, "30cm", WORKSPACES, "Highest position of the command");
    /// Range of the force sensor, N.
    ROBOT_RANGE = number("sensed_range_n", 100.0, "100N", FORCES_ABOVE_0, "Largest force that the sensor shows either way: half of it stops the robot");
    /// Noise of the force sensor, N.
    ROBOT_NOISE = number("sensed_noise_n", 0.0, "0", FORCES, "Standard deviation of the noise of a simulated robot's sensor");
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
/// Keys of the limits of its motion, and of its sensor.
pub const MOTION: &[Parameter] = &[
    MOTION_SPEED,
    MOTION_ACCELERATION,
    MOTION_LOW,
    MOTION_HIGH,
    ROBOT_RANGE,
    ROBOT_NOISE,
];
/// Keys of `[admittance]`.
pub const ADMITTANCE_TABLE: &[Parameter] = &joined::<20>(&[BODY, ROBOT, PUSHING_HANDS, MOTION]);
