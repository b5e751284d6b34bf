//! A moteus servo without hardware, behind a pseudo-terminal.
//!
//! ```text
//! serial port of a host ─▶ lines of an fdcanusb ─▶ servo: registers, watchdog, shaft ─▶ lines back, at once
//! ```
//! Held to the maker's own Python package. The servo answers when it is asked and lives in real time: nothing is late
//! because of it but what this machine makes late.

mod adapter;
mod registers;
mod servo;
mod shaft;

pub use adapter::{EmulatedAdapter, ServoCounts};
pub use servo::EmulatedServo;
pub use shaft::{Hand, Shaft};
