//! A tissue rendered on the simulated rig: everything that relaxation and creep share.

mod device;
mod history;
mod metadata;
mod running;
mod specification;

pub use specification::{Contact, Precision, Rendering};
