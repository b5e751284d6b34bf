//! Motion of a linear plant over part of a sample, by the matrix exponential, and its pulse transfer function.
//!
//! ```text
//! x' = Ax + Bu, u constant:   x(t) = x(0) + E·x(0) + Γ·u,     [E Γ; 0 0] = exp([A B; 0 0]·t) − 1
//! exp(2M) − 1 = 2E + E²
//! ```
//! The exponential less 1 keeps the digits of slow motions beside fast ones: what moves by 1e-9 in a
//! sample would be lost in a 1 + 1e-9. Taylor series for a norm below 1/2, then doublings.
//!
//! Source: N. J. Higham, *Functions of Matrices*, SIAM, 2008, ch. 10.

use nalgebra::{DMatrix, DVector, RowDVector};

/// Terms of the series: (1/2)^k/k! is below 1e-19 from here on.
const TERMS: u32 = 16;

/// E and Γ for one duration.
#[derive(Clone, Debug)]
pub(crate) struct Motion {
    /// exp(A·t) − 1.
    pub(crate) state: DMatrix<f64>,
    /// The state to which a unit input takes the plant from rest.
    pub(crate) input: DVector<f64>,
}

impl Motion {
    /// For `a` and `b` in units of one sample, `duration` in samples.
    pub(crate) fn new(a: &DMatrix<f64>, b: &DVector<f64>, duration: f64) -> Self {
        let n = a.nrows();
        let generator = DMatrix::from_fn(n + 1, n + 1, |row, column| {
            if row == n {
                0.0
            } else if column == n {
                b[row] * duration
            } else {
                a[(row, column)] * duration
            }
        });
        let moved = exponential_less_one(&generator);
        Self {
            state: moved.view((0, 0), (n, n)).into_owned(),
            input: moved.view((0, n), (n, 1)).column(0).into_owned(),
        }
    }

    /// exp(A·t)·x.
    pub(crate) fn carry(&self, x: &DVector<f64>) -> DVector<f64> {
        x + &self.state * x
    }
}

/// The numerator in powers of w of a plant whose input changes at the fraction h of a sample, for
/// the denominator a.
///
/// ```text
/// N = C·adj(1 − wΦ)·(Γ₀ + Γ₁w) = Σ_j (r_jΓ₀ + r_{j−1}Γ₁)w^j,    r₀ = C,  r_j = r_{j−1}Φ + a_jC
/// Γ₀ = ∫₀^(1−h) e^(As)B ds,    Γ₁ = e^(A(1−h))·∫₀^h e^(As)B ds
/// ```
pub(crate) fn numerator(
    a: &DMatrix<f64>,
    b: &DVector<f64>,
    c: &RowDVector<f64>,
    fraction: f64,
    denominator: &[f64],
) -> Vec<f64> {
    let n = a.nrows();
    let sample = Motion::new(a, b, 1.0);
    let late = Motion::new(a, b, 1.0 - fraction);
    let early = (fraction > 0.0).then(|| late.carry(&Motion::new(a, b, fraction).input));
    let mut row = c.clone();
    let mut before: Option<RowDVector<f64>> = None;
    let mut terms = Vec::new();
    for j in 0..=n {
        let mut term = if j < n {
            row.dot(&late.input.transpose())
        } else {
            0.0
        };
        if let (Some(before), Some(early)) = (&before, &early) {
            term += before.dot(&early.transpose());
        }
        if j < n || early.is_some() {
            terms.push(term);
        }
        let next = &row + &row * &sample.state + c * denominator[(j + 1).min(n)];
        before = Some(std::mem::replace(&mut row, next));
    }
    terms
}

/// exp(M) − 1.
fn exponential_less_one(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let norm = (matrix.column_iter())
        .map(|column| column.iter().map(|x| x.abs()).sum::<f64>())
        .fold(0.0, f64::max);
    let halvings = if norm < 0.5 { 0 } else { libm::ilogb(norm) + 2 };
    let small = matrix * libm::ldexp(1.0, -halvings);
    // Horner: M·(1 + M/2·(1 + M/3·(…)))
    let identity = DMatrix::identity(matrix.nrows(), matrix.nrows());
    let inner = (2..=TERMS).rev().fold(identity.clone(), |sum, k| {
        &identity + &small * sum / f64::from(k)
    });
    (0..halvings).fold(small * inner, |e, _| &e * 2.0 + &e * &e)
}
