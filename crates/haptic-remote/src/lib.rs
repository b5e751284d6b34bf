#![doc = include_str!("../README.md")]
#![no_std]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]
#[cfg(feature = "std")]
extern crate std;

mod connections;
mod conversation;
#[cfg(feature = "std")]
mod fits_device;
mod hardware;
#[cfg(feature = "std")]
mod held_clock;
#[cfg(feature = "controllers")]
mod holding;
mod impossible;
mod limits;
mod link_error;
mod moved;
#[cfg(feature = "controllers")]
#[cfg_attr(
    not(feature = "std"),
    expect(
        dead_code,
        reason = "a line alone turns one kind of newtons into the other"
    )
)]
mod newtons;
mod patience;
#[cfg(feature = "std")]
mod plausible;
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
#[cfg(feature = "several-axes")]
mod surface;
mod tick_side;
#[cfg(feature = "several-axes")]
mod workspace;

pub use conversation::{Conversation, HostCounters, Incoming};
#[cfg(feature = "std")]
pub use fits_device::FitsDevice;
pub use hardware::{Exchange, Exclusive, Hardware, PlantSetup};
#[cfg(feature = "std")]
pub use holding::controller_law;
pub use impossible::Impossible;
pub use limits::{wire_guard, wire_limits};
pub use link_error::{LinkError, check_keys};
pub use moved::MovedRobot;
#[cfg(feature = "controllers")]
pub use newtons::ForceFactors;
pub use patience::Patience;
pub use prepared::{
    COEFFICIENTS_MAX, DEGREE_MAX, DeviceOperator, DeviceWall, MODES_MAX, Prepared, abilities,
    prepare,
};
#[cfg(feature = "std")]
pub use prepared::{CONTROLLER_COST, operator_shape};
pub use records::{FLIGHT_SAMPLES, QUEUE_SAMPLES, Records, Tick};
pub use session::{DeviceSession, Side};
#[cfg(feature = "plants")]
pub use simulated::SimulatedPlant;
#[cfg(all(feature = "plants", feature = "several-axes"))]
pub use simulated_axes::SimulatedAxes;
#[cfg(feature = "std")]
pub use surface::wire_surface;
pub use tick_side::TickSide;
