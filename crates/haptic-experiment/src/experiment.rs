//! The kinds of experiment: a folder each, with what it asks of a document, its law, and how it is judged.

#[cfg(test)]
mod bounded_tests;
pub(crate) mod coupler;
pub(crate) mod creep;
pub(crate) mod drive;
pub(crate) mod reading;
pub(crate) mod relaxation;
pub(crate) mod rendering;
pub mod teleoperation;
pub(crate) mod touch;
pub(crate) mod trial;
pub(crate) mod wall;

use crate::document::parameters::{ON_DEVICE, Parameter, SAFETY};
pub use coupler::CouplerCurves;
pub use drive::{DriveCurves, DriveReport, LoopVerdict};
pub use rendering::{Quantity, TheoryCurves};
pub use touch::{
    Grip, HandPath, PostureVerdict, TouchCurves, TouchLaw, TouchShape, TouchVerdict, WorkspaceBox,
};
pub use wall::WallCurves;

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

/// Tables of a kind: heading and parameters; `None` if it is not one.
pub(crate) fn tables(kind: &str) -> Option<Vec<(&'static str, &'static [Parameter])>> {
    let own: &[(&str, &[Parameter])] = match kind {
        "relax" => &[
            ("relaxation", rendering::keys::RELAX),
            ("rendering", rendering::keys::RENDERING),
        ],
        "creep" => &[
            ("creep", rendering::keys::CREEP),
            ("rendering", rendering::keys::RENDERING),
        ],
        "wall" => &[
            ("required", wall::keys::WALL_REQUIRED),
            ("wall", wall::keys::WALL),
        ],
        "coupler" => &[
            ("required", coupler::keys::COUPLER_REQUIRED),
            ("coupler", coupler::keys::COUPLER),
        ],
        "teleoperation" => &[("teleoperation", teleoperation::keys::TELEOPERATION)],
        "touch" => &[("touch", touch::keys::TOUCH)],
        _ => return None,
    };
    let common = match kind {
        // On simulated devices alone.
        "teleoperation" => vec![("safety", SAFETY)],
        _ => vec![("device", ON_DEVICE), ("safety", SAFETY)],
    };
    Some(own.iter().copied().chain(common).collect())
}
