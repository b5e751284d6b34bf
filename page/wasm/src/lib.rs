//! `haptic-analysis` for the page: a bench of one device and operator, judged and drawn.
//!
//! Nothing is computed here. A [`Bench`] holds what depends on the device, the order and the sample time alone (the
//! stability region, the passive walls, the noise of the operator), so that a wall K, B is judged on it within a frame.
#![forbid(unsafe_code)]

mod bench;
mod judgement;
mod passive;
mod remembered;
mod units;

pub use bench::{Bench, Device};
pub use judgement::Judgement;
pub use remembered::Remembered;
pub use units::parse_quantity;
