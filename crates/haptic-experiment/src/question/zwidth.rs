//! Z-width: how stiff a wall can be rendered, by trying (after the dissertation's section 4.4).
//!
//! The device hits a wall at its start position and is pushed into it; the rule by which it comes to rest is
//! that of [`settling`](crate::judge::settling). For each dissipation B the largest stable stiffness K is bracketed
//! from above on a coarse scale and then bisected. Beside it stands what the analysis says. A device at a port
//! is tried from soft walls up instead, and few times beyond its limits.
//! Cells are independent and run on all cores; each has a seed of its own, made from the
//! seed of the experiment and the cell's place, so the result does not depend on the number of cores.
//! - *Friction* can hold a wall that would shake. So a device with friction is tried with and without: stable is
//!   what settles both ways, and how far friction alone holds it stands beside.
//! - *Cost*: about 60 runs of a quarter of a millisecond a cell, twice that with friction.
//!
//! Source: O. Tokatlı, *Fractional Order Control in Haptics*, section 4.4, figure 4.3.

pub(crate) mod keys;
pub(crate) mod reading;
mod report;
mod running;
mod search;
mod specification;
mod theory;
mod trials;
mod upward;

pub use report::{BoundaryPoint, BoundaryRow, OrderBoundary, ZWidthReport};
pub use specification::{ZWidth, dissertation_device};
