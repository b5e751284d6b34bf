//! Intervals of parameters by the profile of the sum of squares.
//! ```text
//! S_p(ψ) = min S over all variables with the parameter at ψ           ζ(ψ) = √((S_p(ψ) − S)/s²)      s² = S/ν
//! the 95 % interval is where ζ ≤ t, the 97.5 % point of Student's t with ν degrees of freedom, beyond every minimum with ζ ≤ t
//! ```
//! ψ is ln V or α, a sum of variables. Where S is a parabola, ζ is straight and the ends are those of the standard error; each end
//! is looked for from there. The others are fitted again with one more row that pulls ψ to its aim: whatever the row weighs, the end of
//! such a fit is a point (ψ, S_p(ψ)) of the profile. Two spring-pots stay in order, the larger order first, by a row that pulls from
//! one side.
//!
//! - *Cost*: two fits of some six evaluations a parameter where S is nearly a parabola; along a valley at most [`ROUNDS`] for each end.
//! - *Source*: D. M. Bates, D. G. Watts, *Nonlinear Regression Analysis and Its Applications*, 1988, section 6.1.

use super::elements::{Candidate, is_order, share};
use super::fit::Certainty;
use super::search::{AT_END, Best, Effort, Minimum, Pull, minimise, ranges};
use super::target::Target;
use rayon::prelude::*;

/// Fits for an end at most.
const ROUNDS: usize = 20;
/// ζ so near to t, over t, is at the end; a straight line gives the rest.
const NEAR: f64 = 0.05;
/// A step over the one before.
const GROWTH: f64 = 4.0;
/// First step in an order or the logarithm of a modulus that has no standard error.
const UNKNOWN: f64 = 0.05;
/// Order by which the second spring-pot may pass the first.
const ORDER_KEPT: f64 = 1e-3;

/// ζ/t by which the pull grows with a step that is missed.
const STIFFNESS: f64 = 10.0;
/// Place of a start inside its range, over the range, at least.
const INSIDE: f64 = 1e-3;

/// A point of a profile.
#[derive(Clone, Debug)]
struct Point {
    values: Vec<f64>,
    /// ln V or α.
    parameter: f64,
    /// ζ.
    distance: f64,
}

struct Profiles<'a> {
    candidate: Candidate,
    target: &'a Target<'a>,
    ranges: Vec<(f64, f64)>,
    /// The best, and others that are no worse than the limit.
    minima: Vec<Minimum>,
    certainty: &'a Certainty,
    /// Sum of the best.
    sum: f64,
}

/// Low and high end of each parameter; infinite where the record gives none.
pub(super) fn intervals(
    candidate: Candidate,
    target: &Target,
    best: &Best,
    certainty: &Certainty,
) -> Vec<(f64, f64)> {
    let limit = best.sum + certainty.student * certainty.student * certainty.variance;
    let lowest = Minimum {
        values: best.elements.variables(candidate),
        sum: best.sum,
        converged: true,
    };
    let others = best.others.iter().filter(|other| other.sum <= limit);
    let profiles = Profiles {
        candidate,
        target,
        ranges: ranges(candidate, target),
        minima: std::iter::once(&lowest).chain(others).cloned().collect(),
        certainty,
        sum: best.sum,
    };
    let ends: Vec<f64> = (0..2 * candidate.parameters())
        .into_par_iter()
        .map(|end| {
            let (parameter, side) = (end / 2, [-1.0, 1.0][end % 2]);
            match profiles.end(parameter, side) {
                order if is_order(parameter) => order.clamp(0.0, 1.0),
                ln_modulus if ln_modulus.is_finite() => libm::exp(ln_modulus),
                none => none,
            }
        })
        .collect();
    (0..candidate.parameters())
        .map(|parameter| (ends[2 * parameter], ends[2 * parameter + 1]))
        .collect()
}

impl Profiles<'_> {
    /// The end of a parameter on one side, beyond all minima.
    fn end(&self, parameter: usize, side: f64) -> f64 {
        let shares = self.shares(parameter);
        let mut end = -side * f64::INFINITY;
        for minimum in &self.minima {
            let point = self.point(&shares, minimum);
            if side * point.parameter > side * end {
                end = self.walk(parameter, &shares, side, point);
            }
        }
        end
    }

    fn shares(&self, parameter: usize) -> Vec<f64> {
        let ln_unit = libm::log(self.target.unit_s);
        let shares = (0..self.candidate.parameters()).map(|v| share(parameter, v, ln_unit));
        shares.collect()
    }

    fn point(&self, shares: &[f64], minimum: &Minimum) -> Point {
        Point {
            values: minimum.values.clone(),
            parameter: shares.iter().zip(&minimum.values).map(|(a, b)| a * b).sum(),
            distance: libm::sqrt((minimum.sum - self.sum).max(0.0) / self.certainty.variance),
        }
    }

    /// Outward from a point within the limit to the limit.
    fn walk(&self, parameter: usize, shares: &[f64], side: f64, from: Point) -> f64 {
        let limit = self.certainty.student;
        let (mut slope, error) = self.certainty.along(shares).unwrap_or_else(|| {
            let own = |v| if v == parameter { 1.0 } else { 0.0 };
            ((0..shares.len()).map(own).collect(), UNKNOWN / limit)
        });
        let mut stride = error * (limit - from.distance).max(0.1 * limit);
        let (mut inner, mut outer): (Point, Option<Point>) = (from, None);
        let mut stiffness = STIFFNESS;
        for _ in 0..ROUNDS {
            if self.at_end(parameter, side, &inner) {
                break;
            }
            let step = match &outer {
                None => side * stride,
                Some(outer) => {
                    let part = (limit - inner.distance) / (outer.distance - inner.distance);
                    part.clamp(0.1, 0.9) * (outer.parameter - inner.parameter)
                }
            };
            let mut aim = inner.parameter + step;
            if is_order(parameter) {
                aim = aim.clamp(0.0, 1.0);
            }
            let step = aim - inner.parameter;
            let start: Vec<f64> = (inner.values.iter().zip(&slope))
                .map(|(value, slope)| value + slope * step)
                .collect();
            let point = self.refit(shares, aim, stiffness * limit / step.abs(), &start);
            let moved = point.parameter - inner.parameter;
            if moved * side <= 0.1 * step.abs() {
                stiffness *= 10.0;
                continue;
            }
            let steepness = (point.distance - inner.distance) / moved;
            if (point.distance - limit).abs() <= NEAR * limit {
                return inner.parameter + (limit - inner.distance) / steepness;
            }
            slope = (point.values.iter().zip(&inner.values))
                .map(|(to, from)| (to - from) / moved)
                .collect();
            if point.distance > limit {
                outer = Some(point);
            } else {
                let wanted = (limit - point.distance) / (side * steepness).max(0.0);
                stride = wanted.min(GROWTH * stride);
                inner = point;
            }
        }
        match outer {
            Some(outer) => outer.parameter,
            None if is_order(parameter) => if side < 0.0 { 0.0 } else { 1.0 },
            None => side * f64::INFINITY,
        }
    }

    /// True if the variable of the parameter has come to the end of its range on that side.
    fn at_end(&self, parameter: usize, side: f64, point: &Point) -> bool {
        let (low, high) = self.ranges[parameter];
        let place = (point.values[parameter] - low) / (high - low);
        if side < 0.0 { place < AT_END } else { place > 1.0 - AT_END }
    }

    /// All variables fitted again, with the parameter pulled to its aim.
    fn refit(&self, shares: &[f64], aim: f64, root: f64, start: &[f64]) -> Point {
        let scale = libm::sqrt(self.certainty.variance);
        let mut pulls = vec![Pull {
            shares: shares.to_vec(),
            aim,
            root: root * scale,
            from_below: false,
        }];
        if self.candidate.parameters() > 2 {
            let mut shares = vec![0.0; shares.len()];
            (shares[1], shares[3]) = (1.0, -1.0);
            pulls.push(Pull {
                shares,
                aim: 0.0,
                root: self.certainty.student * scale / ORDER_KEPT,
                from_below: true,
            });
        }
        // At an end of its range a variable does not move: the sine is flat there.
        let start: Vec<f64> = (start.iter().zip(&self.ranges))
            .map(|(value, (low, high))| {
                let inside = INSIDE * (high - low);
                value.clamp(low + inside, high - inside)
            })
            .collect();
        let free: Vec<usize> = (0..start.len()).collect();
        let limit = self.certainty.student * self.certainty.student / self.certainty.freedom;
        let effort = Effort {
            tolerance: 3e-3 * limit.min(1.0),
            patience: 25,
        };
        let minimum = minimise(
            self.candidate,
            self.target,
            &self.ranges,
            &start,
            &free,
            &pulls,
            effort,
        );
        self.point(shares, &minimum)
    }
}
