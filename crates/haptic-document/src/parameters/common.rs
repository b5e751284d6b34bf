//! Keys that several kinds share, or that a room below the kinds names.

use super::range::Range;
use crate::{
    named, parameters,
    parameters::{
        kind::{Parameter, Paths, joined},
        range::{
            DAMPINGS, DEVICE_TIMES, DISSIPATIONS, DURATIONS, FORCE_LIMITS, FORCE_RATES, FORCES,
            FORCES_ABOVE_0, HALF_ANGLES, MASSES, OFFSETS, POISSON_RATIOS, SAMPLE_TIMES,
            SENSOR_STEPS, SPECIMENS, STIFFNESSES,
        },
    },
};
use haptic_link::{Architecture, Limits as Wire, LoopMode};
use haptic_loop::{Limit, LoadingKind};

/// Files that a document names, as a log of its run has them.
pub const TISSUE_IN_LOG: &str = "tissue_file";
/// The controller of a drive.
pub const CONTROLLER_IN_LOG: &str = "drive.file";
/// The model file of the device.
pub const DEVICE_IN_LOG: &str = "device_model.file";
/// Parameters of the device of a drive.
pub const DRIVE_DEVICE_IN_LOG: &str = "drive_device_model.file";

parameters! {
    /// `k_c` of a coupler, N·s/m.
    COUPLER_DAMPING = optional("coupler_damping_n_s_per_m", DAMPINGS,
        "Damper of the coupler: force = damper v + spring (integral of order mu of v), with v the velocity between device and object");
    /// `b_c` of a coupler, N·s^(1−μ)/m.
    COUPLER_SPRING = optional("coupler_spring_n_s_1_minus_mu_per_m", DISSIPATIONS,
        "Spring of the coupler, N·s^(1−μ)/m: at order 1 N/m");
    /// `k_c` of a coupler, N/m.
    HAND_COUPLER_STIFFNESS = number("coupler_stiffness_n_per_m", 300.0, "300", STIFFNESSES,
        "Spring of the coupler: force = spring x + damper D^mu x, with x the distance between both; without effect for waves");
    /// `b_c` of a coupler, N·s^μ/m.
    HAND_COUPLER_DISSIPATION = number("coupler_dissipation_n_s_mu_per_m", 10.0, "10", DISSIPATIONS,
        "Damper of that coupler, N·s^μ/m: at order 1 N·s/m");
    TISSUE = file("tissue", "prostate-cancerous", Paths::Toml, Some(TISSUE_IN_LOG), "Tissue: a name from `host-cli materials list`, or a TOML file");
    LIBRARY = file("library", "", Paths::All, None, "Folder with more tissue files");
    AGAINST = file("against", "", Paths::All, None, "Measured record, a table or a log, laid over the run");
    /// Area of the specimen, m².
    AREA = number("area_m2", 4e-4, "4cm2", SPECIMENS, "Area of the specimen");
    /// Thickness of the specimen, m.
    THICKNESS = number("thickness_m", 0.02, "20mm", SPECIMENS, "Thickness of the specimen");
    /// Loading of the specimen, a compression by default.
    LOADING = text("loading", "compression", "How it is pressed");
    /// Radius of a punch or sphere, m.
    INDENTER_RADIUS = optional("indenter_radius_m", SPECIMENS, "Radius of a punch or sphere");
    /// Half angle of a cone, rad.
    HALF_ANGLE = optional("half_angle_rad", HALF_ANGLES, "Half angle of a cone, between axis and flank");
    /// Poisson's ratio of a specimen.
    POISSON_RATIO = optional("poisson_ratio", POISSON_RATIOS, "Poisson's ratio [default: 0.5, incompressible]");
    /// True if stiffening is sought.
    STIFFENING = flag("stiffening", "Find how much the tissue stiffens too, by a motion or by motions to several depths");
    /// True if the specimen is bonded.
    BONDED = flag("bonded", "The slab cannot slide on its plates, or the layer under a sphere cannot slide on its base");
    SCHEME = text("scheme", "full", "Scheme of D^μ: full, grunwald:1000, tustin-muir:3…");
    /// Sample time of any loop, s.
    SAMPLE_TIME = number("sample_time_s", 1e-3, "1ms", SAMPLE_TIMES, "Sample time of the loop");
    CONTACT = text("contact", "compliant", "Contact between indenter and tissue");
    /// Force limit of a rendered tissue, N.
    FORCE_LIMIT = number("force_limit_n", Limit::Force.default_number(), "10N", FORCE_LIMITS, "Largest force the loop may command");
    /// A plant that is analysed in place of a device.
    PLANT_MODEL = file("plant_model", "", Paths::All, None, "Plant file with [state_space] in place of a device, from force in N to measured position in m; its delay adds to the one given");
    CONTROLLER = file("controller", "", Paths::All, Some(CONTROLLER_IN_LOG), "Controller file of the indenter, which is then a mass");
    /// Device of a drive at a port.
    DRIVE_DEVICE = text("drive_device", "", "Second device, which the controller moves: it presses the tissue that the other one renders");
    DRIVE_DEVICE_MODEL = file("drive_device_model", "", Paths::AllBut(LABORATORY), Some(DRIVE_DEVICE_IN_LOG), "Its device file from `device measure`");
    DRIVE_LOOP = text("drive_loop", "device", "Where the loop of the second device runs");
    /// Rate limit of a rendered tissue, N/s.
    FORCE_RATE_LIMIT = number("force_rate_limit_n_per_s", Limit::ForceRate.default_number(), "1000N/s", FORCE_RATES, "Largest rate of change of the force");
    TOUCH_AXES = count("axes", 2, "2", "Number of axes, 2 or 3");
    /// Length of a trial, s.
    TRIAL_DURATION = number("duration_s", 5.0, "5s", DURATIONS, "Length of a run");
}

/// Keys of a piece of tissue: what it is, and how it is pressed.
pub const PIECE: &[Parameter] = &[
    TISSUE,
    LIBRARY,
    AREA,
    THICKNESS,
    LOADING,
    INDENTER_RADIUS,
    HALF_ANGLE,
    BONDED,
];

/// `PIECE` without the name of the tissue.
pub const UNNAMED_PIECE: &[Parameter] = PIECE.split_at(1).1;

named! { LoadingKind:
    Shear = LoadingKind::Shear.name(), "Simple shear of a slab";
    Tension = LoadingKind::Tension.name(), "Tension of a slab";
    Compression = LoadingKind::Compression.name(), "Compression of a slab";
    Punch = LoadingKind::Punch.name(), "A flat round punch on a deep body";
    Sphere = LoadingKind::Sphere.name(), "A sphere on a deep body, or on a layer";
    Cone = LoadingKind::Cone.name(), "A cone on a deep body";
}

named! { Architecture:
    PositionPosition = Architecture::PositionPosition.name(), "A fractional coupler pulls each side to the other";
    PositionForce = Architecture::PositionForce.name(), "The slave is pulled to the master, which feels that force";
    Wave = Architecture::Wave.name(), "Waves: passive at any delay";
    TimeDomain = Architecture::TimeDomain.name(), "Position-position with an energy account: passive at any delay";
}

named! { LoopMode:
    Device = "device", "On the device; this program sets parameters and records";
    Host = "host", "On this computer; the device reports positions and applies forces";
}

/// The device file that is shipped.
pub const LABORATORY: &str = "laboratory";

parameters! {
    DEVICE = text("device", "sim", "Device: `sim`, `serial:PATH`, `serial:auto`, `tcp:HOST:PORT`, `haply:PATH`, `moteus:PATH`, `inverse3:`");
    /// Place where the loop is closed.
    LOOP = text("loop", "device", "Where the loop of a serial device runs");
    /// Watchdog of a serial device, s.
    WATCHDOG = optional("watchdog_s", Range::Within(1e-3 * Wire::WATCHDOG_MIN_MS as f64, 1e-3 * Wire::WATCHDOG_MAX_MS as f64),
        "Silence from this program after which a serial device lets go [default: 500ms, 20ms in a host loop]");
    /// Late ticks of a serial device.
    LATE_TICKS = count("late_ticks", Wire::DEFAULT.late_ticks as u64, "20",
        "Late ticks in a row after which a serial device lets go; 0 = off");
    /// Age of a force from the host, ticks.
    MAX_AGE_TICKS = count("max_age_ticks", Wire::DEFAULT.max_age_ticks as u64, "10",
        "Host loop: largest age of a force in ticks from its sample, 1 to 1000; an older one makes a serial device \
         let go [default: 10]");
    /// Source of the push of a trial.
    PUSH_BY = text("push_by", "hand", "Source of the push into the wall");
    LAW = file("law", "", Paths::All, None, "File of the law, with [wall] or a table of these keys, in place of them");
    OTHER_LAW = file("other", "", Paths::All, None, "File of another law to compare with, with [wall] or a table of these keys");
    /// File of what a search has found.
    CAMPAIGN = file("campaign", "", Paths::All, None,
        "File that keeps each point found on a serial device, and from which a search that was stopped goes on");
    DEVICE_MODEL = file("device_model", "", Paths::AllBut(LABORATORY), Some(DEVICE_IN_LOG),
        "Device file from `device measure`; on a rig only the guard uses it");
}

/// Keys of every experiment on a device.
pub const ON_DEVICE: &[Parameter] = &[DEVICE, LOOP, WATCHDOG, LATE_TICKS, MAX_AGE_TICKS];

parameters! {
    /// Encoder of a simulated device, m.
    ENCODER_RESOLUTION = number("encoder_resolution_m", 0.0, "0", SENSOR_STEPS,
        "Encoder resolution per count; 0 = ideal");
    /// Noise of a simulated sensor, m.
    SENSOR_NOISE = number("sensor_noise_m", 0.0, "0", SENSOR_STEPS, "Standard deviation of the sensor noise; 0 = none");
    /// Range of a simulated force sensor, N.
    SENSED_RANGE = optional("sensed_range_n", FORCES_ABOVE_0,
        "Force sensor in the handle that shows up to this force either way; without it there is none");
    /// Noise of that sensor, N.
    SENSED_NOISE = number("sensed_noise_n", 1e-3, "1mN", FORCES, "Standard deviation of its noise");
    /// Lag of that sensor, s.
    SENSED_LAG = number("sensed_lag_s", 1e-3, "1ms", DEVICE_TIMES, "Time constant of its filter; 0 = none");
    /// Offset of that sensor, N.
    SENSED_OFFSET = number("sensed_offset_n", 0.0, "0", OFFSETS, "Its reading without a force, of either sign");
    SENSED_SEED = count("sensed_seed", 1, "1", "Seed of its noise, apart from that of the position");
    SEED = count("seed", 1, "1", "Noise seed: the same seed gives the same run, bit for bit");
    /// Mass of a simulated device, kg.
    MASS = number("mass_kg", 0.065, "65g", MASSES, "Mass of the device");
    /// Damping of a simulated device, N·s/m.
    DAMPING = number("damping_n_s_per_m", 3.5, "3.5", DAMPINGS, "Viscous damping of the device");
    /// Stiffness of the hand, N/m.
    HAND_STIFFNESS = number("hand_stiffness_n_per_m", 0.0, "0", STIFFNESSES, "Stiffness of the hand that holds the device; 0 without a hand");
    /// Delay of a simulated device, s.
    DELAY = number("delay_s", 0.0, "0", DEVICE_TIMES, "Delay from a measurement to its force, not counting the hold of a sample");
    /// Friction of a simulated device, N.
    FRICTION = number("friction_n", 0.0, "0", FORCES, "Coulomb friction");
    /// Current lag of a simulated device, s.
    CURRENT_LAG = number("current_lag_s", 0.0, "0", DEVICE_TIMES, "Time constant of the actuator's current");
}

/// Keys of a simulated or emulated force sensor.
pub const FORCE_SENSOR: &[Parameter] = &[
    SENSED_RANGE,
    SENSED_NOISE,
    SENSED_LAG,
    SENSED_OFFSET,
    SENSED_SEED,
];

/// Keys of a simulated device that is less than ideal.
pub const LESS_THAN_IDEAL: &[Parameter] = &[
    DELAY,
    FRICTION,
    CURRENT_LAG,
    ENCODER_RESOLUTION,
    SENSOR_NOISE,
    SEED,
];

/// Keys of a simulated device.
pub const SIMULATED: &[Parameter] = &joined::<10>(&[
    &[DEVICE_MODEL, MASS, DAMPING, HAND_STIFFNESS],
    LESS_THAN_IDEAL,
]);
