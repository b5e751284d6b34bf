//! Designs from modes of one's own: a tempered memory.

use crate::oracle::{SAMPLE_TIME, assert_close, largest, lively, order, run};
use fracdiff::full_memory::{Design, DesignError, FullMemory, Kernel, Mode};
use fracdiff::{Differintegrator, ParameterError, grunwald_weight};

/// λ, the tempering a sample.
const LAMBDA: f64 = 2e-3;

/// (1 − w)^n·(1 − e^(−λ)·w)^(−ν), n = ⌈μ⌉, ν = n − μ.
fn tempered(mu: f64) -> Design<16, 48> {
    let plain = Design::<16, 48>::closed_form(Kernel::Grunwald, order(mu), 1e-7, 1e5);
    let faster = plain.expect("fits").modes().to_vec().into_iter();
    let faster = faster.map(|mode| Mode {
        rate: mode.rate + LAMBDA,
        ..mode
    });
    let rest = order(mu - mu.ceil());
    let weight = |j: u64| grunwald_weight(rest, j) * (-LAMBDA * j as f64).exp();
    Design::from_modes(order(mu), weight, &faster.collect::<Vec<_>>(), 1e5).expect("fits")
}

#[test]
fn a_tempered_integral_of_a_decay_is_its_closed_form() {
    // Σ_j c_j e^(−λj)·e^(−λ(n−j)) = e^(−λn)·Σ_{j≤n} c_j, and partial sums of weights are weights of one order less.
    for nu in [0.2, 0.5, 0.8] {
        let design = tempered(-nu);
        assert!(design.error_bound() <= 1.1e-7, "{:e}", design.error_bound());
        let operator = FullMemory::<f64, 16, 48>::new(&design, SAMPLE_TIME).expect("valid");
        let decay = |n: usize| (-LAMBDA * n as f64).exp();
        let x: Vec<f64> = (0..5000).map(decay).collect();
        let scale = SAMPLE_TIME.0.powf(nu);
        let want: Vec<f64> = (0..5000)
            .map(|n| scale * decay(n) * grunwald_weight(order(-1.0 - nu), n as u64))
            .collect();
        assert_close(&run(&operator, &x), &want, 2e-7 * largest(&want));
    }
}

#[test]
fn a_tempered_memory_is_its_defining_sum_and_forgets_sooner() {
    let x = lively(3000);
    for mu in [-0.6, 0.2247, 0.9, 1.5] {
        let design = tempered(mu);
        let operator = FullMemory::<f64, 16, 48>::new(&design, SAMPLE_TIME).expect("valid");
        let rest = order(mu - mu.ceil());
        let weights =
            (0..3000_u32).map(|j| grunwald_weight(rest, j.into()) * (-LAMBDA * f64::from(j)).exp());
        let whole = crate::oracle::grunwald_sum(mu.ceil(), fracdiff::Seconds(1.0), 3000, &x);
        let sum = crate::oracle::convolve(&weights.collect::<Vec<_>>(), &whole);
        let want: Vec<f64> = sum.iter().map(|y| SAMPLE_TIME.0.powf(-mu) * y).collect();
        assert_close(&run(&operator, &x), &want, 1e-6 * largest(&want));
    }
    // A step held: plain memory still gives a tenth of what it gave after 100 samples, the tempered one next to nothing.
    let held = vec![1.0; 10_000];
    let have = run(
        &FullMemory::<f64, 16, 48>::new(&tempered(0.5), SAMPLE_TIME).expect("valid"),
        &held,
    );
    assert!(
        have[9999] < 1e-8 * have[100],
        "{} {}",
        have[9999],
        have[100]
    );
}

#[test]
fn modes_given_in_any_order_are_run_fastest_first() {
    let mut modes = tempered(0.5).modes().to_vec();
    modes.reverse();
    let weight = |j: u64| grunwald_weight(order(-0.5), j) * (-LAMBDA * j as f64).exp();
    let design = Design::<16, 48>::from_modes(order(0.5), weight, &modes, 1e5).expect("fits");
    assert_eq!(design, tempered(0.5));
    assert_eq!(design.core_weight(3), weight(3));
}

#[test]
fn an_error_that_is_large_is_said() {
    let modes = [Mode {
        rate: 0.01,
        weight: 0.5,
    }];
    let weight = |j: u64| grunwald_weight(order(-0.5), j);
    let design = Design::<16, 8>::from_modes(order(0.5), weight, &modes, 1e4).expect("is one");
    assert!(design.error_bound() > 0.5, "{}", design.error_bound());
    let operator = FullMemory::<f32, 16, 8>::new(&design, SAMPLE_TIME).expect("valid");
    assert!(operator.output(&operator.at_rest(), 1.0) > 0.0);
}

#[test]
fn modes_and_weights_that_are_none_are_refused() {
    let make = |modes: &[Mode], first: f64, horizon: f64| {
        let weight = |j: u64| if j == 0 { first } else { 0.1 };
        Design::<4, 8>::from_modes(order(0.5), weight, modes, horizon)
    };
    let mode = |rate, weight| Mode { rate, weight };
    let good = [mode(0.1, 1.0)];
    for bad in [
        mode(0.0, 1.0),
        mode(-1.0, 1.0),
        mode(f64::NAN, 1.0),
        mode(1.0, f64::INFINITY),
    ] {
        let refused = make(&[good[0], bad], 1.0, 1e3).expect_err("no mode");
        let DesignError::Parameter(ParameterError::Mode { .. }) = refused else {
            panic!("{refused}");
        };
        assert!(refused.to_string().contains("mode of rate"), "{refused}");
    }
    let refused = make(&good, f64::NAN, 1e3).expect_err("no weight");
    assert_eq!(refused.to_string(), "weight NaN of lag 0 is not finite");
    let refused = make(&good, 1.0, 10.0).expect_err("too short");
    assert!(matches!(
        refused,
        DesignError::Parameter(ParameterError::Horizon(_))
    ));
    let refused = make(&[good[0]; 9], 1.0, 1e3).expect_err("no room");
    assert!(matches!(
        refused,
        DesignError::TooManyModes {
            needed: 9,
            room: 8,
            ..
        }
    ));
}
