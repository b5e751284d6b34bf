//! The response of a plant behind a hold at the samples, without a rule.

use crate::Plant;
use crate::plant::Model;
use core::f64::consts::PI;
use num_complex::Complex;

/// Terms on either side before the rest is a power law.
const TERMS: usize = 64;
/// Orders of the rest from which its sum is known.
const ORDER_LEAST: f64 = 1.02;
/// A dead time this near to whole samples has the rest of one of whole samples.
const WHOLE: f64 = 0.02;
/// ```text
/// G_d(θ) = Σ_k G(jω_k)·e^(−jω_k τ)·(1 − e^(−jθ))/(jω_k T),   ω_k = (θ + 2πk)/T     (S. D. Poisson)
/// ```
/// What G passes on at once, D, is seen by the next measurement: G − D in the sum, and D·w^⌈τ/T⌉, at least D·w.
#[derive(Clone, Debug)]
pub(crate) struct HeldResponse {
    plant: Plant,
    direct: f64,
    /// τ/T.
    delay: f64,
    sample_time_s: f64,
}

impl HeldResponse {
    /// Of a transfer function; `None` of any other.
    pub(crate) fn new(plant: &Plant, sample_time_s: f64) -> Option<Self> {
        let Model::Transfer(function) = &plant.model else {
            return None;
        };
        let above = function.numerator().terms().first()?;
        let below = function.denominator().terms().first()?;
        let direct = if above.order < below.order {
            0.0
        } else {
            above.coefficient / below.coefficient
        };
        Some(Self {
            direct,
            delay: plant.delay_s() / sample_time_s,
            plant: plant.without_dead_time()?,
            sample_time_s,
        })
    }

    /// `G_d` at the angle θ, 0 < θ ≤ π; not finite where the sum does not end.
    pub(crate) fn at(&self, theta: f64) -> Complex<f64> {
        let sum = self.sum(theta) + self.sum(2.0 * PI - theta).conj();
        let one_less_w = Complex::new(1.0 - libm::cos(theta), libm::sin(theta));
        let later = libm::ceil(self.delay - 1e-9).max(1.0);
        let passed = Complex::from_polar(self.direct, -later * theta);
        sum * one_less_w / self.sample_time_s + passed
    }

    /// The number of poles of the plant that grow, where it is known.
    pub(crate) fn growing_poles(&self) -> Option<usize> {
        self.plant.function()?.growing_poles()
    }

    /// (G − D)/(jω) at the angle x = ωT.
    fn term(&self, x: f64) -> Complex<f64> {
        let omega = x / self.sample_time_s;
        let response = self.plant.response(omega).unwrap_or_default();
        (response - self.direct) / Complex::new(0.0, omega)
    }

    /// Σ over x = from + 2πk, k from 0 on.
    fn sum(&self, from: f64) -> Complex<f64> {
        let at = |k: f64| from + 2.0 * PI * k;
        let late = |x: f64| Complex::from_polar(1.0, -x * self.delay);
        let first = (0..TERMS)
            .map(|k| at(k as f64))
            .map(|x| self.term(x) * late(x));
        let sum: Complex<f64> = first.sum();
        let x = at(TERMS as f64);
        let begin = self.term(x);
        if begin.norm() == 0.0 {
            return sum;
        }
        // c·x^(−β) from here on.
        let place = x / (2.0 * PI);
        let order = -libm::log((self.term(1.1 * x) / begin).norm()) / libm::log(1.1);
        if order.is_nan() || order < ORDER_LEAST {
            return Complex::new(f64::NAN, f64::NAN);
        }
        let part = self.delay - libm::round(self.delay);
        let rest = if part.abs() < WHOLE {
            // L. Euler and C. Maclaurin.
            Complex::new(place / (order - 1.0) + 0.5 + order / (12.0 * place), 0.0)
        } else {
            // By parts: z turns, the size hardly changes.
            let size = |k: f64| libm::pow((place + k) / place, -order);
            let z = Complex::from_polar(1.0, -2.0 * PI * part);
            let (once, by) = (size(1.0) - 1.0, (-z + 1.0).inv());
            let twice = size(2.0) - 2.0 * size(1.0) + 1.0;
            by * (z * by * (z * by * twice + once) + 1.0)
        };
        sum + begin * late(x) * rest
    }
}
