#![doc = include_str!("../README.md")]
#![deny(unsafe_code, unsafe_op_in_unsafe_fn)]

mod bridge;
mod c;
mod clock;
mod description;
mod line;
mod meter;
mod pace;
mod program;
mod status;
mod ticking;

pub use bridge::{Bridge, BridgeError, BridgeTicker};
pub use c::{
    HB_ENDED, HB_NULL, HbBridge, HbDevice, hb_close, hb_fault, hb_open, hb_port, hb_reason,
    hb_sense, hb_stop, hb_tick, hb_wait,
};
pub use description::{Description, DescriptionError};
pub use haptic_link::{Reason, Trouble};
pub use line::LineSide;
pub use status::Handle;
