//! Keys of `[zwidth]`.

use crate::document::parameters::kind::{Parameter, parameters};
use crate::document::parameters::range;
use crate::document::parameters::{SCHEME, TRIAL_DURATION};
use crate::experiment::trial::{IMPACT, PUSH, WINDOW};
use crate::experiment::wall::ONE_SIDED;

parameters! {
    /// Orders of a Z-width.
    ZWIDTH_ORDERS = list_of("orders", "0,0.5,1,1.5,2", range::WALL_ORDERS, "Orders of the dissipation, 0 to 2");
    /// Dissipations of a Z-width.
    ZWIDTH_POINTS = count("points", 21, "21", "Dissipations for each order, from 0 to the largest stable one");
}

/// Of `[zwidth]`, beside the device of a question.
pub const ZWIDTH: &[Parameter] = &[
    ZWIDTH_ORDERS,
    ZWIDTH_POINTS,
    SCHEME,
    ONE_SIDED,
    PUSH,
    IMPACT,
    TRIAL_DURATION,
    WINDOW,
];
