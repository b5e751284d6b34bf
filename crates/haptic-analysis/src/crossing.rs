//! Where the loop gain of a sampled loop meets a condition on the circle: every angle, none missed.

use crate::SampledLoop;
use crate::characteristic::Node;
use crate::curve::{Bounds, product};
use core::f64::consts::PI;
use num_complex::Complex;

/// A value and the angle, rad/sample, at which it arises.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AtAngle {
    /// The value.
    pub value: f64,
    /// θ.
    pub theta: f64,
}

/// Crossings nearer to rest than this are not looked for, rad/sample.
const LEAST_ANGLE: f64 = 1e-6;
/// Intervals narrower than this are not halved.
pub(crate) const NARROW: f64 = 1e-12;

impl SampledLoop<'_> {
    /// GH(e^(−jθ)), the loop gain; infinite at a pole of the plant on the circle.
    #[must_use]
    pub fn loop_gain(&self, theta: f64) -> Complex<f64> {
        let terms = Terms::new(self, self.characteristic.node(theta));
        terms.feedback / terms.plant
    }

    /// All zeros in (0, π) of a real function of A and SH, from its value and derivative and a bound
    /// of its second derivative.
    pub(crate) fn zeros(
        &self,
        function: impl Fn(&Terms) -> [f64; 2],
        bend: impl Fn(Bounds, Bounds) -> f64,
    ) -> Vec<f64> {
        let at = |theta| Terms::new(self, self.characteristic.node(theta));
        let mut found = Vec::new();
        if self.alpha == 0.0 && self.beta == 0.0 {
            return found;
        }
        let mut todo = vec![(at(LEAST_ANGLE), at(PI))];
        while let Some((a, b)) = todo.pop() {
            let ([at_a, rate_a], [at_b, _]) = (function(&a), function(&b));
            let (low, high) = (a.theta(), b.theta());
            let width = high - low;
            let (plant, feedback) = Terms::bounds(self, &a, &b);
            let bend = bend(plant, feedback);
            let crosses = (at_a > 0.0) != (at_b > 0.0);
            if !crosses && at_a.abs().min(at_b.abs()) > 0.125 * width * width * bend {
                continue;
            }
            if rate_a.abs() > width * bend {
                // Monotone: one zero or none.
                if crosses {
                    found.push(bisect(low, high, |theta| {
                        (function(&at(theta))[0] > 0.0) == (at_a > 0.0)
                    }));
                }
                continue;
            }
            if width > NARROW {
                let middle = at(0.5 * (low + high));
                todo.extend([(a, middle), (middle, b)]);
            } else if crosses {
                found.push(0.5 * (low + high));
            }
        }
        found
    }
}

/// The point at which a condition that holds at the low end ceases to hold.
pub(crate) fn bisect(mut low: f64, mut high: f64, holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// A·D and S·(αD + βN) of one loop at one angle: GH is their ratio, F·D their sum.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Terms {
    node: Node,
    pub(crate) plant: Complex<f64>,
    pub(crate) feedback: Complex<f64>,
    pub(crate) plant_rate: Complex<f64>,
    pub(crate) feedback_rate: Complex<f64>,
}

impl Terms {
    pub(crate) fn new(subject: &SampledLoop, node: Node) -> Self {
        let [plant, stiff, fractional] = node.terms;
        let (alpha, beta) = (subject.alpha, subject.beta);
        let feedback_rate = if beta == 0.0 {
            stiff.rate * alpha
        } else {
            stiff.rate * alpha + fractional.rate * beta
        };
        Self {
            node,
            plant: plant.value,
            feedback: stiff.value * alpha + fractional.value * beta,
            plant_rate: plant.rate,
            feedback_rate,
        }
    }

    pub(crate) fn theta(&self) -> f64 {
        self.node.theta()
    }

    pub(crate) fn sensitivity(&self) -> f64 {
        self.plant.norm() / (self.plant + self.feedback).norm()
    }

    /// The derivative of the logarithm of the sensitivity.
    pub(crate) fn climb(&self) -> f64 {
        let sum = (self.plant_rate + self.feedback_rate) / (self.plant + self.feedback);
        (self.plant_rate / self.plant - sum).re
    }

    /// Of both terms over an interval.
    pub(crate) fn bounds(subject: &SampledLoop, a: &Self, b: &Self) -> (Bounds, Bounds) {
        let [plant, stiff, fractional] = subject.characteristic.bounds(&a.node, &b.node);
        let sum = |of: fn(&Bounds) -> f64| {
            product(subject.alpha, of(&stiff)) + product(subject.beta, of(&fractional))
        };
        let feedback = Bounds {
            size: sum(|bounds| bounds.size),
            rate: sum(|bounds| bounds.rate),
            bend: sum(|bounds| bounds.bend),
            travel: sum(|bounds| bounds.travel),
        };
        (plant, feedback)
    }

    /// True if |A/F| ≤ `most` is proved for a whole interval: from the paths of A and F, or because
    /// `most`²|F|² − |A|² cannot reach 0 with the second derivative it has.
    pub(crate) fn stays_below(subject: &SampledLoop, a: &Self, b: &Self, most: f64) -> bool {
        let (plant, feedback) = Self::bounds(subject, a, b);
        let sum = |terms: &Self| terms.plant + terms.feedback;
        let path = plant.travel + feedback.travel;
        let least = 0.5 * (sum(a).norm() + sum(b).norm() - path);
        if least > 0.0 && plant.size <= most * least {
            return true;
        }
        let whole = Bounds {
            size: plant.size + feedback.size,
            rate: plant.rate + feedback.rate,
            bend: plant.bend + feedback.bend,
            travel: path,
        };
        let bend = most * most * whole.times(whole).bend + plant.times(plant).bend;
        let room = |terms: &Self| most * most * sum(terms).norm_sqr() - terms.plant.norm_sqr();
        let width = b.theta() - a.theta();
        room(a).min(room(b)) > 0.125 * width * width * bend
    }
}
