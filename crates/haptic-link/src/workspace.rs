//! Where a device of several axes may move, axis by axis.

use crate::sample::AXES_MAX;
use heapless::Vec;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// The range in which a device may move on an axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct AxisWorkspace {
    /// Lowest position, m, −100 to 100.
    pub low_m: f32,
    /// Highest position, m, above the lowest, at most 100. Beyond either a fault latches.
    pub high_m: f32,
    /// Width of the zones at both ends in which an outward motion is braked, m, 0 or 1e-6 to half the range.
    pub soft_m: f32,
}

/// A workspace of its own for each axis of a device of several, in a run. Where [`Limits`](crate::Limits) has a workspace for
/// all axes, this one lies in it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct WorkspaceBox {
    /// An element an axis.
    pub axes: Vec<AxisWorkspace, AXES_MAX>,
}
