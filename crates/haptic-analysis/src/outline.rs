//! Polygons from pieces: which pieces bound the stable region, and how they join.

use crate::AnalysisError;
use crate::arrangement::{Edge, Piece, distance, middle, near};
use crate::decomposition::{Decomposition, Sample};
use crate::stability::Circle;
use core::f64::consts::PI;

#[derive(Clone, Debug)]
pub(crate) struct Outline<'a> {
    pub(crate) decomposition: &'a Decomposition<'a>,
    pub(crate) circle: Circle<'a>,
    pub(crate) edges: &'a [Edge],
    pub(crate) pieces: &'a [Piece],
}

/// A piece that bounds the region, run so that the region is on its left.
#[derive(Clone, Debug)]
struct Arc {
    samples: Vec<Sample>,
    is_curve: bool,
}

impl Arc {
    fn start(&self) -> [f64; 2] {
        self.samples[0].point
    }

    fn end(&self) -> [f64; 2] {
        self.samples[self.samples.len() - 1].point
    }

    fn length(&self) -> f64 {
        let chords = self.samples.windows(2);
        chords
            .map(|pair| distance(pair[0].point, pair[1].point))
            .sum()
    }

    /// Directions at the start and against the end.
    fn leaving(&self) -> f64 {
        direction(self.samples[0].point, self.samples[1].point)
    }

    fn arriving(&self) -> f64 {
        let n = self.samples.len();
        direction(self.samples[n - 1].point, self.samples[n - 2].point)
    }
}

fn direction(from: [f64; 2], to: [f64; 2]) -> f64 {
    libm::atan2(to[1] - from[1], to[0] - from[0])
}

impl Outline<'_> {
    /// The polygons, with about `points` points on their curved parts together.
    pub(crate) fn polygons(&self, points: usize) -> Result<Vec<Polygon>, AnalysisError> {
        let arcs: Vec<Arc> = (self.pieces.iter())
            .filter_map(|piece| self.arc(piece))
            .collect();
        let curved = arcs.iter().filter(|arc| arc.is_curve);
        let density = points as f64 / curved.map(Arc::length).sum::<f64>();
        let loops = join(&arcs)?;
        let polygon = |members: Vec<usize>| {
            let mut polygon = Polygon {
                points: Vec::new(),
                area: 0.0,
            };
            for index in members {
                let arc = &arcs[index];
                let samples = self.fill(arc, density);
                polygon.area += swept(&samples, arc.is_curve);
                // The end of one arc is the start of the next.
                let all_but_last = &samples[..samples.len() - 1];
                (polygon.points).extend(all_but_last.iter().map(boundary_point));
            }
            polygon
        };
        Ok(loops.into_iter().map(polygon).collect())
    }

    /// The piece with its stable side on the left, if it has one and bounds the region.
    fn arc(&self, piece: &Piece) -> Option<Arc> {
        let samples = &piece.samples;
        let arc = Arc {
            samples: samples.clone(),
            is_curve: matches!(self.edges[piece.edge], Edge::Curve(_)),
        };
        if near(arc.start(), arc.end()) && arc.length() < 1e-10 {
            return None;
        }
        let left = match &self.edges[piece.edge] {
            Edge::Curve(_) => Some(samples[middle(samples)].leftward),
            Edge::Straight(line) => {
                let along = [
                    samples[2].point[0] - samples[0].point[0],
                    samples[2].point[1] - samples[0].point[1],
                ];
                let normal_is_left = along[0] * line.normal[1] - along[1] * line.normal[0] > 0.0;
                line.stable_side
                    .map(|with_normal| with_normal == normal_is_left)
            }
        };
        let left = match left {
            Some(left) => self.is_stable(piece, left).then_some(left),
            None => {
                let [on_left, on_right] = [true, false].map(|left| self.is_stable(piece, left));
                (on_left != on_right).then_some(on_left)
            }
        }?;
        let mut arc = arc;
        if !left {
            arc.samples.reverse();
        }
        Some(arc)
    }

    /// True if the cell beside the middle of a piece is stable.
    fn is_stable(&self, piece: &Piece, left: bool) -> bool {
        let samples = &piece.samples;
        let index = middle(samples);
        let at = samples[index].point;
        let along = match &self.edges[piece.edge] {
            Edge::Curve(_) => samples[index].tangent,
            Edge::Straight(_) => {
                let (start, end) = (samples[0].point, samples[2].point);
                [end[0] - start[0], end[1] - start[1]]
            }
        };
        let size = libm::hypot(along[0], along[1]);
        let length: f64 = samples
            .windows(2)
            .map(|pair| distance(pair[0].point, pair[1].point))
            .sum();
        let step = 0.3 * self.clearance(piece, at).min(0.2 * length);
        let side = if left { step } else { -step };
        let (alpha, beta) = (
            at[0] - side * along[1] / size,
            at[1] + side * along[0] / size,
        );
        alpha >= 0.0
            && beta >= 0.0
            && self.circle.count([alpha, beta], 0.0, false).unstable_poles == Some(0)
    }

    /// The distance from a point to everything but its own piece.
    fn clearance(&self, excluded: &Piece, at: [f64; 2]) -> f64 {
        let others = self
            .pieces
            .iter()
            .filter(|piece| !std::ptr::eq(*piece, excluded));
        let chords = others.flat_map(|piece| piece.samples.windows(2));
        chords.fold(f64::INFINITY, |least, pair| {
            least.min(distance_to_chord(at, pair[0].point, pair[1].point))
        })
    }

    /// More samples on a curved arc, `density` to a unit of length.
    fn fill(&self, arc: &Arc, density: f64) -> Vec<Sample> {
        if !arc.is_curve {
            return [arc.samples.first(), arc.samples.last()]
                .into_iter()
                .flatten()
                .copied()
                .collect();
        }
        let mut filled = Vec::new();
        // Balance of the steps so far, left over or borrowed, so that the total is right.
        let mut due = 0.0;
        for pair in arc.samples.windows(2) {
            let (a, b) = (&pair[0], &pair[1]);
            filled.push(*a);
            due += density * distance(a.point, b.point);
            // The stretches to the straight lines at θ = 0 and π hold nothing to be sampled.
            let has_end = [a.theta, b.theta]
                .iter()
                .any(|&theta| theta <= 0.0 || theta >= PI);
            let steps = if has_end {
                1.0
            } else {
                libm::floor(due).max(1.0)
            };
            due -= steps;
            for k in 1..steps as usize {
                let share = k as f64 / steps;
                let theta = a.theta + share * (b.theta - a.theta);
                filled.push(self.decomposition.sample(theta));
            }
        }
        filled.extend(arc.samples.last());
        filled
    }
}

fn distance_to_chord(at: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let along = [b[0] - a[0], b[1] - a[1]];
    let size = along[0] * along[0] + along[1] * along[1];
    let share = ((at[0] - a[0]) * along[0] + (at[1] - a[1]) * along[1]) / size;
    // A chord of no length gives NaN, and clamp keeps it.
    let share = if share.is_nan() {
        0.0
    } else {
        share.clamp(0.0, 1.0)
    };
    distance(at, [a[0] + share * along[0], a[1] + share * along[1]])
}

/// ½∮(α dβ − β dα) along an arc: exact for the cubics through the samples and their tangents.
/// ```text
/// ∫ p × p′ = p₀ × p₁ + (p₀ − p₁) × (m₀ − m₁)/5 − m₀ × m₁/30,   m = tangent·Δθ
/// ```
fn swept(samples: &[Sample], is_curve: bool) -> f64 {
    let cross = |u: [f64; 2], v: [f64; 2]| u[0] * v[1] - u[1] * v[0];
    let sum: f64 = (samples.windows(2))
        .map(|pair| {
            let (a, b) = (&pair[0], &pair[1]);
            let chord = cross(a.point, b.point);
            let ends = [a.theta, b.theta]
                .iter()
                .any(|&theta| theta <= 0.0 || theta >= PI);
            if !is_curve || ends {
                return chord;
            }
            let step = b.theta - a.theta;
            let [m0, m1] = [a, b].map(|sample| sample.tangent.map(|x| x * step));
            let difference = |u: [f64; 2], v: [f64; 2]| [u[0] - v[0], u[1] - v[1]];
            chord + 0.2 * cross(difference(a.point, b.point), difference(m0, m1))
                - cross(m0, m1) / 30.0
        })
        .sum();
    0.5 * sum
}

/// Joins arcs end to start. Where several leave one point, takes the sharpest left turn, which keeps to the boundary of one cell.
fn join(arcs: &[Arc]) -> Result<Vec<Vec<usize>>, AnalysisError> {
    let mut used = vec![false; arcs.len()];
    let mut loops = Vec::new();
    for first in 0..arcs.len() {
        if used[first] {
            continue;
        }
        used[first] = true;
        let mut members = vec![first];
        let mut last = first;
        while !near(arcs[last].end(), arcs[first].start()) {
            let back = arcs[last].arriving();
            let candidates = (0..arcs.len())
                .filter(|&next| !used[next] && near(arcs[last].end(), arcs[next].start()));
            // Clockwise angle from the way back.
            let turn = |&next: &usize| {
                let angle = back - arcs[next].leaving();
                angle - 2.0 * PI * libm::floor(angle / (2.0 * PI))
            };
            let Some(next) = candidates.min_by(|a, b| turn(a).total_cmp(&turn(b))) else {
                return Err(AnalysisError::Unresolved {
                    what: "the boundary of the stability region",
                    why: "parts of it are too close to each other",
                });
            };
            used[next] = true;
            members.push(next);
            last = next;
        }
        loops.push(members);
    }
    Ok(loops)
}

/// One corner or point of a boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutlinePoint {
    /// α, the stiffness without units.
    pub alpha: f64,
    /// β, the dissipation without units.
    pub beta: f64,
    /// The angle at which a pole crosses the circle there, rad/sample; `None` on an axis.
    pub theta: Option<f64>,
}

/// A closed boundary; the last point is followed by the first. The region lies to its left: an
/// outer boundary runs anticlockwise, the boundary of a hole clockwise.
#[derive(Clone, Debug, PartialEq)]
pub struct Polygon {
    /// Its corners, one after another around it; the first is not repeated.
    pub points: Vec<OutlinePoint>,
    /// Enclosed area, negative for a hole; by cubics between the points, not by chords.
    pub area: f64,
}

impl Polygon {
    /// Each point with the one that follows it.
    pub fn edges(&self) -> impl Iterator<Item = (&OutlinePoint, &OutlinePoint)> {
        self.points.iter().zip(self.points.iter().cycle().skip(1))
    }

    pub(crate) fn contains(&self, alpha: f64, beta: f64) -> bool {
        let mut inside = false;
        for (a, b) in self.edges() {
            if (a.beta > beta) != (b.beta > beta) {
                let share = (beta - a.beta) / (b.beta - a.beta);
                inside ^= alpha < a.alpha + share * (b.alpha - a.alpha);
            }
        }
        inside
    }
}

/// A point for a picture, from a sample.
pub(crate) fn boundary_point(sample: &Sample) -> OutlinePoint {
    OutlinePoint {
        alpha: sample.point[0].max(0.0),
        beta: sample.point[1].max(0.0),
        theta: (!sample.theta.is_nan()).then_some(sample.theta),
    }
}
