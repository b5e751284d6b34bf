//! A wall: a device hits it, is pushed into it with a constant force, and settles or not.
//!
//! ```text
//! m·x'' + b·x' + k·x = push + f,   f = −(K·x + B·D^μ x) through the safety chain,   x(0) = 0, x'(0) = impact
//! at rest: x = push/(K + k), and B beside K for μ = 0
//! ```
//! The wall is linear, as theory assumes, unless it is asked to push only. The rule by which a device is at
//! rest is that of [`settling`](crate::judge::settling). A device with friction that settles is tried again without:
//! if it then does not, friction alone holds it.
//!
//! Source: O. Tokatlı, *Fractional Order Control in Haptics*, section 4.4, figure 4.3.

pub(crate) mod keys;
pub(crate) mod reading;
mod report;
mod running;
mod specification;
mod verdict;

pub use report::{WallCurves, WallReport};
pub use specification::WallExperiment;
