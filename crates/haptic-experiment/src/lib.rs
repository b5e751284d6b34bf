#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

pub mod document;
pub mod experiment;
pub mod judge;
mod open;
pub mod question;
pub mod run;

pub use document::failure::Failure;
pub use document::named::Named;
pub use experiment::coupler::{CouplerExperiment, CouplerReport};
pub use experiment::indentation::{Indentation, Load, Report};
pub use experiment::rendering::{Contact, Precision, Rendering};
pub use experiment::teleoperation::{TeleoperationExperiment, TeleoperationReport};
pub use experiment::touch::{TouchExperiment, TouchReport};
pub use experiment::trial::{TrialPlan, TrialReport, TrialSetup, dynamics};
pub use experiment::wall::{WallExperiment, WallReport};
pub use haptic_analysis::Dynamics;
pub use judge::modelled_tissue::{ModelledTissue, TissuePiece};
pub use judge::preflight::Matter;
pub use judge::report::{RunReport, Summary};
pub use judge::rows::{Line, Row, Table, lines};
pub use judge::settling::{Criterion, Settling, TrialVerdict};
pub use open::ExperimentFile;
pub use open::parameters;
pub use question::bench::AskedDevice;
pub use question::zwidth::{ZWidth, ZWidthReport, dissertation_device};
pub use run::Supervisor;
pub use run::preflight::{PreflightRequest, PreflightVerdict};
pub use run::realtime::{RealtimeOptions, RealtimeSummary};
pub use run::safety::{GuardChoice, Safety};
pub use run::schedule::Pace;
pub use run::sensors::{Imperfections, Sensors};
