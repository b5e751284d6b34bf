//! The Haply 2DIY: a five-bar pantograph with two motors, on a USB serial port without checksum and watchdog.
//!
//! With one axis the force along a line of the plane is that of the safety chain, and across it there is none; with both it is a
//! vector. [`Planar`] is a tick of both arms.

mod greeting;
mod hardware;
mod kinematics;
mod model;
mod name;
mod planar;
mod plane;
mod plausible;
mod protocol;

pub use greeting::HaplyOpenError;
pub use hardware::{FORCE_MAX_N, Haply2Diy};
pub use kinematics::{Pantograph, Posture, Singular};
pub use model::{Direction, Joint, Model, Version, counts_at};
pub use name::{Axis, HaplyName, Home};
pub use planar::{LATE_MOST, Planar};
pub use plane::{Plane, Unreachable};
pub use plausible::{SPEED_MOST_M_PER_S, Trouble};
pub use protocol::{
    ANSWER_BYTES, CONFIGURATION_BYTES, TORQUE_MAX_NM, TORQUES_BYTES, angles_of, answer,
    configuration, reset, torques,
};
