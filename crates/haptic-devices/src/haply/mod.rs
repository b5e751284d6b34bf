//! The Haply 2DIY: a five-bar pantograph with two motors, on a USB serial port without checksum and watchdog.
//!
//! With one axis the safety chain gives the force along a line of the plane, and the force across it is 0; with both axes it is a
//! vector.

mod greeting;
mod hardware;
mod kinematics;
mod model;
mod protocol;

pub use greeting::HaplyOpenError;
pub use hardware::{FORCE_MAX_N, Haply2Diy, LATE_MOST};
pub use kinematics::{Pantograph, Posture, Singular};
pub use model::{
    Axis, BaseJoint, CountingSense, HaplyModel, HaplyName, HaplyPlane, Home, Unreachable, Version,
    counts_at,
};
pub use protocol::{
    ANSWER_BYTES, CONFIGURATION_BYTES, HaplyTrouble, SPEED_MOST_M_PER_S, TORQUE_MAX_NM,
    TORQUES_BYTES, angles_of, answer, configuration, reset, torques,
};
