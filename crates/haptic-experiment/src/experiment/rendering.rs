//! A tissue rendered on the simulated rig: everything that relaxation and creep share.

mod device;
mod history;
pub(crate) mod keys;
mod metadata;
pub(crate) mod outcome;
pub(crate) mod reading;
mod report;
mod running;
mod specification;

pub use report::{Quantity, Report, TheoryCurves};
pub use specification::{Contact, Precision, Rendering};
