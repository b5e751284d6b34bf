//! How far the rule of a plant's samples is from the plant behind its hold.

use crate::SampledLoop;
use crate::enclosure::{Arc, count};
use core::f64::consts::PI;
use num_complex::Complex;
use std::vec::Vec;

/// Share of |1 + L| by which the rule may be off for the loop to turn as its plant does. Below 1 it does (E. Rouché); the rest is for what lies
/// between the angles that are looked at.
const HOLDS: f64 = 0.7;
/// Angles looked at, from the first on to π: below it a rule is right as long as its memory lasts.
const ANGLES: usize = 800;
const FIRST: f64 = 1e-4;

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
        let growing = held.growing_poles();
        // With one at rest neither can be counted on the circle.
        poles.zip(growing).is_none_or(|(rule, own)| rule == own)
    }
}
