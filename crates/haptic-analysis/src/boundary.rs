//! The boundary of a region: its points and polygons.

use crate::decomposition::Sample;

/// One corner or point of a boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundaryPoint {
    /// α.
    pub alpha: f64,
    /// β.
    pub beta: f64,
    /// The angle at which a pole crosses the circle there, rad/sample; `None` on an axis.
    pub theta: Option<f64>,
}

/// A closed boundary; the last point is followed by the first. The region lies to its left: an
/// outer boundary runs anticlockwise, that of a hole clockwise.
#[derive(Clone, Debug, PartialEq)]
pub struct Polygon {
    /// In order.
    pub points: Vec<BoundaryPoint>,
    /// Enclosed area, negative for a hole; by cubics between the points, not by chords.
    pub area: f64,
}

impl Polygon {
    pub(crate) fn contains(&self, alpha: f64, beta: f64) -> bool {
        let mut inside = false;
        let Some(mut a) = self.points.last() else {
            return false;
        };
        for b in &self.points {
            if (a.beta > beta) != (b.beta > beta) {
                let share = (beta - a.beta) / (b.beta - a.beta);
                inside ^= alpha < a.alpha + share * (b.alpha - a.alpha);
            }
            a = b;
        }
        inside
    }
}

/// A point for a picture, from a sample.
pub(crate) fn boundary_point(sample: &Sample) -> BoundaryPoint {
    BoundaryPoint {
        alpha: sample.point[0].max(0.0),
        beta: sample.point[1].max(0.0),
        theta: (!sample.theta.is_nan()).then_some(sample.theta),
    }
}
