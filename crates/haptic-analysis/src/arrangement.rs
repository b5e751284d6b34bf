//! The pieces into which the boundary curve, the straight lines and the axes cut each other.
//!
//! The curve is first cut where it is level or upright, so that the box of any stretch is that of its two ends; two stretches whose boxes
//! are apart do not meet. The others are halved on the true curve, not on chords, and the crossing is then found by Newton's method.

use crate::decomposition::{Decomposition, Sample};

/// A whole curve between two of its extremes, or a straight line.
#[derive(Clone, Debug)]
pub(crate) enum Edge {
    /// Monotone in α and in β, θ increasing.
    Curve(Vec<Sample>),
    Straight(Straight),
}

/// Part of an edge between two neighbouring cuts.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    pub(crate) edge: usize,
    pub(crate) samples: Vec<Sample>,
}

/// Cuts a gap-free stretch where α or β is extreme.
pub(crate) fn monotone(decomposition: &Decomposition, stretch: &[Sample]) -> Vec<Edge> {
    let mut edges = Vec::new();
    let mut run: Vec<Sample> = stretch.first().copied().into_iter().collect();
    for pair in stretch.windows(2) {
        let mut extremes: Vec<Sample> = [0, 1]
            .into_iter()
            .filter(|&axis| pair[0].tangent[axis] * pair[1].tangent[axis] < 0.0)
            .map(|axis| decomposition.solve(&pair[0], &pair[1], |sample| sample.tangent[axis]))
            .filter(|extreme| extreme.theta > pair[0].theta && extreme.theta < pair[1].theta)
            .collect();
        extremes.sort_by(|a, b| a.theta.total_cmp(&b.theta));
        for extreme in extremes {
            run.push(extreme);
            edges.push(Edge::Curve(std::mem::replace(&mut run, vec![extreme])));
        }
        run.push(pair[1]);
    }
    if run.len() > 1 {
        edges.push(Edge::Curve(run));
    }
    edges
}

/// All pieces of all edges that lie in the quadrant.
pub(crate) fn pieces(decomposition: &Decomposition, edges: &[Edge]) -> Vec<Piece> {
    let mut cuts: Vec<Vec<Cut>> = edges.iter().map(ends).collect();
    for first in 0..edges.len() {
        for second in first + 1..edges.len() {
            let found = crossings(decomposition, &edges[first], &edges[second]);
            for (a, b) in found {
                cuts[first].push(a);
                cuts[second].push(b);
            }
        }
    }
    let mut pieces = Vec::new();
    for (index, (edge, mut cuts)) in edges.iter().zip(cuts).enumerate() {
        cuts.sort_by(|a, b| a.at.total_cmp(&b.at));
        cuts.dedup_by(|b, a| near(a.point, b.point));
        for pair in cuts.windows(2) {
            if let Some(samples) = between(decomposition, edge, pair[0], pair[1]) {
                pieces.push(Piece {
                    edge: index,
                    samples,
                });
            }
        }
    }
    pieces
}

fn ends(edge: &Edge) -> Vec<Cut> {
    match edge {
        Edge::Curve(samples) => [samples.first(), samples.last()]
            .into_iter()
            .flatten()
            .map(|sample| Cut {
                at: sample.theta,
                point: sample.point,
            })
            .collect(),
        Edge::Straight(line) => (line.ends.iter().zip([0.0, 1.0]))
            .map(|(&point, at)| Cut { at, point })
            .collect(),
    }
}

/// The samples from one cut to the next, if its middle is in the quadrant.
fn between(decomposition: &Decomposition, edge: &Edge, a: Cut, b: Cut) -> Option<Vec<Sample>> {
    let samples = match edge {
        Edge::Straight(line) => {
            let middle = line.at(0.5 * (a.at + b.at));
            [a.point, middle, b.point]
                .map(|point| line.sample(point))
                .into()
        }
        Edge::Curve(all) => {
            // The ends of the whole curve are not solutions of the equations at their angle.
            let end = |cut: Cut| {
                let known = [all[0], all[all.len() - 1]];
                let known = known
                    .into_iter()
                    .find(|sample| sample.theta.total_cmp(&cut.at).is_eq());
                let sample = known.unwrap_or_else(|| decomposition.sample(cut.at));
                Sample {
                    point: cut.point,
                    ..sample
                }
            };
            let inner = all
                .iter()
                .filter(|sample| sample.theta > a.at && sample.theta < b.at);
            let mut samples = vec![end(a)];
            samples.extend(inner.copied());
            samples.push(end(b));
            // Whatever there was, now something is well inside.
            let halfway = decomposition.sample(0.5 * (a.at + b.at));
            let after = samples.partition_point(|sample| sample.theta < halfway.theta);
            samples.insert(after.clamp(1, samples.len() - 1), halfway);
            samples
        }
    };
    let middle = samples[middle(&samples)].point;
    (middle[0] >= 0.0 && middle[1] >= 0.0).then_some(samples)
}

/// The inner sample farthest from both ends, by which a piece is judged; 0 without inner samples.
pub(crate) fn middle(samples: &[Sample]) -> usize {
    let (Some(first), Some(last)) = (samples.first(), samples.last()) else {
        return 0;
    };
    let depth = |index: &usize| {
        let point = samples[*index].point;
        distance(point, first.point).min(distance(point, last.point))
    };
    let inner = 1..samples.len() - 1;
    inner
        .max_by(|a, b| depth(a).total_cmp(&depth(b)))
        .unwrap_or(0)
}

fn crossings(decomposition: &Decomposition, first: &Edge, second: &Edge) -> Vec<(Cut, Cut)> {
    match (first, second) {
        (Edge::Straight(a), Edge::Straight(b)) => straights(a, b).into_iter().collect(),
        (Edge::Curve(curve), Edge::Straight(line)) => curve_and_line(decomposition, curve, line),
        (Edge::Straight(line), Edge::Curve(curve)) => {
            let found = curve_and_line(decomposition, curve, line).into_iter();
            found
                .map(|(on_curve, on_line)| (on_line, on_curve))
                .collect()
        }
        (Edge::Curve(a), Edge::Curve(b)) => {
            let mut found = Vec::new();
            curves(decomposition, a, b, &mut found);
            // Newton's method may have left for the neighbouring edge, which has found it itself.
            let is_on = |edge: &[Sample], cut: &Cut| {
                (edge[0].theta..=edge[edge.len() - 1].theta).contains(&cut.at)
            };
            found.retain(|(on_a, on_b)| is_on(a, on_a) && is_on(b, on_b));
            // Nearly parallel branches: the same crossing found twice, a rounding error apart.
            found.sort_by(|(p, _), (q, _)| p.at.total_cmp(&q.at));
            found.dedup_by(|(p, q), (r, s)| {
                (p.at - r.at).abs() <= 1e-7 && (q.at - s.at).abs() <= 1e-7
            });
            found
        }
    }
}

fn straights(a: &Straight, b: &Straight) -> Option<(Cut, Cut)> {
    let determinant = a.normal[0] * b.normal[1] - a.normal[1] * b.normal[0];
    let size = libm::hypot(a.normal[0], a.normal[1]) * libm::hypot(b.normal[0], b.normal[1]);
    if determinant.abs() <= 1e-12 * size {
        return None;
    }
    let point = [
        (a.offset * b.normal[1] - b.offset * a.normal[1]) / determinant,
        (a.normal[0] * b.offset - b.normal[0] * a.offset) / determinant,
    ];
    let cut = |line: &Straight| line.meet(point, 0.0);
    Some((cut(a)?, cut(b)?))
}

fn curve_and_line(
    decomposition: &Decomposition,
    curve: &[Sample],
    line: &Straight,
) -> Vec<(Cut, Cut)> {
    let height = |sample: &Sample| line.height(sample.point);
    let climb =
        |sample: &Sample| line.normal[0] * sample.tangent[0] + line.normal[1] * sample.tangent[1];
    let mut found = Vec::new();
    let mut add = |sample: Sample| {
        if let Some(on_line) = line.meet(sample.point, rounding(&sample)) {
            // One point for both, whatever the curve's own rounding error.
            let on_curve = Cut {
                at: sample.theta,
                point: on_line.point,
            };
            found.push((on_curve, on_line));
        }
    };
    // The ends of the curve lie on the lines of w = 1 and w = −1 by construction.
    let touches = |sample: &Sample| near(sample.point, line.at(line.share(sample.point)));
    for (index, pair) in curve.windows(2).enumerate() {
        let (a, b) = (&pair[0], &pair[1]);
        let at_start = index == 0 && touches(a);
        let at_end = index + 2 == curve.len() && touches(b);
        if at_start {
            add(*a);
        }
        if at_end {
            add(*b);
        }
        if at_start || at_end {
            continue;
        }
        if (height(a) > 0.0) != (height(b) > 0.0) {
            add(decomposition.solve(a, b, height));
        } else if climb(a) * climb(b) < 0.0 {
            // There and back between two samples.
            let turn = decomposition.solve(a, b, climb);
            if (height(&turn) > 0.0) != (height(a) > 0.0) {
                add(decomposition.solve(a, &turn, height));
                add(decomposition.solve(&turn, b, height));
            }
        }
    }
    found
}

fn apart(a: [&Sample; 2], b: [&Sample; 2]) -> bool {
    (0..2).any(|axis| {
        let range = |[p, q]: [&Sample; 2]| {
            let (p, q) = (p.point[axis], q.point[axis]);
            (p.min(q), p.max(q))
        };
        let ((a0, a1), (b0, b1)) = (range(a), range(b));
        a1 <= b0 || b1 <= a0
    })
}

fn curves(decomposition: &Decomposition, a: &[Sample], b: &[Sample], found: &mut Vec<(Cut, Cut)>) {
    let (Some(a0), Some(a1), Some(b0), Some(b1)) = (a.first(), a.last(), b.first(), b.last())
    else {
        return;
    };
    if apart([a0, a1], [b0, b1]) {
        return;
    }
    if a.len() == 2 && b.len() == 2 {
        segments(decomposition, [*a0, *a1], [*b0, *b1], 0, found);
    } else if a.len() >= b.len() {
        let half = a.len() / 2;
        curves(decomposition, &a[..=half], b, found);
        curves(decomposition, &a[half..], b, found);
    } else {
        let half = b.len() / 2;
        curves(decomposition, a, &b[..=half], found);
        curves(decomposition, a, &b[half..], found);
    }
}

/// Halvings of a segment before Newton's method starts: it then turns by less than 0.01 rad.
const HALVINGS: u32 = 4;

fn segments(
    decomposition: &Decomposition,
    a: [Sample; 2],
    b: [Sample; 2],
    depth: u32,
    found: &mut Vec<(Cut, Cut)>,
) {
    if apart([&a[0], &a[1]], [&b[0], &b[1]]) {
        return;
    }
    if depth == HALVINGS {
        if let Some(cuts) = newton(decomposition, a, b) {
            found.push(cuts);
        }
        return;
    }
    let middle = |[p, q]: &[Sample; 2]| decomposition.sample(0.5 * (p.theta + q.theta));
    let (a_middle, b_middle) = (middle(&a), middle(&b));
    for half_a in [[a[0], a_middle], [a_middle, a[1]]] {
        for half_b in [[b[0], b_middle], [b_middle, b[1]]] {
            segments(decomposition, half_a, half_b, depth + 1, found);
        }
    }
}

/// Distance by which a few units in the last place of θ move a point.
fn rounding(sample: &Sample) -> f64 {
    let [dx, dy] = sample.tangent;
    16.0 * f64::EPSILON * (1.0 + sample.theta) * libm::hypot(dx, dy)
}

/// p(θ₁) = p(θ₂) from the middles of two short segments. `None` if there is no solution near.
fn newton(decomposition: &Decomposition, a: [Sample; 2], b: [Sample; 2]) -> Option<(Cut, Cut)> {
    let (width_a, width_b) = (a[1].theta - a[0].theta, b[1].theta - b[0].theta);
    let (start_a, start_b) = (
        0.5 * (a[0].theta + a[1].theta),
        0.5 * (b[0].theta + b[1].theta),
    );
    let (mut theta_a, mut theta_b) = (start_a, start_b);
    for _ in 0..24 {
        let (p, q) = (decomposition.sample(theta_a), decomposition.sample(theta_b));
        let gap = [q.point[0] - p.point[0], q.point[1] - p.point[1]];
        let size = 1.0 + p.point[0].abs() + p.point[1].abs();
        // A curve that comes from infinity is so steep that no angle gives its points to 1e-13.
        if libm::hypot(gap[0], gap[1]) <= 1e-13 * size + rounding(&p) + rounding(&q) {
            // A curve meets itself at the same angle everywhere.
            if (theta_a - theta_b).abs() <= 1e-7 {
                return None;
            }
            let point = p.point;
            return Some((Cut { at: theta_a, point }, Cut { at: theta_b, point }));
        }
        // p + p′·s = q + q′·t
        let determinant = p.tangent[1] * q.tangent[0] - p.tangent[0] * q.tangent[1];
        let s = (gap[1] * q.tangent[0] - gap[0] * q.tangent[1]) / determinant;
        let t = (gap[1] * p.tangent[0] - gap[0] * p.tangent[1]) / determinant;
        theta_a += s;
        theta_b += t;
        let near = |theta: f64, start: f64, width: f64| (theta - start).abs() <= 1.5 * width;
        if !near(theta_a, start_a, width_a) || !near(theta_b, start_b, width_b) {
            return None;
        }
    }
    None
}

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
    /// beside it. A point within its `error` of an end is the end; a point beyond is no cut.
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

    /// Sample at a point of the line, for what handles both kinds alike.
    pub(crate) fn sample(&self, point: [f64; 2]) -> Sample {
        Sample {
            theta: self.theta.unwrap_or(f64::NAN),
            point,
            tangent: [0.0, 0.0],
            leftward: false,
        }
    }
}
