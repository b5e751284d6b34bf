//! Markers: shapes of like size that are told apart without colour.

use std::fmt::Write as _;

/// Outline of a marker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shape {
    Circle,
    Square,
    Triangle,
    Diamond,
    Plus,
    Wedge,
    Cross,
    Star,
}

impl Shape {
    /// The shape of the markers of a series. One more than colours, as with dashes.
    pub(crate) fn of_series(index: usize) -> Self {
        let shapes = [
            Self::Circle,
            Self::Square,
            Self::Triangle,
            Self::Diamond,
            Self::Plus,
            Self::Wedge,
            Self::Cross,
            Self::Star,
        ];
        shapes[index % shapes.len()]
    }

    /// Corners around the origin, for a marker of about the area of a circle of radius 1.
    fn corners(self) -> Vec<(f64, f64)> {
        let around = |corners: u32, radius: fn(u32) -> f64, turn: f64| {
            let corner = |i| {
                let (y, x) = f64::sin_cos(
                    std::f64::consts::TAU * (f64::from(i) / f64::from(corners) + turn),
                );
                (radius(i) * x, radius(i) * y)
            };
            (0..corners).map(corner).collect()
        };
        let bars = |turn: f64| {
            let (sin, cos) = f64::sin_cos(turn);
            let (long, thin) = (1.25, 0.38);
            let quarter = [(long, -thin), (long, thin), (thin, thin)];
            let quarters = (0..4).flat_map(|turns| {
                quarter.map(|(x, y)| match turns {
                    0 => (x, y),
                    1 => (-y, x),
                    2 => (-x, -y),
                    _ => (y, -x),
                })
            });
            quarters
                .map(|(x, y)| (cos * x - sin * y, sin * x + cos * y))
                .collect()
        };
        match self {
            Self::Circle => Vec::new(),
            Self::Square => around(4, |_| 1.25, 0.125),
            Self::Triangle => around(3, |_| 1.4, -0.25),
            Self::Wedge => around(3, |_| 1.4, 0.25),
            Self::Diamond => around(4, |_| 1.35, 0.0),
            Self::Plus => bars(0.0),
            Self::Cross => bars(std::f64::consts::FRAC_PI_4),
            Self::Star => around(10, |i| if i % 2 == 0 { 1.55 } else { 0.65 }, -0.25),
        }
    }

    /// A marker of this shape as SVG path data relative to its middle; begins with `m`.
    pub(crate) fn outline(self, radius: f64) -> String {
        if self == Self::Circle {
            let (r, across) = (radius, 2.0 * radius);
            return format!("m-{r} 0a{r} {r} 0 1 0 {across} 0a{r} {r} 0 1 0-{across} 0z");
        }
        let mut outline = String::new();
        let mut from = (0.0, 0.0);
        for (x, y) in self.corners() {
            // Rounded first, so that the steps end where they began.
            let to = ((10.0 * radius * x).round(), (10.0 * radius * y).round());
            let start = if outline.is_empty() { "m" } else { " " };
            let (dx, dy) = ((to.0 - from.0) / 10.0, (to.1 - from.1) / 10.0);
            let _ = write!(outline, "{start}{dx} {dy}");
            from = to;
        }
        outline + "z"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markers_are_of_like_size_and_end_where_they_began() {
        let shapes: Vec<Shape> = (0..8).map(Shape::of_series).collect();
        for (index, shape) in shapes.iter().enumerate() {
            assert_eq!(shapes.iter().position(|other| other == shape), Some(index));
            let corners = shape.corners();
            let twice_area: f64 = (corners.iter().zip(corners.iter().cycle().skip(1)))
                .map(|(a, b)| a.0 * b.1 - a.1 * b.0)
                .sum();
            let area = if corners.is_empty() {
                std::f64::consts::PI
            } else {
                twice_area / 2.0
            };
            assert!((2.0..4.0).contains(&area), "{shape:?}: {area}");
            let outline = shape.outline(4.0);
            assert!(
                outline.starts_with('m') && outline.ends_with('z'),
                "{outline}"
            );
        }
    }
}
