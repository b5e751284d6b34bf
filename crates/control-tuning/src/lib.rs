#![doc = include_str!("../README.md")]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]

mod baseline;
pub mod design;
mod open_loop;
mod search;
mod specification;

pub use baseline::integer_baseline;
pub use open_loop::Measures;
pub use search::{Tuned, tune, tune_integer};
pub use specification::{Bound, GAINS, Sampling, Specification, Wish, WishName, steps};

/// The crate of plants, controllers and loops, whose types this crate's interface has.
pub use fractional_control;
