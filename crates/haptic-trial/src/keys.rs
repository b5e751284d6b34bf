//! Keys of trials.

pub mod admittance;
pub mod drive;
pub mod teleoperation;
pub mod trial;
pub mod wall;
