//! The certified count of the zeros of the characteristic function inside the unit circle.
//!
//! ```text
//! zeros in |w| < 1 = −(1/π)·Δarg F·D over 0 ≤ θ ≤ π
//! ```
//! Each way between two samples is proved by a bound of the length of F's path, from the travel of every factor or from |F′| at the ends and a bound
//! of |F″|, whichever is less, as [`Curve`] says.
//!
//! *A loop that drifts* has zeros at w = 1 itself, F ~ c·v^p with c > 0, v = 1 − w. They are left outside by an arc round them, on which F turns
//! by p·π/2 from v = ε to v = jε: F is judged beside them, as it is.

use crate::characteristic::{Characteristic, Node, Span};
use certified_count::{Count, Curve, Sample};
use core::f64::consts::PI;

/// Samples of the circle that all counts for one plant, operator and delay share.
#[derive(Clone, Debug)]
pub(crate) struct Circle<'a> {
    pub(crate) characteristic: Characteristic<'a>,
    nodes: Vec<Node>,
    spans: Vec<Span>,
}

impl<'a> Characteristic<'a> {
    /// The circle, sampled once for any number of counts.
    pub(crate) fn circle(&self) -> Circle<'a> {
        let nodes: Vec<Node> = Self::first_angles().map(|theta| self.node(theta)).collect();
        let spans = nodes
            .windows(2)
            .map(|pair| self.span(&pair[0], &pair[1]))
            .collect();
        Circle {
            characteristic: *self,
            nodes,
            spans,
        }
    }
}

/// Radii of the arc round w = 1 that are tried: the least on which F is above rounding.
const ARCS: [f64; 5] = [1e-9, 1e-8, 1e-7, 1e-6, 1e-5];
/// So many times.
const ABOVE: f64 = 1e3;

impl Circle<'_> {
    /// Zeros of F in |w| < 1. On the circle if some |F| ≤ `tolerance`·(n₁ + n₀), or
    /// is no more than rounding error. `beside_rest`: those at w = 1 are left out.
    ///
    /// Cost: about 80 evaluations of three multiply-adds, and a full node wherever F is so small that
    /// an interval has to be halved: some ten for each decade.
    pub(crate) fn count(
        &self,
        (alpha, beta): (f64, f64),
        tolerance: f64,
        beside_rest: bool,
    ) -> Count {
        let mut curve = Weighed {
            circle: self,
            alpha,
            beta,
            fall: 0.0,
        };
        let arc = beside_rest.then(|| {
            let (end, turned) = curve.round_rest();
            (end, curve.span(&end, &self.nodes[1]), turned)
        });
        let whole = (&self.nodes[0], &self.spans[0], 0.0);
        let (begin, span, turned) = arc
            .as_ref()
            .map_or(whole, |(end, span, turned)| (end, span, *turned));
        let spans = core::iter::once(span).chain(&self.spans[1..]);
        let scale = self.characteristic.plant.numerator_sum();
        let count = curve.count(
            (begin, turned),
            spans.zip(&self.nodes[1..]),
            tolerance * scale,
        );
        Count {
            closest: count.closest / scale,
            ..count
        }
    }
}

/// F of one pair of gains.
struct Weighed<'a, 'b> {
    circle: &'a Circle<'b>,
    alpha: f64,
    beta: f64,
    /// p.
    fall: f64,
}

impl Weighed<'_, '_> {
    /// The end of the arc round w = 1 and the turn up to there; keeps p.
    fn round_rest(&mut self) -> (Node, f64) {
        let characteristic = self.circle.characteristic;
        let value = |node: &Node| node.value(self.alpha, self.beta);
        let mut arcs = ARCS.iter().map(|radius| characteristic.node(*radius));
        let is_clear = |node: &Node| value(node).norm() > ABOVE * node.noise(self.alpha, self.beta);
        let end = arcs.find(is_clear).unwrap_or(self.circle.nodes[1]);
        let (near, far) = (value(&end), value(&characteristic.node(2.0 * end.theta())));
        self.fall = libm::log2(far.norm() / near.norm()).max(0.0);
        // Of the turns that end at this angle that of v^p.
        let whole = libm::round((0.25 * self.fall) - near.arg() / (2.0 * PI));
        (end, near.arg() + 2.0 * PI * whole)
    }
}

impl Curve for Weighed<'_, '_> {
    type Node = Node;
    type Span = Span;

    fn node(&self, theta: f64) -> Node {
        self.circle.characteristic.node(theta)
    }

    fn span(&self, a: &Node, b: &Node) -> Span {
        self.circle.characteristic.span(a, b)
    }

    /// The size is |F|, that of a loop that drifts over |v|^p too.
    fn sample(&self, node: &Node) -> Sample {
        let value = node.value(self.alpha, self.beta);
        let fallen = match self.fall {
            0.0 => 1.0,
            fall => libm::pow(node.place.size_v.min(1.0), fall),
        };
        Sample {
            theta: node.theta(),
            value,
            size: value.norm() / (node.operator.denominator.value.norm() * fallen),
            noise: node.noise(self.alpha, self.beta),
        }
    }

    fn path(&self, (a, b): (&Node, &Node), span: &Span) -> f64 {
        span.path(a, b, self.alpha, self.beta)
    }
}
