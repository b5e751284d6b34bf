//! A surface for the law of a run, on a device of several axes.

use crate::sample::AXES_MAX;
use heapless::Vec;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// The kind of a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum SurfaceKind {
    /// A plane, with the law where its normal points.
    #[default]
    Plane,
    /// A ball, with the law inside.
    Ball,
    /// A hollow ball, with the law around it.
    HollowBall,
}

/// A surface: the law receives the depth into it, and its force acts along the normal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct SurfaceShape {
    /// The kind of surface, which gives the numbers below their meaning.
    pub kind: SurfaceKind,
    /// Distance of a plane from 0 along the normal, or radius of a ball, m.
    pub distance_m: f32,
    /// One element per axis: for a plane the unit normal, pointing into the law; for a ball the
    /// centre, m.
    pub axes: Vec<f32, AXES_MAX>,
}
