//! The best minimum of many: starts spread evenly, few samples first, the best few on all samples.
//!
//! Each variable stays in its range by x = low + (high − low)(1 + sin u)/2, and the solver moves u. The sine reaches both
//! ends, where a spring-pot becomes a spring or a dashpot.

use super::elements::{Candidate, Elements, is_order};
use super::error::IdentifyError;
use super::target::Target;
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt, TerminationReason};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn};

/// Samples of the first pass.
const FEW: usize = 160;
/// Minima of the first pass that are followed on all samples.
const FOLLOWED: usize = 6;
/// Sums closer than this are one minimum.
const SAME: f64 = 1e-4;
const ROUGH: Effort = Effort {
    tolerance: 1e-5,
    step: 1e-5,
    patience: 12,
};
/// Enough to see which of the followed minima is the lowest.
const CLOSE: Effort = Effort {
    tolerance: 1e-7,
    step: 1e-7,
    patience: 25,
};
/// Effort of a fit that counts.
pub(super) const FINE: Effort = Effort {
    tolerance: 1e-11,
    step: 1e-11,
    patience: 100,
};
/// A variable so near to an end of its range, over the range, is at the end.
const AT_END: f64 = 2e-4;
/// A fixed end may cost so much of the sum.
const COST_OF_END: f64 = 1e-5;

/// The best minimum.
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

/// Fits a candidate from so many starts.
pub(super) fn search(
    candidate: Candidate,
    target: &Target,
    starts: usize,
) -> Result<Best, IdentifyError> {
    if target.len() <= candidate.parameters() {
        return Err(IdentifyError::TooFew {
            model: candidate.kind().name(),
            numbers: target.len(),
            parameters: candidate.parameters(),
        });
    }
    let ranges = ranges(candidate, target);
    let all: Vec<usize> = (0..ranges.len()).collect();
    let few = target.thinned(FEW);
    let mut found: Vec<Minimum> = (0..starts)
        .take_while(|_| !target.stops())
        .map(|n| start(candidate, target, n))
        .map(|start| minimise(candidate, &few, &ranges, &start, &all, &[], ROUGH))
        .filter(|minimum| minimum.sum.is_finite())
        .collect();
    found.sort_by(|a, b| a.sum.total_cmp(&b.sum));
    found.dedup_by(|later, earlier| later.sum <= earlier.sum * (1.0 + SAME));
    found.truncate(FOLLOWED);
    let mut followed: Vec<Minimum> = (found.iter())
        .map(|minimum| {
            minimise(
                candidate,
                target,
                &ranges,
                &minimum.values,
                &all,
                &[],
                CLOSE,
            )
        })
        .filter(|minimum| minimum.sum.is_finite())
        .collect();
    followed.sort_by(|a, b| a.sum.total_cmp(&b.sum));
    // The lowest that converges; one that creeps along a valley without end is none.
    let best = (followed.iter())
        .map(|minimum| minimise(candidate, target, &ranges, &minimum.values, &all, &[], FINE))
        .find(|minimum| minimum.converged);
    let best = best.ok_or(IdentifyError::NotConverged {
        model: candidate.kind().name(),
    })?;
    for minimum in &mut followed {
        let elements = Elements::from_variables(&minimum.values).sorted(candidate);
        minimum.values = elements.variables(candidate);
    }
    Ok(Best {
        others: followed,
        ..at_ends(candidate, target, &ranges, best)
    })
}

/// Fixes variables that have come to an end of their range, and fits the others once more.
fn at_ends(candidate: Candidate, target: &Target, ranges: &[(f64, f64)], best: Minimum) -> Best {
    let mut values = best.values.clone();
    let mut free = Vec::new();
    for (v, &(low, high)) in ranges.iter().enumerate() {
        let place = (values[v] - low) / (high - low);
        if place < AT_END {
            values[v] = low;
        } else if place > 1.0 - AT_END {
            values[v] = high;
        } else {
            free.push(v);
        }
    }
    let mut chosen = (best.values, best.sum, (0..ranges.len()).collect());
    if free.len() < ranges.len() {
        let fixed = minimise(candidate, target, ranges, &values, &free, &[], FINE);
        if fixed.converged && fixed.sum <= best.sum * (1.0 + COST_OF_END) {
            chosen = (fixed.values, fixed.sum, free);
        }
    }
    let (values, sum, free) = chosen;
    let elements = Elements::from_variables(&values);
    let sorted = elements.sorted(candidate);
    let free = if sorted == elements {
        free
    } else {
        // The pairs of the two spring-pots change places.
        let mut swapped: Vec<usize> = free
            .iter()
            .map(|&v| if v < 4 { v ^ 2 } else { v })
            .collect();
        swapped.sort_unstable();
        swapped
    };
    Best {
        elements: sorted,
        sum,
        free,
        others: Vec::new(),
    }
}

/// Start n: the fractional parts of n times the powers of 1/φ, which fill a cube of d dimensions evenly (M. Roberts, *The unreasonable
/// effectiveness of quasirandom sequences*, 2018; φ^(d+1) = φ + 1). Start 0 is the middle.
fn start(candidate: Candidate, target: &Target, n: usize) -> Vec<f64> {
    let d = candidate.parameters() as f64;
    let mut phi = 1.5;
    for _ in 0..40 {
        phi = libm::pow(1.0 + phi, 1.0 / (d + 1.0));
    }
    let mut share = 0.5;
    // Moduli lie around those of the record: an element in series may be much stiffer, one side by side much softer.
    let spread = target.span + 6.0;
    (0..candidate.parameters())
        .map(|k| {
            let step = libm::pow(phi, -(k as f64 + 1.0));
            share = 0.5 + n as f64 * step;
            share -= libm::floor(share);
            match (is_order(k), n) {
                (false, _) => target.middle + (share - 0.5) * spread,
                (true, 0) => [0.6, 0.2][k / 2],
                (true, _) => 0.02 + 0.96 * share,
            }
        })
        .collect()
}

/// A modulus is at most so many times above or below all moduli of the record, as a logarithm: e^14 is 10⁶.
const BEYOND: f64 = 14.0;

/// Low and high end of each variable.
pub(super) fn ranges(candidate: Candidate, target: &Target) -> Vec<(f64, f64)> {
    let width = BEYOND + 0.5 * target.span;
    (0..candidate.parameters())
        .map(|variable| match is_order(variable) {
            true => (0.0, 1.0),
            false => (target.middle - width, target.middle + width),
        })
        .collect()
}

/// The end of a minimisation.
#[derive(Clone, Debug)]
pub(super) struct Minimum {
    /// Values of the variables.
    pub(super) values: Vec<f64>,
    /// Sum of the squared residuals, weights in.
    pub(super) sum: f64,
    /// True if the solver met one of its criteria.
    pub(super) converged: bool,
}

/// A row beside those of the record: weight·(Σ share·x − aim), for each variable x.
#[derive(Clone, Debug)]
pub(super) struct Pull {
    pub(super) shares: Vec<f64>,
    pub(super) aim: f64,
    pub(super) weight: f64,
    /// Nothing is pulled down.
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

/// The problem at its present variables.
struct Problem<'a> {
    candidate: Candidate,
    target: &'a Target<'a>,
    ranges: &'a [(f64, f64)],
    /// Values of all variables.
    values: Vec<f64>,
    /// Those that are moved.
    free: &'a [usize],
    pulls: &'a [Pull],
    u: DVector<f64>,
    residuals: DVector<f64>,
    jacobian: DMatrix<f64>,
    finite: bool,
}

impl Problem<'_> {
    fn evaluate(&mut self) {
        let mut turn = vec![0.0; self.free.len()];
        for (k, &v) in self.free.iter().enumerate() {
            let (low, high) = self.ranges[v];
            let half = 0.5 * (high - low);
            self.values[v] = low + half * (1.0 + libm::sin(self.u[k]));
            turn[k] = half * libm::cos(self.u[k]);
        }
        let elements = Elements::from_variables(&self.values);
        let (free, residuals, jacobian) = (self.free, &mut self.residuals, &mut self.jacobian);
        self.finite = (self.target).residuals(self.candidate, &elements, |n, root, slope| {
            residuals[n] = root * slope.value;
            for (k, &v) in free.iter().enumerate() {
                jacobian[(n, k)] = root * slope.by[v] * turn[k];
            }
        });
        for (n, pull) in (self.target.len()..).zip(self.pulls) {
            let sum = pull.sum(&self.values);
            let weight = pull.weight(sum);
            residuals[n] = weight * (sum - pull.aim);
            for (k, &v) in free.iter().enumerate() {
                jacobian[(n, k)] = weight * pull.shares[v] * turn[k];
            }
        }
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Problem<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, u: &DVector<f64>) {
        self.u.copy_from(u);
        self.evaluate();
    }

    fn params(&self) -> DVector<f64> {
        self.u.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        self.finite.then(|| self.residuals.clone())
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        self.finite.then(|| self.jacobian.clone())
    }
}

/// How far to go.
#[derive(Clone, Copy, Debug)]
pub(super) struct Effort {
    /// Relative change of the sum at which to stop.
    pub(super) tolerance: f64,
    /// Relative change of the variables at which to stop.
    pub(super) step: f64,
    /// Evaluations per variable.
    pub(super) patience: usize,
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
    let (n, rows) = (target.len(), target.len() + pulls.len());
    let u = free.iter().map(|&v| {
        let (low, high) = ranges[v];
        libm::asin(((start[v] - low) / (high - low) * 2.0 - 1.0).clamp(-1.0, 1.0))
    });
    let mut problem = Problem {
        candidate,
        target,
        ranges,
        values: start.to_vec(),
        free,
        pulls,
        u: DVector::from_iterator(free.len(), u),
        residuals: DVector::zeros(rows),
        jacobian: DMatrix::zeros(rows, free.len()),
        finite: false,
    };
    problem.evaluate();
    let solver = LevenbergMarquardt::new()
        .with_ftol(effort.tolerance)
        .with_xtol(effort.step)
        .with_gtol(1e-12)
        .with_patience(effort.patience);
    let (problem, report) = solver.minimize(problem);
    let converged = report.termination.was_successful()
        || matches!(
            report.termination,
            TerminationReason::NoImprovementPossible(_)
        );
    let sum = if problem.finite {
        problem.residuals.rows(0, n).norm_squared()
    } else {
        f64::INFINITY
    };
    Minimum {
        values: problem.values,
        sum,
        converged: converged && sum.is_finite(),
    }
}
