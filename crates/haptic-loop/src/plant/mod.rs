//! Simulated plants: what the loop holds instead of hardware, and what makes it less than ideal.
//!
//! ```text
//! force ─▶ delay ─▶ saturation ─▶ current lag ─▶ MassDamper or IndentationRig ─▶ position
//!                                       position ─▶ MeasurementDelay ─▶ SensorNoise ─▶ EncoderQuantiser ─▶ reading
//! ```
//! - *Virtual time*: [`write`](crate::Device::write) moves a plant on by one sample time T,
//!   [`read`](crate::Device::read) only looks. No clock is read, so runs repeat bit for bit.
//! - *Exact*: forces are held over a sample, so each linear piece is stepped with its exact
//!   zero-order-hold transition. What is not exact (friction, making and breaking contact) says so.
//! - *Precision*: plants compute in `f64` whatever the loop streams in, so that errors of the loop
//!   are the loop's; a position is rounded once, on its way out.
//! - *Composition*: the wrappers take any [`Device`](crate::Device), in any order. A real sensor
//!   quantises last, so put [`EncoderQuantiser`] outermost.
//! - *Not finite*: a safe force is always finite; nothing else enters after construction, except
//!   an external force or a state set by the caller, whose NaN would stay.

mod axes;
mod delay;
mod discretise;
mod encoder;
mod friction;
mod held;
mod imposed;
mod mass_damper;
mod mass_matrix;
mod motion;
mod noise;
mod profile;
mod rig;
mod rig_config;
mod sensed;

pub use axes::Axes;
pub use delay::{MAX_DELAY_SAMPLES, MeasurementDelay};
pub use encoder::EncoderQuantiser;
pub use held::{HeldRig, Holder};
pub use imposed::ImposedMotion;
pub use mass_damper::{MassDamper, MassDamperConfig};
pub use mass_matrix::MassMatrix;
pub use motion::RigMotion;
pub use noise::SensorNoise;
pub use profile::RampHold;
pub use rig::{IndentationRig, SUB_STEPS};
pub use rig_config::{RigConfig, RigContact, RigDrive, RigServo};
pub use sensed::Sensed;
