//! Stability of a polynomial: the Schur–Cohn (Jury) recursion and the eigenvalues of its companion.

use nalgebra::{Complex, DMatrix, Schur};

/// The outcome of the recursion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Jury {
    /// All zeros are outside the closed unit disc of w: all poles in z inside.
    Stable,
    /// At least one is not.
    NotStable,
    /// A reflection coefficient is so close to ±1 that rounding errors could decide.
    Undecided,
}

/// Decides if Σ `x_j` w^j has no zero in |w| ≤ 1, by the recursion of Schur and Cohn.
///
/// ```text
/// k = x_n/x₀,   x_j ← (x_j − k·x_{n−j})/(1 − k²),   n ← n − 1;    no such zero ⇔ all |k| < 1
/// ```
/// In f64 the recursion loses a factor 1/(1 − |k|) a step; it says so ([`Jury::Undecided`]) when the
/// estimated loss reaches the next 1 − |k|, which happens within about 1e-8 of the boundary, or
/// farther for several slow poles at once. Cost: n² multiply-adds.
///
/// Source: E. I. Jury, *Theory and Application of the z-Transform Method*, Wiley, 1964, ch. 3.
///
/// ```
/// use haptic_analysis::{Jury, jury};
///
/// assert_eq!(jury(&[1.0, -0.9]), Jury::Stable); // z = 0.9
/// assert_eq!(jury(&[1.0, -1.1]), Jury::NotStable);
/// ```
#[must_use]
pub fn jury(coefficients: &[f64]) -> Jury {
    let Some((&first, _)) = coefficients.split_first() else {
        return Jury::Undecided;
    };
    if !coefficients.iter().all(|x| x.is_finite()) {
        return Jury::Undecided;
    }
    if first == 0.0 {
        return Jury::NotStable;
    }
    let mut x: Vec<f64> = coefficients.iter().map(|x| x / first).collect();
    let size = x.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let mut error = 4.0 * f64::EPSILON * size;
    while x.len() > 1 {
        let n = x.len() - 1;
        let k = x[n];
        if (1.0 - k.abs()).abs() <= error {
            return Jury::Undecided;
        }
        if k.abs() > 1.0 {
            return Jury::NotStable;
        }
        error = error / (1.0 - k.abs()) + f64::EPSILON;
        let scale = 1.0 / ((1.0 - k) * (1.0 + k));
        let next = (0..n).map(|j| {
            if j == 0 {
                1.0
            } else {
                (x[j] - k * x[n - j]) * scale
            }
        });
        x = next.collect();
    }
    Jury::Stable
}

/// The zeros in z = 1/w of Σ `x_j` w^j: eigenvalues of the companion matrix of x₀zⁿ + … + `x_n`.
///
/// `None` if x₀ = 0, something is not finite, or the iteration does not converge. Simple zeros to
/// about 1e-14 of the largest coefficient, an m-fold one to its m-th root. Cost: some 10·n³.
#[must_use]
pub fn companion_eigenvalues(coefficients: &[f64]) -> Option<Vec<Complex<f64>>> {
    let used = coefficients.iter().rposition(|&x| x != 0.0)?;
    let first = coefficients[0];
    let monic: Vec<f64> = coefficients[1..=used].iter().map(|x| x / first).collect();
    if !monic.iter().all(|x| x.is_finite()) {
        return None;
    }
    let n = monic.len();
    if n == 0 {
        return Some(Vec::new());
    }
    let companion = DMatrix::from_fn(n, n, |row, column| {
        if row == 0 {
            -monic[column]
        } else {
            f64::from(u8::from(row == column + 1))
        }
    });
    let schur = Schur::try_new(companion, f64::EPSILON, 200 * n.max(10))?;
    let values: Vec<_> = schur.complex_eigenvalues().iter().copied().collect();
    if values.iter().all(|value| value.im.is_finite()) {
        return Some(values);
    }
    // Two real ones so close that they were left in one block: nalgebra takes the root of the wrong sign.
    let blocks = blocks(&schur.unpack().1);
    Some(blocks.into_iter().flat_map(Block::eigenvalues).collect())
}

/// A block on the diagonal of a real Schur form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Block {
    /// A real eigenvalue.
    Single(f64),
    /// The two eigenvalues `mean` ± √`square`.
    Pair {
        /// Half the trace.
        mean: f64,
        /// Negative for a complex pair.
        square: f64,
    },
}

impl Block {
    fn eigenvalues(self) -> Vec<Complex<f64>> {
        match self {
            Self::Single(value) => vec![value.into()],
            Self::Pair { mean, square } => {
                let root = Complex::from(square).sqrt();
                vec![root + mean, -root + mean]
            }
        }
    }
}

/// The blocks on the diagonal.
pub(crate) fn blocks(triangle: &DMatrix<f64>) -> Vec<Block> {
    let n = triangle.nrows();
    let mut found = Vec::new();
    let mut row = 0;
    while row < n {
        if row + 1 < n && triangle[(row + 1, row)] != 0.0 {
            let at = |i: usize, j: usize| triangle[(row + i, row + j)];
            let half = 0.5 * (at(0, 0) - at(1, 1));
            found.push(Block::Pair {
                mean: 0.5 * (at(0, 0) + at(1, 1)),
                square: half * half + at(0, 1) * at(1, 0),
            });
            row += 2;
        } else {
            found.push(Block::Single(triangle[(row, row)]));
            row += 1;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::operator::multiply;

    fn from_poles(poles: &[f64]) -> Vec<f64> {
        // Π (1 − p·w)
        (poles.iter()).fold(vec![1.0], |product, p| multiply(&product, &[1.0, -p]))
    }

    #[test]
    fn a_polynomial_is_stable_when_all_its_poles_are_inside() {
        assert_eq!(jury(&from_poles(&[0.9, -0.5, 0.99])), Jury::Stable);
        assert_eq!(jury(&from_poles(&[0.9, -0.5, 1.01])), Jury::NotStable);
        assert_eq!(jury(&from_poles(&[0.9, -1.5, 0.3])), Jury::NotStable);
        assert_eq!(jury(&from_poles(&[0.9, 1.0])), Jury::Undecided);
        assert_eq!(jury(&[1.0]), Jury::Stable);
        assert_eq!(jury(&[0.0, 1.0]), Jury::NotStable);
        assert_eq!(jury(&[1.0, f64::NAN]), Jury::Undecided);
    }

    #[test]
    fn no_eigenvalue_is_lost_where_two_real_ones_are_left_in_one_block() {
        let triangle =
            DMatrix::from_row_slice(3, 3, &[2.0, 1.0, 5.0, 1.0, 2.0, 7.0, 0.0, 0.0, -4.0]);
        let values: Vec<f64> = (blocks(&triangle).into_iter())
            .flat_map(Block::eigenvalues)
            .map(|value| value.re)
            .collect();
        assert_eq!(values, [3.0, 1.0, -4.0]);
        // A triple pole splits by rounding; whatever it becomes, it is counted.
        for pole in [0.3, 0.9, 0.99, 1.01] {
            let values = companion_eigenvalues(&from_poles(&[pole; 3])).expect("converges");
            let far = |value: &Complex<f64>| (value - pole).norm() > 1e-4;
            assert!(values.len() == 3 && !values.iter().any(far), "{values:?}");
            assert!(values.iter().all(|value| value.norm().is_finite()));
        }
    }

    #[test]
    fn the_companion_gives_back_the_poles_it_was_made_from() {
        let mut have: Vec<f64> = companion_eigenvalues(&from_poles(&[0.9, -0.5, 1.2, 0.0]))
            .expect("converges")
            .iter()
            .map(|pole| pole.re)
            .collect();
        have.sort_by(f64::total_cmp);
        for (have, want) in have.iter().zip([-0.5, 0.9, 1.2]) {
            assert!((have - want).abs() < 1e-13, "{have} {want}");
        }
        assert_eq!(companion_eigenvalues(&[0.0, 1.0]), None);
    }
}
