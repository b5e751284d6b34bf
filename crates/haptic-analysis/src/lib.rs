#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]

mod arrangement;
mod behind;
mod boundary;
mod characteristic;
mod circle;
mod continuous;
mod corollary;
mod coupling;
mod crossing;
mod curve;
mod decomposition;
mod dynamics;
mod environment;
mod error;
mod extremum;
mod functions;
mod jury;
mod largest;
mod lateness;
mod least_damping;
mod linear;
mod margin;
mod mass_damper;
mod noise;
mod object;
mod operator;
mod outline;
mod own_operator;
mod parameters;
mod passivity;
mod path;
mod plant;
mod region;
mod required;
mod schemes;
mod stability;
mod straight;
mod strip;
mod teleoperation;
mod theorem;
mod transition;
mod transparency;

pub use boundary::{BoundaryPoint, Polygon};
pub use corollary::corollary_delta;
pub use coupling::{Coupler, HybridMatrix, Llewellyn};
pub use crossing::AtAngle;
pub use dynamics::Dynamics;
pub use environment::{Effective, Environment};
pub use error::AnalysisError;
pub use fracdiff::parameter::RangeError;
pub use jury::{Jury, jury};
pub use largest::Largest;
pub use least_damping::LeastDamping;
pub use margin::Margins;
pub use noise::{exact_noise_gain, noise_gain};
pub use object::{CoupledLoop, CoupledObject, CouplerOperator};
pub use operator::LoopOperator;
pub use parameters::{Loop, Nondimensional};
pub use passivity::OnePort;
pub use path::ForcePath;
pub use plant::SampledPlant;
pub use region::{StabilityRegion, StableArea};
pub use required::{RequiredDamping, RequiredDelta};
pub use stability::{SampledLoop, StabilityVerdict};
pub use teleoperation::{
    AbsoluteStability, BestCoupler, CouplerSearch, HandCoupler, HandLine, HandMass, LargestDelay,
    Teleoperation, Transparency,
};
pub use transparency::{ClosedLoop, DelayedLoop};

/// Complex numbers: [`num_complex::Complex`].
pub use num_complex;
