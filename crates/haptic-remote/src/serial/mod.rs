//! A device on a serial port: two threads that speak, and a [`Device`](haptic_loop::Device) whose force comes from here.
//!
//! ```text
//! reader thread:  port ─▶ Conversation ─▶ answers, samples and notices (bounded; what finds no room counts)
//! writer thread:  requests, forces ─▶ Conversation ─▶ port; retries; keep-alives
//! ```
//! The thread that ticks never waits for the port: it takes samples from a queue and puts forces into one.
//! Dropping a [`SerialLink`] disarms the device, then closes the port.

mod connect;
mod error;
mod greeting;
mod link;
mod port;
mod request;
mod run;
mod shared;
mod threads;

pub use connect::ConnectOptions;
pub use error::SerialError;
pub use greeting::{BAUDS, GREETING};
pub use link::{LinkReport, SerialLink};
pub use port::{PortInfo, ports};
pub use shared::Heard;
