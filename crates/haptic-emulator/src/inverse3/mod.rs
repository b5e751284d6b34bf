//! An emulated Inverse Service: HTTP and WebSocket at one port, with Inverse3 devices behind it, each with a mass and a hand.
//!
//! Messages are those of the maker's documents for 3.5, and his crate `haply` 1.3.1 takes it for the service. Emulated are
//! `/version`, `/devices`, the inventory on connecting, one answer a message, forces that end with the session or after
//! [`SILENCE_US`] without commands, the presets, damping, and a wireless grip that nobody turns or presses. Not emulated: the
//! force gate, other transforms, settings and the channel of events.
//!
//! *Ours*, since the maker's documents do not say: that silence, and a `set_cursor_force` with `values`, as messages before 3.5 have
//! it. Those documents have `vector` alone and promise that programs go on working, so both names make a force; a command with
//! neither makes none, and is counted.

mod body;
mod connection;
mod service;
mod tcp;

pub use body::{Body, CENTRE_M, Hand};
pub use connection::Connection;
pub use service::{Counted, SILENCE_US, Service};
pub use tcp::serve;
