//! Designs of memories of one's own, from a density and exact modes.

use crate::oracle::{assert_close, largest, lively, order, run};
use fracdiff::full_memory::{Design, DesignError, FullMemory, Kernel, Memory, MemoryWeights, Mode};
use fracdiff::{ParameterError, Seconds, grunwald_weight};
use std::f64::consts::PI;

/// (1 − w)^(−ν) and exact modes, and something that is gone after a sample.
#[derive(Clone)]
struct Mixed {
    nu: f64,
    modes: Vec<Mode>,
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

    fn mode(&self, index: usize) -> Option<Mode> {
        self.modes.get(index).copied()
    }
}

fn mixed(nu: f64, modes: &[(f64, f64)], instant: f64) -> Mixed {
    let modes = modes.iter().map(|&(rate, weight)| Mode { rate, weight });
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
        let own = Design::<16, 64>::pruned(Kernel::Grunwald, order(1.0 - nu), 1e-6, 2e5);
        let own = own.expect("reachable").modes().len();
        let have = Design::<16, 64>::of_memory(order(1.0 - nu), &mixed(nu, &[], 0.0), 1e-6, 2e5);
        let have = have.expect("reachable").modes().len();
        assert!(have.abs_diff(own) <= 4, "ν {nu}: {have}, not {own}");
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
struct Odd<D: Fn(f64) -> f64>(f64, D, Option<Mode>);

impl<D: Fn(f64) -> f64> Memory for Odd<D> {
    fn first(&self) -> f64 {
        self.0
    }

    fn density(&self, rate: f64) -> f64 {
        (self.1)(rate)
    }

    fn mode(&self, index: usize) -> Option<Mode> {
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
        let mode = |rate, weight| Some(Mode { rate, weight });
        assert!(refused(&|| design(1.0, |s| s, mode(wrong, 1.0))).contains("mode of rate"));
        assert!(refused(&|| design(1.0, |s| s, mode(1.0, wrong))).contains("mode of rate"));
    }
    assert!(refused(&|| design(1.0, |s| -s, None)).contains("is negative or not finite"));
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
