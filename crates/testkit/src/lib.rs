//! Shared by the tests of several crates. For integration tests only: a unit test would see its own crate twice.
//!
//! ```
//! use testkit::{Random, assert_close};
//!
//! let mut random = Random(1);
//! assert_close("a mean", 0.5 * (random.between(0.0, 1.0) + 1.0), 0.75, 0.25);
//! ```
#![forbid(unsafe_code)]

#[cfg(feature = "book")]
pub mod book;
#[cfg(feature = "browser")]
pub mod browser;
mod campaign;
mod compare;
pub mod device;
pub mod golden;
pub mod operator;
mod random;
mod skip;
pub mod tissue;

pub use campaign::cases;
pub use compare::{assert_close, assert_relative};
pub use random::Random;
pub use skip::{skip, skip_for_load};
