#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod announce;
pub mod feel;
pub mod frame;
mod identify;
mod on_close;
pub mod pyramid;
mod runs;
mod server;

pub(crate) use announce::Announce;
pub use feel::DeviceNumbers;
pub use on_close::OnClose;
pub use server::{PageServer, ServerOptions};
