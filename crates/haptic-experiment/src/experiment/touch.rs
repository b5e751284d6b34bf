//! A touch: a hand moves a device of two or three axes over a shape of tissue, simulated here or at a port.
//!
//! ```text
//! m_i·x_i'' + b·x_i' = k·(hand_i − x_i) + f_i       or with the hand's force in place of its spring
//! f = n·min(0, −(K·p + B·D^μ p))  through the safety chain         p depth into the shape, n its normal
//! ```
//! - *One operator* on the depth, whatever the number of axes: see [`Contact`](haptic_loop::Contact). No friction.
//! - *Energy* that the hand was given: of the force and motion at the hand, exact between samples. What is passive never gives
//!   more than it got.
//! - *Pre-flight* along the normal, with the effective mass 1/(nᵀ M⁻¹ n) of the posture. Round a ball every normal comes up, so
//!   the lightest and the heaviest are judged and the worse one is told.

mod device;
mod hand;
pub(crate) mod keys;
mod metadata;
mod on_device;
mod posture;
pub(crate) mod reading;
mod report;
mod running;
mod shape;
mod specification;
mod verdict;

pub(crate) use hand::GripName;
pub use hand::{Grip, HandPath};
pub use posture::PostureVerdict;
pub use report::{TouchCurves, TouchReport, TouchVerdict};
pub(crate) use shape::ShapeName;
pub use shape::{TouchLaw, TouchShape};
pub use specification::{TouchExperiment, WorkspaceBox};
