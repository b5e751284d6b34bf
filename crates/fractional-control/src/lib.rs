#![doc = include_str!("../README.md")]
#![no_std]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]
#[cfg(feature = "std")]
extern crate std;

#[cfg(feature = "std")]
pub mod analysis;
mod chain;
mod controller;
#[cfg(feature = "std")]
mod curves;
#[cfg(feature = "std")]
pub mod design;
#[cfg(feature = "std")]
mod enclosure;
mod error;
#[cfg(feature = "std")]
mod far_aliases;
mod function_controller;
#[cfg(feature = "std")]
mod gains;
#[cfg(feature = "std")]
mod held_response;
#[cfg(feature = "std")]
mod identify;
#[cfg(feature = "std")]
mod lateness;
#[cfg(feature = "std")]
mod law;
mod lead;
#[cfg(feature = "std")]
mod loaded;
#[cfg(feature = "std")]
mod margins;
mod memory;
#[cfg(feature = "std")]
pub mod model_search;
mod notation;
mod parallel;
#[cfg(feature = "std")]
mod peaks;
mod pid;
mod pid_notation;
#[cfg(feature = "std")]
mod plant;
#[cfg(feature = "std")]
mod plant_margins;
#[cfg(feature = "std")]
mod poles;
mod polynomial;
mod quotient;
#[cfg(feature = "std")]
mod ratio;
#[cfg(feature = "std")]
mod records;
#[cfg(feature = "std")]
mod rule_error;
#[cfg(feature = "std")]
pub mod run;
mod sampled;
#[cfg(feature = "std")]
mod sampled_plant;
#[cfg(feature = "std")]
mod setup;
mod shaped;
#[cfg(feature = "std")]
mod simulate;
#[cfg(feature = "std")]
mod state_space;
mod transfer;
#[cfg(feature = "std")]
pub mod tuning;
#[cfg(feature = "std")]
mod verdict;
#[cfg(feature = "std")]
mod wide;

pub use controller::{Actuator, Controller, Mode, Station};
#[cfg(feature = "std")]
pub use curves::ControllerParameters;
pub use error::ControlError;
pub use function_controller::{FunctionController, FunctionHistory};
#[cfg(feature = "std")]
pub use identify::{
    FreeNumber, Identified, Record, WholeGuess, WholeShape, identify, identify_coefficients,
    whole_guess,
};
#[cfg(feature = "std")]
pub use law::SampledLaw;
#[cfg(feature = "std")]
pub use loaded::{LoadedPlant, TwoPort};
#[cfg(feature = "std")]
pub use margins::{Crossing, Margins};
pub use memory::{Memory, Rule};
pub use notation::factor_after_division;
pub use parallel::ParallelHistory;
pub use pid::{FractionalPid, PidParameters, SetPoint, Tid, TidParameters};
#[cfg(feature = "std")]
pub use plant::Plant;
#[cfg(feature = "std")]
pub use poles::Commensurate;
pub use polynomial::{FractionalPolynomial, ORDER_MAX, TERMS_MAX, Term};
#[cfg(feature = "std")]
pub use records::{MODES, impulse_response, respond, step_response};
#[cfg(feature = "std")]
pub use rule_error::RuleError;
pub use sampled::{ORDERS_MAX, PARTS_MAX, SampledHistory, SampledTransferFunction};
#[cfg(feature = "std")]
pub use sampled_plant::{PlantState, SampledPlant};
#[cfg(feature = "std")]
pub use setup::{ControllerSetup, UseController, rule_of_scheme};
pub use shaped::{Crone, CroneParameters, LeadLag, LeadLagParameters, ShapedHistory};
#[cfg(feature = "std")]
pub use simulate::{Response, Shape, simulate};
#[cfg(feature = "std")]
pub use state_space::StateSpace;
pub use transfer::FractionalTransferFunction;
#[cfg(feature = "std")]
pub use verdict::{SampledLoop, StabilityVerdict};

/// The crate of operators, whose types this crate's interface has.
pub use fracdiff;
/// The crate of complex numbers, which responses are.
pub use num_complex;
