//! Short words for plants, controllers and loops, and numbers that are drawn.

use fracdiff::Seconds;
use fractional_control::{
    HeldPlant, PidParameters, Plant, PowerMemory, Rule, SampledControlLoop, StateSpace,
};
use nalgebra::{DMatrix, DVector, RowDVector};

/// The plant of a formula.
///
/// # Panics
/// A text that is no formula.
pub fn plant(text: &str) -> Plant {
    text.parse().expect("a plant")
}

/// A, b and c.
///
/// # Panics
/// If they do not fit.
pub fn states<const N: usize>(a: [[f64; N]; N], b: [f64; N], c: [f64; N]) -> StateSpace {
    let states = StateSpace::new(
        DMatrix::from_row_slice(N, N, a.as_flattened()),
        DVector::from_column_slice(&b),
        RowDVector::from_row_slice(&c),
    );
    states.expect("matrices that fit")
}

/// A gain alone.
#[must_use]
pub fn p(proportional: f64) -> PidParameters {
    pi(proportional, 0.0, 1.0)
}

/// Gain, integral and the order of the integral.
#[must_use]
pub fn pi(proportional: f64, integral: f64, integral_order: f64) -> PidParameters {
    PidParameters {
        proportional,
        integral,
        integral_order,
        ..PidParameters::NONE
    }
}

/// The loop of these gains around a plant behind its hold.
///
/// # Panics
/// If it cannot be closed.
pub fn closed(
    gains: PidParameters,
    plant: &Plant,
    memory: PowerMemory,
    t: f64,
) -> SampledControlLoop {
    SampledControlLoop::new(gains.into(), memory, &held(plant, memory, t)).expect("a loop")
}

/// A plant behind its hold.
///
/// # Panics
/// If it cannot run with this memory.
pub fn held(plant: &Plant, memory: PowerMemory, t: f64) -> HeldPlant {
    HeldPlant::new(plant, memory, Seconds(t)).expect("runs")
}

/// A memory for so many seconds.
///
/// # Panics
/// If its tolerance or length is out of range.
pub fn bdf2(tolerance: f64, duration_s: f64) -> PowerMemory {
    PowerMemory::new(Rule::Bdf2, tolerance, duration_s).expect("valid")
}

/// |have − want| < most.
#[must_use]
pub fn near(have: f64, want: f64, most: f64) -> bool {
    (have - want).abs() < most
}

/// Numbers from 0 to 1, the same in every run: a linear congruence (D. E. Knuth, MMIX).
#[derive(Debug)]
pub struct Draw(pub u64);

impl Draw {
    /// Even from `low` to `high`.
    pub fn from(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * ((self.0 >> 11) as f64 / (1u64 << 53) as f64)
    }

    /// Normal, by the sum of twelve.
    pub fn normal(&mut self, deviation: f64) -> f64 {
        deviation * (0..12).map(|_| self.from(-0.5, 0.5)).sum::<f64>()
    }

    /// Even in the logarithm.
    pub fn scale(&mut self, low: f64, high: f64) -> f64 {
        libm::exp(self.from(libm::log(low), libm::log(high)))
    }
}
