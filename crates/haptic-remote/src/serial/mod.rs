//! A device on a serial port: two threads that speak, and a [`Device`](haptic_loop::Device) whose force comes from here.
//!
//! ```text
//! reader thread:  port ─▶ Conversation ─▶ answers, samples and notices (bounded; what finds no room counts)
//! writer thread:  requests, forces ─▶ Conversation ─▶ port; retries; keep-alives
//! ```
//! The other end is a board, or a thread of this process that [serves](Served) a device of another maker.
//!
//! The thread that ticks never waits for the port: it takes samples from a queue and puts forces into one.
//! Dropping a [`SerialLink`] disarms the device, then closes the port.

mod connect;
mod device_time;
mod error;
mod greeting;
mod line;
mod link;
mod pipe;
mod port;
mod punctual;
mod request;
mod run;
mod served;
mod shared;
#[cfg(unix)]
mod socket;
mod threads;
mod trouble;

pub use crate::held_clock::HeldClock;
pub use connect::ConnectOptions;
pub use device_time::DeviceTime;
pub use error::SerialError;
pub use greeting::{BAUDS, GREETING};
pub use line::Line;
pub use link::{LinkReport, SerialLink};
pub use pipe::Pipe;
pub use port::{PortInfo, open, ports};
pub use served::{ServeError, Served, ServedHardware};
pub use shared::Heard;
#[cfg(unix)]
pub use socket::{set_patience, timed_out};
pub use trouble::{BoardTrouble, TroubleCause};
