#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]

mod admittance;
mod affine;
mod arrangement;
mod characteristic;
mod coupling;
mod curve;
mod decomposition;
mod dynamics;
mod error;
mod extremum;
mod functions;
mod hand_port;
mod largest;
mod lateness;
mod law_set;
mod linear;
mod margin;
mod nearest;
mod noise;
mod object;
mod operator;
mod outline;
mod passivity;
mod path;
mod plant;
mod region;
mod schemes;
mod slope;
mod stability;
mod teleoperation;
mod transparency;

pub use admittance::{
    AdmittanceBody, AdmittanceBox, AdmittanceLoop, AdmittanceMargins, AdmittanceNumber,
    AdmittanceWorld, BoxVerdict, EffortWeight, ForceFilter, HandImpedance, Robot, VelocityLoop,
};
pub use certified_count::{AtAngle, StabilityVerdict};
pub use coupling::Coupler;
pub use coupling::LeastDamping;
pub use dynamics::Dynamics;
pub use error::AnalysisError;
pub use fracdiff::parameter::RangeError;
pub use hand_port::HandPort;
pub use largest::Largest;
pub use law_set::{LawElements, LawSet, PotRange, SetVerdict, prove_laws};
pub use margin::WallMargins;
pub use nearest::{WantedNumber, nearest};
pub use noise::NoiseGain;
pub use object::{CoupledLoop, CoupledObject, CouplerOperator};
pub use operator::LoopOperator;
pub use outline::{OutlinePoint, Polygon};
pub use passivity::OnePort;
pub use passivity::RequiredDelta;
pub use passivity::corollary_delta;
pub use path::ForcePath;
pub use plant::SampledPlant;
pub use region::{StabilityRegion, StableArea};
pub use slope::SlopeLimit;
pub use stability::{Nondimensional, SampledLoop};
pub use teleoperation::{
    AbsoluteStability, BestCoupler, CouplerSearch, HandCoupler, HandLine, HandMass, LargestDelay,
    Teleoperation, Transparency,
};
pub use transparency::ClosedLoop;
pub use transparency::{Effective, SampledWall};

/// Complex numbers: [`num_complex::Complex`].
pub use num_complex;
