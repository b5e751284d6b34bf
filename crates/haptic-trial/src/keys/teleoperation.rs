//! Keys of two hands over a line.

use super::trial::TRIAL_FORCE_RATE_LIMIT;
use haptic_document::{
    parameters,
    parameters::{
        DAMPING, FORCE_LIMIT, HAND_COUPLER_DISSIPATION, HAND_COUPLER_STIFFNESS, MASS, PIECE,
        Parameter, SAMPLE_TIME, SCHEME, SENSED_LAG, SENSED_NOISE, SENSED_RANGE, SENSED_SEED,
        joined,
        range::{
            ARM_PLACES, COUPLER_ORDERS, DAMPINGS, DAMPINGS_ABOVE_0, DISSIPATIONS, DURATIONS,
            FREQUENCIES_HZ, LINE_TIMES, MASSES, REACHES_ABOVE_0, SAFETY_TIMES, SHARES, STIFFNESSES,
            STIFFNESSES_ABOVE_0, WALL_ORDERS,
        },
    },
};
use haptic_teleoperation::Settings;

parameters! {
    /// The law that joins master and slave.
    ARCHITECTURE = text("architecture", "position-position",
        "How master and slave are joined");
    HAND_COUPLER_ORDER = number("order", 0.5, "0.5", COUPLER_ORDERS, "Order mu of that coupler");
    WAVE_IMPEDANCE = number("wave_impedance_n_s_per_m", 3.0, "3", DAMPINGS_ABOVE_0,
        "b of waves: the damping of the line that both hands feel; at most that of the devices");
    PLAYOUT = optional("playout_s", LINE_TIMES,
        "Time over which waves or energy arriving in a bunch are played out [default: a sample plus the jitter]");
    /// Delay of the line, s.
    LINE_DELAY = number("line_delay_s", 0.02, "20ms", LINE_TIMES, "Delay of the line, each way; a message takes one sample more");
    LINE_JITTER = number("line_jitter", 0.0, "0", SHARES, "Share of that delay by which messages arrive earlier or later");
    LINE_LOSS = number("line_loss", 0.0, "0", SHARES, "Chance that a message is lost");
    LINE_DUPLICATION = number("line_duplication", 0.0, "0", SHARES, "Chance that a message arrives twice");
    LINE_SEED = count("seed", 1, "1", "Line seed: the same seed gives the same run, bit for bit");
    /// Silence of the other side, s.
    SILENCE = number("silence_s", Settings::SILENCE_S, "0.2s", SAFETY_TIMES,
        "Silence of the other side after which the force falls to zero");
    /// Mass of the slave, kg.
    SLAVE_MASS = optional("slave_mass_kg", MASSES, "Mass of the slave [default: same as the master]");
    /// Damping of the slave, N·s/m.
    SLAVE_DAMPING = optional("slave_damping_n_s_per_m", DAMPINGS, "Damping of the slave [default: same as the master]");
    /// Spring of the hand, N/m.
    HAND_SPRING = number("hand_stiffness_n_per_m", 300.0, "300", STIFFNESSES_ABOVE_0, "Stiffness with which the hand holds the master");
    /// Damper of the hand, N·s/m.
    HAND_DAMPER = number("hand_damping_n_s_per_m", 3.0, "3", DAMPINGS, "Damping with which the hand holds the master");
    /// Press of the hand, m.
    PRESS = number("press_m", 0.0, "0", ARM_PLACES, "Position that the hand moves to in 1 s and holds");
    /// Amplitude of the hand, m.
    AMPLITUDE = number("amplitude_m", 4e-3, "4mm", REACHES_ABOVE_0, "Sum of the amplitudes of the sines with which the hand moves");
    /// Lowest frequency of the hand, Hz.
    LOW = number("low_hz", 0.5, "0.5", FREQUENCIES_HZ, "Lowest frequency of these sines");
    /// Highest frequency of the hand, Hz.
    HIGH = number("high_hz", 20.0, "20", FREQUENCIES_HZ, "Highest frequency of these sines");
    FREQUENCIES = count("frequencies", 8, "8", "Number of these sines, 1 to 100, evenly on a log scale, each with whole periods in the window");
    ENVIRONMENT = text("environment", "tissue", "What the slave touches");
    /// K of a remote wall, N/m.
    PLACE_STIFFNESS = number("wall_stiffness_n_per_m", 200.0, "200", STIFFNESSES, "K of a wall");
    /// B of a remote wall, N·s^μ/m.
    PLACE_DISSIPATION = number("wall_dissipation_n_s_mu_per_m", 0.0, "0", DISSIPATIONS, "B of a wall");
    /// Order of a remote wall.
    PLACE_ORDER = number("wall_order", 1.0, "1", WALL_ORDERS, "Order of the dissipation of a wall");
    /// True if a remote wall only pushes.
    PLACE_ONE_SIDED = flag("one_sided", "Push but never pull; there is then no formula to compare with");
    /// Length of a teleoperation, s.
    TELEOPERATION_DURATION = number("duration_s", 10.0, "10s", DURATIONS, "Length of a run");
    /// Window of a teleoperation, s.
    TELEOPERATION_WINDOW = number("window_s", 4.0, "4s", DURATIONS, "Time at the end from which the impedances are computed");
    /// True if a line that gives energy is a failure.
    MUST_BE_PASSIVE = flag("must_be_passive", "Fail if the line, or held forces beyond the damping of the devices, give energy, or a force reaches its limit");
}

/// Keys of `[teleoperation]`.
pub const TELEOPERATION: &[Parameter] = &joined::<47>(&[
    &[ARCHITECTURE, HAND_COUPLER_STIFFNESS],
    &[HAND_COUPLER_DISSIPATION, HAND_COUPLER_ORDER],
    &[WAVE_IMPEDANCE, PLAYOUT, LINE_DELAY, LINE_JITTER],
    &[LINE_LOSS, LINE_DUPLICATION, LINE_SEED],
    &[SILENCE, MASS, DAMPING, SLAVE_MASS, SLAVE_DAMPING],
    &[HAND_SPRING, HAND_DAMPER],
    &[PRESS, AMPLITUDE, LOW, HIGH, FREQUENCIES],
    &[ENVIRONMENT],
    PIECE,
    &[PLACE_STIFFNESS, PLACE_DISSIPATION, PLACE_ORDER],
    &[PLACE_ONE_SIDED],
    // Without an offset: the slave is joined to its place from its start on, so it could not be measured.
    &[SENSED_RANGE, SENSED_NOISE, SENSED_LAG, SENSED_SEED],
    &[SCHEME, SAMPLE_TIME, TELEOPERATION_DURATION],
    &[TELEOPERATION_WINDOW],
    &[FORCE_LIMIT, TRIAL_FORCE_RATE_LIMIT, MUST_BE_PASSIVE],
]);
