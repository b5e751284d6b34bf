//! Slow and certain: the definitions themselves, in `f64`.
use fracdiff::full_memory::{Design, Kernel};
use fracdiff::{
    Differintegrator, FullMemory, Operator, Order, Real, Scheme, Seconds, grunwald_weights,
};

/// T of most tests: 1 kHz.
pub(crate) const SAMPLE_TIME: Seconds = Seconds(1e-3);

pub(crate) fn order(mu: f64) -> Order {
    Order::new(mu).expect("tests use valid orders")
}

/// `Σ_{j=0}^{n} w_j·x[n−j]`, oldest term first, for every n.
pub(crate) fn convolve(weights: &[f64], x: &[f64]) -> Vec<f64> {
    (0..x.len())
        .map(|n| {
            let most = n.min(weights.len() - 1);
            (0..=most).rev().map(|j| weights[j] * x[n - j]).sum()
        })
        .collect()
}

/// `T^(−μ)·Σ c_j x[n−j]` with the first `length` Grünwald weights.
pub(crate) fn grunwald_sum(mu: f64, sample_time: Seconds, length: usize, x: &[f64]) -> Vec<f64> {
    let rate = sample_time.0.powf(-mu);
    let weights: Vec<f64> = grunwald_weights(order(mu)).take(length).collect();
    convolve(&weights, x).iter().map(|y| rate * y).collect()
}

/// Runs an operator from rest.
pub(crate) fn run<F: Real>(operator: &impl Differintegrator<F>, x: &[f64]) -> Vec<f64> {
    let mut history = operator.at_rest();
    x.iter()
        .map(|&x| operator.step(&mut history, F::from_f64(x)).to_f64())
        .collect()
}

/// A full memory with room to spare.
pub(crate) fn full<F: Real>(kernel: Kernel, mu: f64, tolerance: f64) -> FullMemory<F, 16, 64> {
    let design = Design::pruned(kernel, order(mu), tolerance, 1e6).expect("reachable");
    FullMemory::new(&design, SAMPLE_TIME).expect("valid sample time")
}

/// One of each kind of operator, as users name them.
pub(crate) const SCHEMES: [&str; 8] = [
    "grunwald:100",
    "grunwald:3000",
    "muir:3",
    "tustin-muir:9",
    "oustaloup:9:0.01:100",
    "full:1e-6",
    "piecewise-linear:1e-6",
    "full-bdf2:1e-6",
];

/// An operator by name, designed for 100 s.
pub(crate) fn build<F: Real>(scheme: &str, mu: f64) -> Operator<F> {
    let scheme: Scheme = scheme.parse().expect("valid scheme");
    scheme
        .build(order(mu), SAMPLE_TIME, 1e5)
        .expect("valid operator")
}

/// A lively signal that does not start at zero, of magnitude about 1.
pub(crate) fn lively(length: usize) -> Vec<f64> {
    (0..length)
        .map(|n| {
            let t = n as f64;
            (0.37 * t).sin() + 0.4 * (0.011 * t + 1.0).cos() + if n % 97 < 5 { 0.5 } else { 0.0 }
        })
        .collect()
}

/// Fails with index, have and want unless |have − want| ≤ tolerance everywhere.
#[track_caller]
pub(crate) fn assert_close(have: &[f64], want: &[f64], tolerance: f64) {
    assert_eq!(have.len(), want.len());
    for (n, (have, want)) in have.iter().zip(want).enumerate() {
        // Negated, so that a NaN fails.
        assert!(
            (have - want).abs() <= tolerance,
            "sample {n}: have {have:e}, want {want:e}, tolerance {tolerance:e}"
        );
    }
}

/// Largest magnitude.
pub(crate) fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |most, x| x.abs().max(most))
}
