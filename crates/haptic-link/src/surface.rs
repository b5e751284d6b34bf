//! A surface for the law of a run, on a device of several axes.

use crate::sample::AXES_MAX;
use heapless::Vec;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// The kind of a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum SurfaceKind {
    /// A plane.
    #[default]
    Plane,
    /// A ball, with the law inside.
    Ball,
    /// A hollow ball, with the law around it.
    HollowBall,
}

/// A surface: the law sees the depth into it, and its force acts along the normal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct SurfaceShape {
    /// Tells how the numbers below are read.
    pub kind: SurfaceKind,
    /// The distance of a plane from 0 along its normal, the radius of a ball, m.
    pub distance_m: f32,
    /// An element an axis: the unit normal of a plane, into the law; the centre of a ball, m.
    pub axes: Vec<f32, AXES_MAX>,
}
