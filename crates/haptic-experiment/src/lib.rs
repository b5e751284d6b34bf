#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
#![warn(unreachable_pub)]

pub mod experiment;
pub mod judge;
pub mod live;
mod open;
pub mod question;

pub use experiment::indentation::Indentation;
pub use experiment::press::{PressRecord, specimen};
pub use haptic_analysis::Dynamics;
pub use haptic_document::{Cause, Failure, Named, ReportLine, ReportTable, Row, lines, named};
pub use haptic_judge::rendering::Precision;
pub use haptic_trial::{GuardChoice, Imperfections, Sensors};
pub use judge::Report;
pub use open::{DocumentOfKind, ExperimentFile, parameters, pressed};
