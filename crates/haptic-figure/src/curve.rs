//! What stands in the box of a panel: lines, areas and markers, and their samples in the legend.

use std::fmt::Write as _;

use kuva::render::render::{PathData, Primitive};

use super::axis::Axis;
use super::clip::clip;
use super::style::Stroke;
use super::thin::{Points, scatter, simplify};

/// How much of the colour of its outline an area has.
const AREA_OPACITY: f64 = 0.1;
/// The rim that sets a marker off from what lies beneath it.
const RIM: &str = "white";
const RIM_WIDTH: f64 = 0.8;
/// A marker takes as much of a file as so many points of a line.
const POINTS_OF_A_MARKER: usize = 5;
/// Length and height of a sample in the legend.
pub(super) const SAMPLE_LENGTH: f64 = 40.0;
const SAMPLE_HEIGHT: f64 = 14.0;

/// A curve, drawn in the order given: the first lies beneath.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Curve {
    /// Between two pieces there is a gap; the pieces of an area are closed, and one within another
    /// is a hole.
    pub(super) pieces: Vec<Points>,
    pub(super) form: Form,
}

/// How the points of a curve are shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Form {
    Line(Stroke),
    Area(Stroke),
    Markers {
        colour: &'static str,
        shape: Shape,
        radius: f64,
        /// A marker that would cover part of an earlier one is left out.
        apart: bool,
    },
}

/// Outline of a marker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
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
    pub(super) fn of_series(index: usize) -> Self {
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
    fn outline(self, radius: f64) -> String {
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

/// Where a box lies, px.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BoxEdges {
    pub(super) left: f64,
    pub(super) right: f64,
    pub(super) top: f64,
    pub(super) bottom: f64,
}

/// What a curve is on the paper, from beneath to the top.
#[derive(Debug, Default)]
pub(super) struct Drawn {
    /// Insides of areas, which must not tint the lines of others; to be cut off at the edge of the
    /// box.
    pub(super) fills: Vec<Primitive>,
    /// To be cut off at the edge of the box.
    pub(super) lines: Vec<Primitive>,
    /// Markers: their middles are in the box, and at its edge they are whole.
    pub(super) markers: Vec<Primitive>,
}

impl Curve {
    /// All points of the curve.
    pub(super) fn points(&self) -> impl Iterator<Item = (f64, f64)> {
        self.pieces.iter().flatten().copied()
    }

    /// Whether any of it lies within axes.
    pub(super) fn is_within(&self, x: &Axis, y: &Axis) -> bool {
        !self.within(x, y).is_empty()
    }

    /// The pieces in and near the box, as fractions of the axes.
    fn within(&self, x: &Axis, y: &Axis) -> Vec<Points> {
        let inside = |fraction: f64| (-1e-9..=1.0 + 1e-9).contains(&fraction);
        let pieces = self.pieces.iter().map(|piece| {
            let placed = (piece.iter()).map(|point| (x.fraction(point.0), y.fraction(point.1)));
            match self.form {
                Form::Line(_) => clip(&placed.collect::<Points>(), false),
                Form::Area(_) => clip(&placed.collect::<Points>(), true),
                Form::Markers { .. } => placed
                    .filter(|point| inside(point.0) && inside(point.1))
                    .collect(),
            }
        });
        pieces.filter(|piece| !piece.is_empty()).collect()
    }

    /// Draws the curve with about `most` points in all. `placed` are the middles of the panel's markers so far.
    pub(super) fn draw(
        &self,
        x: &Axis,
        y: &Axis,
        edges: BoxEdges,
        most: usize,
        placed: &mut Points,
    ) -> Drawn {
        let mut pieces = self.within(x, y);
        for (x, y) in pieces.iter_mut().flatten() {
            *x = edges.left + *x * (edges.right - edges.left);
            *y = edges.bottom - *y * (edges.bottom - edges.top);
        }
        let mut drawn = Drawn::default();
        match self.form {
            Form::Line(stroke) => {
                // A gap on both sides of a point leaves no line to draw, and a line of more pieces
                // than the paper has room for is a cloud.
                let (mut dots, mut lines): (Vec<Points>, Vec<Points>) =
                    pieces.into_iter().partition(|piece| piece.len() == 1);
                if 4 * lines.len() > most {
                    dots.append(&mut lines);
                }
                let lines = simplify_all(lines, most);
                if !lines.is_empty() {
                    drawn.lines.push(path(&lines, stroke));
                }
                let dots = scatter(dots.concat(), most / POINTS_OF_A_MARKER);
                if !dots.is_empty() {
                    let (colour, radius) = (stroke.colour, 0.7 * stroke.width);
                    (drawn.markers).push(markers(&dots, Shape::Circle, radius, colour));
                }
            }
            Form::Area(stroke) => {
                let rings = simplify_all(pieces, most / 2);
                if !rings.is_empty() {
                    drawn.fills.push(fill(&rings, stroke.colour));
                    let outline = rings.iter().flat_map(|ring| outline(ring, edges));
                    drawn
                        .lines
                        .push(path(&outline.collect::<Vec<Points>>(), stroke));
                }
            }
            Form::Markers {
                colour,
                shape,
                radius,
                apart: is_apart,
            } => {
                let mut middles = scatter(pieces.concat(), most / POINTS_OF_A_MARKER);
                if is_apart {
                    middles = apart(middles, 2.0 * radius + RIM_WIDTH, placed);
                }
                placed.extend(&middles);
                if !middles.is_empty() {
                    (drawn.markers).push(markers(&middles, shape, radius, colour));
                }
            }
        }
        drawn
    }
}

impl Form {
    /// What stands for the form in the legend, from `x` on and around the height `y`.
    pub(super) fn sample(&self, x: f64, y: f64) -> Vec<Primitive> {
        let end = x + SAMPLE_LENGTH;
        match *self {
            Self::Line(stroke) => vec![path(&[vec![(x, y), (end, y)]], stroke)],
            Self::Area(stroke) => {
                let (top, bottom) = (y - SAMPLE_HEIGHT / 2.0, y + SAMPLE_HEIGHT / 2.0);
                let corners = [(x, top), (end, top), (end, bottom), (x, bottom), (x, top)];
                let ring = [corners.to_vec()];
                vec![fill(&ring, stroke.colour), path(&ring, stroke)]
            }
            Self::Markers {
                colour,
                shape,
                radius,
                ..
            } => vec![markers(
                &[(x + SAMPLE_LENGTH / 2.0, y)],
                shape,
                radius,
                colour,
            )],
        }
    }
}

/// The outline of an area, closed or, where it runs along a side of the box or outside, broken:
/// there the axis is the border.
fn outline(ring: &Points, edges: BoxEdges) -> Vec<Points> {
    const ON_A_SIDE: f64 = 0.02;
    let beyond = |(x, y): (f64, f64)| {
        [
            x < edges.left + ON_A_SIDE,
            x > edges.right - ON_A_SIDE,
            y < edges.top + ON_A_SIDE,
            y > edges.bottom - ON_A_SIDE,
        ]
    };
    let hidden = |from: (f64, f64), to: (f64, f64)| {
        let both = beyond(from).into_iter().zip(beyond(to));
        both.into_iter().any(|(from, to)| from && to)
    };
    let next = |index: usize| ring[(index + 1) % ring.len()];
    // Begun after a gap, no stretch between gaps is in two parts.
    let gap = (0..ring.len()).find(|&index| hidden(ring[index], next(index)));
    let start = gap.map_or(0, |index| index + 1);
    let mut outline: Vec<Points> = Vec::new();
    let mut joined = false;
    for index in (start..start + ring.len()).map(|index| index % ring.len()) {
        let (from, to) = (ring[index], next(index));
        if hidden(from, to) {
            joined = false;
            continue;
        }
        match outline.last_mut() {
            Some(stretch) if joined => stretch.push(to),
            _ => outline.push(vec![from, to]),
        }
        joined = true;
    }
    outline
}

/// The points at least this far from all before them and from all that are placed already.
fn apart(points: Points, distance: f64, placed: &Points) -> Points {
    let mut kept = Points::new();
    for (x, y) in points {
        let near =
            |&(other_x, other_y): &(f64, f64)| f64::hypot(x - other_x, y - other_y) < distance;
        if !placed.iter().chain(&kept).any(near) {
            kept.push((x, y));
        }
    }
    kept
}

/// Simplifies pieces to about `most` points in all, shared out by their lengths.
fn simplify_all(pieces: Vec<Points>, most: usize) -> Vec<Points> {
    let total = pieces.iter().map(Vec::len).sum::<usize>().max(1);
    let share = |piece: &Points| (most as f64 * piece.len() as f64 / total as f64) as usize;
    (pieces.into_iter())
        .map(|piece| {
            let share = share(&piece);
            simplify(piece, share)
        })
        .collect()
}

fn path(pieces: &[Points], stroke: Stroke) -> Primitive {
    Primitive::Path(Box::new(PathData {
        d: path_data(pieces),
        fill: None,
        stroke: stroke.colour.into(),
        stroke_width: stroke.width,
        opacity: None,
        stroke_dasharray: stroke.dash.map(str::to_owned),
    }))
}

fn fill(rings: &[Points], colour: &str) -> Primitive {
    Primitive::Path(Box::new(PathData {
        d: path_data(rings),
        fill: Some(colour.into()),
        stroke: "none".into(),
        stroke_width: 0.0,
        opacity: Some(AREA_OPACITY),
        stroke_dasharray: None,
    }))
}

fn path_data(pieces: &[Points]) -> String {
    let mut data = String::new();
    for piece in pieces {
        for (index, (x, y)) in piece.iter().enumerate() {
            let start = if index == 0 { "M" } else { " " };
            let _ = write!(data, "{start}{} {}", hundredths(*x), hundredths(*y));
        }
    }
    data
}

fn markers(middles: &[(f64, f64)], shape: Shape, radius: f64, colour: &str) -> Primitive {
    let outline = shape.outline(radius);
    let mut data = String::new();
    for (x, y) in middles {
        let _ = write!(data, "M{} {}{outline}", hundredths(*x), hundredths(*y));
    }
    Primitive::Path(Box::new(PathData {
        d: data,
        fill: Some(colour.into()),
        stroke: RIM.into(),
        stroke_width: RIM_WIDTH,
        opacity: None,
        stroke_dasharray: None,
    }))
}

fn hundredths(value: f64) -> f64 {
    (100.0 * value).round() / 100.0
}

#[cfg(test)]
mod tests {
    use super::*;

    const EDGES: BoxEdges = BoxEdges {
        left: 0.0,
        right: 100.0,
        top: 0.0,
        bottom: 50.0,
    };

    #[test]
    fn the_outline_of_an_area_leaves_out_what_runs_along_the_axes_or_outside() {
        let hill = vec![(0.0, 50.0), (40.0, 10.0), (80.0, 50.0)];
        assert_eq!(outline(&hill, EDGES), [hill]);
        let corner = vec![(30.0, 50.0), (0.0, 50.0), (0.0, 20.0), (20.0, 10.0)];
        let open = vec![(0.0, 20.0), (20.0, 10.0), (30.0, 50.0)];
        assert_eq!(outline(&corner, EDGES), [open]);
        let inside = vec![(10.0, 10.0), (20.0, 10.0), (20.0, 20.0)];
        let closed = [inside.clone(), vec![inside[0]]].concat();
        assert_eq!(outline(&inside, EDGES), [closed]);
        let around = vec![(-5.0, -5.0), (105.0, -5.0), (105.0, 55.0), (-5.0, 55.0)];
        assert!(outline(&around, EDGES).is_empty());
    }

    #[test]
    fn no_marker_that_is_to_keep_apart_covers_part_of_another() {
        let line: Points = (0..100)
            .map(|i| (f64::from(i), 0.5 * f64::from(i)))
            .collect();
        let first = apart(line.clone(), 9.0, &Vec::new());
        let second = apart(
            line.iter().map(|&(x, y)| (x, y + 5.0)).collect(),
            9.0,
            &first,
        );
        let all = [first.clone(), second.clone()].concat();
        assert!(first.len() > 10 && first[0] == line[0], "{first:?}");
        for (index, a) in all.iter().enumerate() {
            for b in &all[index + 1..] {
                assert!(f64::hypot(a.0 - b.0, a.1 - b.1) >= 9.0, "{a:?} {b:?}");
            }
        }
        assert!(apart(line, 9.0, &first).is_empty(), "all are covered");
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
            let outline = shape.outline(4.0);
            assert!(
                outline.starts_with('m') && outline.ends_with('z'),
                "{outline}"
            );
        }
    }
}
