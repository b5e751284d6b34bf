//! Counts between samples, which may be kept for many counts.
//!
//! *Certificate*: between two samples a and b the curve stays within the ellipse with foci F(a) and F(b) whose long axis is the length L of the
//! path. If |F(a)| + |F(b)| > L the ellipse does not hold 0, so the argument changes by exactly that of F(b)/F(a).

use crate::circle::{StabilityVerdict, Winding};
use num_complex::Complex;

/// A turn is this near to a whole number of half turns.
const WHOLE: f64 = 0.1;
/// Halvings of a way before it is given up: one of π/64 is 1e-20 rad then.
const HALVINGS: u32 = 60;

/// F at a node, with its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeValue {
    /// The angle θ, rad, of the node.
    pub theta: f64,
    /// F there, off by no more than `noise`.
    pub value: Complex<f64>,
    /// |F| over the scale in which its closeness is reported.
    pub size: f64,
    /// |F| up to which it counts as 0: at least the rounding error of the value.
    pub noise: f64,
}

/// A function on the upper half circle, known at nodes and bounded between them. F is real on the real axis.
///
/// ```
/// use certified_count::num_complex::Complex;
/// use certified_count::{Curve, Place, NodeValue};
///
/// /// 1 − cw.
/// struct Linear(f64);
///
/// impl Curve for Linear {
///     type Node = Place;
///     type Span = f64;
///
///     fn node(&self, theta: f64) -> Place {
///         Place::new(theta)
///     }
///     fn span(&self, a: &Place, b: &Place) -> f64 {
///         b.theta - a.theta
///     }
///     fn sample(&self, node: &Place) -> NodeValue {
///         let value = 1.0 - node.w * self.0;
///         NodeValue { theta: node.theta, value, size: value.norm(), noise: 1e-9 }
///     }
///     fn path(&self, _: &Place, _: &Place, width: &f64) -> f64 {
///         self.0.abs() * width
///     }
/// }
///
/// let zeros = |c: f64| {
///     let (curve, [begin, end]) = (Linear(c), [0.0, std::f64::consts::PI].map(Place::new));
///     curve.count(&begin, 0.0, [(&curve.span(&begin, &end), &end)]).unstable_poles
/// };
/// assert_eq!((zeros(2.0), zeros(0.5), zeros(1.0)), (Some(1), Some(0), None));
/// ```
pub trait Curve {
    /// All that is known at an angle.
    type Node;
    /// All that is known between two nodes.
    type Span;

    /// The node at this angle.
    fn node(&self, theta: f64) -> Self::Node;

    /// The span between these two nodes.
    fn span(&self, a: &Self::Node, b: &Self::Node) -> Self::Span;

    /// F at a node.
    fn sample(&self, node: &Self::Node) -> NodeValue;

    /// A bound of the length of F's path between two nodes.
    fn path(&self, a: &Self::Node, b: &Self::Node, span: &Self::Span) -> f64;

    /// Counts the zeros in |w| < 1 from the turn of F up to a first node, rad, and the ways from there to π, each with the node at its end. Halves
    /// a way where it has to. `None` if some |F| is no more than its noise.
    fn count<'a>(
        &self,
        begin: &'a Self::Node,
        turned: f64,
        ways: impl IntoIterator<Item = (&'a Self::Span, &'a Self::Node)>,
    ) -> StabilityVerdict
    where
        Self: Sized,
        Self::Node: 'a,
        Self::Span: 'a,
    {
        let mut walk = Walk {
            curve: self,
            winding: Winding::new(turned),
            touched: false,
        };
        let mut last = (begin, walk.sample(begin));
        for (span, node) in ways {
            let next = (node, walk.sample(node));
            walk.advance(last, next, span, 0);
            last = next;
            if walk.touched {
                break;
            }
        }
        walk.winding.counted(!walk.touched, WHOLE)
    }
}

struct Walk<'a, C> {
    curve: &'a C,
    winding: Winding,
    /// F was 0, or within its noise of 0.
    touched: bool,
}

impl<C: Curve> Walk<'_, C> {
    fn sample(&mut self, node: &C::Node) -> NodeValue {
        let sample = self.curve.sample(node);
        self.winding.meets(sample.size, sample.theta);
        let clear = sample.value.norm() - sample.noise;
        self.touched |= clear.is_nan() || clear <= 0.0;
        sample
    }

    fn advance(
        &mut self,
        a: (&C::Node, NodeValue),
        b: (&C::Node, NodeValue),
        span: &C::Span,
        depth: u32,
    ) {
        if self.touched {
            return;
        }
        let path = self.curve.path(a.0, b.0, span);
        let ends = a.1.value.norm() + b.1.value.norm();
        if ends > path + (a.1.noise + b.1.noise) {
            self.winding.turned += (b.1.value * a.1.value.conj()).arg();
            return;
        }
        if depth >= HALVINGS {
            self.touched = true;
            return;
        }
        let middle = self.curve.node(0.5 * (a.1.theta + b.1.theta));
        let sample = self.sample(&middle);
        let spans = [self.curve.span(a.0, &middle), self.curve.span(&middle, b.0)];
        self.advance(a, (&middle, sample), &spans[0], depth + 1);
        self.advance((&middle, sample), b, &spans[1], depth + 1);
    }
}
