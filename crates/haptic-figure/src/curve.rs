//! Contents of a panel's box: lines, areas and markers, and their samples in the legend.

use crate::axis::Axis;
use crate::drawing::{Item, Marker, Rectangle, Shape};
use crate::style::{PAPER, Stroke};
use crate::thin::{Points, clip, scatter, simplify};

/// Opacity of an area in the colour of its outline.
pub(crate) const AREA_OPACITY: f64 = 0.1;
/// The rim that sets a marker off from what lies beneath it; the inner half is under the marker.
const RIM: Stroke = Stroke::solid(PAPER, 1.2);
/// Width of the outline of an open marker.
const OPEN_RIM: f64 = 1.4;
/// Size of a marker in a file, in points of a line.
const POINTS_OF_A_MARKER: usize = 5;
/// Length and height of a sample in the legend.
pub(crate) const SAMPLE_LENGTH: f64 = 40.0;
const SAMPLE_HEIGHT: f64 = 14.0;

/// A curve, drawn in the order given: the first lies beneath.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Curve {
    /// Between two pieces there is a gap; the pieces of an area are closed, and one within another is a hole.
    pub(crate) pieces: Vec<Points>,
    pub(crate) form: Form,
}

/// The form in which the points of a curve are shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Form {
    Line(Stroke),
    Area(Stroke),
    Markers(Marker),
}

/// Edges of a box, px.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BoxEdges {
    pub(crate) left: f64,
    pub(crate) right: f64,
    pub(crate) top: f64,
    pub(crate) bottom: f64,
}

impl BoxEdges {
    /// The place of a share of the horizontal axis, px.
    pub(crate) fn x(self, share: f64) -> f64 {
        self.left + share * (self.right - self.left)
    }

    /// The place of a share of the vertical axis, px.
    pub(crate) fn y(self, share: f64) -> f64 {
        self.bottom - share * (self.bottom - self.top)
    }

    pub(crate) fn middle(self) -> (f64, f64) {
        (self.x(0.5), self.y(0.5))
    }

    pub(crate) fn rectangle(self) -> Rectangle {
        Rectangle::new((self.left, self.top), (self.right, self.bottom))
    }
}

/// A curve on the paper, from beneath to the top.
#[derive(Debug, Default)]
pub(crate) struct Drawn {
    /// Insides of areas, which must not tint the lines of others; to be cut off at the edge of the box.
    pub(crate) fills: Vec<Item>,
    /// Lines, to be cut off at the edge of the box.
    pub(crate) lines: Vec<Item>,
    /// Markers: their middles are in the box, and at its edge they are whole.
    pub(crate) markers: Vec<Item>,
}

impl Curve {
    /// All points of the curve.
    pub(crate) fn points(&self) -> impl Iterator<Item = (f64, f64)> {
        self.pieces.iter().flatten().copied()
    }

    /// True if any of it lies within axes.
    pub(crate) fn is_within(&self, x: &Axis, y: &Axis) -> bool {
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
                Form::Markers(_) => placed
                    .filter(|point| inside(point.0) && inside(point.1))
                    .collect(),
            }
        });
        pieces.filter(|piece| !piece.is_empty()).collect()
    }

    /// Draws the curve with about `most` points in all.
    pub(crate) fn draw(&self, x: &Axis, y: &Axis, edges: BoxEdges, most: usize) -> Drawn {
        let mut pieces = self.within(x, y);
        for (x, y) in pieces.iter_mut().flatten() {
            (*x, *y) = (edges.x(*x), edges.y(*y));
        }
        match self.form {
            Form::Line(stroke) => draw_lines(pieces, stroke, most),
            Form::Area(stroke) => draw_areas(pieces, stroke, edges, most),
            Form::Markers(marker) => {
                let middles = scatter(pieces.concat(), most / POINTS_OF_A_MARKER);
                let mut drawn = Drawn::default();
                if !middles.is_empty() {
                    drawn.markers.push(Item::markers(&middles, marker));
                }
                drawn
            }
        }
    }
}

impl Marker {
    /// A marker in this colour, filled with a rim of paper or open.
    pub(crate) fn new(colour: &'static str, shape: Shape, radius: f64, open: bool) -> Self {
        let (inside, rim) = if open {
            (None, Stroke::solid(colour, OPEN_RIM))
        } else {
            (Some(colour), RIM)
        };
        Self {
            shape,
            radius,
            inside,
            rim,
        }
    }
}

fn draw_lines(pieces: Vec<Points>, stroke: Stroke, most: usize) -> Drawn {
    let mut drawn = Drawn::default();
    // A gap on both sides of a point leaves no line to draw, and a line of more pieces than the paper has room for is a cloud.
    let (mut dots, mut lines): (Vec<Points>, Vec<Points>) =
        pieces.into_iter().partition(|piece| piece.len() == 1);
    if 4 * lines.len() > most {
        dots.append(&mut lines);
    }
    let lines = simplify_all(lines, most);
    if !lines.is_empty() {
        drawn.lines.push(Item::curves(&lines, stroke));
    }
    let dots = scatter(dots.concat(), most / POINTS_OF_A_MARKER);
    if !dots.is_empty() {
        let dot = Marker::new(stroke.colour, Shape::Circle, 0.7 * stroke.width, false);
        drawn.markers.push(Item::markers(&dots, dot));
    }
    drawn
}

fn draw_areas(pieces: Vec<Points>, stroke: Stroke, edges: BoxEdges, most: usize) -> Drawn {
    let mut drawn = Drawn::default();
    let rings = simplify_all(pieces, most / 2);
    if !rings.is_empty() {
        (drawn.fills).push(Item::area(&rings, stroke.colour, AREA_OPACITY));
        let outline = rings.iter().flat_map(|ring| outline(ring, edges));
        (drawn.lines).push(Item::curves(&outline.collect::<Vec<Points>>(), stroke));
    }
    drawn
}

impl Form {
    /// The sample of the form in the legend, from `x` on and around the height `y`.
    pub(crate) fn sample(&self, x: f64, y: f64) -> Vec<Item> {
        let end = x + SAMPLE_LENGTH;
        match *self {
            Self::Line(stroke) => vec![Item::curves(&[vec![(x, y), (end, y)]], stroke)],
            Self::Area(stroke) => {
                let (top, bottom) = (y - SAMPLE_HEIGHT / 2.0, y + SAMPLE_HEIGHT / 2.0);
                let corners = [(x, top), (end, top), (end, bottom), (x, bottom), (x, top)];
                let ring = [corners.to_vec()];
                vec![
                    Item::area(&ring, stroke.colour, AREA_OPACITY),
                    Item::curves(&ring, stroke),
                ]
            }
            Self::Markers(marker) => {
                vec![Item::markers(&[(x + SAMPLE_LENGTH / 2.0, y)], marker)]
            }
        }
    }
}

/// The outline of an area, closed or, where it runs along a side of the box or outside, broken: there the axis is the border.
fn outline(ring: &Points, edges: BoxEdges) -> Vec<Points> {
    const ON_A_SIDE: f64 = 0.02;
    let beyond = |point: (f64, f64)| {
        let (x, y) = point;
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
}
