#![doc = include_str!("../README.md")]
#![no_std]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]
#[cfg(feature = "std")]
extern crate std;

mod account;
#[cfg(feature = "std")]
mod channel;
mod coupled;
mod law;
mod peer;
mod port;
mod settings;
mod wave;

#[cfg(feature = "std")]
pub use channel::{Channel, ChannelCounts, ChannelModel};
pub use coupled::CouplerGains;
pub use peer::{Heard, Introduction, Peer, PeerError};
pub use port::{Begun, Port, PortCounts, Ticked};
pub use settings::{PortLaw, Settings};
