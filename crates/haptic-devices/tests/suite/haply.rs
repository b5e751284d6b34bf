//! The 2DIY in virtual time: driver, device side and an emulated board, byte by byte.

mod corruption;
mod driver;
mod late_host;
mod plane;
pub(crate) mod wire;
