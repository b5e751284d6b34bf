//! The Haply Inverse3, Inverse3x and Minverse: arms with three motors behind the maker's Inverse Service, a program on this or
//! another machine.
//!
//! ```text
//! GET /version                                          which service it is; then a WebSocket at the same port
//! {"inverse3":[{"device_id":"049D","commands":{"set_cursor_force":{"vector":{"x":0,"y":0,"z":1.5}}}}]}    to it, f in N
//! {"inverse3":[{"device_id":"049D","state":{"cursor_position":{"x":0,"y":-0.12,"z":0.15},…},…}],…}        from it, x in m
//! ```
//! The service sends one answer for each message, and nothing unasked. With three axes force and position are vectors, x to the
//! right, y away from the base, z up, from the middle of the workspace (the preset `arm_front_centered`); with one they are along
//! a line through that middle.
//!
//! *Filters*: the service's own damping would be felt as the tissue's, so it is set to 0, and read back. Its force gate lowers
//! forces while it sees an oscillation; the gain that disables it is not documented, so it is left as it is, and reported. A second
//! detector of oscillations cannot be read, nor can the factor for all forces, `devices/force_scale`.
//!
//! *Not known*, since neither messages nor documents give it: the largest force, the resolution of the position, the rate at
//! which the service talks to the device, and the time after which the device lets go when commands stop.
//!
//! *Source*: the maker's crate `haply` 1.3.1 and his pages on the Inverse SDK 3.5. That crate is not used here: it brings some two
//! hundred others (an HTTP client with OpenSSL, a second `nalgebra`, two more `syn`), holds a lock, and starts a task for each
//! connection. A package of its own, `tests/inverse3`, holds the emulated service to it instead.

mod greeting;
mod hardware;
mod in_time;
mod name;
mod trouble;
mod wire;

pub use hardware::{FORCE_MAX_N, Inverse3};
pub use in_time::InTime;
pub use name::Inverse3Name;
pub use trouble::{Inverse3OpenError, Inverse3Trouble};
