//! Keys of `[touch]`.

use crate::document::parameters::kind::{Parameter, joined, parameters};
use crate::document::parameters::range::{
    DAMPINGS, DISSIPATIONS, DURATIONS, MASSES, NUMBERS, PLACES, RADII, Range, STIFFNESSES,
    STIFFNESSES_ABOVE_0, WALL_ORDERS,
};
use crate::document::parameters::{
    AREA, FORCE_LIMIT, LESS_THAN_IDEAL, LIBRARY, SAMPLE_TIME, SCHEME, THICKNESS, TOUCH_AXES,
};
use crate::experiment::trial::keys::TRIAL_FORCE_RATE_LIMIT;

parameters! {
    /// The shape that is touched.
    TOUCH_SHAPE = text("shape", "ball",
        "Shape to touch");
    /// Normal of a plane.
    TOUCH_NORMAL = list("normal", NUMBERS,
        "Plane: direction into it, one number per axis, of any length [default: along the first axis]");
    /// Place of a plane, m.
    TOUCH_SURFACE = number("surface_m", 0.0, "0", PLACES, "Plane: its distance from 0 along that direction");
    /// Centre of a ball, m.
    TOUCH_CENTRE = list("centre_m", PLACES, "Ball: its centre, one number per axis [default: zeros]");
    /// Radius of a ball, m.
    TOUCH_RADIUS = number("radius_m", 0.02, "20mm", RADII, "Ball: its radius");
    /// Tissue of the shape.
    TOUCH_TISSUE = text("tissue", "",
        "Tissue of the shape: a name from `host-cli materials list`, or a TOML file [default: K, B and order]");
    /// K, N/m.
    TOUCH_STIFFNESS = number("stiffness_n_per_m", 300.0, "300", STIFFNESSES, "K of the shape, without a tissue");
    /// B, N·s^μ/m.
    TOUCH_DISSIPATION = number("dissipation_n_s_mu_per_m", 5.0, "5", DISSIPATIONS, "B of the shape, N·s^μ/m");
    /// μ.
    TOUCH_ORDER = number("order", 0.5, "0.5", WALL_ORDERS, "Order of the dissipation: 0 a spring, 1 a damper");
    /// Mass of the device, kg.
    TOUCH_MASS = list("mass_kg", MASSES, "Mass of the device, above 0: one number, or one per axis [default: 0.065]");
    /// Damping of device and hand, N·s/m.
    TOUCH_DAMPING = number("damping_n_s_per_m", 3.5, "3.5", DAMPINGS, "Damping of device and hand on each axis");
    /// The hand.
    TOUCH_HAND = text("hand", "spring", "What the hand is");
    /// Stiffness of the hand, N/m.
    TOUCH_HAND_STIFFNESS = number("hand_stiffness_n_per_m", 300.0, "300", STIFFNESSES_ABOVE_0, "Stiffness of that spring");
    /// Path of the hand.
    TOUCH_WAY = list("way_points", WAY,
        "Path of the hand instead of a circle: rows of time in s and position in m (or force in N), one number per axis, \
         straight in between");
    /// Centre of the circle of the hand, m.
    TOUCH_CIRCLE_CENTRE = list("circle_centre_m", PLACES, "Circle: its centre [default: that of the ball, else zeros]");
    /// Radius of the circle of the hand, m.
    TOUCH_CIRCLE_RADIUS = number("circle_radius_m", 0.018, "18mm", RADII, "Circle, in the plane of the first two axes: its radius");
    /// Radius at the start of the circle, m.
    TOUCH_CIRCLE_START = optional("circle_start_radius_m", RADII,
        "Circle: radius at time 0, from which it is reached in 1 s [default: that of the ball]");
    /// Time of a turn, s.
    TOUCH_CIRCLE_PERIOD = number("circle_period_s", 2.0, "2s", DURATIONS, "Circle: time per turn");
    /// Length of a run, s.
    TOUCH_DURATION = number("duration_s", 5.0, "5s", DURATIONS, "Length of a run, at most a million samples");
    /// Low corner of the workspace, m.
    TOUCH_BOX_LOW = list("box_low_m", PLACES, "Low corner of a box, one number per axis; outside it a fault ends the run");
    /// High corner of the workspace, m.
    TOUCH_BOX_HIGH = list("box_high_m", PLACES, "High corner of that box");
    /// True if energy for the hand is a failure.
    TOUCH_MUST_BE_PASSIVE = flag("must_be_passive", "Fail if the hand gets energy or a force reaches its limit");
}

/// Times, places and forces alike.
const WAY: Range = Range::Within(-1e4, 1e7);

/// Mass on an axis that is not given, kg.
pub(crate) const TOUCH_MASS_DEFAULT: f64 = MASS_KG;

/// Of `[touch]`.
pub const TOUCH: &[Parameter] = &joined::<36>(&[TOUCHED, LESS_THAN_IDEAL, TOUCHING]);

/// The shape, what it is of, and the device.
const TOUCHED: &[Parameter] = &[
    TOUCH_AXES,
    TOUCH_SHAPE,
    TOUCH_NORMAL,
    TOUCH_SURFACE,
    TOUCH_CENTRE,
    TOUCH_RADIUS,
    TOUCH_TISSUE,
    LIBRARY,
    AREA,
    THICKNESS,
    TOUCH_STIFFNESS,
    TOUCH_DISSIPATION,
    TOUCH_ORDER,
    SCHEME,
    TOUCH_MASS,
    TOUCH_DAMPING,
];

/// The hand, the loop and the workspace.
const TOUCHING: &[Parameter] = &[
    TOUCH_HAND,
    TOUCH_HAND_STIFFNESS,
    TOUCH_WAY,
    TOUCH_CIRCLE_CENTRE,
    TOUCH_CIRCLE_RADIUS,
    TOUCH_CIRCLE_START,
    TOUCH_CIRCLE_PERIOD,
    SAMPLE_TIME,
    TOUCH_DURATION,
    FORCE_LIMIT,
    TRIAL_FORCE_RATE_LIMIT,
    TOUCH_BOX_LOW,
    TOUCH_BOX_HIGH,
    TOUCH_MUST_BE_PASSIVE,
];

const MASS_KG: f64 = 0.065;
