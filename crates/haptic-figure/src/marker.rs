//! Markers: shapes of like size that are told apart without colour.

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

/// A marker, to be drawn around its middle.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Outline {
    /// By its radius, px.
    Circle(f64),
    /// Whole tenths of a pixel, so that steps from corner to corner end where they began.
    Corners(Vec<(f64, f64)>),
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

    /// A marker of this shape around the origin.
    pub(crate) fn outline(self, radius: f64) -> Outline {
        if self == Self::Circle {
            return Outline::Circle(radius);
        }
        let tenths = |length: f64| (10.0 * radius * length).round();
        let corners = self.corners().into_iter();
        Outline::Corners(corners.map(|(x, y)| (tenths(x), tenths(y))).collect())
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
            if let Outline::Corners(tenths) = shape.outline(4.0) {
                for ((x, y), corner) in tenths.iter().zip(&corners) {
                    let off = f64::hypot(x / 40.0 - corner.0, y / 40.0 - corner.1);
                    assert!(off < 0.02, "{shape:?}: {off}");
                }
                assert_eq!(tenths.len(), corners.len());
            }
        }
    }
}
