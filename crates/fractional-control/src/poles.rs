//! Poles and stability of a transfer function.

use crate::{ControlError, FractionalPolynomial, FractionalTransferFunction};
use core::f64::consts::PI;
use fracdiff::roots;
use num_complex::Complex;
use std::{vec, vec::Vec};

/// The denominator of a function whose orders are multiples of one: a polynomial in λ = s^q, 0 < q ≤ 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Commensurate {
    order: f64,
    /// Coefficients of λ⁰, λ¹, …
    denominator: Vec<f64>,
}

const DEGREE_MAX: usize = 200;
/// Error of an order that counts as none, relative to the common one.
const SAME: f64 = 1e-6;

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
        let mut denominator = vec![0.0; libm::round(highest / order) as usize + 1];
        for term in self.denominator().terms() {
            denominator[libm::round(term.order / order) as usize] += term.coefficient;
        }
        Ok(Commensurate { order, denominator })
    }

    /// The number of poles with Re s > 0 on the principal branch, for any orders: by the turn of the denominator along the
    /// imaginary axis, with a bound of its derivative between samples. `None` with a pole on the axis, s = 0 included.
    #[must_use]
    pub fn unstable_poles(&self) -> Option<usize> {
        let at_rest = self.denominator().lowest() > 0.0;
        self.growing_poles().filter(|_| !at_rest)
    }

    /// Counts the poles with Re s > 0, also of a function with a pole at s = 0, which does not count.
    pub(crate) fn growing_poles(&self) -> Option<usize> {
        let denominator = self.denominator();
        let turn = OnAxis(denominator).turn()?;
        // From jω → 0 to jω → ∞ one that does not grow turns by (α − α₀)·π/2.
        let missing = (0.5 * PI * (denominator.degree() - denominator.lowest()) - turn) / PI;
        let poles = libm::round(missing);
        (poles >= 0.0 && (missing - poles).abs() < 1e-3).then_some(poles as usize)
    }

    /// Refuses a plant that is to be simulated alone but does not settle.
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

/// A polynomial on the imaginary axis, over x = ln ω. Its numbers are relative to e^scale, so that no power is too large or too small.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OnAxis<'a>(pub &'a FractionalPolynomial);

/// Steps of a turn at most: a thousand times what any of the tests takes.
const STEPS_MAX: usize = 1_000_000;
/// Shortest step of ln ω: what is nearer to the axis is on it.
const STEP_MIN: f64 = 1e-11;

impl OnAxis<'_> {
    /// ln of the largest term.
    pub(crate) fn scale(&self, x: f64) -> f64 {
        let terms = self.0.terms().iter();
        let sizes = terms.map(|term| libm::log(term.coefficient.abs()) + term.order * x);
        sizes.fold(f64::NEG_INFINITY, f64::max)
    }

    pub(crate) fn at(&self, x: f64, scale: f64) -> Complex<f64> {
        let terms = self.0.terms().iter();
        let terms = terms.map(|term| {
            let size = libm::exp(libm::log(term.coefficient.abs()) + term.order * x - scale);
            let (sin, cos) = libm::sincos(0.5 * PI * term.order);
            Complex::new(cos, sin) * size * term.coefficient.signum()
        });
        terms.sum()
    }

    /// `α_i` and `|a_i|ω^(α_i)`/e^scale, highest order first.
    pub(crate) fn sizes(&self, x: f64, scale: f64) -> impl Iterator<Item = (f64, f64)> + Clone {
        let terms = self.0.terms().iter();
        terms.map(move |term| {
            let size = libm::log(term.coefficient.abs()) + term.order * x - scale;
            (term.order, libm::exp(size))
        })
    }

    /// `Σ α_i|a_i|ω^(α_i)`/e^scale.
    fn rate(&self, x: f64, scale: f64) -> f64 {
        let sizes = self.sizes(x, scale);
        sizes.map(|(order, size)| order * size).sum()
    }

    /// Below the first place the lowest term is at least twice all others together, above the second the highest.
    fn ends(&self) -> (f64, f64) {
        let terms = self.0.terms();
        let (Some(first), Some(last)) = (terms.first(), terms.last()) else {
            return (0.0, 0.0);
        };
        let room = libm::log(2.0 * terms.len() as f64);
        let ln = |term: &crate::Term| libm::log(term.coefficient.abs());
        let others = |one: f64| {
            let terms = terms.iter();
            terms.filter(move |term| (term.order - one).abs() > 0.0)
        };
        let low = others(last.order)
            .map(|term| (ln(last) - ln(term) - room) / (term.order - last.order))
            .fold(f64::INFINITY, f64::min);
        let high = others(first.order)
            .map(|term| (ln(term) - ln(first) + room) / (first.order - term.order))
            .fold(f64::NEG_INFINITY, f64::max);
        if low < high { (low, high) } else { (0.0, 0.0) }
    }

    /// The angle by which A turns for ω from 0 to ∞, or `None` if A is 0 on the way.
    fn turn(&self) -> Option<f64> {
        let (low, high) = self.ends();
        let lowest = self.0.terms().last()?;
        let (sin, cos) = libm::sincos(0.5 * PI * lowest.order);
        let begin = Complex::new(cos, sin) * lowest.coefficient.signum();
        let first = self.at(low, self.scale(low));
        Some((first / begin).arg() + self.turned(low, high)? + self.left(high))
    }

    /// The angle by which A turns for ω from this one to ∞; 0 where A is 0 on the way.
    pub(crate) fn turn_from(&self, omega: f64) -> f64 {
        let (from, high) = (libm::log(omega), self.ends().1);
        if from >= high {
            return self.left(from);
        }
        self.turned(from, high)
            .map_or(0.0, |turn| turn + self.left(high))
    }

    /// The angle that is left from where the highest term is the largest by far.
    fn left(&self, x: f64) -> f64 {
        let highest = self.0.terms().first();
        highest.map_or(0.0, |highest| {
            let (sin, cos) = libm::sincos(0.5 * PI * highest.order);
            let end = Complex::new(cos, sin) * highest.coefficient.signum();
            (end / self.at(x, self.scale(x))).arg()
        })
    }

    /// The angle between two places, in steps that are short enough for each to be below π.
    /// ```text
    /// |dA/d ln ω| ≤ Σ α_i|a_i|ω^(α_i), which grows with ω: over a step in ln ω it is below its value at the end
    /// ```
    fn turned(&self, low: f64, high: f64) -> Option<f64> {
        let (mut turn, mut x) = (0.0, low);
        let mut step = 0.1;
        for _ in 0..STEPS_MAX {
            if x >= high {
                return Some(turn);
            }
            let next = (x + step).min(high);
            let scale = self.scale(next);
            let middle = self.at(0.5 * (x + next), scale);
            if middle.norm() <= 0.51 * (next - x) * self.rate(next, scale) {
                step *= 0.5;
                if step < STEP_MIN {
                    return None;
                }
                continue;
            }
            turn += (self.at(next, scale) / self.at(x, scale)).arg();
            x = next;
            step *= 2.0;
        }
        None
    }
}

impl Commensurate {
    /// q, the largest order up to 1 of which all orders are multiples.
    #[must_use]
    pub fn order(&self) -> f64 {
        self.order
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
}
