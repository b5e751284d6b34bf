//! Straight lines in the α–β plane, and where something cuts them.

use crate::decomposition::Sample;

/// The straight line n·(α, β) = c between two points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Straight {
    pub(crate) ends: [[f64; 2]; 2],
    pub(crate) normal: [f64; 2],
    pub(crate) offset: f64,
    /// The angle at which F = 0 on it; `None` for an axis.
    pub(crate) theta: Option<f64>,
    /// The side that can be stable: that of the normal, the other, or (`None`) either.
    pub(crate) stable_side: Option<bool>,
}

/// A cut: where on the edge (θ, or a share of the straight line), and the point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cut {
    pub(crate) at: f64,
    pub(crate) point: [f64; 2],
}

pub(crate) fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    libm::hypot(a[0] - b[0], a[1] - b[1])
}

/// Points nearer than this are one.
pub(crate) fn near(a: [f64; 2], b: [f64; 2]) -> bool {
    distance(a, b) <= 1e-11 * (1.0 + a[0].abs() + a[1].abs())
}

impl Straight {
    pub(crate) fn height(&self, point: [f64; 2]) -> f64 {
        self.normal[0] * point[0] + self.normal[1] * point[1] - self.offset
    }

    /// Place of a point along the line, 0 to 1 between the ends.
    pub(crate) fn share(&self, point: [f64; 2]) -> f64 {
        let [a, b] = self.ends;
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        ((point[0] - a[0]) * dx + (point[1] - a[1]) * dy) / (dx * dx + dy * dy)
    }

    pub(crate) fn at(&self, share: f64) -> [f64; 2] {
        let [a, b] = self.ends;
        [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])]
    }

    /// The cut at a point of the line, exactly on it, so that a cut of an axis is not a rounding error
    /// beside it. A point within its `error` of an end is the end; beyond there is none.
    pub(crate) fn meet(&self, point: [f64; 2], error: f64) -> Option<Cut> {
        let share = self.share(point);
        let known = [0.0, 1.0].into_iter().find(|&end| {
            let end = self.at(end);
            near(end, point) || distance(end, point) <= error
        });
        let at = known.or((0.0..=1.0).contains(&share).then_some(share))?;
        Some(Cut {
            at,
            point: self.at(at),
        })
    }

    /// As samples, for what handles both kinds alike.
    pub(crate) fn sample(&self, point: [f64; 2]) -> Sample {
        Sample {
            theta: self.theta.unwrap_or(f64::NAN),
            point,
            tangent: [0.0, 0.0],
            leftward: false,
        }
    }
}
