//! Designs of memories of one's own: from a density and exact modes, and from modes alone.

use crate::oracle::{SAMPLE_TIME, assert_close, largest, lively, order, run};
use fracdiff::full_memory::{
    DecayingMode, Design, DesignError, FullMemory, Kernel, Memory, MemoryWeights,
};
use fracdiff::{Differintegrator, ParameterError, Seconds, grunwald_weight};
use std::f64::consts::PI;

/// (1 − w)^(−ν) and exact modes, and something that is gone after a sample.
#[derive(Clone)]
struct Mixed {
    nu: f64,
    modes: Vec<DecayingMode>,
    instant: f64,
}

impl Mixed {
    fn weight(&self, lag: u64) -> f64 {
        let law = if self.nu > 0.0 {
            grunwald_weight(order(-self.nu), lag)
        } else {
            0.0
        };
        let modes = self.modes.iter();
        let modes = modes.map(|mode| mode.weight * (-mode.rate * lag as f64).exp());
        law + modes.sum::<f64>() + if lag == 0 { self.instant } else { 0.0 }
    }
}

impl Memory for Mixed {
    fn first(&self) -> f64 {
        self.weight(0)
    }

    fn density(&self, rate: f64) -> f64 {
        rate * (PI * self.nu).sin() * rate.exp_m1().powf(-self.nu) / PI
    }

    fn mode(&self, index: usize) -> Option<DecayingMode> {
        self.modes.get(index).copied()
    }
}

fn mixed(nu: f64, modes: &[(f64, f64)], instant: f64) -> Mixed {
    let modes = modes
        .iter()
        .map(|&(rate, weight)| DecayingMode { rate, weight });
    Mixed {
        nu,
        modes: modes.collect(),
        instant,
    }
}

fn examples() -> [Mixed; 5] {
    [
        mixed(0.7, &[], 0.0),
        mixed(0.3, &[(1e-3, 2.0)], 0.0),
        mixed(0.9, &[(0.4, 3.0), (1e-4, 1e-2)], 5.0),
        // Modes alone, and next to nothing at all.
        mixed(0.0, &[(30.0, 1.0), (0.1, 1.0), (2e-6, 0.5)], 0.0),
        mixed(0.0, &[], 1.0),
    ]
}

#[test]
fn weights_are_those_of_the_parts() {
    for memory in examples() {
        let weights = MemoryWeights::new(&memory, 1e6).expect("smooth");
        for lag in [0, 1, 2, 5, 15, 16, 100, 3000, 100_000, 1_000_000] {
            let (have, want) = (weights.weight(lag), memory.weight(lag));
            assert!(
                (have - want).abs() <= 2e-12 * want,
                "ν {} lag {lag}: {have:e} {want:e}",
                memory.nu
            );
        }
    }
}

#[test]
fn a_design_keeps_every_weight_within_its_bound() {
    for memory in examples() {
        for (tolerance, horizon) in [(1e-3, 1e3), (1e-6, 1e7), (1e-9, 1e5)] {
            let design = Design::<16, 112>::of_memory(order(0.5), &memory, tolerance, horizon)
                .expect("reachable");
            assert!(design.error_bound() <= tolerance);
            assert!(design.modes().iter().all(|mode| mode.weight > 0.0));
            assert!(design.modes().is_sorted_by(|a, b| a.rate >= b.rate));
            let lags = (0..200).map(|k| (1.08_f64.powi(k) as u64).min(horizon as u64));
            for lag in lags {
                let (have, want) = (design.core_weight(lag), memory.weight(lag));
                assert!(
                    (have - want).abs() <= 1.01 * tolerance * want + 2e-12 * want,
                    "ν {} at {tolerance:e}, lag {lag}: {have:e} {want:e}",
                    memory.nu
                );
            }
        }
    }
}

#[test]
fn a_named_kernel_takes_as_many_modes_as_its_own_design() {
    for nu in [0.1, 0.5, 0.7753] {
        let modes = Design::<16, 64>::pruned(Kernel::Grunwald, order(1.0 - nu), 1e-6, 2e5);
        let modes = modes.expect("reachable").modes().len();
        let have = Design::<16, 64>::of_memory(order(1.0 - nu), &mixed(nu, &[], 0.0), 1e-6, 2e5);
        let have = have.expect("reachable").modes().len();
        assert!(have.abs_diff(modes) <= 4, "ν {nu}: {have}, not {modes}");
    }
}

#[test]
fn the_operator_is_its_defining_sum() {
    let x = lively(3000);
    let increments: Vec<f64> = (0..x.len())
        .map(|n| x[n] - if n > 0 { x[n - 1] } else { 0.0 })
        .collect();
    for memory in examples() {
        let weights: Vec<f64> = (0..3000).map(|lag| memory.weight(lag)).collect();
        let design = Design::<16, 48>::of_memory(order(1.0), &memory, 1e-6, 1e4).expect("modes");
        let operator = FullMemory::<f64, 16, 48>::new(&design, Seconds(1.0)).expect("valid");
        let want = crate::oracle::convolve(&weights, &increments);
        assert_close(&run(&operator, &x), &want, 3e-6 * largest(&want));
    }
}

/// Anything.
struct Odd<D: Fn(f64) -> f64>(f64, D, Option<DecayingMode>);

impl<D: Fn(f64) -> f64> Memory for Odd<D> {
    fn first(&self) -> f64 {
        self.0
    }

    fn density(&self, rate: f64) -> f64 {
        (self.1)(rate)
    }

    fn mode(&self, index: usize) -> Option<DecayingMode> {
        self.2.filter(|_| index == 0)
    }
}

#[test]
fn what_is_no_memory_that_fades_is_refused() {
    let refused = |memory: &dyn Fn() -> Result<Design<16, 48>, DesignError>| match memory() {
        Err(DesignError::Parameter(error)) => error.to_string(),
        other => panic!("{other:?}"),
    };
    let design = |first, density: fn(f64) -> f64, mode| {
        Design::<16, 48>::of_memory(order(0.5), &Odd(first, density, mode), 1e-6, 1e4)
    };
    for wrong in [f64::NAN, -1.0, f64::INFINITY] {
        assert!(refused(&|| design(wrong, |s| s, None)).contains("weight"));
        let mode = |rate, weight| Some(DecayingMode { rate, weight });
        assert!(refused(&|| design(1.0, |s| s, mode(wrong, 1.0))).contains("mode of rate"));
        assert!(refused(&|| design(1.0, |s| s, mode(1.0, wrong))).contains("mode of rate"));
    }
    assert!(refused(&|| design(1.0, |s| -s, None)).contains("is not finite and at least 0"));
    assert!(refused(&|| design(1.0, |_| f64::NAN, None)).contains("density NaN"));
    // No finite mass at the slow end; rough everywhere.
    for density in [(|_| 1.0) as fn(f64) -> f64, |s| s * (1e9 * s).sin().abs()] {
        assert!(matches!(
            design(1.0, density, None),
            Err(DesignError::Unreachable { .. })
        ));
    }
    // A step is none the worse: ∫ e^(−js) ds from 0.01 to 0.03.
    let weights = MemoryWeights::new(
        &Odd(
            1.0,
            |s| if (0.01..0.03).contains(&s) { s } else { 0.0 },
            None,
        ),
        1e4,
    );
    let have = weights.expect("halved as often as it must be").weight(50);
    let want = ((-0.5_f64).exp() - (-1.5_f64).exp()) / 50.0;
    assert!((have / want - 1.0).abs() < 1e-11, "{have:e} {want:e}");
    let smooth = mixed(0.5, &[], 0.0);
    for (tolerance, horizon) in [(1e-12, 1e4), (0.5, 1e4), (1e-6, 10.0), (1e-6, f64::NAN)] {
        let have = Design::<16, 48>::of_memory(order(0.5), &smooth, tolerance, horizon);
        assert!(matches!(
            have,
            Err(DesignError::Parameter(
                ParameterError::Tolerance(_) | ParameterError::Horizon(_)
            ))
        ));
    }
    let room = Design::<16, 8>::of_memory(order(0.5), &smooth, 1e-6, 1e7);
    assert!(matches!(
        room,
        Err(DesignError::TooManyModes { room: 8, .. })
    ));
}

/// λ, the tempering a sample.
const LAMBDA: f64 = 2e-3;

/// (1 − w)^n·(1 − e^(−λ)·w)^(−ν), n = ⌈μ⌉, ν = n − μ.
fn tempered(mu: f64) -> Design<16, 48> {
    let plain = Design::<16, 48>::closed_form(Kernel::Grunwald, order(mu), 1e-7, 1e5);
    let faster = plain.expect("fits").modes().to_vec().into_iter();
    let faster = faster.map(|mode| DecayingMode {
        rate: mode.rate + LAMBDA,
        ..mode
    });
    let rest = order(mu - mu.ceil());
    let weight = |j: u64| grunwald_weight(rest, j) * (-LAMBDA * j as f64).exp();
    Design::from_modes(order(mu), weight, &faster.collect::<Vec<_>>(), 1e5).expect("fits")
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
    let modes = [DecayingMode {
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
    let make = |modes: &[DecayingMode], first: f64, horizon: f64| {
        let weight = |j: u64| if j == 0 { first } else { 0.1 };
        Design::<4, 8>::from_modes(order(0.5), weight, modes, horizon)
    };
    let mode = |rate, weight| DecayingMode { rate, weight };
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
