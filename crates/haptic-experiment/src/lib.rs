#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
#![warn(unreachable_pub)]

pub mod document;
pub mod experiment;
pub mod judge;
pub mod live;
mod open;
pub mod question;
pub mod run;

pub use document::failure::{Cause, Failure};
pub use document::named::Named;
pub use experiment::indentation::Indentation;
pub use experiment::press::{PressRecord, specimen};
pub use experiment::reading::pressed;
pub use experiment::rendering::Precision;
pub use experiment::trial::TrialPlan;
pub use haptic_analysis::Dynamics;
pub use judge::Report;
pub use judge::control;
pub use judge::modelled_tissue::{ModelledTissue, TissuePiece};
pub use judge::preflight::Matter;
pub use judge::rows::{ReportLine, Row, Table, lines};
pub use judge::settling::Settling;
pub use open::{ExperimentFile, parameters};
pub use run::Supervisor;
pub use run::preflight::PreflightVerdict;
pub use run::realtime::RealtimeOptions;
pub use run::safety::GuardChoice;
pub use run::schedule::Pace;
pub use run::sensors::{Imperfections, Sensors};
