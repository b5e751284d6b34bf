//! Experiments on the simulated rig: run the loop, keep the log, judge the result.

pub mod creep;
pub mod judge;
pub mod outcome;
pub mod recorder;
pub mod relaxation;
pub mod rendering;
pub mod report;
pub mod run;
pub mod sensed;
pub mod zwidth;

pub use creep::Creep;
pub use relaxation::Relaxation;
pub use rendering::{Contact, Precision, Rendering};
pub use report::{Report, Warnings};
pub use run::{Pace, Supervisor};
pub use sensed::{Sensed, Sensors};
pub use zwidth::{ZWidth, ZWidthReport, dissertation_device};
