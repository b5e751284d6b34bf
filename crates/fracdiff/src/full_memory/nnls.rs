//! Least squares with no negative unknown.
//! ```text
//! min_x |A·x − b|²,   x ≥ 0
//! ```
//! The unknowns that are free to be positive (the *passive* ones) enter one by one, the one with the steepest descent
//! first; A is kept triangular in them by Householder reflections, and by Givens rotations when one leaves again.
//! Plain loops from the first row to the last, so the same bits on every machine.
//!
//! Source: C. L. Lawson, R. J. Hanson, *Solving Least Squares Problems*, 1974, ch. 23, algorithm NNLS.

use std::vec;
use std::vec::Vec;

/// A column whose new part is smaller than this share of the rounding error of the rest depends on the passive ones.
const INDEPENDENT: f64 = 0.01;
/// Columns may enter this many times each; Lawson and Hanson give three.
const ENTRIES_A_COLUMN: usize = 10;

/// x ≥ 0 with the least |A·x − b|², of the columns of A, each as long as b; all zero if there is
/// nothing to fit.
///
/// Algorithm NNLS of C. L. Lawson and R. J. Hanson, *Solving Least Squares Problems*, 1974, ch. 23, by plain loops, so the
/// same bits on every machine. NaN inputs give a result without meaning, never an endless loop.
#[must_use]
pub fn non_negative_least_squares(columns: Vec<Vec<f64>>, target: Vec<f64>) -> Vec<f64> {
    nearly_least_squares(columns, target, 0.0)
}

/// Solution as of [`non_negative_least_squares`], but no unknown becomes positive whose column adds to the others what is alike what is left by
/// less than this share of the root of its mean square: such columns draw noise.
#[must_use]
pub fn nearly_least_squares(columns: Vec<Vec<f64>>, target: Vec<f64>, share: f64) -> Vec<f64> {
    let mut problem = Problem {
        solution: vec![0.0; columns.len()],
        order: (0..columns.len()).collect(),
        passive: 0,
        columns,
        target,
        share,
    };
    for _ in 0..ENTRIES_A_COLUMN * problem.order.len() {
        if !problem.enter() {
            break;
        }
        problem.descend();
    }
    problem.solution
}

struct Problem {
    /// A and b after the reflections and rotations so far.
    columns: Vec<Vec<f64>>,
    target: Vec<f64>,
    /// The columns, passive ones first.
    order: Vec<usize>,
    passive: usize,
    solution: Vec<f64>,
    /// The least descent along what a column adds, over the root of the mean square of what is left.
    share: f64,
}

impl Problem {
    /// Makes the column of the steepest descent passive; false where none descends.
    fn enter(&mut self) -> bool {
        let row = self.passive;
        if row >= self.target.len() {
            return false;
        }
        let square = |part: &[f64]| part.iter().fold(0.0, |sum, b| sum + b * b);
        let left = square(&self.target[row..]) / self.target.len() as f64;
        let descent = |column: &usize| {
            let rest = &self.columns[*column][row..];
            let pairs = rest.iter().zip(&self.target[row..]);
            let descent = pairs.fold(0.0, |sum, (a, b)| sum + a * b);
            // Of what the column adds to the passive ones: that part may be small and all that is left.
            let is_noise =
                self.share > 0.0 && descent <= self.share * libm::sqrt(left * square(rest));
            if is_noise { 0.0 } else { descent }
        };
        let mut descents: Vec<f64> = self.order[row..].iter().map(descent).collect();
        while let Some(steepest) = steepest(&descents) {
            if self.try_to_enter(row + steepest) {
                return true;
            }
            descents[steepest] = 0.0;
        }
        false
    }

    /// Makes the column at a place of the order passive, unless it depends on the passive ones or would be negative.
    fn try_to_enter(&mut self, place: usize) -> bool {
        let (row, entering) = (self.passive, self.order[place]);
        let column = &mut self.columns[entering];
        let Some(reflection) = Reflection::of(&column[row..]) else {
            return false;
        };
        let known = libm::sqrt(column[..row].iter().fold(0.0, |sum, a| sum + a * a));
        // In floating point: whether the new part adds anything to the known one.
        if known + reflection.diagonal.abs() * INDEPENDENT - known <= 0.0 {
            return false;
        }
        let below = column.split_off(row + 1);
        let mut target = self.target.clone();
        reflection.apply(&below, &mut target[row..]);
        if target[row] / reflection.diagonal <= 0.0 {
            self.columns[entering].extend(below);
            return false;
        }
        self.target = target;
        self.order[place] = self.order[row];
        self.order[row] = entering;
        self.passive += 1;
        for &other in &self.order[self.passive..] {
            reflection.apply(&below, &mut self.columns[other][row..]);
        }
        let column = &mut self.columns[entering];
        column[row] = reflection.diagonal;
        column.resize(self.target.len(), 0.0);
        true
    }

    /// Goes to the least squares of the passive columns, or towards it as far as no unknown becomes negative; those that become zero leave.
    fn descend(&mut self) {
        // Each round but the last takes a column away.
        for _ in 0..=self.passive {
            let wanted = self.least_squares();
            let Some((place, share)) = self.first_to_vanish(&wanted) else {
                for (&column, wanted) in self.order.iter().zip(wanted) {
                    self.solution[column] = wanted;
                }
                return;
            };
            for (&column, wanted) in self.order.iter().zip(wanted) {
                let x = &mut self.solution[column];
                *x += share * (wanted - *x);
            }
            self.leave(place);
            // Rounding may have brought others to zero.
            while let Some(place) = self.vanished() {
                self.leave(place);
            }
        }
    }

    /// The unknowns of the passive columns, in order, that solve the triangle.
    fn least_squares(&self) -> Vec<f64> {
        let mut x = self.target[..self.passive].to_vec();
        for row in (0..self.passive).rev() {
            let column = &self.columns[self.order[row]];
            x[row] /= column[row];
            let solved = x[row];
            for (x, a) in x[..row].iter_mut().zip(column) {
                *x -= a * solved;
            }
        }
        x
    }

    /// The unknown that becomes zero first on the way to the wanted ones, and the share of the way at which it does.
    fn first_to_vanish(&self, wanted: &[f64]) -> Option<(usize, f64)> {
        let mut first = None;
        for (place, (&column, &wanted)) in self.order.iter().zip(wanted).enumerate() {
            let x = self.solution[column];
            if wanted <= 0.0 {
                let share = -x / (wanted - x);
                if first.is_none_or(|(_, least)| least > share) {
                    first = Some((place, share));
                }
            }
        }
        first
    }

    /// A passive column whose unknown is not positive.
    fn vanished(&self) -> Option<usize> {
        let mut passive = self.order[..self.passive].iter();
        passive.position(|&column| self.solution[column] <= 0.0)
    }

    /// Takes a column out of the passive ones and makes the rest triangular again.
    fn leave(&mut self, place: usize) {
        let leaving = self.order[place];
        self.solution[leaving] = 0.0;
        for row in place + 1..self.passive {
            let moved = self.order[row];
            self.order[row - 1] = moved;
            let column = &mut self.columns[moved];
            let rotation = Rotation::of(column[row - 1], column[row]);
            for (other, column) in self.columns.iter_mut().enumerate() {
                if other != moved {
                    rotation.apply(column, row);
                }
            }
            self.columns[moved][row - 1] = rotation.length;
            self.columns[moved][row] = 0.0;
            rotation.apply(&mut self.target, row);
        }
        self.passive -= 1;
        self.order[self.passive] = leaving;
    }
}

/// Index of the largest value, if it is above 0; the first of equals.
fn steepest(descents: &[f64]) -> Option<usize> {
    let mut best = None;
    let mut most = 0.0;
    for (place, &descent) in descents.iter().enumerate() {
        if descent > most {
            (best, most) = (Some(place), descent);
        }
    }
    best
}

/// The Householder reflection that turns a vector into (diagonal, 0, 0, …). Its own vector is (up, below), where below
/// is the vector's rest.
struct Reflection {
    diagonal: f64,
    up: f64,
}

impl Reflection {
    /// `None` for a vector of zeros.
    fn of(vector: &[f64]) -> Option<Self> {
        let (&first, below) = vector.split_first()?;
        // A scale, against overflow.
        let scale = below
            .iter()
            .fold(first.abs(), |most, &a| libm::fmax(most, a));
        if scale <= 0.0 {
            return None;
        }
        let inverse = 1.0 / scale;
        let squared = |a: f64| (a * inverse) * (a * inverse);
        let rest = below.iter().fold(0.0, |sum, &a| sum + squared(a));
        let length = scale * libm::sqrt(squared(first) + rest);
        let diagonal = if first > 0.0 { -length } else { length };
        Some(Self {
            diagonal,
            up: first - diagonal,
        })
    }

    /// c ← c + (up, below)·(cᵀ·(up, below))/(up·diagonal)
    fn apply(&self, below: &[f64], c: &mut [f64]) {
        let (b, Some((first, rest))) = (self.up * self.diagonal, c.split_first_mut()) else {
            return;
        };
        if b >= 0.0 {
            return;
        }
        let products = rest.iter().zip(below);
        let sum = products.fold(*first * self.up, |sum, (c, u)| sum + c * u);
        let share = sum * (1.0 / b);
        *first += share * self.up;
        for (c, u) in rest.iter_mut().zip(below) {
            *c += share * u;
        }
    }
}

/// The Givens rotation that turns (a, b) into (length, 0).
struct Rotation {
    cos: f64,
    sin: f64,
    length: f64,
}

impl Rotation {
    fn of(a: f64, b: f64) -> Self {
        let [(small, large), (cos, sin)] = if a.abs() > b.abs() {
            [(b, a), (1.0, b / a)]
        } else if b != 0.0 {
            [(a, b), (a / b, 1.0)]
        } else {
            return Self {
                cos: 0.0,
                sin: 1.0,
                length: a,
            };
        };
        let ratio = small / large;
        let secant = libm::sqrt(1.0 + ratio * ratio);
        let unit = libm::copysign(1.0 / secant, large);
        Self {
            cos: unit * cos,
            sin: unit * sin,
            length: large.abs() * secant,
        }
    }

    /// Turns rows row − 1 and row.
    fn apply(&self, column: &mut [f64], row: usize) {
        let (above, below) = (column[row - 1], column[row]);
        column[row - 1] = self.cos * above + self.sin * below;
        column[row] = -self.sin * above + self.cos * below;
    }
}

#[cfg(test)]
mod tests {
    use super::non_negative_least_squares as solve;
    use super::*;

    /// Name, columns of A, b, and x of another solver.
    type Golden = (&'static str, Vec<Vec<f64>>, Vec<f64>, Vec<f64>);

    fn golden() -> Vec<Golden> {
        let lines = include_str!("../../tests/golden/nnls.csv").lines();
        let problem = |line: &'static str| {
            let mut cells = line.split(';');
            let name = cells.next().expect("a name");
            let mut count = || cells.next().and_then(|n| n.parse().ok()).expect("a count");
            let [rows, columns]: [usize; 2] = [count(), count()];
            let mut numbers = cells.map(|x| x.parse::<f64>().expect("a number"));
            let a = (0..columns).map(|_| numbers.by_ref().take(rows).collect());
            let a = a.collect();
            let b = numbers.by_ref().take(rows).collect();
            (name, a, b, numbers.collect())
        };
        lines.map(problem).collect()
    }

    /// Aᵀ(b − A·x): how fast the sum of squares falls with each unknown.
    fn descents(a: &[Vec<f64>], b: &[f64], x: &[f64]) -> Vec<f64> {
        let mut residual = b.to_vec();
        for (column, x) in a.iter().zip(x) {
            for (r, a) in residual.iter_mut().zip(column) {
                *r -= a * x;
            }
        }
        let product = |column: &Vec<f64>| column.iter().zip(&residual).map(|(a, r)| a * r).sum();
        a.iter().map(product).collect()
    }

    /// Karush, Kuhn and Tucker: no unknown negative, none that is zero would descend, none that is positive has a slope.
    #[track_caller]
    fn assert_optimal(name: &str, a: &[Vec<f64>], b: &[f64], x: &[f64]) {
        let size = |v: &[f64]| v.iter().fold(0.0, |sum, v| sum + v * v).sqrt();
        let descents = descents(a, b, x);
        for (q, (&x, &descent)) in x.iter().zip(&descents).enumerate() {
            let rounding = 1e-12 * size(&a[q]) * size(b);
            assert!(x >= 0.0, "{name}: unknown {q} is {x:e}");
            assert!(
                descent <= rounding,
                "{name}: unknown {q} descends by {descent:e}"
            );
            assert!(
                x == 0.0 || descent >= -rounding,
                "{name}: unknown {q} has slope {descent:e}"
            );
        }
    }

    #[test]
    fn solutions_are_scipys_and_optimal() {
        let problems = golden();
        assert_eq!(problems.len(), 8);
        for (name, a, b, want) in problems {
            let have = solve(a.clone(), b.clone());
            assert_optimal(name, &a, &b, &have);
            for (q, (have, want)) in have.iter().zip(&want).enumerate() {
                let error = (have - want).abs();
                assert!(
                    error <= 1e-9 * want.abs().max(1e-3),
                    "{name}: unknown {q} is {have}, not {want}"
                );
            }
        }
    }

    #[test]
    fn random_problems_are_solved_to_the_optimum() {
        // A generator of its own: a linear congruence (Knuth's MMIX).
        let mut seed = 7_u64;
        let mut random = || {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let mut left = 0;
        for case in 0..2000 {
            let (rows, columns) = (1 + case % 13, 1 + case % 7);
            let a: Vec<Vec<f64>> = (0..columns)
                .map(|_| (0..rows).map(|_| random()).collect())
                .collect();
            let b: Vec<f64> = (0..rows).map(|_| random()).collect();
            let x = solve(a.clone(), b.clone());
            assert_optimal("random", &a, &b, &x);
            left += x.iter().filter(|x| **x == 0.0).count();
        }
        assert!(left > 1000, "{left}: the bound never matters");
    }

    #[test]
    fn nothing_to_fit_and_columns_that_are_no_help_are_left_at_zero() {
        assert_eq!(solve(vec![], vec![1.0]), [0.0; 0]);
        assert_eq!(solve(vec![vec![]], vec![]), [0.0]);
        assert_eq!(solve(vec![vec![0.0, 0.0]], vec![1.0, 1.0]), [0.0]);
        // The same column twice: the first takes it all.
        let twice = vec![vec![1.0, 2.0], vec![1.0, 2.0]];
        let x = solve(twice, vec![2.0, 4.0]);
        assert!((x[0] - 2.0).abs() < 1e-15 && x[1] == 0.0, "{x:?}");
        // No number is no reason to go on for ever.
        assert_eq!(solve(vec![vec![f64::NAN, 1.0]], vec![1.0, 1.0]).len(), 1);
    }
}
