//! The hand: a path, and how it holds the device on it. And the shape that is touched.

use super::{TOUCH_NORMAL, TOUCH_SURFACE};
use fracdiff::Operator;
use haptic_document::{Failure, named};
use haptic_loop::{Ball, Contact, Plane, Shape, SpringDamper, units::Metres};
use std::f64::consts::{PI, TAU};

/// Means by which the hand moves the device.
#[derive(Clone, Copy, Debug)]
pub(super) enum Grip {
    /// Spring to the point of the path, N/m, above 0.
    Spring(f64),
    /// Force that is the point of the path, N.
    Force,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GripName {
    Spring,
    Force,
}

named! { GripName:
    Spring = "spring", "A spring to a point that moves along the path";
    Force = "force", "A force that follows the path";
}

/// Path of the hand over time, m or N.
#[derive(Clone, Debug)]
pub(super) enum HandPath {
    /// Straight from row to row: time in s, then a number an axis. Before the first and behind the last row it stands.
    WayPoints(Vec<(f64, Vec<f64>)>),
    /// A circle in the plane of the first two axes, m, beginning along the first. From `start_radius` the hand spirals to
    /// `radius` in 1 s.
    Circle(Circle),
}

#[derive(Clone, Debug)]
pub(super) struct Circle {
    /// One number for each axis, as the keys of the file give them.
    pub centre: Vec<f64>,
    pub start_radius: f64,
    pub radius: f64,
    /// Time per turn, s, above 0.
    pub period_s: f64,
}

impl HandPath {
    /// Time in which a circle is reached, s.
    const APPROACH_S: f64 = 1.0;

    /// Coordinate of an axis at a time, s.
    pub(super) fn at(&self, time_s: f64, axis: usize) -> f64 {
        match self {
            Self::Circle(circle) => {
                // (1 − cos)/2 of the way in.
                let share = (time_s / Self::APPROACH_S).clamp(0.0, 1.0);
                let risen = 0.5 * (1.0 - libm::cos(PI * share));
                let start = circle.start_radius;
                let radius = start + risen * (circle.radius - start);
                let angle = TAU * time_s / circle.period_s;
                let round = match axis {
                    0 => libm::cos(angle),
                    1 => libm::sin(angle),
                    _ => 0.0,
                };
                circle.centre.get(axis).copied().unwrap_or(0.0) + radius * round
            }
            Self::WayPoints(rows) => {
                let coordinate = |row: &(f64, Vec<f64>)| row.1.get(axis).copied().unwrap_or(0.0);
                let next = rows.partition_point(|row| row.0 <= time_s);
                match (next.checked_sub(1).map(|n| &rows[n]), rows.get(next)) {
                    (Some(from), Some(to)) => {
                        let share = (time_s - from.0) / (to.0 - from.0);
                        coordinate(from) + share * (coordinate(to) - coordinate(from))
                    }
                    (Some(row), None) | (None, Some(row)) => coordinate(row),
                    (None, None) => 0.0,
                }
            }
        }
    }

    pub(super) fn words(&self) -> String {
        match self {
            Self::WayPoints(rows) => format!("{} way points", rows.len()),
            Self::Circle(circle) => {
                let (radius_mm, period_s) = (1e3 * circle.radius, circle.period_s);
                format!("a circle of {radius_mm} mm in {period_s} s")
            }
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ShapeName {
    Plane,
    Ball,
    /// A room in the form of a ball.
    HollowBall,
}

named! { ShapeName:
    Plane = "plane", "A plane";
    Ball = "ball", "A disc with two axes, a sphere with three";
    HollowBall = "hollow-ball", "A room inside a ball";
}

#[derive(Debug)]
pub(super) enum TouchShape {
    Plane {
        /// Direction into it, a number an axis, of any length above 0.
        normal: Vec<f64>,
        /// Its distance from 0 along that, m.
        surface_m: f64,
    },
    Ball(TouchBall),
}

#[derive(Debug)]
pub(super) struct TouchBall {
    /// One number for each axis, m.
    pub centre_m: Vec<f64>,
    pub radius_m: f64,
    /// True if the tissue lies around the ball, not inside.
    pub hollow: bool,
}

impl TouchShape {
    /// The shape with D axes.
    pub(super) fn of<const D: usize>(&self) -> Result<Shape<f64, D>, Failure> {
        match self {
            Self::Plane { normal, surface_m } => {
                let plane = Plane::new(per_axis(normal), Metres(*surface_m));
                let plane = plane.map_err(|error| {
                    let advice = format_args!("change {TOUCH_NORMAL} or {TOUCH_SURFACE}");
                    Failure::input_with_advice(error, advice)
                })?;
                Ok(Shape::Plane(plane))
            }
            Self::Ball(ball) => {
                let (centre, radius) = (per_axis(&ball.centre_m), Metres(ball.radius_m));
                let ball = if !ball.hollow {
                    Ball::solid(centre.map(Metres), radius)
                } else {
                    Ball::hollow(centre.map(Metres), radius)
                };
                Ok(Shape::Ball(ball.map_err(Failure::input)?))
            }
        }
    }

    pub(super) fn words(&self) -> String {
        match self {
            Self::Plane { normal, .. } if normal.len() == 2 => "straight edge".to_owned(),
            Self::Plane { .. } => "plane".to_owned(),
            Self::Ball(ball) => {
                let is_flat = ball.centre_m.len() == 2;
                let round = if is_flat { "disc" } else { "sphere" };
                let room = if ball.hollow { "room, a " } else { "" };
                format!("{room}{round} of {} mm", 1e3 * ball.radius_m)
            }
        }
    }
}

/// One number for each axis.
pub(super) fn per_axis<const D: usize>(numbers: &[f64]) -> [f64; D] {
    std::array::from_fn(|axis| numbers.get(axis).copied().unwrap_or(0.0))
}

/// A shape with the law behind it.
pub(super) type Touched<const D: usize> =
    Contact<f64, SpringDamper<f64, Operator<f64>>, D, Shape<f64, D>>;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn way_points_are_joined_by_straight_lines_and_end_where_they_end() {
        let path = HandPath::WayPoints(vec![
            (0.5, vec![0.0, 1.0]),
            (1.5, vec![2.0, 1.0]),
            (2.0, vec![2.0, -1.0]),
        ]);
        for (time_s, want) in [
            (0.0, [0.0, 1.0]),
            (0.5, [0.0, 1.0]),
            (1.0, [1.0, 1.0]),
            (1.75, [2.0, 0.0]),
            (9.0, [2.0, -1.0]),
        ] {
            for (axis, want) in want.into_iter().enumerate() {
                let have = path.at(time_s, axis);
                assert!((have - want).abs() < 1e-15, "{time_s} s, {axis}: {have}");
            }
        }
    }

    #[test]
    fn a_circle_begins_along_the_first_axis_and_comes_back() {
        let path = HandPath::Circle(Circle {
            centre: vec![0.1, 0.2, 0.3],
            start_radius: 0.06,
            radius: 0.05,
            period_s: 2.0,
        });
        for (time_s, want) in [
            (0.0, [0.16, 0.2, 0.3]),
            (0.5, [0.1, 0.255, 0.3]),
            (1.0, [0.05, 0.2, 0.3]),
            (1.5, [0.1, 0.15, 0.3]),
            (3.0, [0.05, 0.2, 0.3]),
        ] {
            for (axis, want) in want.into_iter().enumerate() {
                assert!((path.at(time_s, axis) - want).abs() < 1e-15);
            }
        }
    }
}
