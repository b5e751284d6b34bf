//! Keys of trials.

pub mod teleoperation;
pub mod trial;
pub mod wall;
