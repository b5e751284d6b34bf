//! Motion of a linear plant under a held input, by the exponential of a matrix less 1.
//!
//! Source: N. J. Higham, *Functions of Matrices*, SIAM, 2008, ch. 10.

use std::vec;
use std::vec::Vec;

/// Terms of the series: (1/2)^k/k! is below 1e-19 from here on.
const TERMS: u32 = 16;

/// e^(At) − 1 and ∫₀ᵗ e^(As)B ds of x′ = Ax + Bu, the matrices by columns.
/// ```text
/// x(t) = x(0) + E·x(0) + Γ·u,     [E Γ; 0 0] = M + M²/2! + … = exp(M) − 1,  M = [A B; 0 0]·t
/// exp(2M) − 1 = 2E + E²
/// ```
/// The exponential less 1 keeps the digits of slow motions beside fast ones. Taylor series for a norm below 1/2, then at most 60 doublings; a
/// number that is not finite spoils all.
/// ```
/// // x″ = u: in 2 s by 2·v(0) + 2·u.
/// let (state, input) = fracdiff::linear_motion(&[0.0, 0.0, 1.0, 0.0], &[0.0, 1.0], 2.0);
/// assert_eq!(state, [0.0, 0.0, 2.0, 0.0]);
/// assert_eq!(input, [2.0, 2.0]);
/// ```
///
/// # Panics
/// If A has less than n² numbers, of n in B.
#[must_use]
pub fn linear_motion(a: &[f64], b: &[f64], t: f64) -> (Vec<f64>, Vec<f64>) {
    let (n, size) = (b.len(), b.len() + 1);
    let columns = (0..n).map(|column| &a[column * n..][..n]).chain([b]);
    let mut small: Vec<f64> = columns
        .flat_map(|column| column.iter().map(|x| x * t).chain([0.0]))
        .collect();
    let norms = small
        .chunks(size)
        .map(|column| column.iter().map(|x| x.abs()).sum());
    let norm = norms.fold(0.0, f64::max);
    let halvings = if norm < 0.5 {
        0
    } else {
        (libm::ilogb(norm) + 2).min(60)
    };
    for x in &mut small {
        *x *= libm::ldexp(1.0, -halvings);
    }
    let product = |left: &[f64], right: &[f64], entry: &dyn Fn(usize, f64) -> f64| -> Vec<f64> {
        let entries = (0..size * size).map(|at| {
            let column = right[at / size * size..].iter();
            let row = left[at % size..].iter().step_by(size);
            entry(at, row.zip(column).map(|(x, y)| x * y).sum())
        });
        entries.collect()
    };
    // Horner: M·(1 + M/2·(1 + M/3·(…)))
    let mut moved = vec![0.0; size * size];
    for k in (1..=TERMS).rev() {
        moved = product(&small, &moved, &|at, x| (small[at] + x) / f64::from(k));
    }
    for _ in 0..halvings {
        moved = product(&moved, &moved, &|at, square| 2.0 * moved[at] + square);
    }
    let mut columns = moved.chunks(size).map(|column| &column[..n]);
    let state = columns.by_ref().take(n).flatten().copied().collect();
    (state, columns.flatten().copied().collect())
}
