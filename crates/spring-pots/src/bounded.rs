//! Least squares within bounds.
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

use nalgebra::{DMatrix, DVector};

/// The end of a minimisation.
#[derive(Clone, Debug)]
pub struct Minimum {
    /// The variables at the end, within their ranges.
    pub values: Vec<f64>,
    /// Sum of the squared residuals, weights in.
    pub sum: f64,
    /// True if the solver met one of its criteria, or the residual is below the accuracy of a record.
    pub converged: bool,
}

/// A row beside those of the record: weight·(Σ share·x − aim), for each variable x.
#[derive(Clone, Debug)]
pub struct Pull {
    /// Share of each variable in the sum.
    pub shares: Vec<f64>,
    /// The aim of the sum.
    pub aim: f64,
    /// Weight of the row among the residuals.
    pub weight: f64,
    /// True if a sum above the aim costs nothing.
    pub from_below: bool,
}

impl Pull {
    /// The sum at these values.
    #[must_use]
    pub fn sum(&self, values: &[f64]) -> f64 {
        let pairs = self.shares.iter().zip(values);
        pairs.map(|(share, value)| share * value).sum()
    }

    fn weight(&self, sum: f64) -> f64 {
        if self.from_below && sum > self.aim {
            0.0
        } else {
            self.weight
        }
    }
}

/// Residuals whose sum of squares is to be the least.
pub trait Problem {
    /// Number of the residuals.
    fn count(&self) -> usize;

    /// A sum of squares that counts as 0.
    fn exact(&self) -> f64;

    /// Calls `each` with number, residual and its derivatives by the variables, both with the root of the weight; false if a number is not finite, or the search
    /// is to end.
    fn residuals(&self, values: &[f64], each: &mut dyn FnMut(usize, f64, &[f64])) -> bool;
}

/// The problem with its bounds.
struct Bounded<'a> {
    problem: &'a dyn Problem,
    ranges: &'a [(f64, f64)],
    free: &'a [usize],
    pulls: &'a [Pull],
}

/// The problem where its variables have these values.
struct Point {
    values: Vec<f64>,
    /// Residuals of the record, then of the pulls.
    residuals: DVector<f64>,
    jacobian: DMatrix<f64>,
}

impl Bounded<'_> {
    /// None where a number is not finite, or the fit is to end.
    fn at(&self, values: Vec<f64>) -> Option<Point> {
        let (n, free) = (self.problem.count(), self.free);
        let mut residuals = DVector::zeros(n + self.pulls.len());
        let mut jacobian = DMatrix::zeros(residuals.len(), free.len());
        let finite = (self.problem).residuals(&values, &mut |n, value, by| {
            residuals[n] = value;
            for (k, &v) in free.iter().enumerate() {
                jacobian[(n, k)] = by[v];
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
        if inside.iter().any(|&k| steep(k)) {
            inside
        } else {
            Vec::new()
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

/// Criteria by which a search ends.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Relative change of the sum at which to stop.
    pub tolerance: f64,
    /// Relative change of the variables at which to stop.
    pub step: f64,
    /// Most steps for each free variable and one.
    pub patience: usize,
}

impl Effort {
    /// Both changes at most so large.
    #[must_use]
    pub const fn to(tolerance: f64, patience: usize) -> Self {
        Self {
            tolerance,
            step: tolerance,
            patience,
        }
    }
}

/// Moves the free variables from these values to the nearest minimum, under these pulls; they are not in its sum.
#[must_use]
pub fn minimise(
    problem: &dyn Problem,
    ranges: &[(f64, f64)],
    start: &[f64],
    free: &[usize],
    pulls: &[Pull],
    effort: Effort,
) -> Minimum {
    let bounded = Bounded {
        problem,
        ranges,
        free,
        pulls,
    };
    let inside = start.iter().zip(ranges);
    let start: Vec<f64> = inside
        .map(|(value, &(low, high))| value.clamp(low, high))
        .collect();
    let Some(mut here) = bounded.at(start.clone()) else {
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
        let movable = bounded.movable(&here);
        for (scale, column) in scale.iter_mut().zip(here.jacobian.column_iter()) {
            *scale = scale.max(column.norm());
        }
        converged = movable.is_empty() || damping > DAMPING_MOST;
        let values = if converged {
            None
        } else {
            bounded.moved(&here, &movable, damping, &scale)
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
        let evaluated = bounded.at(values);
        let gain = (evaluated.as_ref()).map_or(f64::NEG_INFINITY, |evaluated| {
            square - evaluated.residuals.norm_squared()
        });
        let still = gain.abs() <= effort.tolerance * square;
        converged = small || still && expected <= effort.tolerance * square;
        match evaluated {
            Some(evaluated) if gain > 0.0 => {
                here = evaluated;
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
    let sum = here.residuals.rows(0, problem.count()).norm_squared();
    Minimum {
        sum,
        values: here.values,
        converged: converged || sum <= problem.exact(),
    }
}
