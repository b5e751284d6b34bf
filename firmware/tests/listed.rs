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
        count: list.values().1 as u16,
    }
}
