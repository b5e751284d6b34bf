//! Poles and stability of a transfer function.

use crate::{ControlError, FractionalPolynomial, FractionalTransferFunction};
use core::f64::consts::PI;
use nalgebra::DMatrix;
use num_complex::Complex;
use std::vec;
use std::vec::Vec;

/// A function whose orders are multiples of one: a ratio of polynomials in λ = s^q, 0 < q ≤ 1.
///
/// ```
/// use fractional_control::FractionalTransferFunction;
///
/// // λ² + 0.4λ + 1 with λ = √s: roots at ±101.5°, in the open right half-plane of s none.
/// let plant: FractionalTransferFunction = "1/(s+0.4s^0.5+1)".parse()?;
/// let commensurate = plant.commensurate()?;
/// assert!((commensurate.order() - 0.5).abs() < 1e-12 && commensurate.is_stable());
/// # Ok::<(), fractional_control::ControlError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Commensurate {
    order: f64,
    /// Coefficients of λ⁰, λ¹, …
    numerator: Vec<f64>,
    denominator: Vec<f64>,
}

/// Largest degree in λ.
const DEGREE_MAX: usize = 200;
/// Error of an order that counts as none, relative to the common one.
const SAME: f64 = 1e-6;
/// A root this close to the edge, in rad, is on it.
const EDGE: f64 = 1e-9;

impl FractionalTransferFunction {
    /// The function in powers of λ = s^q, with the largest q ≤ 1 of which all orders are multiples.
    ///
    /// # Errors
    /// [`ControlError::NotCommensurate`] if the degree in λ were above 200.
    pub fn commensurate(&self) -> Result<Commensurate, ControlError> {
        let terms = self.denominator().terms().iter();
        let orders: Vec<f64> = terms
            .chain(self.numerator().terms())
            .map(|term| term.order)
            .collect();
        let highest = self.denominator().degree();
        let Some(order) = common(&orders, highest) else {
            return Err(ControlError::NotCommensurate { degree: DEGREE_MAX });
        };
        let in_lambda = |polynomial: &FractionalPolynomial| {
            let degree = libm::round(polynomial.degree() / order) as usize;
            let mut coefficients = vec![0.0; degree + 1];
            for term in polynomial.terms() {
                coefficients[libm::round(term.order / order) as usize] += term.coefficient;
            }
            coefficients
        };
        Ok(Commensurate {
            order,
            numerator: in_lambda(self.numerator()),
            denominator: in_lambda(self.denominator()),
        })
    }

    /// The number of poles with Re s > 0 on the principal branch, for any orders: by the turn of the denominator along the
    /// imaginary axis, with a bound of its derivative between samples. `None` with a pole on the axis, s = 0 included.
    #[must_use]
    pub fn unstable_poles(&self) -> Option<usize> {
        let denominator = self.denominator();
        if denominator.lowest() > 0.0 {
            return None;
        }
        let turn = turn_along_the_axis(denominator)?;
        // From jω → 0 to jω → ∞ a stable one turns by α·π/2.
        let missing = (0.5 * PI * denominator.degree() - turn) / PI;
        let poles = libm::round(missing);
        (poles >= 0.0 && (missing - poles).abs() < 1e-3).then_some(poles as usize)
    }

    /// Refuses a plant that is shown by itself and does not settle.
    ///
    /// # Errors
    /// [`ControlError::UnstablePlant`].
    pub fn stable_by_itself(&self) -> Result<(), ControlError> {
        match self.unstable_poles() {
            Some(0) => Ok(()),
            poles => Err(ControlError::UnstablePlant {
                poles: poles.unwrap_or(1),
            }),
        }
    }
}

/// The largest q = highest/n ≤ 1 of which all orders are multiples; n at most [`DEGREE_MAX`].
fn common(orders: &[f64], highest: f64) -> Option<f64> {
    if highest == 0.0 {
        return Some(1.0);
    }
    let least = libm::ceil(highest - SAME).max(1.0) as usize;
    (least..=DEGREE_MAX).map(|n| highest / n as f64).find(|q| {
        orders
            .iter()
            .all(|order| (order / q - libm::round(order / q)).abs() < SAME)
    })
}

/// The angle by which A(jω) turns for ω from 0 to ∞, or `None` if A is 0 on the way.
///
/// ```text
/// |dA/d ln ω| ≤ Σ α_i|a_i|ω^(α_i), which grows with ω: over a step in ln ω it is below its value at the end
/// ```
fn turn_along_the_axis(a: &FractionalPolynomial) -> Option<f64> {
    let size = |term: &crate::Term, x: f64| term.coefficient.abs() * libm::exp(term.order * x);
    let others = |order: f64, x: f64| -> f64 {
        let terms = a.terms().iter();
        terms
            .filter(|t| (t.order - order).abs() > 0.0)
            .map(|t| size(t, x))
            .sum()
    };
    let (first, last) = (a.terms()[0], *a.terms().last()?);
    // Beyond these one term is all but alone.
    let (mut low, mut high) = (0.0, 0.0);
    while others(last.order, low) > 1e-6 * size(&last, low) {
        low -= 1.0;
        if low < -700.0 {
            return None;
        }
    }
    while others(first.order, high) > 1e-6 * size(&first, high) {
        high += 1.0;
        if high > 700.0 {
            return None;
        }
    }
    let at = |x: f64| a.at(Complex::new(0.0, libm::exp(x)));
    let rate = |x: f64| -> f64 { a.terms().iter().map(|t| t.order * size(t, x)).sum() };
    let (mut turn, mut x, mut here) = (0.0, low, at(low));
    let mut step = 0.1;
    while x < high {
        let next = (x + step).min(high);
        let middle = at(0.5 * (x + next));
        if middle.norm() <= 0.51 * (next - x) * rate(next) {
            step *= 0.5;
            if step < 1e-11 {
                return None;
            }
            continue;
        }
        let there = at(next);
        turn += (there / here).arg();
        (x, here) = (next, there);
        step = (2.0 * step).min(0.1);
    }
    Some(turn)
}

impl Commensurate {
    /// q.
    #[must_use]
    pub fn order(&self) -> f64 {
        self.order
    }

    /// Coefficients of numerator and denominator in powers of λ, of λ⁰ first.
    #[must_use]
    pub fn polynomials(&self) -> (&[f64], &[f64]) {
        (&self.numerator, &self.denominator)
    }

    /// The roots λ of the denominator.
    #[must_use]
    pub fn roots(&self) -> Vec<Complex<f64>> {
        roots(&self.denominator)
    }

    /// The poles s = λ^(1/q), of those roots that lie on the principal branch, |arg λ| ≤ qπ.
    #[must_use]
    pub fn poles(&self) -> Vec<Complex<f64>> {
        let on_branch = |root: &Complex<f64>| root.arg().abs() <= self.order * PI * (1.0 + 1e-12);
        let roots = self.roots().into_iter().filter(on_branch);
        roots.map(|root| root.powf(1.0 / self.order)).collect()
    }

    /// Matignon's condition: |arg λ| > qπ/2 for every root λ, which is not 0.
    ///
    /// Source: D. Matignon, *Stability properties for generalized fractional differential systems*, ESAIM Proc. 5, 1998.
    #[must_use]
    pub fn is_stable(&self) -> bool {
        let edge = 0.5 * PI * self.order;
        let outside = |root: &Complex<f64>| root.norm() > 0.0 && root.arg().abs() > edge + EDGE;
        self.roots().iter().all(outside)
    }
}

/// Roots of a polynomial, coefficient of λ⁰ first, by the eigenvalues of its companion matrix.
pub(crate) fn roots(coefficients: &[f64]) -> Vec<Complex<f64>> {
    let zeros = coefficients.iter().take_while(|c| **c == 0.0).count();
    let rest = &coefficients[zeros..];
    let mut all = vec![Complex::new(0.0, 0.0); zeros];
    let n = rest.len().saturating_sub(1);
    if n > 0 {
        // λ = r·z with r = |a₀/a_n|^(1/n), so that the roots are near the unit circle.
        let radius = libm::pow((rest[0] / rest[n]).abs(), 1.0 / n as f64);
        let scaled = |k: usize| rest[k] / rest[n] * libm::pow(radius, k as f64 - n as f64);
        let companion = DMatrix::from_fn(n, n, |row, column| {
            let last = if column + 1 == n { -scaled(row) } else { 0.0 };
            last + f64::from(u8::from(row == column + 1))
        });
        all.extend(companion.complex_eigenvalues().iter().map(|z| z * radius));
    }
    all
}
