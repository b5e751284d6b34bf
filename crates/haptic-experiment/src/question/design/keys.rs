//! Keys of `[design]`.

use crate::document::parameters::kind::{Parameter, parameters};
use crate::document::parameters::range;
use crate::document::parameters::range::Range;
use crate::document::parameters::{AREA, LIBRARY, SCHEME, THICKNESS};

parameters! {
    /// Aim of a design.
    WISH = text("wish", "stiffest-wall", "What to optimise");
    /// Tissue of a design.
    WISH_TISSUE = text("tissue", "", "Tissue of that wish: a name from `host-cli materials list`, or a TOML file");
    /// Frequency of a design, Hz.
    WISH_FREQUENCY = optional("frequency_hz", range::FREQUENCIES_HZ,
        "Frequency for most-damping, and to compare the orders of a tissue or coupler [default there: 1 Hz]");
    /// What a wall must be.
    REQUIRE = text("require", "stable", "Condition that the wall must meet");
    /// Gain margin of a design.
    GAIN_MARGIN = number("gain_margin", 2.0, "2", Range::AboveUpTo(1.0, 1e3),
        "Factor by which a stable wall could grow before it is unstable");
    /// Orders of a design.
    DESIGN_ORDERS = list_of("orders", "0,0.25,0.5,0.75,1,1.25,1.5,1.75,2", range::WALL_ORDERS, "Orders to try, 0 to 2");
    /// Limit on the noise of the force, N.
    FORCE_NOISE_LIMIT = optional("force_noise_limit_n", range::FORCES_ABOVE_0,
        "Largest rms force noise from encoder steps and sensor noise [default: any]");
}

/// Frequency at which the orders of a tissue or coupler are compared where none is given, Hz.
pub(crate) const COMPARED_AT_HZ: f64 = 1.0;

/// Of `[design]`, beside the device of a question.
pub const DESIGN: &[Parameter] = &[
    WISH,
    WISH_TISSUE,
    LIBRARY,
    AREA,
    THICKNESS,
    WISH_FREQUENCY,
    REQUIRE,
    GAIN_MARGIN,
    DESIGN_ORDERS,
    SCHEME,
    FORCE_NOISE_LIMIT,
];
