#![doc = include_str!("../README.md")]
#![no_std]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]
#[cfg(feature = "std")]
extern crate std;

mod connections;
mod conversation;
mod hardware;
#[cfg(feature = "std")]
mod held_clock;
mod impossible;
mod limits;
mod link_error;
mod prepared;
mod records;
#[cfg(feature = "std")]
pub mod serial;
mod session;
#[cfg(feature = "plants")]
mod simulated;
mod tick_side;
#[cfg(feature = "several-axes")]
mod workspace;

pub use conversation::{Conversation, HostCounters, Incoming};
pub use hardware::{Exchange, Exclusive, Hardware};
pub use impossible::Impossible;
pub use limits::{wire_guard, wire_limits};
pub use link_error::{LinkError, check_keys};
#[cfg(feature = "std")]
pub use prepared::operator_shape;
pub use prepared::{
    COEFFICIENTS_MAX, DEGREE_MAX, DeviceOperator, DeviceWall, MODES_MAX, Prepared, prepare,
};
pub use records::{FLIGHT_SAMPLES, QUEUE_SAMPLES, Records, Tick};
pub use session::DeviceSession;
#[cfg(feature = "std")]
pub use simulated::FitsDevice;
#[cfg(all(feature = "plants", feature = "several-axes"))]
pub use simulated::SimulatedAxes;
#[cfg(feature = "plants")]
pub use simulated::SimulatedPlant;
pub use tick_side::TickSide;
