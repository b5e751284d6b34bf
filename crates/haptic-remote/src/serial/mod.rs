//! A device on a serial port or at a TCP address: two threads that speak, and a [`Device`](haptic_loop::Device) whose force comes from
//! here.
//!
//! ```text
//! reader thread:  port ─▶ Conversation ─▶ answers, samples and notices (bounded; what finds no room counts)
//! writer thread:  requests, forces ─▶ Conversation ─▶ port; retries; keep-alives
//! ```
//! The other end is a board, or a thread of this process that [serves](Served) a device of another maker. The thread
//! that ticks never waits for the port. Dropping a [`SerialLink`] disarms the device, then closes the port.

mod clock;
mod connect;
mod error;
mod line;
mod link;
mod listening;
mod port;
mod request;
mod run;
mod served;
mod socket;
mod stopping;
mod tcp;

pub use crate::held_clock::HeldClock;
pub use clock::{ClockLine, DeviceClock, Ping, Pings};
pub use connect::{BAUDS, ConnectOptions, GREETING};
pub use error::{BoardTrouble, SerialError, TroubleCause};
pub use line::{Line, Pipe};
pub use link::{DeviceMessage, LinkReport, SerialLink};
pub use port::{PortInfo, is_socket, latency_file, open, port_of, ports};
pub use request::Companions;
pub use served::{DeviceTime, ServeError, Served, ServedHardware, USB_PERIOD_US};
pub use stopping::unless_stopped;
pub use tcp::{TcpListening, host_and_port, tcp_address};
