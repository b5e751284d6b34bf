#![doc = include_str!("../README.md")]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]

pub mod autoregression;
mod identify;
pub mod model_search;

pub use identify::{
    DeadTime, FreeNumber, Identified, IdentifiedResponse, InputOutputRecord, KramersKronig,
    StartState, WholeGuess, WholeShape, identify, identify_coefficients, identify_response,
    kramers_kronig, search_response, whole_guess,
};

/// The crate of transfer functions, whose types this crate's interface has.
pub use fractional_control;

fn largest(numbers: &[f64]) -> f64 {
    numbers.iter().fold(0.0, |most: f64, x| most.max(x.abs()))
}
