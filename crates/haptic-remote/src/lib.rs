#![doc = include_str!("../README.md")]
#![no_std]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]
#[cfg(feature = "std")]
extern crate std;

mod connections;
mod conversation;
mod exchange;
#[cfg(feature = "std")]
mod fits_device;
mod flight;
mod hardware;
#[cfg(feature = "std")]
mod held_clock;
mod impossible;
mod limits;
mod link_error;
mod outbox;
mod prepared;
mod records;
mod rendered;
#[cfg(feature = "std")]
pub mod serial;
mod session;
#[cfg(feature = "plants")]
mod simulated;
#[cfg(all(feature = "plants", feature = "several-axes"))]
mod simulated_axes;
mod tick;
mod tick_side;
#[cfg(feature = "several-axes")]
mod workspace;

pub use conversation::{Conversation, HostCounters, Incoming};
pub use exchange::Exchange;
#[cfg(feature = "std")]
pub use fits_device::FitsDevice;
pub use flight::FLIGHT_SAMPLES;
pub use hardware::{Exclusive, Hardware};
pub use impossible::Impossible;
pub use limits::{wire_guard, wire_limits};
pub use link_error::{LinkError, check_keys};
pub use outbox::QUEUE_SAMPLES;
#[cfg(feature = "std")]
pub use prepared::operator_shape;
pub use prepared::{
    COEFFICIENTS_MAX, DEGREE_MAX, DeviceOperator, DeviceWall, MODES_MAX, Prepared, prepare,
};
pub use records::Records;
pub use session::DeviceSession;
#[cfg(feature = "plants")]
pub use simulated::SimulatedPlant;
#[cfg(all(feature = "plants", feature = "several-axes"))]
pub use simulated_axes::SimulatedAxes;
pub use tick::Tick;
pub use tick_side::TickSide;
