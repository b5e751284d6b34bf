//! Roots of polynomials, all at once, in a bounded number of steps.
//! ```text
//! z_k ← z_k − 1/(p'/p − Σ_{j≠k} 1/(z_k − z_j))
//! ```
//! begun on the circles of the Newton polygon, whose radii are those of the roots within a factor. Near a root p and p' are summed with twice the
//! digits, so a double root is known to all of them and a triple one to ten.
//!
//! Sources: O. Aberth, *Iteration methods for finding all zeros of a polynomial simultaneously*, Math. Comp. 27, 1973, eq. 2; D. A. Bini, *Numerical
//! computation of polynomial zeros by means of Aberth's method*, Numerical Algorithms 13, 1996 (where to begin, when to end); T. J. Dekker, *A
//! floating-point technique for extending the available precision*, Numerische Mathematik 18, 1971.

use core::f64::consts::PI;
use num_complex::Complex;
use std::vec;
use std::vec::Vec;

/// Sweeps over all roots at most. A simple root takes about ten, each doubling of the digits of an m-fold one m times as many.
const SWEEPS: usize = 200;

/// The roots of `Σ c_k z^k`, coefficient of z⁰ first: as many as its degree, conjugate to each other or real.
///
/// Coefficients may differ by any factor. At most 200 sweeps over all roots are made, of degree n some 10·n² multiply-adds each; simple roots are
/// exact to rounding of the root itself wherever the coefficients determine them, an m-fold one to the m-th part of 31 digits. A coefficient that
/// is not finite makes every root NaN; a constant has none.
/// ```
/// let roots = fracdiff::roots(&[1.0, 0.0, 0.0, 0.0, 1.0]); // z⁴ + 1, whose companion matrix QR leaves as it is
/// assert!(roots.iter().all(|z| (z.powu(4) + 1.0).norm() < 1e-15) && roots.len() == 4);
/// ```
#[must_use]
pub fn roots(coefficients: &[f64]) -> Vec<Complex<f64>> {
    found(coefficients).0
}

/// The product of two polynomials that are not empty, in the order of their coefficients.
#[must_use]
pub fn product(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; a.len() + b.len() - 1];
    for (i, x) in a.iter().enumerate() {
        for (sum, y) in product[i..].iter_mut().zip(b) {
            *sum += x * y;
        }
    }
    product
}

/// The roots, and the sweeps that they took.
fn found(coefficients: &[f64]) -> (Vec<Complex<f64>>, usize) {
    let used = coefficients
        .iter()
        .rposition(|c| *c != 0.0)
        .map_or(0, |last| last + 1);
    let zeros = coefficients
        .iter()
        .take_while(|c| **c == 0.0)
        .count()
        .min(used);
    let rest = &coefficients[zeros..used];
    let mut all = vec![Complex::new(0.0, 0.0); zeros];
    if rest.iter().any(|c| !c.is_finite()) {
        all = vec![Complex::new(f64::NAN, f64::NAN); used.saturating_sub(1)];
        return (all, 0);
    }
    let mut polynomial = Polynomial {
        coefficients: rest,
        scaled: Vec::new(),
    };
    let mut places = polynomial.beginning();
    let sweeps = polynomial.sweep(&mut places);
    pair(&mut places);
    all.extend(places);
    (all, sweeps)
}

struct Polynomial<'a> {
    /// Coefficients, the first and the last not 0.
    coefficients: &'a [f64],
    /// Those of p(2^e·z)/2^m for some e, the largest about 1: so no power of z is too large or too small.
    scaled: Vec<(i32, Vec<f64>)>,
}

impl Polynomial<'_> {
    /// Starts on circles of |`c_i`/`c_j`|^(1/(j−i)) for each edge i to j of the upper hull of (k, ln|`c_k`|).
    fn beginning(&self) -> Vec<Complex<f64>> {
        let logarithms: Vec<f64> = self
            .coefficients
            .iter()
            .map(|c| libm::log(c.abs()))
            .collect();
        let slope = |i: usize, j: usize| (logarithms[j] - logarithms[i]) / (j - i) as f64;
        let mut hull: Vec<usize> = Vec::new();
        for (k, c) in self.coefficients.iter().enumerate() {
            if *c == 0.0 {
                continue;
            }
            while let [.., before, last] = hull[..]
                && slope(before, last) <= slope(last, k)
            {
                hull.pop();
            }
            hull.push(k);
        }
        let mut places = Vec::with_capacity(self.coefficients.len());
        for edge in hull.windows(2) {
            let [i, j] = [edge[0], edge[1]];
            let radius = libm::exp(-slope(i, j));
            places.extend((i..j).map(|k| {
                // No two of them conjugate: such a pair could never become two real roots.
                let angle = 2.0
                    * PI
                    * ((k - i) as f64 / (j - i) as f64 + i as f64 / self.coefficients.len() as f64);
                Complex::from_polar(radius, angle + 0.7)
            }));
        }
        places
    }

    /// Moves all places to the roots and returns the number of sweeps.
    fn sweep(&mut self, places: &mut [Complex<f64>]) -> usize {
        let mut moves = vec![true; places.len()];
        for sweep in 0..SWEEPS {
            if !moves.contains(&true) {
                return sweep;
            }
            for k in 0..places.len() {
                let z = places[k];
                // A root whose size is zero, subnormal or not finite stays there.
                if !moves[k] || !z.norm().is_normal() {
                    moves[k] = false;
                    continue;
                }
                let unit = libm::ilogb(z.norm());
                let (pulled, is_zero) = pulled(self.in_unit(unit), scaled(z, -unit));
                let others = places.iter().enumerate().filter(|(j, _)| *j != k);
                let pushed = others.map(|(_, other)| inverse(z - other));
                let pushed: Complex<f64> = pushed.filter(|push| push.is_finite()).sum();
                let step = scaled(inverse(pulled - scaled(pushed, unit)), unit);
                let usable = !is_zero && step.is_finite();
                if usable {
                    places[k] = z - step;
                }
                moves[k] = usable && step.norm() > f64::EPSILON * z.norm();
            }
        }
        SWEEPS
    }

    /// The coefficients for places of the size 2^unit.
    fn in_unit(&mut self, unit: i32) -> &[f64] {
        let known = self.scaled.iter().position(|(known, _)| *known == unit);
        let place = known.unwrap_or_else(|| {
            let powers = || {
                self.coefficients
                    .iter()
                    .zip(0..)
                    .map(|(c, k)| (*c, unit * k))
            };
            let used = powers().filter(|(c, _)| *c != 0.0);
            let sizes = used.map(|(c, power)| libm::ilogb(c) + power);
            let most = sizes.max().unwrap_or(0);
            let coefficients = powers().map(|(c, power)| libm::scalbn(c, power - most));
            self.scaled.push((unit, coefficients.collect()));
            self.scaled.len() - 1
        });
        &self.scaled[place].1
    }
}

fn scaled(z: Complex<f64>, by: i32) -> Complex<f64> {
    Complex::new(libm::scalbn(z.re, by), libm::scalbn(z.im, by))
}

/// 1/z, even if |z|² overflows or vanishes.
fn inverse(z: Complex<f64>) -> Complex<f64> {
    if z.re.abs() > z.im.abs() {
        let share = z.im / z.re;
        let size = z.re + z.im * share;
        Complex::new(1.0 / size, -share / size)
    } else {
        let share = z.re / z.im;
        let size = z.im + z.re * share;
        Complex::new(share / size, -1.0 / size)
    }
}

/// p'/p, and true if p is 0 there within rounding.
fn pulled(coefficients: &[f64], z: Complex<f64>) -> (Complex<f64>, bool) {
    let (mut value, mut slope) = (Complex::new(0.0, 0.0), Complex::new(0.0, 0.0));
    let (mut size, length) = (0.0, z.norm());
    for coefficient in coefficients.iter().rev() {
        slope = slope * z + value;
        value = value * z + coefficient;
        size = size * length + coefficient.abs();
    }
    let rounding = 4.0 * coefficients.len() as f64 * f64::EPSILON * size;
    let mut is_zero = false;
    if value.norm() < NEAR * rounding {
        (value, slope) = twice(z, coefficients);
        is_zero = value.norm() <= f64::EPSILON * rounding;
    }
    (slope / value, is_zero)
}

/// Multiple of the rounding error below which p is summed with twice the digits.
const NEAR: f64 = 1e6;

/// p and p' with twice the digits.
fn twice(z: Complex<f64>, coefficients: &[f64]) -> (Complex<f64>, Complex<f64>) {
    let zero = [Double(0.0, 0.0); 2];
    let (mut value, mut slope) = (zero, zero);
    let turned = |[re, im]: [Double; 2]| {
        [
            re.times(z.re).plus(im.times(-z.im)),
            re.times(z.im).plus(im.times(z.re)),
        ]
    };
    for coefficient in coefficients.iter().rev() {
        let [re, im] = turned(slope);
        slope = [re.plus(value[0]), im.plus(value[1])];
        let [re, im] = turned(value);
        value = [re.plus(Double(*coefficient, 0.0)), im];
    }
    let rounded = |[re, im]: [Double; 2]| Complex::new(re.0, im.0);
    (rounded(value), rounded(slope))
}

/// A number and what rounding left of it.
#[derive(Clone, Copy)]
struct Double(f64, f64);

impl Double {
    fn plus(self, other: Self) -> Self {
        let sum = self.0 + other.0;
        let part = sum - self.0;
        let left = (self.0 - (sum - part)) + (other.0 - part);
        let left = left + self.1 + other.1;
        Self(sum + left, left - ((sum + left) - sum))
    }

    fn times(self, x: f64) -> Self {
        let halves = |x: f64| {
            let high = 134_217_729.0 * x;
            let high = high - (high - x);
            (high, x - high)
        };
        let product = self.0 * x;
        let ((a, b), (c, d)) = (halves(self.0), halves(x));
        let left = b * d - (((product - a * c) - b * c) - a * d) + self.1 * x;
        let sum = product + left;
        Self(sum, left - (sum - product))
    }
}

/// Makes numbers that are real or come in conjugate pairs, but for rounding, so: the farthest from the real axis first. The smallest comes first.
pub(crate) fn pair(numbers: &mut [Complex<f64>]) {
    numbers.sort_by(|a, b| b.im.abs().total_cmp(&a.im.abs()));
    let mut rest = &mut *numbers;
    while let [z, others @ ..] = rest {
        let apart = |other: &Complex<f64>| (other - z.conj()).norm();
        let nearest = others.iter().enumerate();
        let nearest = nearest.min_by(|a, b| apart(a.1).total_cmp(&apart(b.1)));
        match nearest {
            Some((j, other)) if apart(other) < 2.0 * z.im.abs() => {
                let middle = (*z + other.conj()) * 0.5;
                *z = Complex::new(middle.re, middle.im.abs());
                others[..=j].rotate_right(1);
                others[0] = z.conj();
                rest = &mut others[1..];
            }
            _ => {
                z.im = 0.0;
                rest = others;
            }
        }
    }
    numbers.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Coefficients and Σ cos(3·ln|z| + |arg z|) of the roots that are not 0, with 60 digits by mpmath.
    const GOLDEN: &str = include_str!("../tests/golden/roots.csv");

    #[test]
    fn every_root_is_that_of_mpmath_within_bounded_sweeps() {
        let (mut cases, mut most) = (0, 0);
        for line in GOLDEN.lines().skip(1) {
            let (coefficients, witness) = line.split_once(',').expect("two cells");
            let numbers = coefficients
                .split(' ')
                .map(|c| c.parse().expect("a number"));
            let coefficients: Vec<f64> = numbers.collect();
            let (roots, sweeps) = found(&coefficients);
            assert_eq!(roots.len(), coefficients.len() - 1, "{line}");
            let shown = roots.iter().filter(|z| z.norm() > 0.0);
            let have: f64 = shown
                .map(|z| libm::cos(3.0 * libm::log(z.norm()) + z.arg().abs()))
                .sum();
            let want: f64 = witness.parse().expect("a number");
            // 1e-10 of each root, which the witness shows three times as large.
            assert!((have - want).abs() < 3e-10, "{line}: {have}, {roots:?}");
            (cases, most) = (cases + 1, most.max(sweeps));
        }
        assert!(cases == 2000 && most <= 100, "{cases} cases, {most} sweeps");
    }

    #[test]
    fn real_roots_are_real_and_the_others_are_conjugate() {
        // (z − 1)(z + 2)(z² + z + 5)(z − 3)²
        let factors: [&[f64]; 5] = [
            &[-1.0, 1.0],
            &[2.0, 1.0],
            &[5.0, 1.0, 1.0],
            &[-3.0, 1.0],
            &[-3.0, 1.0],
        ];
        let whole = factors.iter().fold(vec![1.0], |all, factor| {
            let mut next = vec![0.0; all.len() + factor.len() - 1];
            for (i, a) in all.iter().enumerate() {
                for (j, b) in factor.iter().enumerate() {
                    next[i + j] += a * b;
                }
            }
            next
        });
        let have = roots(&whole);
        let swing = Complex::new(-0.5, libm::sqrt(4.75));
        let want = [
            (1.0).into(),
            (-2.0).into(),
            swing,
            swing.conj(),
            (3.0).into(),
            (3.0).into(),
        ];
        for (have, want) in have.iter().zip(want) {
            assert!((have - want).norm() < 1e-15 * want.norm(), "{have} {want}");
            assert_eq!(have.im == 0.0, want.im == 0.0, "{have} {want}");
        }
    }

    #[test]
    fn what_has_no_roots_and_what_is_no_number() {
        assert_eq!(roots(&[]), []);
        assert_eq!(roots(&[0.0, 0.0]), []);
        assert_eq!(roots(&[3.0]), []);
        assert_eq!(roots(&[0.0, 0.0, 3.0, 0.0]), [Complex::new(0.0, 0.0); 2]);
        assert!(roots(&[1.0, f64::NAN, 1.0]).iter().all(|z| z.re.is_nan()));
        assert!(
            roots(&[1.0, 1.0, f64::INFINITY])
                .iter()
                .all(|z| z.re.is_nan())
        );
        // Radii of 1e±280, beside which the others are nothing.
        let far = roots(&[1e-300, 1e-20, 0.0, 1e-20, 1e-300]);
        let sizes: Vec<f64> = far.iter().map(|z| z.norm()).collect();
        for (have, want) in sizes.iter().zip([1e-280, 1.0, 1.0, 1e280]) {
            assert!((have / want - 1.0).abs() < 1e-15, "{sizes:?}");
        }
        assert!(far[0].im == 0.0 && far[1] == far[2].conj() && far[3].im == 0.0);
    }
}
