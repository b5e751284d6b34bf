//! What the tests share: short words for plants, controllers and loops, numbers that are drawn, golden values.

use fracdiff::Seconds;
use fractional_control::num_complex::Complex;
use fractional_control::{
    FractionalTransferFunction, HeldPlant, PidParameters, Plant, PowerMemory, Rule,
    SampledControlLoop, StateSpace,
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

/// |have − want| < most.
pub(crate) fn near(have: f64, want: f64, most: f64) -> bool {
    (have - want).abs() < most
}

/// Numbers from 0 to 1, the same in every run: a linear congruence (D. E. Knuth, MMIX).
pub(crate) struct Draw(pub(crate) u64);

impl Draw {
    pub(crate) fn from(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * ((self.0 >> 11) as f64 / (1u64 << 53) as f64)
    }

    /// Normal, by the sum of twelve.
    pub(crate) fn normal(&mut self, deviation: f64) -> f64 {
        deviation * (0..12).map(|_| self.from(-0.5, 0.5)).sum::<f64>()
    }

    /// Even in the logarithm.
    pub(crate) fn scale(&mut self, low: f64, high: f64) -> f64 {
        self.from(low.ln(), high.ln()).exp()
    }
}

/// `Σ h[j]·e^(−iθj)` of an impulse response.
pub(crate) fn of_impulse_response(weights: &[f64], theta: f64) -> Complex<f64> {
    let terms = weights.iter().enumerate();
    terms
        .map(|(j, h)| Complex::from_polar(*h, -theta * j as f64))
        .sum()
}

/// A function and its step response at some times.
#[derive(Debug)]
pub(crate) struct Golden {
    pub(crate) function: FractionalTransferFunction,
    pub(crate) points: Vec<(f64, f64)>,
}

pub(crate) fn read(text: &str) -> Vec<Golden> {
    let mut all: Vec<(String, Golden)> = Vec::new();
    for line in text.lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let [name, t, y] = fields[..] else {
            panic!("three fields: {line}");
        };
        let point = (t.parse().expect("a time"), y.parse().expect("a value"));
        match all.last_mut() {
            Some((last, golden)) if last == name => golden.points.push(point),
            _ => {
                let function = name.parse().expect("a transfer function");
                let points = vec![point];
                all.push((name.to_owned(), Golden { function, points }));
            }
        }
    }
    all.into_iter().map(|(_, golden)| golden).collect()
}

pub(crate) fn podlubny() -> [Golden; 2] {
    read(include_str!("../golden/podlubny.csv"))
        .try_into()
        .expect("two functions")
}

pub(crate) fn randoms() -> Vec<Golden> {
    read(include_str!("../golden/random.csv"))
}
