//! Lists on the wire, and a board that takes each of them.

use super::lists::List;
use haptic_link::{Capabilities, OperatorForm, OperatorShape};
use haptic_remote::abilities;

/// A board with room for every list.
pub(crate) fn capabilities(board: &str) -> Capabilities {
    Capabilities {
        force_max_n: 40.0,
        force_rate_max_n_per_s: 1e6,
        ..abilities(board, 1)
    }
}

/// The operator of a list as the wire has it.
pub(crate) fn shape(list: &List) -> OperatorShape {
    OperatorShape {
        form: match list.form {
            "taps" => OperatorForm::Taps,
            "modes" => OperatorForm::Modes,
            _ => OperatorForm::Recursion,
        },
        integer: list.integer,
        count: list.bits.len() as u16,
    }
}

/// Its values, so many as it has.
pub(crate) fn values(list: &List) -> ([f32; 256], usize) {
    let mut values = [0.0; 256];
    for (value, bits) in values.iter_mut().zip(list.bits) {
        *value = f32::from_bits(*bits);
    }
    (values, list.bits.len())
}
