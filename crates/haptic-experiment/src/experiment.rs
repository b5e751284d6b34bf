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

pub use coupler::CouplerCurves;
pub use drive::{DriveCurves, DriveReport, LoopVerdict};
pub use rendering::{Quantity, TheoryCurves};
pub use touch::{
    Grip, HandPath, PostureVerdict, TouchCurves, TouchLaw, TouchShape, TouchVerdict, WorkspaceBox,
};
pub use wall::WallCurves;
