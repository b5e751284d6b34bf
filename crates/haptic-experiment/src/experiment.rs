//! The kinds of experiment: a folder each, with what it asks of a document, its law, and how it is judged.

#[cfg(test)]
mod bounded_tests;
pub(crate) mod coupler;
pub(crate) mod drive;
pub(crate) mod indentation;
pub(crate) mod reading;
pub(crate) mod rendering;
pub(crate) mod teleoperation;
pub(crate) mod touch;
pub(crate) mod trial;
pub(crate) mod wall;

use crate::document::parameters::{ON_DEVICE, Parameter};
use crate::run::safety::keys::SAFETY;
pub use teleoperation::{End, FarReport, FeltAt, Terms};

/// Kinds of experiments, the names of their tables in files.
pub const KINDS: [&str; 6] = [
    "relax",
    "creep",
    "wall",
    "coupler",
    "teleoperation",
    "touch",
];

/// The table beside an experiment that a controller drives.
pub const DRIVE_TABLE: &str = "drive";

/// Tables of a kind, or of the drive beside one: heading and parameters; `None` if it is not one.
pub(crate) fn tables(kind: &str) -> Option<Vec<(&'static str, &'static [Parameter])>> {
    let own: &[(&str, &[Parameter])] = match kind {
        "relax" => &[
            ("relaxation", rendering::RELAX),
            ("rendering", rendering::RENDERING),
        ],
        "creep" => &[
            ("creep", rendering::CREEP),
            ("rendering", rendering::RENDERING),
        ],
        "wall" => &[("required", wall::WALL_REQUIRED), ("wall", wall::WALL)],
        "coupler" => &[
            ("required", coupler::COUPLER_REQUIRED),
            ("coupler", coupler::COUPLER),
        ],
        "teleoperation" => &[("teleoperation", teleoperation::TELEOPERATION)],
        "touch" => &[("touch", touch::TOUCH)],
        DRIVE_TABLE => return Some(vec![(DRIVE_TABLE, drive::DRIVE)]),
        _ => return None,
    };
    let common = match kind {
        // On simulated devices alone.
        "teleoperation" => vec![("safety", SAFETY)],
        _ => vec![("device", ON_DEVICE), ("safety", SAFETY)],
    };
    Some(own.iter().copied().chain(common).collect())
}
