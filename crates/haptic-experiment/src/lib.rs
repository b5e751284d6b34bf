#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

#[cfg(test)]
mod bounded_tests;
pub mod creep;
pub mod curves;
pub mod design;
pub mod device;
pub mod failure;
pub mod file;
pub mod flight;
pub mod folder;
pub mod imperfections;
pub mod input;
pub mod judge;
pub mod kept;
pub mod modelled;
pub mod named;
pub mod outcome;
pub mod preflight;
mod pushed;
pub mod realtime;
pub mod recorder;
pub mod refused;
pub mod relaxation;
pub mod remote;
pub mod rendering;
pub mod report;
pub mod rt_check;
pub mod run;
pub mod safety;
pub mod sensed;
pub mod settling;
mod thinned;
mod track;
pub mod trials;
pub mod wall;
pub mod zwidth;

pub use creep::Creep;
pub use failure::Failure;
pub use file::ExperimentFile;
pub use imperfections::Imperfections;
pub use modelled::ModelledTissue;
pub use named::Named;
pub use preflight::{Dynamics, PreflightRequest};
pub use pushed::{TrialPlan, dynamics};
pub use realtime::{RealtimeOptions, RealtimeSummary};
pub use relaxation::Relaxation;
pub use rendering::{Contact, Precision, Rendering};
pub use report::{Report, RunReport, Summary, Warnings};
pub use run::{Pace, Supervisor};
pub use safety::{GuardChoice, Safety};
pub use sensed::{Sensed, Sensors};
pub use settling::{Criterion, CriterionName, Settling, TrialVerdict};
pub use wall::{Wall, WallReport};
pub use zwidth::{ZWidth, ZWidthReport, dissertation_device};
