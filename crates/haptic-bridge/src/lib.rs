#![doc = include_str!("../README.md")]
#![deny(unsafe_code, unsafe_op_in_unsafe_fn)]

mod bridge;
mod c;
mod clock;
mod description;
mod line;
mod meter;
mod motion;
mod pace;
mod program;
mod status;
mod ticking;

pub use bridge::{Bridge, BridgeError, BridgeTicker};
pub use c::{
    HB_ENDED, HB_FORCE, HB_NULL, HB_OTHER, HB_VELOCITY, HbBridge, HbDevice, hb_close, hb_fault,
    hb_open, hb_port, hb_reason, hb_sense, hb_stop, hb_tick, hb_tick_motion, hb_wait,
};
pub use description::{Description, DescriptionError, Takes};
pub use haptic_link::{Reason, Trouble};
pub use line::LineSide;
pub use status::Handle;
