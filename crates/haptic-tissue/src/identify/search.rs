//! The best minimum of many: starts spread evenly, few samples first, the best few on all samples.
//!
//! ```text
//! (JᵀJ + λD²)·step = −Jᵀr        D the largest length of each column of J so far
//! ```
//! Levenberg–Marquardt with bounds: a step beyond the range of a variable ends at the end of the range, and there the variable
//! rests as long as the sum of squares would fall only beyond it. So a spring-pot becomes a spring or a dashpot in a few steps; a
//! variable that only approaches its end, as under a sine, loses its slope there and creeps.
//!
//! *Source*: H. B. Nielsen, *Damping parameter in Marquardt's method*, 1999 (λ); J. J. Moré, *The Levenberg–Marquardt algorithm*,
//! 1978 (D); C. Kanzow, N. Yamashita, M. Fukushima, *Levenberg–Marquardt methods with strong local convergence properties for solving
//! nonlinear equations with convex constraints*, Journal of Computational and Applied Mathematics 172, 2004 (the projection).

use super::elements::{Candidate, Elements, is_order};
use super::error::IdentifyError;
use super::target::Target;
use nalgebra::{DMatrix, DVector};

/// Samples of the first pass.
const FEW: usize = 160;
/// Minima of the first pass that are followed on all samples.
const FOLLOWED: usize = 6;
/// Sums closer than this are one minimum.
const SAME: f64 = 1e-4;
/// Enough to see which of the followed minima is the lowest.
const CLOSE: Effort = Effort::to(1e-7, 25);
/// Effort of a fit that counts.
pub(super) const FINE: Effort = Effort::to(1e-11, 100);
/// A variable this near to an end of its range, over the range, is at the end.
const AT_END: f64 = 2e-4;
/// Share of the sum that a fixed end may cost.
const COST_OF_END: f64 = 1e-5;

#[derive(Clone, Debug)]
pub(super) struct Best {
    pub(super) elements: Elements,
    /// Sum of the squared residuals, weights in.
    pub(super) sum: f64,
    /// Numbers of the variables that are not at an end of their range, in order.
    pub(super) free: Vec<usize>,
    /// Minima beside it, and points of valleys that lead to it.
    pub(super) others: Vec<Minimum>,
}

/// Fits a candidate from `starts` starts.
pub(super) fn search(
    candidate: Candidate,
    target: &Target,
    starts: usize,
) -> Result<Best, IdentifyError> {
    // The noise is a parameter too, and the criterion of small samples divides by the remaining degrees of freedom.
    if target.len() <= candidate.parameters() + 2 {
        return Err(IdentifyError::TooFew {
            model: candidate.kind().name(),
            numbers: target.len(),
            parameters: candidate.parameters(),
        });
    }
    let ranges = ranges(candidate, target);
    let all = loose(&ranges);
    let few = target.thinned(FEW);
    let to = |target: &Target, start: &[f64], effort: Effort| {
        minimise(candidate, target, &ranges, start, &all, &[], effort)
    };
    // Few variables have few minima.
    let most = [1, 2, 5, 20].get(all.len()).copied().unwrap_or(starts);
    let mut found: Vec<Minimum> = (0..starts.min(most))
        .take_while(|_| !target.stops())
        .map(|n| to(&few, &start(candidate, target, n), CLOSE))
        .filter(|minimum| minimum.sum.is_finite())
        .collect();
    found.sort_by(|a, b| a.sum.total_cmp(&b.sum));
    found.dedup_by(|later, earlier| later.sum <= earlier.sum * (1.0 + SAME));
    found.truncate(FOLLOWED);
    let mut followed: Vec<Minimum> = (found.iter())
        .map(|minimum| to(target, &minimum.values, CLOSE))
        .filter(|minimum| minimum.sum.is_finite() && minimum.is_in_order(candidate))
        .collect();
    followed.sort_by(|a, b| a.sum.total_cmp(&b.sum));
    let best = polished(candidate, target, followed.iter().map(|one| &one.values))?;
    for minimum in &mut followed {
        let elements = Elements::from_variables(&minimum.values).sorted(candidate);
        minimum.values = elements.variables(candidate);
    }
    Ok(Best {
        others: followed,
        ..best
    })
}

/// The minimum next to the first of these starts that leads to one, which may be a limit at the end of a valley.
pub(super) fn polished<'a>(
    candidate: Candidate,
    target: &Target,
    mut starts: impl Iterator<Item = &'a Vec<f64>>,
) -> Result<Best, IdentifyError> {
    let ranges = ranges(candidate, target);
    let all = loose(&ranges);
    let best = starts.find_map(|start| {
        let along = |from: &[f64]| minimise(candidate, target, &ranges, from, &all, &[], FINE);
        let valley = along(start);
        let best = match valley.converged {
            true => Some(valley),
            false => limit(candidate, target, &ranges, &valley, &all).or_else(|| {
                // A valley that falls no further in as many steps again counts as level.
                let further = along(&valley.values);
                let is_level = valley.sum <= further.sum * (1.0 + COST_OF_END);
                (further.converged || is_level).then_some(further)
            }),
        };
        best.filter(|best| best.is_in_order(candidate))
    });
    let best = best.ok_or(IdentifyError::NotConverged {
        model: candidate.kind().name(),
    })?;
    Ok(at_ends(candidate, target, &ranges, best))
}

/// The limit of a valley along which a modulus goes to an end of its range, where its element is rigid or nothing: the slope dies out
/// on the way there, so no step ever meets the end. The modulus is put there and the others fitted.
fn limit(
    candidate: Candidate,
    target: &Target,
    ranges: &[(f64, f64)],
    valley: &Minimum,
    free: &[usize],
) -> Option<Minimum> {
    let moduli = free.iter().filter(|v| !is_order(**v));
    let ends = moduli.flat_map(|&v| [(v, ranges[v].0), (v, ranges[v].1)]);
    let limits = ends.map(|(end, at)| {
        let mut start = valley.values.clone();
        start[end] = at;
        let rest: Vec<usize> = free.iter().copied().filter(|v| *v != end).collect();
        let limit = minimise(candidate, target, ranges, &start, &rest, &[], FINE);
        (limit, rest)
    });
    let near = limits.filter(|(limit, _)| limit.sum <= valley.sum * (1.0 + COST_OF_END));
    let (limit, rest) = near.min_by(|a, b| a.0.sum.total_cmp(&b.0.sum))?;
    match limit.converged {
        true => Some(limit),
        false => self::limit(candidate, target, ranges, &limit, &rest),
    }
}

/// The variables that are not fixed.
pub(super) fn loose(ranges: &[(f64, f64)]) -> Vec<usize> {
    let loose = |v: &usize| ranges[*v].0 < ranges[*v].1;
    (0..ranges.len()).filter(loose).collect()
}

/// Puts variables that are near an end of their range there, and fits the others once more, if that costs next to nothing.
fn at_ends(candidate: Candidate, target: &Target, ranges: &[(f64, f64)], best: Minimum) -> Best {
    // From 0 at the low end of the range to 1 at the high one.
    let share = |values: &[f64], v: usize| {
        let (low, high) = ranges[v];
        (values[v] - low) / (high - low)
    };
    let free = |values: &[f64], near: f64| -> Vec<usize> {
        let is_free = |v: &usize| (share(values, *v) - 0.5).abs() < 0.5 - near;
        (0..values.len()).filter(is_free).collect()
    };
    let inside = free(&best.values, AT_END);
    let mut ends = best.values.clone();
    for v in (0..ends.len()).filter(|v| !inside.contains(v)) {
        let (low, high) = ranges[v];
        ends[v] = if share(&ends, v) < 0.5 { low } else { high };
    }
    let fixed = minimise(candidate, target, ranges, &ends, &inside, &[], FINE);
    let is_good = fixed.converged && fixed.sum <= best.sum * (1.0 + COST_OF_END);
    let Minimum { values, sum, .. } = if is_good { fixed } else { best };
    let elements = Elements::from_variables(&values).sorted(candidate);
    Best {
        elements,
        sum,
        free: free(&elements.variables(candidate), 0.0),
        others: Vec::new(),
    }
}

/// Start n: the fractional parts of n times the powers of 1/φ, which fill a cube of d dimensions evenly (M. Roberts, *The unreasonable
/// effectiveness of quasirandom sequences*, 2018; φ^(d+1) = φ + 1). Start 0 is the middle.
fn start(candidate: Candidate, target: &Target, n: usize) -> Vec<f64> {
    let d = candidate.variables() as f64;
    let mut phi = 1.5;
    for _ in 0..40 {
        phi = libm::pow(1.0 + phi, 1.0 / (d + 1.0));
    }
    let mut share = 0.5;
    // Moduli lie around those of the record: an element in series may be much stiffer, one side by side much softer.
    let spread = target.span + 6.0;
    let mut values: Vec<f64> = (0..candidate.variables())
        .map(|k| {
            let step = libm::pow(phi, -(k as f64 + 1.0));
            share = 0.5 + n as f64 * step;
            share -= libm::floor(share);
            let (low, high) = candidate.range(k);
            match (is_order(k), n) {
                (false, _) => target.middle + (share - 0.5) * spread,
                (true, 0) => low + [0.6, 0.2][k / 2] * (high - low),
                (true, _) => low + (0.02 + 0.96 * share) * (high - low),
            }
        })
        .collect();
    for k in 0..values.len() {
        values[k] += match values.get(k + 1).filter(|_| !is_order(k)) {
            Some(order) => order * target.shift,
            None => 0.0,
        };
    }
    values
}

/// Largest ratio of a modulus to the moduli of the record, as a logarithm: e^14 is 10⁶.
const BEYOND: f64 = 14.0;

/// Low and high end of each variable.
pub(super) fn ranges(candidate: Candidate, target: &Target) -> Vec<(f64, f64)> {
    let width = BEYOND + 0.5 * target.span + target.shift.abs();
    (0..candidate.variables())
        .map(
            |variable| match is_order(variable) || candidate.is_held(variable) {
                true => candidate.range(variable),
                false => (target.middle - width, target.middle + width),
            },
        )
        .collect()
}

/// The end of a minimisation.
#[derive(Clone, Debug)]
pub(super) struct Minimum {
    pub(super) values: Vec<f64>,
    /// Sum of the squared residuals, weights in.
    pub(super) sum: f64,
    /// True if the solver met one of its criteria, or the residual is below the accuracy of a record.
    pub(super) converged: bool,
}

impl Minimum {
    /// True unless the second order is the larger one, as it may be where a modulus is held.
    fn is_in_order(&self, candidate: Candidate) -> bool {
        let elements = Elements::from_variables(&self.values).sorted(candidate);
        !candidate.has_two_orders() || elements.order[0] >= elements.order[1]
    }
}

/// A row beside those of the record: weight·(Σ share·x − aim), for each variable x.
#[derive(Clone, Debug)]
pub(super) struct Pull {
    pub(super) shares: Vec<f64>,
    pub(super) aim: f64,
    pub(super) weight: f64,
    pub(super) from_below: bool,
}

impl Pull {
    pub(super) fn sum(&self, values: &[f64]) -> f64 {
        let pairs = self.shares.iter().zip(values);
        pairs.map(|(share, value)| share * value).sum()
    }

    fn weight(&self, sum: f64) -> f64 {
        match self.from_below && sum > self.aim {
            true => 0.0,
            false => self.weight,
        }
    }
}

/// The problem, whatever its variables are.
struct Problem<'a> {
    candidate: Candidate,
    target: &'a Target<'a>,
    ranges: &'a [(f64, f64)],
    free: &'a [usize],
    pulls: &'a [Pull],
}

/// The problem where its variables have these values.
struct Point {
    values: Vec<f64>,
    /// Of the record, then of the pulls.
    residuals: DVector<f64>,
    jacobian: DMatrix<f64>,
}

impl Problem<'_> {
    /// None where a number is not finite, or the fit is to end.
    fn at(&self, values: Vec<f64>) -> Option<Point> {
        let (n, free) = (self.target.len(), self.free);
        let mut residuals = DVector::zeros(n + self.pulls.len());
        let mut jacobian = DMatrix::zeros(residuals.len(), free.len());
        let elements = Elements::from_variables(&values);
        let finite = (self.target).residuals(self.candidate, &elements, |n, root, slope| {
            residuals[n] = root * slope.value;
            for (k, &v) in free.iter().enumerate() {
                jacobian[(n, k)] = root * slope.by[v];
            }
        });
        for (n, pull) in (n..).zip(self.pulls) {
            let sum = pull.sum(&values);
            let weight = pull.weight(sum);
            residuals[n] = weight * (sum - pull.aim);
            for (k, &v) in free.iter().enumerate() {
                jacobian[(n, k)] = weight * pull.shares[v];
            }
        }
        (finite && jacobian.iter().all(|slope| slope.is_finite())).then_some(Point {
            values,
            residuals,
            jacobian,
        })
    }

    /// The places in `free` of the variables that can move downhill, those at an end of their range inwards alone.
    fn movable(&self, here: &Point) -> Vec<usize> {
        let slope = here.jacobian.tr_mul(&here.residuals);
        let steep = |k: usize| {
            let length = here.jacobian.column(k).norm() * here.residuals.norm();
            slope[k].abs() > FLAT * length
        };
        let inwards = |k: usize| {
            let (v, (low, high)) = (self.free[k], self.ranges[self.free[k]]);
            let (at_low, at_high) = (here.values[v] <= low, here.values[v] >= high);
            !(at_low && slope[k] > 0.0 || at_high && slope[k] < 0.0)
        };
        let inside: Vec<usize> = (0..self.free.len()).filter(|&k| inwards(k)).collect();
        match inside.iter().any(|&k| steep(k)) {
            true => inside,
            false => Vec::new(),
        }
    }

    /// The values after a damped step of these variables, which ends in their ranges.
    fn moved(
        &self,
        here: &Point,
        movable: &[usize],
        damping: f64,
        scale: &DVector<f64>,
    ) -> Option<Vec<f64>> {
        let (rows, count) = (here.residuals.len(), movable.len());
        let mut matrix = DMatrix::zeros(rows + count, count);
        let mut right = DVector::zeros(rows + count);
        right.rows_mut(0, rows).copy_from(&-&here.residuals);
        for (column, &k) in movable.iter().enumerate() {
            let slopes = here.jacobian.column(k);
            matrix.view_mut((0, column), (rows, 1)).copy_from(&slopes);
            matrix[(rows + column, column)] = libm::sqrt(damping) * scale[k];
        }
        let parts = matrix.qr();
        parts.q_tr_mul(&mut right);
        let step = parts.r().solve_upper_triangular(&right.rows(0, count))?;
        let mut values = here.values.clone();
        for (&k, step) in movable.iter().zip(step.iter()) {
            let (v, (low, high)) = (self.free[k], self.ranges[self.free[k]]);
            values[v] = (values[v] + step).clamp(low, high);
        }
        Some(values)
    }
}

/// Cosine of the angle between the residuals and a change of them, up to which the slope counts as 0.
const FLAT: f64 = 1e-12;
/// λ at first, and where no step gains anything any more.
const DAMPING: f64 = 1e-3;
const DAMPING_MOST: f64 = 1e12;

#[derive(Clone, Copy, Debug)]
pub(super) struct Effort {
    /// Relative change of the sum at which to stop.
    pub(super) tolerance: f64,
    /// Relative change of the variables at which to stop.
    pub(super) step: f64,
    pub(super) patience: usize,
}

impl Effort {
    const fn to(tolerance: f64, patience: usize) -> Self {
        Self {
            tolerance,
            step: tolerance,
            patience,
        }
    }
}

/// Moves the free variables from these values to the nearest minimum, under these pulls; they are not in its sum.
pub(super) fn minimise(
    candidate: Candidate,
    target: &Target,
    ranges: &[(f64, f64)],
    start: &[f64],
    free: &[usize],
    pulls: &[Pull],
    effort: Effort,
) -> Minimum {
    let problem = Problem {
        candidate,
        target,
        ranges,
        free,
        pulls,
    };
    let inside = start.iter().zip(ranges);
    let start: Vec<f64> = inside
        .map(|(value, &(low, high))| value.clamp(low, high))
        .collect();
    let Some(mut here) = problem.at(start.clone()) else {
        return Minimum {
            values: start,
            sum: f64::INFINITY,
            converged: false,
        };
    };
    // Above 0, where nothing depends on a variable.
    let mut scale: DVector<f64> = DVector::from_element(free.len(), f64::EPSILON);
    let (mut damping, mut growth, mut converged) = (DAMPING, 2.0, false);
    for _ in 0..effort.patience * (free.len() + 1) {
        let movable = problem.movable(&here);
        for (scale, column) in scale.iter_mut().zip(here.jacobian.column_iter()) {
            *scale = scale.max(column.norm());
        }
        converged = movable.is_empty() || damping > DAMPING_MOST;
        let values = match converged {
            true => None,
            false => problem.moved(&here, &movable, damping, &scale),
        };
        let Some(values) = values else { break };
        let over_free = |value: &dyn Fn(usize) -> f64| {
            DVector::from_iterator(free.len(), free.iter().map(|&v| value(v)))
        };
        let step = over_free(&|v| values[v] - here.values[v]);
        let square = here.residuals.norm_squared();
        let expected = square - (&here.residuals + &here.jacobian * &step).norm_squared();
        let size = over_free(&|v| here.values[v]).component_mul(&scale).norm();
        let small = step.component_mul(&scale).norm() <= effort.step * size;
        let there = problem.at(values);
        let gain = (there.as_ref()).map_or(f64::NEG_INFINITY, |there| {
            square - there.residuals.norm_squared()
        });
        let still = gain.abs() <= effort.tolerance * square;
        converged = small || still && expected <= effort.tolerance * square;
        match there {
            Some(there) if gain > 0.0 => {
                here = there;
                let miss = 2.0 * gain / expected - 1.0;
                damping *= (1.0 - miss * miss * miss).max(1.0 / 3.0);
                growth = 2.0;
            }
            _ => {
                damping *= growth;
                growth *= 2.0;
            }
        }
        if converged {
            break;
        }
    }
    let sum = here.residuals.rows(0, target.len()).norm_squared();
    Minimum {
        sum,
        values: here.values,
        converged: converged || sum <= target.exact,
    }
}

/// The next place at which to look for the least sum, of places in order with their sums: the vertex of the parabola through the
/// lowest three neighbours, or outwards as far as the range goes. None once a step is as near as wanted, or of fewer than three places.
pub(super) fn next_place(
    points: &[[f64; 2]],
    range: [f64; 2],
    near: f64,
    round: usize,
) -> Option<f64> {
    let last = points.len().checked_sub(3)? + 2;
    let lowest = (0..=last).min_by(|&a, &b| points[a][1].total_cmp(&points[b][1]))?;
    let place = |n: usize| points[n][0];
    let is_new = |at: f64| points.iter().all(|point| (point[0] - at).abs() > near);
    let outwards = match lowest {
        0 => (3.0 * place(0) - 2.0 * place(1)).max(range[0]),
        n if n == last => (3.0 * place(n) - 2.0 * place(n - 1)).min(range[1]),
        n => place(n),
    };
    if is_new(outwards) {
        return Some(outwards);
    }
    let three = lowest.clamp(1, last - 1);
    let three = [three - 1, three, three + 1];
    let [a, m, z] = three.map(place);
    let [fa, fm, fz] = three.map(|n| points[n][1] / points[lowest][1]);
    // Newton's form: f = fa + s·(x − a) + c·(x − a)(x − m).
    let s = (fm - fa) / (m - a);
    let c = ((fz - fm) / (z - m) - s) / (z - a);
    let vertex = (0.5 * (a + m) - 0.5 * s / c).clamp(a, z);
    let is_there = c > 0.0 && (vertex - place(lowest)).abs() <= near;
    if is_there || c.is_nan() || z - a <= 2.0 * near {
        return None;
    }
    // Every third step halves the wider side, in case the vertices come from one side.
    Some(
        match c > 0.0 && is_new(vertex) && !round.is_multiple_of(3) {
            true => vertex,
            false if z - m > m - a => 0.5 * (m + z),
            false => 0.5 * (a + m),
        },
    )
}
