//! Keys of analyses.

use haptic_document::parameters;
use haptic_document::parameters::KeyTable;
use haptic_document::parameters::range::{
    ANGULAR_FREQUENCIES, DELAY_SAMPLES as SAMPLES, DELTAS, FORCES_ABOVE_0, FREQUENCIES_HZ,
    REACHES_ABOVE_0, Range, WALL_NUMBERS, WALL_ORDERS,
};
use haptic_document::parameters::{
    AREA, COUPLER_DAMPING, COUPLER_SPRING, CURRENT_LAG, DAMPING, DELAY, DEVICE_MODEL,
    HAND_COUPLER_DISSIPATION, HAND_COUPLER_STIFFNESS, HAND_STIFFNESS, LAW, LIBRARY, MASS,
    OTHER_LAW, PLANT_MODEL, SAMPLE_TIME, SCHEME, THICKNESS, TISSUE, UNNAMED_PIECE,
};
use haptic_document::parameters::{Parameter, Paths, joined};
use haptic_trial::keys::admittance::{BODY, PUSHING_HANDS, ROBOT};
use haptic_trial::keys::teleoperation::{
    ARCHITECTURE, HAND_COUPLER_ORDER, LINE_DELAY, SLAVE_DAMPING, SLAVE_MASS, WAVE_IMPEDANCE,
};
use haptic_trial::keys::wall::{DISSIPATION, ORDER, STIFFNESS};

parameters! {
    ANALYSED_TISSUE = file("tissue", "", Paths::Toml, None, "Tissue in place of a wall: a name from `host-cli materials list`, or a TOML file");
    ANALYSED_CONTROLLER = file("controller", "", Paths::All, None, "Controller file in place of a wall, from position in m to force in N: judged while its reference stands and within its limits, so set-point weights, limits and anti-windup do not count");
    /// Depth of a tissue whose force is not linear, m.
    JUDGED_DEPTH = optional("depth_m", REACHES_ABOVE_0, "Depth at which a tissue that stiffens, or that a sphere or cone presses, is judged");
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
    FELT_LOW = number("low_hz", 0.5, "0.5Hz", FREQUENCIES_HZ, "Lowest frequency of what the hand feels");
    /// Highest frequency of a remote tissue, Hz.
    FELT_HIGH = number("high_hz", 5.0, "5Hz", FREQUENCIES_HZ, "Highest frequency of what the hand feels");
    /// Number of frequencies of a remote tissue.
    FELT_POINTS = count("points", 20, "20", "Number of frequencies");
    WEBER_SHARE = number("weber_share", 0.1, "0.1", Range::AboveUpTo(0.0, 1.0), "Share of the force that a hand notices; published values for a spring reach from 0.08 to 0.23");
    HAND_AMPLITUDE = number("hand_amplitude_m", 0.01, "10mm", REACHES_ABOVE_0, "Amplitude of the hand's motion");
    LEAST_FORCE = number("least_force_n", 0.02, "20mN", FORCES_ABOVE_0, "Least force that a hand feels");
    PLAYOUT_SAMPLES = count("playout", 2, "2", "Samples over which waves are played out");
    /// Search for the best body.
    BEST_BODY = flag("best", "Find the body of each order, and the lagged mass, that bears all hands and walls with the least effort");
    /// Search for all bodies that none beats.
    BODY_FRONT = flag("front", "Best body: find all bodies too that none beats in effort, command noise and hand margin");
    /// Factor on the hands that the best body bears too.
    HAND_MARGIN = number("hand_margin", 1.2, "1.2", Range::Within(1.0, 100.0), "Best body: factor by which the heaviest, stiffest hand that damps most may grow");
    /// Search for the best coupler.
    BEST = flag("best", "Find the best coupler of each order, or the best wave impedance");
}

// The parts of a device that an analysis knows only if they are given.
pub(crate) const ANALYSED_MASS: Parameter = MASS.without_default();
pub(crate) const ANALYSED_DAMPING: Parameter = DAMPING.without_default();
pub(crate) const ANALYSED_HAND: Parameter = HAND_STIFFNESS.without_default();
pub(crate) const ANALYSED_SAMPLE_TIME: Parameter = SAMPLE_TIME.without_default();
pub(crate) const ANALYSED_DELAY: Parameter = DELAY.without_default();
pub(crate) const ANALYSED_LAG: Parameter = CURRENT_LAG.without_default();

#[rustfmt::skip]
const WALL: KeyTable = ("Wall", &[ORDER, ANALYSED_SCHEME, STIFFNESS, DISSIPATION, ANALYSED_SAMPLE_TIME]);
#[rustfmt::skip]
const IN_PLACE: KeyTable = ("Tissue or controller in place of a wall", &joined::<10>(&[&[ANALYSED_TISSUE], UNNAMED_PIECE, &[JUDGED_DEPTH, ANALYSED_CONTROLLER]]));
const ON_DEVICE: KeyTable = (
    "Device",
    &[
        DEVICE_MODEL,
        ANALYSED_MASS,
        ANALYSED_DAMPING,
        ANALYSED_HAND,
        ANALYSED_DELAY,
        ANALYSED_LAG,
    ],
);
const THROUGH_DEVICE: KeyTable = (
    "Device",
    &[
        DEVICE_MODEL,
        ANALYSED_MASS,
        ANALYSED_DAMPING,
        ANALYSED_DELAY,
        ANALYSED_LAG,
        DELAY_SAMPLES,
    ],
);
const WITHOUT_UNITS: KeyTable = ("Without units", &[ALPHA, BETA, DELTA, GAMMA, DELAY_SAMPLES]);
const OMEGAS: KeyTable = ("Frequencies", &[OMEGA_MIN, OMEGA_MAX, POINTS]);

const ON_PLANT: KeyTable = ("Plant in place of a device", &[PLANT_MODEL]);

/// Keys of an analysis of a wall on a device, or on any linear plant.
pub const STABILITY: &[KeyTable] = &[WALL, IN_PLACE, ON_DEVICE, ON_PLANT, WITHOUT_UNITS];
/// Keys of a wall whose sensitivity is drawn.
pub const SENSITIVITY: &[KeyTable] = &[
    WALL,
    IN_PLACE,
    ON_DEVICE,
    ON_PLANT,
    WITHOUT_UNITS,
    ("Frequencies", &[SENSITIVITY_POINTS]),
];
/// Keys of the impedance of a wall alone.
pub const ENVIRONMENT: &[KeyTable] = &[WALL, IN_PLACE, OMEGAS];
/// Keys of the impedance of a wall behind a device or a plant.
pub const TRANSPARENCY: &[KeyTable] = &[WALL, IN_PLACE, THROUGH_DEVICE, ON_PLANT, OMEGAS];
/// Keys of a law that a hand feels through a device.
pub(crate) const OF_A_LAW: &[KeyTable] = &[WALL, IN_PLACE, THROUGH_DEVICE];
/// Keys of the difference of two laws.
pub const DIFFERENCE: &[KeyTable] = &[
    ("Laws", &[LAW, OTHER_LAW]),
    WALL,
    IN_PLACE,
    THROUGH_DEVICE,
    (
        "Hand",
        &[
            FELT_LOW,
            FELT_HIGH,
            WEBER_SHARE,
            HAND_AMPLITUDE,
            LEAST_FORCE,
            POINTS,
        ],
    ),
];
/// Keys of a device that moves.
pub const ADMITTANCE: &[KeyTable] = &[
    (
        "Virtual body",
        &joined::<8>(&[BODY, &[BEST_BODY, BODY_FRONT, HAND_MARGIN]]),
    ),
    (
        "Robot",
        &joined::<8>(&[&[DEVICE_MODEL], ROBOT, &[ANALYSED_SAMPLE_TIME]]),
    ),
    ("Hands", PUSHING_HANDS),
    (
        "Wall, from free space on",
        &[ORDER, ANALYSED_SCHEME, STIFFNESS, DISSIPATION],
    ),
    IN_PLACE,
    ("Frequencies", &[FELT_LOW, FELT_HIGH, POINTS]),
];
/// Keys of the passivity of a coupler.
pub const COUPLING: &[KeyTable] = &[(
    "Coupler",
    &[
        COUPLING_ORDER,
        ANALYSED_SCHEME,
        COUPLER_DAMPING,
        COUPLER_SPRING,
        ANALYSED_SAMPLE_TIME,
        ANALYSED_DAMPING,
    ],
)];
/// Keys of a teleoperation: two hands over a line.
#[rustfmt::skip]
pub const HANDS: &[KeyTable] = &[
    ("Line", &[
        ARCHITECTURE, LINE_DELAY, HAND_COUPLER_STIFFNESS, HAND_COUPLER_DISSIPATION,
        HAND_COUPLER_ORDER, WAVE_IMPEDANCE, PLAYOUT_SAMPLES, BEST,
    ]),
    ("Tissue", &[TISSUE, LIBRARY, AREA, THICKNESS, FELT_LOW, FELT_HIGH, FELT_POINTS]),
    ("Devices", &[MASS, DAMPING, SLAVE_MASS, SLAVE_DAMPING, SAMPLE_TIME]),
];
