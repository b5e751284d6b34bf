//! Intervals of parameters by the profile of the sum of squares.
//! ```text
//! S_p(ψ) = min S over all variables with ψ held     ζ(ψ) = √((S_p(ψ) − S)/s²)     s² = S/ν
//! the 95 % interval: from the lowest to the highest ψ with ζ ≤ t, the 97.5 % point of Student's t with ν degrees of freedom
//! ```
//! ψ is ln V or α, a sum of variables. Where S is a parabola, ζ is straight and the ends are those of the standard error; from there each
//! end is looked for, outward along the valley. ψ is held by one more row, which pulls it to an aim: whatever the row weighs, a fit
//! with it ends in a point of the profile. A second row keeps two spring-pots in order, the larger order first.
//!
//! A valley may bend, fork, or have others beside it. So each point within the limit that the search or the walk to any end has seen
//! is a start for the ends that it lies beyond, and an end stands when no other minimum within the limit leads past it; one of these is
//! the best with its spring-pots exchanged, since where their orders are equal one valley continues as the other. A modulus that goes
//! on to the end of its range has no bound.
//!
//! - *Cost*: some 15 evaluations of the model an end where S is nearly a parabola, some 100 along a valley, 4000 at most for each walk.
//! - *Source*: D. M. Bates, D. G. Watts, *Nonlinear Regression Analysis and Its Applications*, 1988, section 6.1.

use super::elements::{Candidate, number};
use super::fit::Certainty;
use super::search::{Best, Compared, loose, ranges};
use super::target::Target;
use rayon::prelude::*;
use spring_pots::{Effort, Elements, Minimum, Pull, is_order, minimise};

/// Minima beside the best of which each end is tried.
const OTHERS: usize = 3;
/// Walks to an end, the later ones from what others have seen.
const PASSES: usize = 3;
/// Fits of a walk, at most.
const ROUNDS: usize = 20;
/// A ζ this near to t, over t, is at the end; a straight line gives the rest.
const NEAR: f64 = 0.05;
/// ζ/t of a point that is only known to be beyond.
const FAR: f64 = 3.0;
/// A step over the one before, at most.
const GROWTH: f64 = 4.0;
/// First and any step over the range of the variable, at most.
const FIRST: f64 = 0.05;
const FURTHEST: f64 = 0.15;
/// ζ/t for a step that the pull misses.
const STIFF: f64 = 10.0;
/// Excess of the second spring-pot's order over the first at ζ = t; a point with ten times that is discarded.
const ORDER_KEPT: f64 = 1e-3;
/// The pull that keeps them in order over that which holds ψ, at least.
const FIRM: f64 = 30.0;
/// First step of ψ over t that has no standard error.
const UNKNOWN: f64 = 0.02;
/// Minima this near, over the range of each variable, are one; an order twice as near to an end is at the end.
const INSIDE: f64 = 1e-3;
/// A modulus this near to an end of its range, over the range, has no bound.
const OPEN: f64 = 0.05;

/// Low and high end of each parameter; infinite where the record gives none.
pub(super) fn intervals(
    candidate: Candidate,
    target: &Target,
    best: &Best,
    certainty: &Certainty,
) -> Vec<(f64, f64)> {
    let ranges = ranges(candidate, target);
    let lowest = Minimum {
        values: best.elements.variables(candidate.joint()),
        sum: best.sum,
        converged: true,
    };
    let mut profiles = Profiles {
        candidate,
        target,
        ranges,
        certainty,
        minima: vec![lowest],
        seen: Vec::new(),
    };
    let limit = best.sum + certainty.student * certainty.student * certainty.variance;
    let exchanged = profiles.exchanged(&best.elements);
    let others = exchanged.into_iter().chain(best.others.iter().cloned());
    let others: Vec<Minimum> = others.filter(|other| other.sum <= limit).collect();
    for other in &others {
        let same = |one: &Minimum| {
            let pairs = one.values.iter().zip(&other.values).zip(&profiles.ranges);
            let mut apart = pairs.map(|((a, b), (low, high))| (a - b).abs() / (high - low));
            apart.all(|apart| apart <= INSIDE)
        };
        if profiles.minima.len() <= OTHERS && !profiles.minima.iter().any(same) {
            profiles.minima.push(other.clone());
        }
    }
    let ln_unit = libm::log(target.unit_s);
    let end = |parameter: usize, side: f64| End {
        variable: candidate.variable(parameter),
        side,
        shares: candidate.shares(parameter, ln_unit),
        range: candidate.range(candidate.variable(parameter)),
        at: None,
    };
    let mut ends: Vec<End> = (0..candidate.kind().parameters().len())
        .flat_map(|parameter| [end(parameter, -1.0), end(parameter, 1.0)])
        .collect();
    for _ in 0..PASSES {
        // Minima seen from one end reach the others in the next pass: the result does not depend on the threads.
        let seen: Vec<Vec<Minimum>> = (ends.par_iter_mut())
            .map(|end| profiles.pass(end))
            .collect();
        profiles.seen = seen.concat();
        profiles.seen.extend_from_slice(&others);
    }
    let ends = ends.as_chunks().0.iter();
    ends.map(|[low, high]| (low.number(), high.number()))
        .collect()
}

/// One end of an interval.
struct End {
    variable: usize,
    /// −1 for the low one, 1 for the high one.
    side: f64,
    /// Shares of the variables in ψ.
    shares: Vec<f64>,
    /// Range of ψ.
    range: (f64, f64),
    /// ψ; `None` before the first pass.
    at: Option<f64>,
}

impl End {
    fn number(&self) -> f64 {
        let at = self.at.unwrap_or(f64::NAN);
        match at.clamp(self.range.0, self.range.1) {
            infinite if infinite.is_infinite() => infinite,
            at => number(self.variable, at),
        }
    }
}

/// A point of a profile.
struct Point {
    values: Vec<f64>,
    at: f64,
    distance: f64,
}

struct Profiles<'a> {
    candidate: Candidate,
    target: &'a Target<'a>,
    ranges: Vec<(f64, f64)>,
    certainty: &'a Certainty,
    /// The best, and the first others within the limit.
    minima: Vec<Minimum>,
    seen: Vec<Minimum>,
}

impl Profiles<'_> {
    /// Moves an end outward, from the best or from what lies furthest beyond it; the points on the way.
    fn pass(&self, end: &mut End) -> Vec<Minimum> {
        if end.range.0 >= end.range.1 {
            end.at = Some(end.range.0);
            return Vec::new();
        }
        let best = self.point(end, &self.minima[0]);
        let from = match end.at {
            None => Some(best),
            Some(at) => {
                let margin = NEAR * (at - best.at).abs();
                let points = self.seen.iter().map(|seen| self.point(end, seen));
                points
                    .filter(|point| end.side * (point.at - at) > margin)
                    .max_by(|a, b| (end.side * a.at).total_cmp(&(end.side * b.at)))
            }
        };
        let mut seen = Vec::new();
        if let Some(from) = from {
            end.at = Some(self.walk(end, from, &mut seen));
        }
        seen
    }

    /// ψ at the limit, outward from a point within it.
    fn walk(&self, end: &End, from: Point, seen: &mut Vec<Minimum>) -> f64 {
        let (v, side, limit) = (end.variable, end.side, self.certainty.student);
        let (low, high) = self.ranges[v];
        let along = self.certainty.along(&end.shares);
        let (mut slope, error) = along.unwrap_or_else(|| (vec![0.0; end.shares.len()], UNKNOWN));
        let mut stride = error * (limit - from.distance).max(0.1 * limit);
        stride = stride.min(FIRST * (high - low));
        let mut stiffness = STIFF * limit;
        let mut refused = side * f64::INFINITY;
        let (mut inner, mut outer): (Point, Option<Point>) = (from, None);
        for _ in 0..ROUNDS {
            let room = if side > 0.0 {
                high - inner.values[v]
            } else {
                inner.values[v] - low
            };
            let margin = if is_order(v) { 2.0 * INSIDE } else { OPEN };
            if room < margin * (high - low) {
                return side * f64::INFINITY;
            }
            let step = match &outer {
                None => side * stride.min(room),
                Some(outer) => {
                    let beyond = outer.distance.min(FAR * limit) - inner.distance;
                    let part = (limit - inner.distance) / beyond;
                    part.clamp(0.1, 0.9) * (outer.at - inner.at)
                }
            };
            let (aim, stiff) = (inner.at + step, stiffness / step.abs());
            // Along the valley, but with no variable too far; if that leads beyond, with this parameter alone.
            let moved = inner.values.iter().zip(&slope).zip(&self.ranges);
            let moved = moved.map(|((value, slope), (low, high))| {
                let most = FIRST * (high - low);
                value + (slope * step).clamp(-most, most)
            });
            let mut point = self.held(end, aim, stiff, moved.collect());
            if point.distance > (1.0 + NEAR) * limit {
                let alone = self.held(end, aim, stiff, inner.values.clone());
                if alone.distance < point.distance {
                    point = alone;
                }
            }
            let moved = point.at - inner.at;
            if side * moved <= 0.1 * step.abs() {
                stiffness *= STIFF;
                continue;
            }
            if point.distance >= (1.0 - NEAR) * limit {
                refused = point.at;
            }
            let steepness = (point.distance - inner.distance) / moved;
            if (point.distance - limit).abs() <= NEAR * limit {
                let beyond = self.minima[1..].iter().find_map(|other| {
                    let point = self.held(end, aim, stiff, other.values.clone());
                    (point.distance < (1.0 - NEAR) * limit).then_some(point)
                });
                let Some(beyond) = beyond else {
                    return inner.at + (limit - inner.distance) / steepness;
                };
                seen.push(self.minimum(&beyond));
                slope.fill(0.0);
                (inner, outer) = (beyond, None);
                continue;
            }
            slope = (point.values.iter().zip(&inner.values))
                .map(|(to, from)| (to - from) / moved)
                .collect();
            if point.distance > limit {
                outer = Some(point);
            } else {
                let wanted = (limit - point.distance) / (side * steepness).max(0.0);
                stride = wanted.min(GROWTH * stride).min(FURTHEST * (high - low));
                seen.push(self.minimum(&point));
                inner = point;
            }
        }
        refused
    }

    /// Fits all variables with ψ pulled to `aim`, from values that are moved there; ζ grows by `stiff` for each 1 that ψ misses.
    fn held(&self, end: &End, aim: f64, stiff: f64, mut values: Vec<f64>) -> Point {
        let pull = Pull {
            shares: end.shares.clone(),
            aim,
            weight: stiff * libm::sqrt(self.certainty.variance),
            from_below: false,
        };
        values[end.variable] += aim - pull.sum(&values);
        self.point(end, &self.fitted(&values, Some(pull)))
    }

    fn fitted(&self, values: &[f64], pull: Option<Pull>) -> Minimum {
        let limit = self.certainty.student;
        let mut pulls: Vec<Pull> = pull.into_iter().collect();
        if self.candidate.has_two_orders() {
            let mut shares = vec![0.0; values.len()];
            (shares[1], shares[3]) = (1.0, -1.0);
            let held = pulls.first().map_or(0.0, |pull| pull.weight);
            let kept = limit * libm::sqrt(self.certainty.variance) / ORDER_KEPT;
            pulls.push(Pull {
                shares,
                aim: 0.0,
                weight: kept.max(FIRM * held),
                from_below: true,
            });
        }
        let free = loose(&self.ranges);
        let effort = Effort {
            tolerance: 1e-2 * (limit * limit / self.certainty.freedom).min(1.0),
            step: 1e-8,
            patience: 10,
        };
        let (candidate, target, ranges) = (self.candidate, self.target, &self.ranges);
        let mut found = minimise(
            &Compared(candidate, target),
            ranges,
            values,
            &free,
            &pulls,
            effort,
        );
        if self.candidate.has_two_orders() && found.values[3] - found.values[1] > 10.0 * ORDER_KEPT
        {
            found.sum = f64::INFINITY;
        }
        found
    }

    /// The best with its two spring-pots exchanged, from either of their orders.
    fn exchanged(&self, best: &Elements) -> Option<Minimum> {
        if !self.candidate.has_two_orders() {
            return None;
        }
        let mut exchanged = *best;
        exchanged.ln_modulus.swap(0, 1);
        let fits = [best.order[0], best.order[1]].map(|order| {
            exchanged.order[..2].fill(order);
            self.fitted(&exchanged.variables(self.candidate.joint()), None)
        });
        fits.into_iter().min_by(|a, b| a.sum.total_cmp(&b.sum))
    }

    fn point(&self, end: &End, minimum: &Minimum) -> Point {
        let excess = (minimum.sum - self.minima[0].sum).max(0.0);
        let shares = end.shares.iter().zip(&minimum.values);
        Point {
            values: minimum.values.clone(),
            at: shares.map(|(share, value)| share * value).sum(),
            distance: libm::sqrt(excess / self.certainty.variance.max(f64::MIN_POSITIVE)),
        }
    }

    fn minimum(&self, point: &Point) -> Minimum {
        let elements = self
            .candidate
            .sorted(Elements::from_variables(&point.values));
        let excess = point.distance * point.distance * self.certainty.variance;
        Minimum {
            values: elements.variables(self.candidate.joint()),
            sum: self.minima[0].sum + excess,
            converged: true,
        }
    }
}
