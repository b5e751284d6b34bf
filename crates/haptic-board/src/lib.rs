#![doc = include_str!("../README.md")]
#![no_std]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]

mod clock;
mod device;
mod image;
mod main_loop;
#[cfg(all(feature = "defmt", target_os = "none"))]
mod news;
mod parts;
mod quadrature;
mod queue;
mod retained;

// All that a board needs, so that it has one dependency and versions that belong together.
pub use {haptic_link, haptic_loop, haptic_remote, nalgebra};

pub use clock::Clock;
pub use device::{DeviceMemory, Shared, Ticker, TickerSlot, power_up};
pub use image::Image;
pub use main_loop::{MainLoop, serve};
pub use parts::{HostLine, NoWatchdog, Parts, TickTimer, Watchdog};
pub use quadrature::Quadrature;
pub use queue::Queue;
pub use retained::{Retained, RetainedMemory};
