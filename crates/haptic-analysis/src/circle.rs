//! The certified count of the zeros of the characteristic function inside the unit circle.
//!
//! ```text
//! zeros in |w| < 1 = −(1/π)·Δarg F·D over 0 ≤ θ ≤ π
//! ```
//! *Certificate*: between two samples a and b the curve stays within the ellipse with foci G(a) and
//! G(b) whose long axis is the length L of the path. If |G(a)| + |G(b)| > L the ellipse does not hold
//! 0, so the argument changes by exactly that of G(b)/G(a). L is bounded by the travel of every
//! factor, or by |G′| at the ends and a bound of |G″|, whichever is less. Where neither suffices the
//! interval is halved; so no loop of the curve is too narrow to be seen.
//!
//! *A loop that drifts* has zeros at w = 1 itself, F ~ c·v^p with c > 0, v = 1 − w. They are left outside by an arc round them, on which F turns
//! by p·π/2 from v = ε to v = jε: F is judged beside them, as it is.

use crate::characteristic::{Characteristic, Node, Span};
use core::f64::consts::PI;
use num_complex::Complex;

/// The result of the count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Count {
    /// Zeros in |w| < 1; `None` if F vanishes on the circle itself, within the tolerance.
    pub(crate) zeros: Option<usize>,
    /// The least |F|/(n₁ + n₀) met; of a loop that drifts over v^p too, |v| ≤ 1.
    pub(crate) closest: f64,
    /// The angle at which that was, rad/sample.
    pub(crate) theta: f64,
}

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
        let mut count = Counter {
            circle: self,
            alpha,
            beta,
            limit: tolerance * self.characteristic.plant.numerator_sum(),
            fall: 0.0,
            turned: 0.0,
            touched: false,
            closest: f64::INFINITY,
            theta: 0.0,
        };
        let arc = beside_rest.then(|| {
            let end = count.round_rest();
            (end, self.characteristic.span(&end, &self.nodes[1]))
        });
        let whole = (&self.nodes[0], &self.spans[0]);
        let (begin, span) = arc.as_ref().map_or(whole, |(end, span)| (end, span));
        let mut last = (begin, count.sample(begin));
        let spans = core::iter::once(span).chain(&self.spans[1..]);
        for (node, span) in self.nodes[1..].iter().zip(spans) {
            let next = (node, count.sample(node));
            count.advance(last, next, span, 0);
            last = next;
            if count.touched {
                break;
            }
        }
        let zeros = -count.turned / PI;
        // A whole number, unless some rounding error was larger than it should be.
        let whole = zeros.round();
        let zeros = (!count.touched && whole >= 0.0 && (zeros - whole).abs() < 0.1)
            .then_some(whole as usize);
        Count {
            zeros,
            closest: count.closest / self.characteristic.plant.numerator_sum(),
            theta: count.theta,
        }
    }
}

/// One walk round the half circle.
struct Counter<'a, 'b> {
    circle: &'a Circle<'b>,
    alpha: f64,
    beta: f64,
    limit: f64,
    /// p.
    fall: f64,
    turned: f64,
    touched: bool,
    closest: f64,
    theta: f64,
}

/// Halvings of a first interval, π/64, after which it is 1e-20 rad wide.
const DEPTH: u32 = 60;

impl Counter<'_, '_> {
    /// The end of the arc round w = 1, with p and the turn up to there.
    fn round_rest(&mut self) -> Node {
        let characteristic = self.circle.characteristic;
        let value = |node: &Node| node.value(self.alpha, self.beta);
        let mut arcs = ARCS.iter().map(|radius| characteristic.node(*radius));
        let is_clear = |node: &Node| value(node).norm() > ABOVE * node.noise(self.alpha, self.beta);
        let end = arcs.find(is_clear).unwrap_or(self.circle.nodes[1]);
        let (near, far) = (value(&end), value(&characteristic.node(2.0 * end.theta())));
        self.fall = libm::log2(far.norm() / near.norm()).max(0.0);
        // Of the turns that end at this angle that of v^p.
        let whole = libm::round((0.25 * self.fall) - near.arg() / (2.0 * PI));
        self.turned = near.arg() + 2.0 * PI * whole;
        end
    }

    fn sample(&mut self, node: &Node) -> Complex<f64> {
        let value = node.value(self.alpha, self.beta);
        let fallen = match self.fall {
            0.0 => 1.0,
            fall => libm::pow(node.place.size_v.min(1.0), fall),
        };
        let size = value.norm() / (node.operator.denominator.value.norm() * fallen);
        if size < self.closest {
            self.closest = size;
            self.theta = node.theta();
        }
        let noise = node.noise(self.alpha, self.beta);
        // A NaN touches too.
        self.touched |= !(size > self.limit && value.norm() > noise);
        value
    }

    fn advance(
        &mut self,
        a: (&Node, Complex<f64>),
        b: (&Node, Complex<f64>),
        span: &Span,
        depth: u32,
    ) {
        if self.touched {
            return;
        }
        let noise = a.0.noise(self.alpha, self.beta) + b.0.noise(self.alpha, self.beta);
        let path = span.path(a.0, b.0, self.alpha, self.beta);
        if a.1.norm() + b.1.norm() > path + noise {
            self.turned += (b.1 * a.1.conj()).arg();
            return;
        }
        if depth == DEPTH {
            self.touched = true;
            return;
        }
        let characteristic = self.circle.characteristic;
        let middle = characteristic.node(0.5 * (a.0.theta() + b.0.theta()));
        let value = self.sample(&middle);
        let (low, high) = (
            characteristic.span(a.0, &middle),
            characteristic.span(&middle, b.0),
        );
        self.advance(a, (&middle, value), &low, depth + 1);
        self.advance((&middle, value), b, &high, depth + 1);
    }
}
