//! A drawing: a sheet of paper and the few kinds of things that lie on it.
//!
//! Places are in CSS pixels from the upper left corner. They are rounded to hundredths here, so that both writers, of
//! SVG text and of pixels, have the same numbers.

use crate::style::{INK, Stroke};
use crate::thin::{Place, Points};

/// A sheet of white paper and the things on it: each covers those before.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Drawing {
    pub(crate) width: f64,
    pub(crate) height: f64,
    /// Width on paper, m; without one a pixel is that of CSS.
    pub(crate) printed_m: Option<f64>,
    pub(crate) items: Vec<Item>,
}

impl Drawing {
    pub(crate) fn new(width: f64, height: f64) -> Self {
        Self {
            width: hundredths(width),
            height: hundredths(height),
            printed_m: None,
            items: Vec::new(),
        }
    }

    /// Puts a text on top.
    pub(crate) fn text(&mut self, text: Text) {
        self.items.push(Item::Text(text));
    }
}

/// A thing on the paper.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Item {
    /// Things whose places count from `by`.
    Moved {
        by: Place,
        items: Vec<Item>,
    },
    /// Straight lines in one stroke.
    Ruled(Ruled),
    /// Things of which only what is within a box is seen. Corners of lines are round here, and a ring within another is a hole.
    Boxed {
        name: char,
        edges: Rectangle,
        items: Vec<Item>,
    },
    Curves {
        pieces: Vec<Points>,
        stroke: Stroke,
    },
    /// The insides of closed rings.
    Area {
        rings: Vec<Points>,
        colour: &'static str,
        opacity: f64,
    },
    /// The middles of markers that look alike.
    Markers(Points, Marker),
    Text(Text),
}

impl Item {
    pub(crate) fn curves(pieces: &[Points], stroke: Stroke) -> Self {
        Self::Curves {
            pieces: pieces.iter().map(|piece| rounded_all(piece)).collect(),
            stroke,
        }
    }

    pub(crate) fn area(rings: &[Points], colour: &'static str, opacity: f64) -> Self {
        Self::Area {
            rings: rings.iter().map(|ring| rounded_all(ring)).collect(),
            colour,
            opacity,
        }
    }

    pub(crate) fn markers(middles: &[Place], marker: Marker) -> Self {
        Self::Markers(rounded_all(middles), marker)
    }
}

/// Look of all markers of a series.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Marker {
    pub(crate) shape: Shape,
    pub(crate) radius: f64,
    /// Colour within the rim; `None` leaves it transparent.
    pub(crate) inside: Option<&'static str>,
    pub(crate) rim: Stroke,
}

/// Straight lines in one stroke, and the border of a box if there is one.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Ruled {
    pub(crate) colour: &'static str,
    pub(crate) width: f64,
    pub(crate) border: Option<Rectangle>,
    pub(crate) lines: Vec<(Place, Place)>,
}

impl Ruled {
    pub(crate) fn new(colour: &'static str, width: f64) -> Self {
        Self {
            colour,
            width,
            border: None,
            lines: Vec::new(),
        }
    }

    /// Puts a line on top.
    pub(crate) fn line(&mut self, from: Place, to: Place) {
        self.lines.push((rounded(from), rounded(to)));
    }
}

/// A rectangle along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rectangle {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) width: f64,
    pub(crate) height: f64,
}

impl Rectangle {
    pub(crate) fn new((left, top): Place, (right, bottom): Place) -> Self {
        Self {
            x: hundredths(left),
            y: hundredths(top),
            width: hundredths(right - left),
            height: hundredths(bottom - top),
        }
    }
}

/// The part of a text that stands at its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Text {
    /// `^μ` and `^{…}` in it are superscripts.
    pub(crate) content: String,
    pub(crate) place: Place,
    pub(crate) size: u32,
    pub(crate) anchor: Anchor,
    pub(crate) upright: bool,
    pub(crate) colour: &'static str,
}

impl Text {
    /// Black text from a place on. Control characters, which no XML can hold and no font can show, are left out.
    pub(crate) fn new(content: &str, x: f64, y: f64, size: u32) -> Self {
        Self {
            content: content.chars().filter(|c| !c.is_control()).collect(),
            place: rounded((x, y)),
            size,
            anchor: Anchor::Start,
            upright: false,
            colour: INK,
        }
    }

    /// Anchors the text at its middle or end.
    pub(crate) fn anchored(self, anchor: Anchor) -> Self {
        Self { anchor, ..self }
    }
}

/// Nobody sees a hundredth of a pixel, and further digits only make files large.
pub(crate) fn hundredths(value: f64) -> f64 {
    (100.0 * value).round() / 100.0
}

fn rounded((x, y): Place) -> Place {
    (hundredths(x), hundredths(y))
}

fn rounded_all(places: &[Place]) -> Points {
    places.iter().copied().map(rounded).collect()
}

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
    /// Four cubic curves, from the left by the top: radius, and length of their handles. Both in pixels.
    ///
    /// Written as arcs each reader would flatten them by rules of its own.
    Circle { radius: f64, handle: f64 },
    /// Whole tenths of a pixel, so that steps from corner to corner end where they began.
    Corners(Vec<(f64, f64)>),
}

impl Shape {
    pub(crate) const CROSS_INDEX: usize = 6;

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
                let (y, x) = libm::sincos(
                    std::f64::consts::TAU * (f64::from(i) / f64::from(corners) + turn),
                );
                (radius(i) * x, radius(i) * y)
            };
            (0..corners).map(corner).collect()
        };
        let bars = |turn: f64| {
            let (sin, cos) = libm::sincos(turn);
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
            // (4/3)·(√2 − 1): off by 3e-4 of the radius at most.
            let handle = hundredths(0.552_284_75 * radius);
            return Outline::Circle { radius, handle };
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
    fn places_are_rounded_to_hundredths() {
        let mut ruled = Ruled::new(INK, 1.0);
        ruled.line((1.0 / 3.0, 80.710_000_000_1), (0.0, -2.0 / 3.0));
        assert_eq!(ruled.lines, [((0.33, 80.71), (0.0, -0.67))]);
        let rectangle = Rectangle::new((0.004, 0.0), (10.006, 1.0));
        assert_eq!((rectangle.x, rectangle.width), (0.0, 10.0));
    }

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
