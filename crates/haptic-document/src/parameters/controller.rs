//! Keys of controller files and plant files.

use super::{
    common::{
        CURRENT_LAG, DAMPING, DELAY, ENCODER_RESOLUTION, FRICTION, HAND_STIFFNESS, MASS,
        SENSOR_NOISE,
    },
    kind::{Parameter, Paths},
    range::{
        ANGULAR_FREQUENCIES, DEAD_TIMES, DURATIONS, MEMORIES, NUMBERS, RATIOS, Range, SAMPLE_TIMES,
    },
};
use crate::parameters;

const ORDERS: Range = Range::AboveUpTo(0.0, 2.0);
const SIGNED_ORDERS: Range = Range::Within(-2.0, 2.0);

parameters! {
    /// `K_p`.
    PROPORTIONAL_GAIN = number("proportional_gain", 0.0, "0", NUMBERS, "K_p, output over input");
    /// `K_i`.
    INTEGRAL_GAIN = number("integral_gain_per_s_lambda", 0.0, "0", NUMBERS, "K_i, output over input and s^λ");
    INTEGRAL_ORDER = number("integral_order", 1.0, "1", ORDERS, "λ of the integral");
    /// `K_d`.
    DERIVATIVE_GAIN = number("derivative_gain_s_mu", 0.0, "0", NUMBERS, "K_d, output·s^μ over input");
    DERIVATIVE_ORDER = number("derivative_order", 1.0, "1", ORDERS, "μ of the derivative");
    SET_POINT_WEIGHT = number("set_point_weight", 1.0, "1", NUMBERS, "b: share of the reference in the proportional part");
    DERIVATIVE_SET_POINT_WEIGHT = number("derivative_set_point_weight", 0.0, "0", NUMBERS,
        "c: share of the reference in the derivative; 0 differentiates the measurement alone");
    /// `K_t` of a TID.
    TILT_GAIN = optional("tilt_gain_per_s_1_over_n", NUMBERS, "K_t of the tilt s^(−1/n)");
    TILT_DIVISOR = number("tilt_divisor", 3.0, "3", Range::Within(1.0, 1e3), "n of the tilt");
    /// `K_i` of a TID.
    TID_INTEGRAL_GAIN = number("integral_gain_per_s", 0.0, "0", NUMBERS, "K_i");
    /// `K_d` of a TID.
    TID_DERIVATIVE_GAIN = number("derivative_gain_s", 0.0, "0", NUMBERS, "K_d");
    CRONE_GAIN = optional("gain", NUMBERS, "Gain below both corners, not 0");
    LEAD_GAIN = optional("gain", NUMBERS, "Gain above both corners, not 0");
    /// Order of CRONE and lead–lag.
    SHAPED_ORDER = optional("order", SIGNED_ORDERS, "Power");
    /// `ω_b` of CRONE.
    CRONE_LOW = optional("low_rad_s", ANGULAR_FREQUENCIES, "Lower corner, rad/s");
    /// `ω_h` of CRONE.
    CRONE_HIGH = optional("high_rad_s", ANGULAR_FREQUENCIES, "Upper corner, rad/s");
    LEAD_LAMBDA = optional("lambda_s", DURATIONS, "λ: the zero is at 1/λ");
    LEAD_X = optional("x", RATIOS, "Below 1 a lead, above 1 a lag");
    /// A transfer function in notation.
    FUNCTION = text("function", "", "Transfer function, as in 1/(0.8s^2.2+0.5s^0.9+1)");
    /// Sample time of a controller.
    CONTROLLER_SAMPLE_TIME = optional("sample_time_s", SAMPLE_TIMES, "Sample time");
    /// Rule and tolerance of a controller.
    CONTROLLER_SCHEME = text("scheme", "full-bdf2", "Rule of the powers of s: full[:TOLERANCE] or full-bdf2[:TOLERANCE]");
    MEMORY = optional("memory_s", MEMORIES, "Memory within the tolerance [default: 200000 samples]");
    /// Lower limit of the command.
    OUTPUT_LOW = optional("output_low", NUMBERS, "Lowest command [default: no limit]");
    /// Upper limit of the command.
    OUTPUT_HIGH = optional("output_high", NUMBERS, "Highest command [default: no limit]");
    /// Time in which a bump fades.
    FADE_TIME = number("fade_time_s", 1.0, "1s", DURATIONS, "Time constant of the fade after a change");
    /// Plant that a controller was made for.
    SOURCE_PLANT = text("plant", "", "Plant that the controller is for");
    /// Wishes that a controller was made for.
    SOURCE_WISHES = text("wishes", "", "Wishes that it meets");
    SOURCE_PROGRAM = text("program", "", "Program that made the file");
    /// Anything worth knowing of a file.
    SOURCE_NOTE = text("note", "", "Anything worth knowing");
    STATE_A = list("a", NUMBERS, "A of ẋ = Ax + Bu, a list of rows");
    STATE_B = list("b", NUMBERS, "B of ẋ = Ax + Bu");
    STATE_C = list("c", NUMBERS, "C of y = Cx");
    STATE_B_HAND = list("b_hand", NUMBERS, "B of the force of a hand, in N [default: b]");
    STATE_C_HAND = list("c_hand", NUMBERS, "C of the place of the hand, in m [default: c]");
    /// Table of a measured response.
    RESPONSE_FILE = file("file", "", Paths::All, None, "CSV with omega_rad_s and gain, phase_deg or real, imaginary");
    /// Dead time of a plant.
    DEAD_TIME = number("delay_s", 0.0, "0", DEAD_TIMES, "Dead time");
}

/// Keys of `[pid]`.
pub const PID: &[Parameter] = &[
    PROPORTIONAL_GAIN,
    INTEGRAL_GAIN,
    INTEGRAL_ORDER,
    DERIVATIVE_GAIN,
    DERIVATIVE_ORDER,
    SET_POINT_WEIGHT,
    DERIVATIVE_SET_POINT_WEIGHT,
];
/// Keys of `[tid]`.
pub const TID: &[Parameter] = &[
    TILT_GAIN,
    TILT_DIVISOR,
    TID_INTEGRAL_GAIN,
    TID_DERIVATIVE_GAIN,
    DERIVATIVE_SET_POINT_WEIGHT,
];
/// Keys of `[crone]`.
pub const CRONE: &[Parameter] = &[CRONE_GAIN, SHAPED_ORDER, CRONE_LOW, CRONE_HIGH];
/// Keys of `[lead_lag]`.
pub const LEAD_LAG: &[Parameter] = &[LEAD_GAIN, SHAPED_ORDER, LEAD_LAMBDA, LEAD_X];
/// Keys of `[transfer_function]` in a controller file.
pub const TRANSFER_CONTROLLER: &[Parameter] = &[FUNCTION];
/// Keys of `[loop]` in a controller file.
pub const CONTROLLER_LOOP: &[Parameter] = &[
    CONTROLLER_SAMPLE_TIME,
    CONTROLLER_SCHEME,
    MEMORY,
    OUTPUT_LOW,
    OUTPUT_HIGH,
    FADE_TIME,
];
/// Keys of `[source]` in a controller file.
pub const CONTROLLER_SOURCE: &[Parameter] =
    &[SOURCE_PLANT, SOURCE_WISHES, SOURCE_PROGRAM, SOURCE_NOTE];
/// Keys of `[transfer_function]` in a plant file.
pub const TRANSFER_PLANT: &[Parameter] = &[FUNCTION, DEAD_TIME];
/// Keys of `[device]` in a plant file.
pub const DEVICE_PLANT: &[Parameter] = &[
    MASS,
    DAMPING,
    HAND_STIFFNESS,
    DELAY,
    CURRENT_LAG,
    FRICTION,
    ENCODER_RESOLUTION,
    SENSOR_NOISE,
];
/// Keys of `[state_space]` in a plant file.
pub const STATE_PLANT: &[Parameter] = &[
    STATE_A,
    STATE_B,
    STATE_C,
    STATE_B_HAND,
    STATE_C_HAND,
    DEAD_TIME,
    CURRENT_LAG,
];
/// Keys of `[measured_response]` in a plant file.
pub const MEASURED_PLANT: &[Parameter] = &[RESPONSE_FILE];
/// Keys of `[source]` in a plant file.
pub const PLANT_SOURCE: &[Parameter] = &[SOURCE_PROGRAM, SOURCE_NOTE];
