//! Measurements of a device at a port, or of a simulated one, from their document to their report.

mod answer;
pub(super) mod serial;

pub use answer::{MeasureReport, Measurement};
