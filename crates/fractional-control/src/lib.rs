#![doc = include_str!("../README.md")]
#![no_std]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]
#[cfg(feature = "std")]
extern crate std;

#[cfg(feature = "std")]
pub mod analysis;
mod controller;
#[cfg(feature = "std")]
mod curves;
#[cfg(feature = "std")]
mod cut;
#[cfg(feature = "std")]
mod enclosure;
mod error;
#[cfg(feature = "std")]
mod held_response;
mod implicit;
#[cfg(feature = "std")]
mod lateness;
mod lead;
#[cfg(feature = "std")]
mod list;
#[cfg(feature = "std")]
mod loaded;
#[cfg(feature = "std")]
mod margins;
mod memory;
mod notation;
#[cfg(feature = "std")]
mod own_times;
mod parallel;
mod pid;
#[cfg(feature = "std")]
mod plant;
#[cfg(feature = "std")]
mod poles;
mod portable;
#[cfg(feature = "std")]
mod records;
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
#[cfg(feature = "std")]
mod sum;
mod transfer;
#[cfg(feature = "std")]
mod verdict;
#[cfg(feature = "std")]
pub mod whole_orders;
#[cfg(feature = "std")]
mod wide;

pub use controller::{
    AVERAGED, Actuator, Controller, DEAD_ZONE, MISSED_MOST, Mode, RANGE_MOST, Station,
};
pub use error::ControlError;
pub use implicit::{ImplicitFactor, ImplicitFactors};
pub use memory::{Integral, PowerMemory, Rule};
pub use notation::factor_after_division;
pub use parallel::{FractionalPid, ParallelHistory};
pub use pid::{PidParameters, SetPoint, TidParameters};
pub use portable::{
    CONTROLLER_PARTS, PortableController, PortableControllerHistory, PortableForm, PortablePart,
};
pub use sampled::{ORDERS_MAX, PARTS_MAX, SampledHistory, SampledTransferFunction, fractions};
pub use shaped::{
    CroneParameters, FunctionController, LeadController, LeadLagParameters, OnError, OnErrorHistory,
};
pub use transfer::FractionalTransferFunction;
pub use transfer::{FractionalPolynomial, Term};
#[cfg(feature = "std")]
pub use {
    certified_count::StabilityVerdict,
    curves::ControllerParameters,
    enclosure::SampledLaw,
    list::{BranchList, ControllerList, LawList, LeadList, ParallelList},
    loaded::{LoadedPlant, TwoPort},
    margins::{Crossing, Margins},
    plant::Plant,
    poles::Commensurate,
    records::{MODES, impulse_response, respond, step_response, through},
    sampled_plant::{HeldPlant, PlantState},
    setup::{ControllerSetup, Feedback, UseController, rule_of_scheme},
    simulate::{Response, StepShape, simulate},
    state_space::StateSpace,
    sum::SumOfParts,
    verdict::{Judged, SampledControlLoop},
};

/// The crate of operators, whose types this crate's interface has.
pub use fracdiff;
/// The crate of complex numbers, which responses are.
pub use num_complex;
