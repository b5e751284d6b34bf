//! Devices that move: a virtual body between a hand and a virtual world, on a robot that takes a velocity.
//! ```text
//! M(D)·v = f_m + f_e,   M(s) = m·s^α + b,   f_e = −(K + B·D^μ)x,   x' = v        f_m = −L(w)·v of the hand, by way of the robot
//! stable ⇔ (1 − w)(M + L)/T + w·E has no zero in |w| ≤ 1
//! ```
//! *Free space is not the robot*: a body that is stable in a hand may be unstable against a wall of a middle stiffness, and stable against a stiff one. Laws
//! are judged by hands × walls.

mod closed;
mod margins;
mod members;
mod robot;
mod terms;

pub use closed::{AdmittanceLoop, AdmittanceNumber, EffortWeight, HandImpedance};
pub use margins::AdmittanceMargins;
pub use members::{AdmittanceBox, BoxVerdict};
pub use robot::{ForceFilter, Robot, VelocityLoop};
pub use terms::{AdmittanceBody, AdmittanceWorld};
