//! A [moteus](https://mjbots.com) servo with a capstan or lever, behind an `fdcanusb` adapter or on a UART.
//!
//! Text, registers and their scales are the maker's own crate `moteus-protocol`. Its transports wait for as long as an answer
//! takes and allocate for each; a loop must do neither, so the lines are taken from the port here.

mod adapter;
mod axis;
mod frames;
mod settings;
mod trouble;

pub(crate) use adapter::is_not_now;
pub use axis::MoteusAxis;
pub use frames::Frames;
pub use settings::{MoteusName, MoteusSettings};
pub use trouble::{Instead, MoteusOpenError, MoteusTrouble};
