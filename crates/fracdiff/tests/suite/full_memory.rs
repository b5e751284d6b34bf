//! Full memory: the weights it promises, and what it does with them.

use crate::oracle::{SAMPLE_TIME, assert_close, full, largest, lively, order, run};
use fracdiff::full_memory::{Design, DesignError, FullMemory, Kernel};
use fracdiff::{Differintegrator, ParameterError, Seconds, grunwald_weight};

/// 24 h at 1 kHz.
const DAY: f64 = 86_400_000.0;
/// 0.05, 0.10, …, 0.95.
fn orders() -> impl Iterator<Item = f64> {
    (1..=19).map(|i| f64::from(i) * 0.05)
}

type Day = Design<16, 32>;

#[test]
fn at_most_29_pruned_or_40_plain_modes_hold_a_day_within_1e_6() {
    for mu in orders() {
        let pruned = Day::pruned(Kernel::Grunwald, order(mu), 1e-6, DAY).expect("fits 32");
        assert!(
            pruned.modes().len() <= 29,
            "μ {mu}: {}",
            pruned.modes().len()
        );
        let plain =
            Design::<16, 40>::closed_form(Kernel::Grunwald, order(mu), 1e-6, DAY).expect("fits 40");
        for (modes, design_error) in [
            (pruned.modes(), pruned.error_bound()),
            (plain.modes(), plain.error_bound()),
        ] {
            assert!(design_error <= 1e-6, "μ {mu}: {design_error:e}");
            assert!(
                modes
                    .iter()
                    .all(|mode| mode.weight > 0.0 && mode.rate > 0.0)
            );
            assert!(modes.is_sorted_by(|a, b| a.rate >= b.rate));
        }
        // A grid of its own, 300 points a decade, not the one the design checked itself on.
        let mut lag = 16.0_f64;
        while lag <= DAY {
            let j = lag as u64;
            // The core is the integral of order 1 − μ, on increments.
            let want = grunwald_weight(order(mu - 1.0), j);
            for have in [pruned.core_weight(j), plain.core_weight(j)] {
                let error = (have / want - 1.0).abs();
                assert!(error <= 1e-6, "μ {mu} lag {j}: {error:e}");
            }
            lag *= 1.0077;
        }
    }
}

#[test]
fn the_bound_it_reports_is_the_error_it_has() {
    for (kernel, mu, tolerance) in [
        (Kernel::Grunwald, 0.3, 1e-3),
        (Kernel::Grunwald, 0.458, 1e-2),
        (Kernel::Grunwald, 0.9, 0.1),
        (Kernel::Grunwald, -0.7, 1e-4),
        (Kernel::PiecewiseLinear, 0.8, 1e-5),
        (Kernel::PiecewiseLinear, -1.4, 1e-6),
    ] {
        let design = Design::<16, 64>::pruned(kernel, order(mu), tolerance, 1e5).expect("fits");
        // TAPS larger than the lags under test: these weights are exact.
        let exact = Design::<2048, 64>::closed_form(kernel, order(mu), 1e-2, 1e5).expect("fits");
        let worst = (16..2048)
            .map(|j| (design.core_weight(j) / exact.core_weight(j) - 1.0).abs())
            .fold(0.0, f64::max);
        let bound = design.error_bound();
        assert!(bound <= tolerance && worst <= bound, "{worst:e} {bound:e}");
        assert!(worst >= 0.02 * bound, "{worst:e} {bound:e}");
    }
}

#[test]
fn it_runs_the_weights_of_its_design() {
    for mu in [-0.9, -0.5, -0.05, 0.05, 0.2247, 0.5, 0.95] {
        let design =
            Design::<16, 64>::pruned(Kernel::Grunwald, order(mu), 1e-6, 1e6).expect("reachable");
        let operator = FullMemory::<f64, 16, 64>::new(&design, Seconds(1.0)).expect("valid");
        let mut impulse = vec![0.0; 3000];
        impulse[0] = 1.0;
        let have = run(&operator, &impulse);
        // (1 − w)^n of the weights of the core.
        let core: Vec<f64> = (0..3000).map(|j| design.core_weight(j)).collect();
        let before = |j: usize| if j > 0 && mu > 0.0 { core[j - 1] } else { 0.0 };
        let want: Vec<f64> = (0..3000).map(|j| core[j] - before(j)).collect();
        assert_close(&have, &want, 1e-14);
    }
}

#[test]
fn it_agrees_with_the_defining_sum_for_all_orders_and_both_precisions() {
    let x = lively(4000);
    for mu in [
        -1.9, -1.5, -1.0, -0.5, -0.05, 0.0, 0.05, 0.2247, 0.9, 1.0, 1.3, 1.95, 2.0,
    ] {
        let want = crate::oracle::grunwald_sum(mu, SAMPLE_TIME, x.len(), &x);
        let scale = largest(&want);
        let double = run(&full::<f64>(Kernel::Grunwald, mu, 1e-9), &x);
        assert_close(&double, &want, 1e-8 * scale);
        let single = run(&full::<f32>(Kernel::Grunwald, mu, 1e-9), &x);
        // f32 holds x itself to 6e-8, and an integral sums 4000 such errors at worst.
        assert_close(&single, &want, 2e-6 * scale);
    }
}

#[test]
fn piecewise_linear_input_is_differentiated_exactly() {
    // Ramp of 1 s, hold, corners on samples: theory in closed form.
    let t = |n: usize| n as f64 * 1e-3;
    let x: Vec<f64> = (0..20_000).map(|n| t(n).min(1.0)).collect();
    let part = |t: f64, p: f64| if t > 0.0 { t.powf(p) } else { 0.0 };
    for mu in [-1.7, -1.0, -0.5, 0.2247, 0.9] {
        let want: Vec<f64> = (0..x.len())
            .map(|n| (part(t(n), 1.0 - mu) - part(t(n) - 1.0, 1.0 - mu)) / libm::tgamma(2.0 - mu))
            .collect();
        let have = run(&full::<f64>(Kernel::PiecewiseLinear, mu, 1e-9), &x);
        assert_close(&have, &want, 2e-9 * largest(&want));
    }
}

#[test]
fn double_integral_of_straight_lines_is_exact() {
    // ∬ t = t³/6 by the piecewise-linear kernel of order −2, which has no modes at all.
    let x: Vec<f64> = (0..500).map(|n| f64::from(n) * 1e-3).collect();
    let want: Vec<f64> = x.iter().map(|t| t.powi(3) / 6.0).collect();
    let have = run(&full::<f64>(Kernel::PiecewiseLinear, -2.0, 1e-6), &x);
    assert_close(&have, &want, 1e-14);
}

#[test]
fn it_refuses_what_it_cannot_reach() {
    let design = |tolerance, horizon| {
        Design::<16, 8>::closed_form(Kernel::Grunwald, order(0.5), tolerance, horizon)
    };
    let many = design(1e-6, DAY).expect_err("8 modes cannot");
    assert!(
        matches!(
            many,
            DesignError::TooManyModes {
                needed: 20..=80,
                room: 8,
                ..
            }
        ),
        "{many}"
    );
    assert!(Design::<16, 8>::pruned(Kernel::Grunwald, order(0.5), 1e-6, DAY).is_err());
    for tolerance in [0.0, -1.0, 1e-12, 0.5, f64::NAN] {
        let error = design(tolerance, 1e4).expect_err("not a tolerance");
        assert!(
            matches!(error, DesignError::Parameter(ParameterError::Tolerance(_))),
            "{error}"
        );
    }
    for horizon in [0.0, 15.0, 1e13, f64::NAN, f64::INFINITY] {
        let error = design(1e-3, horizon).expect_err("not a horizon");
        assert!(
            matches!(error, DesignError::Parameter(ParameterError::Horizon(_))),
            "{error}"
        );
    }
}

#[test]
fn a_step_in_two_phases_is_the_same_as_one() {
    let operator = full::<f64>(Kernel::Grunwald, 0.5, 1e-6);
    let (mut once, mut twice) = (operator.at_rest(), operator.at_rest());
    for x in lively(100) {
        let y = operator.output(&twice, x);
        assert_eq!(
            operator.output(&twice, x),
            y,
            "output leaves the history alone"
        );
        operator.advance(&mut twice, x);
        assert_eq!(operator.step(&mut once, x), y);
    }
}
