//! The two ends of the link between a device and its host, without the line between them.
//!
//! ```text
//! device, tick interrupt:  TickSide     read ─▶ force ─▶ write, states, watchdog, flight recorder
//! device, main loop:       Session      bytes ─▶ requests ─▶ TickSide;   TickSide ─▶ reports ─▶ bytes
//! host:                    Conversation bytes ─▶ reports, counters;  requests with answers and retries ─▶ bytes
//! ```
//! All three are plain state machines: bytes and the time come in as arguments, bytes go out. The same
//! device side runs in the firmware's interrupt, in `host-cli device emulate`, and in tests that lose,
//! damage and delay what is said.
//!
//! - *Zero force* until armed and started, and again after a stop, a fault, a reset.
//! - *One connection*: a device acts on the frames of the host that it last gave a number, and only those of the host
//!   that armed it keep it going.
//! - *All or nothing*: parameters are staged, checked, and take effect together between two ticks.
//! - *Silence*: armed or running, a device that hears nothing for the watchdog time latches a fault and
//!   lets the force fall to zero within its stop time.

mod connections;
mod conversation;
#[cfg(feature = "std")]
mod faulty_line;
mod flight;
mod hardware;
mod limits;
mod outbox;
mod prepared;
#[cfg(feature = "std")]
pub mod serial;
mod session;
mod simulated;
mod tick_side;

pub use conversation::{Conversation, HostCounters, Incoming, LinkError, check_keys};
#[cfg(feature = "std")]
pub use faulty_line::{FaultyLine, LineDamage, LineFaults};
pub use flight::FLIGHT_SAMPLES;
pub use hardware::{Exclusive, Hardware};
pub use limits::{wire_guard, wire_limits};
pub use outbox::QUEUE_SAMPLES;
#[cfg(feature = "std")]
pub use prepared::operator_shape;
pub use prepared::{
    COEFFICIENTS_MAX, DEGREE_MAX, DeviceOperator, DeviceWall, MODES_MAX, Prepared, prepare,
};
pub use session::Session;
pub use simulated::SimulatedPlant;
pub use tick_side::TickSide;
