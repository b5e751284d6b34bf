//! Eigenvalues of small matrices, in a bounded number of steps.
//!
//! Brought to Hessenberg form by elimination, then QR with the shift of Wilkinson; where that leaves a matrix as it is, as a cyclic one, an
//! exceptional shift does not.
//!
//! Source: J. H. Wilkinson, C. Reinsch, *Handbook for Automatic Computation II: Linear Algebra*, 1971, contributions II/13 (elimination) and II/16
//! (complex QR, exceptional shifts).

use crate::roots::pair;
use num_complex::Complex;
use std::vec;
use std::vec::Vec;

/// Steps for each eigenvalue at most; two or three are usual.
const STEPS: usize = 60;
/// Number of steps after which an exceptional shift is used.
const EXCEPTIONAL: usize = 10;

/// The eigenvalues of a square matrix of real numbers, by rows or by columns: conjugate to each other or real.
///
/// At most 60 steps of some 20·n² multiply-adds for each. To rounding of the largest number of the matrix: balance it first.
/// NaN in place of one that is not found within them, and of all if a number is not finite.
/// ```
/// // A cyclic matrix: QR without an exceptional shift never changes it.
/// let values = fracdiff::eigenvalues(&[0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0], 3);
/// assert!(values.iter().all(|z| (z.powu(3) - 1.0).norm() < 1e-14) && values.len() == 3);
/// ```
///
/// # Panics
/// Unless the matrix has n² numbers.
#[must_use]
pub fn eigenvalues(matrix: &[f64], n: usize) -> Vec<Complex<f64>> {
    assert_eq!(matrix.len(), n * n, "numbers of a square matrix");
    if !matrix.iter().all(|x| x.is_finite()) {
        return vec![Complex::new(f64::NAN, f64::NAN); n];
    }
    let mut rows: Vec<Vec<f64>> = (0..n)
        .map(|k| matrix[k * n..(k + 1) * n].to_vec())
        .collect();
    eliminate(&mut rows);
    let complex = |x: f64| Complex::new(x, 0.0);
    let mut rows = rows
        .into_iter()
        .map(|row| row.into_iter().map(complex).collect())
        .collect();
    let mut values = decoupled(&mut rows);
    pair(&mut values);
    values
}

/// Brings a matrix to Hessenberg form: below the diagonal only its neighbours are left.
fn eliminate(a: &mut [Vec<f64>]) {
    let n = a.len();
    for m in 1..n.saturating_sub(1) {
        let size = |row: &usize| a[*row][m - 1].abs();
        let pivot = (m..n)
            .rev()
            .max_by(|i, j| size(i).total_cmp(&size(j)))
            .unwrap_or(m);
        a.swap(pivot, m);
        for row in &mut *a {
            row.swap(pivot, m);
        }
        if a[m][m - 1] == 0.0 {
            continue;
        }
        for i in m + 1..n {
            let share = a[i][m - 1] / a[m][m - 1];
            let (above, below) = a.split_at_mut(i);
            for (x, pivot) in below[0][m - 1..].iter_mut().zip(&above[m][m - 1..]) {
                *x -= share * pivot;
            }
            for row in &mut *a {
                row[m] += share * row[i];
            }
            a[i][m - 1] = 0.0;
        }
    }
}

/// The eigenvalues of a Hessenberg matrix, from the last.
fn decoupled(h: &mut Vec<Vec<Complex<f64>>>) -> Vec<Complex<f64>> {
    let size = |z: Complex<f64>| z.re.abs() + z.im.abs();
    let mut values = Vec::with_capacity(h.len());
    while let Some(last) = h.len().checked_sub(1) {
        let mut found = None;
        for step in 1..=STEPS {
            let alone = |k: &usize| {
                let neighbours = size(h[k - 1][k - 1]) + size(h[*k][*k]);
                size(h[*k][k - 1]) <= f64::EPSILON * neighbours
            };
            let first = (1..=last).rev().find(alone).unwrap_or(0);
            if last - first <= 1 {
                found = Some(first);
                break;
            }
            let shift = if step % EXCEPTIONAL == 0 {
                Complex::new(1.5 * size(h[last][last - 1]), 0.0)
            } else {
                of_two(h, last)[1]
            };
            turn(h, first..last, shift);
        }
        match found {
            Some(first) if first < last => values.extend(of_two(h, last)),
            Some(_) => values.push(h[last][last]),
            None => values.push(Complex::new(f64::NAN, f64::NAN)),
        }
        h.truncate(found.unwrap_or(last));
    }
    values
}

/// The eigenvalues of the last two rows and columns, the second nearest to the last number.
fn of_two(h: &[Vec<Complex<f64>>], last: usize) -> [Complex<f64>; 2] {
    let [a, b] = [h[last - 1][last - 1], h[last][last]];
    let half = (a - b) * 0.5;
    let product = h[last - 1][last] * h[last][last - 1];
    let root = (half * half + product).sqrt();
    let [one, other] = [half + root, half - root];
    let far = if one.norm_sqr() < other.norm_sqr() {
        other
    } else {
        one
    };
    let near = if product.norm_sqr() == 0.0 {
        product
    } else {
        product / far
    };
    [a + near, b - near]
}

/// One step of QR between these rows: H − s = QR, H ← RQ + s.
fn turn(h: &mut [Vec<Complex<f64>>], rows: core::ops::Range<usize>, shift: Complex<f64>) {
    let (first, last) = (rows.start, rows.end);
    for (k, row) in h.iter_mut().enumerate().take(last + 1).skip(first) {
        row[k] -= shift;
    }
    let mut rotations = Vec::with_capacity(last - first);
    for k in rows.clone() {
        let length = libm::hypot(h[k][k].norm(), h[k + 1][k].norm());
        let (c, s) = if length > 0.0 {
            (h[k][k] / length, h[k + 1][k] / length)
        } else {
            (Complex::new(1.0, 0.0), Complex::new(0.0, 0.0))
        };
        let (above, below) = h.split_at_mut(k + 1);
        for (x, y) in above[k][k..=last].iter_mut().zip(&mut below[0][k..=last]) {
            (*x, *y) = (c.conj() * *x + s.conj() * *y, c * *y - s * *x);
        }
        rotations.push((c, s));
    }
    for (k, (c, s)) in rows.zip(rotations) {
        for row in &mut h[first..=(k + 1)] {
            let (left, right) = (row[k], row[k + 1]);
            row[k] = left * c + right * s;
            row[k + 1] = right * c.conj() - left * s.conj();
        }
    }
    for (k, row) in h.iter_mut().enumerate().take(last + 1).skip(first) {
        row[k] += shift;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The companion matrix of a polynomial whose highest coefficient is 1.
    fn companion(coefficients: &[f64]) -> Vec<f64> {
        let n = coefficients.len() - 1;
        let at = |row: usize, column: usize| {
            let last = if column + 1 == n {
                -coefficients[row]
            } else {
                0.0
            };
            last + f64::from(u8::from(row == column + 1))
        };
        (0..n * n).map(|k| at(k / n, k % n)).collect()
    }

    #[test]
    fn eigenvalues_of_cyclic_matrices_are_found() {
        for n in 1..=17 {
            for last in [1.0, -1.0, 3.0] {
                let mut coefficients = vec![0.0; n + 1];
                (coefficients[0], coefficients[n]) = (last, 1.0);
                let have = eigenvalues(&companion(&coefficients), n);
                let want = crate::roots(&coefficients);
                assert_eq!(have.len(), n);
                for z in &have {
                    let apart = want.iter().map(|root| (root - z).norm());
                    assert!(
                        apart.fold(f64::INFINITY, f64::min) < 1e-13,
                        "{n}, {last}: {have:?}"
                    );
                }
                for (k, z) in have.iter().enumerate() {
                    assert!(
                        !have[..k].contains(z) && have.contains(&z.conj()),
                        "{n}, {last}: {have:?}"
                    );
                }
            }
        }
    }

    /// Similar to a diagonal matrix of known numbers, by an orthogonal reflection.
    #[test]
    fn eigenvalues_of_known_matrices_are_those() {
        for n in 1..=12_usize {
            let want: Vec<f64> = (0..n).map(|k| (k as f64 - 3.0) * 1.5).collect();
            let v: Vec<f64> = (0..n).map(|k| libm::sin(1.0 + k as f64)).collect();
            let length: f64 = v.iter().map(|x| x * x).sum();
            let q = |i: usize, j: usize| f64::from(u8::from(i == j)) - 2.0 * v[i] * v[j] / length;
            let at = |i: usize, j: usize| (0..n).map(|k| q(i, k) * want[k] * q(k, j)).sum();
            let matrix: Vec<f64> = (0..n * n).map(|k| at(k / n, k % n)).collect();
            let mut have: Vec<f64> = eigenvalues(&matrix, n).iter().map(|z| z.re).collect();
            have.sort_by(f64::total_cmp);
            for (have, want) in have.iter().zip(&want) {
                assert!((have - want).abs() < 1e-12, "{n}: {have} {want}");
            }
        }
    }

    #[test]
    fn a_swing_without_damping_lies_on_the_axis() {
        for (below, size) in [
            (-4.0, 2.0),
            (-0.3, libm::sqrt(0.3)),
            (-1e9, libm::sqrt(1e9)),
        ] {
            let have = eigenvalues(&[0.0, 1.0, below, 0.0], 2);
            for z in &have {
                assert!(
                    z.re == 0.0 && (z.im.abs() / size - 1.0).abs() < 1e-15,
                    "{have:?}"
                );
            }
        }
    }

    #[test]
    fn a_triangle_keeps_its_diagonal_and_what_is_no_number_gives_none() {
        let triangle = [0.0, 1.0, 5.0, 0.0, -7.5, 2.0, 0.0, 0.0, -1e-9];
        let have: Vec<f64> = eigenvalues(&triangle, 3).iter().map(|z| z.re).collect();
        assert_eq!(have, [0.0, -1e-9, -7.5]);
        assert!(eigenvalues(&[f64::NAN], 1)[0].re.is_nan());
        assert_eq!(eigenvalues(&[], 0), []);
    }
}
