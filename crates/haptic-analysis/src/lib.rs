#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod arrangement;
mod circle;
mod coupling;
mod curve;
mod decomposition;
mod dynamics;
mod environment;
mod error;
mod extremum;
mod jury;
mod largest;
mod least_damping;
mod linear;
mod margin;
mod operator;
mod outline;
mod parameters;
mod passivity;
mod path;
mod plant;
mod region;
mod stability;
mod strip;
mod transition;
mod transparency;

pub use coupling::{Coupler, HybridMatrix, Llewellyn};
pub use dynamics::Dynamics;
pub use environment::{Effective, Environment};
pub use error::AnalysisError;
pub use jury::{Jury, companion_eigenvalues, jury};
pub use largest::Largest;
pub use least_damping::LeastDamping;
pub use margin::{AtAngle, Margins};
pub use operator::LoopOperator;
pub use parameters::{Loop, Nondimensional};
pub use passivity::{OnePort, RequiredDamping, RequiredDelta, corollary_delta};
pub use path::ForcePath;
pub use plant::SampledPlant;
pub use region::{BoundaryPoint, Polygon, StabilityRegion, StableArea};
pub use stability::{SampledLoop, Verdict};
pub use transparency::{ClosedLoop, DelayedLoop};
