#![doc = include_str!("../README.md")]
#![no_std]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]
#[cfg(feature = "std")]
extern crate std;

#[cfg(feature = "std")]
mod channel;
mod law;
mod peer;
mod port;

#[cfg(feature = "std")]
pub use channel::{ChannelCounts, ChannelModel, OneWayLine};
pub use law::CouplerGains;
pub use peer::{Introduction, Peer, PeerError, PeerMessage};
pub use port::{Begun, FinishedTick, Port, PortCounts, PortLaw, Settings};
