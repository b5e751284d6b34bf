//! The least-squares problem of a candidate and a record, for the solver.
//!
//! Variables are aᵢ and αᵢ of [`Elements`]. Each stays in its range by x = low + (high − low)(1 + sin u)/2, and the solver moves u.
//! The sine reaches both ends, where a spring-pot becomes a spring or a dashpot.

use super::candidate::Candidate;
use super::elements::{Elements, Variable, variables};
use super::target::Target;
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt, TerminationReason};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn};

/// A modulus is at most so many times above or below all moduli of the record, as a logarithm: e^14 is 10⁶.
const BEYOND: f64 = 14.0;

/// Low and high end of each variable.
pub(super) fn ranges(candidate: Candidate, target: &Target) -> Vec<(f64, f64)> {
    let width = BEYOND + 0.5 * target.span;
    (variables(candidate).iter())
        .map(|variable| match variable {
            Variable::Modulus(_) => (target.middle - width, target.middle + width),
            Variable::Order(_) => (0.0, 1.0),
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

/// The problem at its present variables.
struct Problem<'a> {
    candidate: Candidate,
    target: &'a Target<'a>,
    ranges: &'a [(f64, f64)],
    /// Values of all variables.
    values: Vec<f64>,
    /// Those that are moved.
    free: &'a [usize],
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
        let elements = Elements::from_variables(self.candidate, &self.values);
        let (free, residuals, jacobian) = (self.free, &mut self.residuals, &mut self.jacobian);
        self.finite = (self.target).residuals(self.candidate, &elements, |n, root, slope| {
            residuals[n] = root * slope.value;
            for (k, &v) in free.iter().enumerate() {
                jacobian[(n, k)] = root * slope.by[v] * turn[k];
            }
        });
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
    /// Evaluations per variable.
    pub(super) patience: usize,
}

/// Moves the free variables from these values to the nearest minimum.
pub(super) fn minimise(
    candidate: Candidate,
    target: &Target,
    ranges: &[(f64, f64)],
    start: &[f64],
    free: &[usize],
    effort: Effort,
) -> Minimum {
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
        u: DVector::from_iterator(free.len(), u),
        residuals: DVector::zeros(target.len()),
        jacobian: DMatrix::zeros(target.len(), free.len()),
        finite: false,
    };
    problem.evaluate();
    let solver = LevenbergMarquardt::new()
        .with_ftol(effort.tolerance)
        .with_xtol(effort.tolerance)
        .with_gtol(1e-12)
        .with_patience(effort.patience);
    let (problem, report) = solver.minimize(problem);
    let converged = report.termination.was_successful()
        || matches!(
            report.termination,
            TerminationReason::NoImprovementPossible(_)
        );
    let sum = if problem.finite {
        problem.residuals.norm_squared()
    } else {
        f64::INFINITY
    };
    Minimum {
        values: problem.values,
        sum,
        converged: converged && sum.is_finite(),
    }
}
