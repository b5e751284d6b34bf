//! Short words for plants, controllers, loops and wishes, which the tests share.

use control_tuning::{Sampling, Specification};
use fracdiff::Seconds;
use fractional_control::{
    HeldPlant, PidParameters, Plant, PowerMemory, Rule, SampledControlLoop, StateSpace,
};
use nalgebra::{DMatrix, DVector, RowDVector};

pub(crate) fn plant(text: &str) -> Plant {
    text.parse().expect("a plant")
}

/// A, b and c.
pub(crate) fn states<const N: usize>(a: [[f64; N]; N], b: [f64; N], c: [f64; N]) -> StateSpace {
    let states = StateSpace::new(
        DMatrix::from_row_slice(N, N, a.as_flattened()),
        DVector::from_column_slice(&b),
        RowDVector::from_row_slice(&c),
    );
    states.expect("matrices that fit")
}

pub(crate) fn p(proportional: f64) -> PidParameters {
    pi(proportional, 0.0, 1.0)
}

pub(crate) fn pi(proportional: f64, integral: f64, integral_order: f64) -> PidParameters {
    PidParameters {
        proportional,
        integral,
        integral_order,
        ..PidParameters::NONE
    }
}

pub(crate) fn closed(
    gains: PidParameters,
    plant: &Plant,
    memory: PowerMemory,
    t: f64,
) -> SampledControlLoop {
    SampledControlLoop::new(gains.into(), memory, &held(plant, memory, t)).expect("a loop")
}

pub(crate) fn held(plant: &Plant, memory: PowerMemory, t: f64) -> HeldPlant {
    HeldPlant::new(plant, memory, Seconds(t)).expect("runs")
}

/// A memory for so many seconds.
pub(crate) fn bdf2(tolerance: f64, duration_s: f64) -> PowerMemory {
    PowerMemory::new(Rule::Bdf2, tolerance, duration_s).expect("valid")
}

pub(crate) fn every(seconds: f64) -> Sampling {
    Sampling {
        sample_time: Seconds(seconds),
        rule: Rule::Bdf2,
    }
}

/// Wishes without that for a flat phase.
pub(crate) fn not_flat(crossover_rad_s: f64, margin_rad: f64) -> Specification {
    Specification {
        iso_damping: false,
        ..Specification::new(crossover_rad_s, margin_rad)
    }
}
