//! Powers and polynomials on the unit circle with their derivatives, and bounds of both over an interval.

use certified_count::{Bounds, Jet, Place};
use core::f64::consts::PI;
use num_complex::Complex;

/// The least angle that proofs look at, rad/sample: nearer to rest nothing changes but sizes.
pub(crate) const NEAR_REST: f64 = 1e-9;

/// Angles from there to π between which a proof begins: each twice the one before, then even ones.
pub(crate) fn angles_to_pi() -> impl Iterator<Item = f64> {
    let growing = core::iter::successors(Some(NEAR_REST), |theta| Some(2.0 * theta));
    let slow = growing.take_while(|theta| *theta < PI / 64.0);
    slow.chain((1..=64).map(|k| PI * f64::from(k) / 64.0))
}

/// w^k: by squaring while that is exact to a few rounding errors, by the angle beyond.
pub(crate) fn w_to(place: &Place, k: usize) -> Complex<f64> {
    if k <= 16 {
        return (0..k).fold(Complex::new(1.0, 0.0), |power, _| power * place.w);
    }
    let (sin, cos) = libm::sincos(k as f64 * place.theta);
    Complex::new(cos, -sin)
}

/// A polynomial and its derivative at v, the coefficient of v⁰ first.
pub(crate) fn powers_in_v(coefficients: &[f64], v: Complex<f64>) -> (Complex<f64>, Complex<f64>) {
    let horner = |factor: fn(usize) -> f64, skip: usize| {
        let terms = coefficients.iter().enumerate().skip(skip).rev();
        terms.fold(Complex::new(0.0, 0.0), |sum, (k, c)| {
            sum * v + factor(k) * c
        })
    };
    (horner(|_| 1.0, 0), horner(|k| k as f64, 1))
}

/// A polynomial in v as a function of θ: dv/dθ = jw.
pub(crate) fn jet_in_v(coefficients: &[f64], place: &Place) -> Jet {
    let (value, slope) = powers_in_v(coefficients, place.v);
    Jet::new(value, slope * (place.w * Complex::new(0.0, 1.0)))
}

/// `Σ|c_k||v|^k`.
pub(crate) fn size_in_v(coefficients: &[f64], size_v: f64) -> f64 {
    coefficients.iter().enumerate().fold(0.0, |sum, (k, c)| {
        sum + (0..k).fold(c.abs(), |term, _| term * size_v)
    })
}

/// Bounds of a polynomial in v between two places.
pub(crate) fn bounds_in_v(
    coefficients: &[f64],
    a: &Place,
    b: &Place,
    jet_a: &Jet,
    jet_b: &Jet,
) -> Bounds {
    // |A′| ≤ Σ k|a_k||v|^(k−1), |A″| ≤ that + Σ k(k − 1)|a_k||v|^(k−2), and |v| grows with θ.
    let (mut rate, mut curl) = (0.0, 0.0);
    for (k, c) in coefficients.iter().enumerate().skip(1) {
        let most = |power: usize| (0..power).fold(c.abs(), |term, _| term * b.size_v);
        rate += k as f64 * most(k - 1);
        if k > 1 {
            curl += (k * (k - 1)) as f64 * most(k - 2);
        }
    }
    Bounds::from_ends(jet_a, jet_b, b.theta - a.theta, rate, rate + curl)
}

/// A real function of θ with its derivative.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Real {
    pub(crate) value: f64,
    pub(crate) rate: f64,
}

impl Real {
    pub(crate) fn imaginary_of(jet: Jet) -> Self {
        let (value, rate) = (jet.value.im, jet.rate.im);
        Self { value, rate }
    }

    pub(crate) fn times(self, other: Self) -> Self {
        Self {
            value: self.value * other.value,
            rate: self.rate * other.value + self.value * other.rate,
        }
    }
}
