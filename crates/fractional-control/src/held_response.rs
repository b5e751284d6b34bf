//! The response of a plant behind a hold at the samples, without a rule: how far a rule is from it.

use crate::enclosure::{Arc, count};
use crate::plant::Model;
use crate::{Plant, SampledLoop};
use core::f64::consts::PI;
use num_complex::Complex;
use std::vec::Vec;

/// Terms on either side before the rest is a power law.
const TERMS: usize = 64;
/// Orders of the rest from which its sum is known.
const ORDER_LEAST: f64 = 1.02;
/// A dead time this near to whole samples has the rest of one of whole samples.
const WHOLE: f64 = 0.02;
/// Share of |1 + L| by which the rule may be off for the loop to turn as its plant does. Below 1 it does (E. Rouché); the rest is for what lies
/// between the angles that are looked at.
const HOLDS: f64 = 0.7;
/// Angles looked at, from the first on to π: below it a rule is right as long as its memory lasts.
const ANGLES: usize = 800;
const FIRST: f64 = 1e-4;

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

/// What the loop of a plant that follows a rule is, and what it would be without: both open loops at many angles.
#[derive(Clone, Debug)]
pub struct RuleError {
    pairs: Vec<[Complex<f64>; 2]>,
    same_poles: bool,
}

impl RuleError {
    /// True if with this times the gain the loop of the rule turns about −1 as often as that of the plant: its verdict is that of the plant.
    #[must_use]
    pub fn holds(&self, gain: f64) -> bool {
        let near = |[rule, truth]: &[Complex<f64>; 2]| {
            (truth - rule).norm() * gain < HOLDS * (rule * gain + 1.0).norm()
        };
        self.same_poles && self.pairs.iter().all(near)
    }

    /// The gains from 1 down and up to these at which it [`holds`](Self::holds); 1 alone where it does not there.
    #[must_use]
    pub fn within(&self, [low, high]: [f64; 2]) -> [f64; 2] {
        let step = 1.02;
        let reached = |end: f64| {
            let count = libm::ceil(libm::log(end).abs() / libm::log(step)) as i32;
            let gain = |k: i32| libm::pow(end, f64::from(k) / f64::from(count.max(1)));
            let last = (0..=count).take_while(|k| self.holds(gain(*k))).last();
            last.map_or(1.0, gain)
        };
        [reached(low), reached(high)]
    }
}

impl SampledLoop {
    /// How far the rule of its plant is from the plant behind its hold; `None` of a plant that is sampled exactly.
    #[must_use]
    pub fn rule_error(&self) -> Option<RuleError> {
        let plant = self.of_plant()?;
        let angle = |k: usize| {
            let share = k as f64 / ANGLES as f64;
            // As many on a logarithmic scale as on an even one.
            match k % 2 {
                0 => FIRST * libm::pow(PI / FIRST, share),
                _ => PI * share,
            }
        };
        let angles = (0..=ANGLES).map(angle);
        let pairs = angles.map(|theta| [self.open(theta), plant.open(theta)]);
        Some(RuleError {
            pairs: pairs.collect(),
            same_poles: self.plant_grows_alike(),
        })
    }

    /// False if the rule has another number of growing poles than its plant.
    fn plant_grows_alike(&self) -> bool {
        let Some(held) = self.held() else {
            return true;
        };
        let poles = count(|arc: &Arc| self.plant_below(arc)).zeros;
        let growing = (held.plant.function()).and_then(|function| function.growing_poles());
        // With one at rest neither can be counted on the circle.
        poles.zip(growing).is_none_or(|(rule, own)| rule == own)
    }
}
