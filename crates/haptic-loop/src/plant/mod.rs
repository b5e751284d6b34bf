//! Simulated plants: what the loop holds instead of hardware, and what makes it less than ideal.
//!
//! ```text
//! force ─▶ delay ─▶ saturation ─▶ current lag ─▶ MassDamper, IndentationRig or FacingDevices ─▶ position
//!                                                position ─▶ Sensed: noise ─▶ encoder ─▶ reading
//! ```
//! - *Virtual time*: [`write`](crate::Device::write) moves a plant on by one sample time T,
//!   [`read`](crate::Device::read) only looks. No clock is read, so runs repeat bit for bit.
//! - *Exact*: forces are held over a sample, so each linear piece is stepped with its exact
//!   zero-order-hold transition. What is not exact (friction, making and breaking contact) says so.
//! - *Precision*: plants compute in `f64` whatever the loop streams in, so that errors of the loop
//!   are the loop's; a position is rounded once, on its way out.
//! - *Not finite*: a safe force is always finite; nothing else enters after construction, except
//!   an external force or a state set by the caller, whose NaN would stay.

mod axes;
mod discretise;
#[cfg(feature = "alloc")]
mod facing;
mod force_sensor;
#[cfg(feature = "alloc")]
mod held;
mod mass_damper;
mod mass_matrix;
mod noise;
#[cfg(feature = "alloc")]
mod pressed;
mod profile;
mod rig;
mod robot;
mod sensed;
#[cfg(feature = "schemes")]
mod trial;

pub use axes::Axes;
#[cfg(feature = "alloc")]
pub use facing::{FacingConfig, FacingContact, FacingDevices, FacingSide};
pub use force_sensor::{ForceSensor, ForceSensorConfig};
#[cfg(feature = "alloc")]
pub use held::{HeldRig, Holder};
pub use mass_damper::{MAX_DELAY_SAMPLES, MassDamper, MassDamperConfig};
pub use mass_matrix::MassMatrix;
#[cfg(feature = "alloc")]
pub use pressed::{PressedDevice, PressedSpecimen, SpecimenMatter};
pub use profile::{ImposedMotion, RampHold};
pub use rig::{IndentationRig, RigConfig, RigContact, RigDrive, RigServo, SUB_STEPS};
pub use robot::{
    LOOP_STATES, RobotHand, RobotLoop, SENSOR_LAGS, SensorTrouble, SimulatedRobot,
    SimulatedRobotConfig,
};
pub use sensed::Sensed;
#[cfg(feature = "schemes")]
pub use trial::run_wall;
