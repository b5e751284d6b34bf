#![doc = include_str!("../README.md")]
#![no_std]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]
#[cfg(feature = "std")]
extern crate std;

mod chain;
mod error;
mod memory;
mod notation;
#[cfg(feature = "std")]
mod poles;
mod polynomial;
#[cfg(feature = "std")]
mod records;
mod sampled;
mod transfer;

pub use error::ControlError;
pub use memory::{Memory, Rule};
#[cfg(feature = "std")]
pub use poles::Commensurate;
pub use polynomial::{FractionalPolynomial, ORDER_MAX, TERMS_MAX, Term};
#[cfg(feature = "std")]
pub use records::{impulse_response, respond, step_response};
pub use sampled::{ORDERS_MAX, PARTS_MAX, SampledHistory, SampledTransferFunction};
pub use transfer::FractionalTransferFunction;

/// The crate of operators, whose types this crate's interface has.
pub use fracdiff;
/// The crate of complex numbers, which responses are.
pub use num_complex;
