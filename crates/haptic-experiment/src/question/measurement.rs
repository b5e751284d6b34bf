//! Mass, damping, friction, delay, current lag and sensors of a device at hand, from a motion that it makes by small safe forces.
//!
//! ```text
//! m·x″ + b·x′ + k·x + F_c·sgn x′ = a + w        τ·a′ = u(t − D) − a        y = round((x + noise)/q)·q
//! ```
//! *Excitation* ([`MeasurePlan`]): at rest without force; a slow ramp each way until the device moves; then a multi-sine of at most
//! [`MeasurePlan::SHARE`] of the force limit, inside a box about the start, held there by a weak spring. The safety chain has that share
//! as its limit and the box as its workspace.
//!
//! *Estimation* ([`estimate`]): a pure function of the [`MotionRecord`], force applied and position read at each tick. The force is
//! recorded, so the spring and every limiter may close the loop as they like. The model is the sampled device of
//! [`haptic_loop::plant`], exact for a fraction of a sample of delay and for the lag.
//! Least squares over short pieces of the motion, each with a state of its own at its start, so that what no model knows does not add up; from
//! several lags, as there are several minima. Where the residual goes on from sample to sample, friction is stepped more finely than samples.

mod conduct;
mod estimate;
mod excitation;
mod first_guess;
mod fit;
mod intervals;
pub(crate) mod keys;
mod measured;
mod plan;
pub(crate) mod reading;
mod record;
mod replay;
mod sensor;
mod serial;

pub use conduct::{DriveError, Driven, Outcome, drive, on_simulated};
pub use estimate::{MeasureError, estimate};
pub use measured::{Estimate, Measured};
pub use plan::MeasurePlan;
pub use reading::Measurement;
pub use record::MotionRecord;
pub use serial::{SerialMotion, on_serial};
