//! Margins against closed forms, and what is said of a loop.

use super::*;
use crate::run::preflight::delay_samples;
use std::collections::BTreeMap;

/// The dissertation's device.
const TESTBED: Dynamics = Dynamics::ideal(0.065, 3.5);

fn wall(order: f64, stiffness: f64, dissipation: f64) -> Preflight<'static> {
    Preflight {
        stiffness_n_per_m: stiffness,
        dissipation_n_s_mu_per_m: dissipation,
        order: Order::new(order).expect("in range"),
        model: None,
        scheme: Scheme::Exact,
        sample_time_s: 1e-3,
        samples: 5000,
    }
}

#[test]
fn a_damper_has_the_margin_of_its_closed_form() {
    // Without damping of the device: α < 2β(2 − β)/(2 + β), 2/3 at β = 1.
    let device = Dynamics {
        damping_n_s_per_m: 0.0,
        mass_kg: 1.0,
        ..TESTBED
    };
    let at = |factor: f64| wall(1.0, factor * 0.6e6, factor * 1e3);
    let verdict = at(1.0).verdict(device, 0).expect("judges");
    assert!(verdict.stable && !verdict.passive, "{verdict:?}");
    // 0.6g = 2g(2 − g)/(2 + g)  ⇔  1.2 + 0.6g = 4 − 2g.
    let edge = 2.8 / 2.6;
    let margin = verdict.margin.expect("a margin");
    assert!((margin - edge).abs() < 1e-6, "{margin}");
    // Theorem 1 at μ = 1: δ > α/2 + β.
    let required = verdict.required_delta.expect("some");
    assert!((required - 1.3).abs() < 1e-9, "{required}");
    // An unstable one is told how much softer it has to be.
    let verdict = at(2.0).verdict(device, 0).expect("judges");
    let margin = verdict.margin.expect("a margin");
    assert!(!verdict.stable);
    assert!(margin <= 0.5 * edge && margin > 0.499 * edge, "{margin}");
    let refused = verdict.require_stable(false).expect_err("refused");
    assert_eq!(refused.exit_code(), 2);
    let text = refused.to_string();
    for part in [
        "alpha 1.2000",
        "beta 2.0000",
        "delta 0.0000",
        "delay 0 samples",
        "margin 0.538",
        "softer K",
        "less B",
        "`force_unstable`",
    ] {
        assert!(text.contains(part), "\"{part}\" in {text}");
    }
    verdict.require_stable(true).expect("forced");
    for (guarded, words) in [(false, "run all the same"), (true, "the guard alone")] {
        let warning = verdict.warning(guarded).expect("a warning");
        assert!(
            warning.contains("unstable") && warning.contains(words),
            "{warning}"
        );
    }
}

#[test]
fn delay_makes_a_stable_wall_unstable() {
    let wall = wall(0.5, 3000.0, 30.0);
    assert!(wall.verdict(TESTBED, 0).expect("judges").stable);
    assert!(!wall.verdict(TESTBED, 20).expect("judges").stable);
}

#[test]
fn delay_and_current_lag_of_the_device_count_as_they_are() {
    let wall = wall(1.0, 12e3, 15.0);
    let late = |delay_s: f64, current_lag_s: f64| {
        let device = Dynamics {
            delay_s,
            current_lag_s,
            ..TESTBED
        };
        wall.verdict(device, 0).expect("judges")
    };
    let margin = |delay, lag| late(delay, lag).margin.expect("a margin");
    // Between whole samples the margin is between theirs, and a lag costs too.
    let (none, half, one) = (margin(0.0, 0.0), margin(0.5e-3, 0.0), margin(1e-3, 0.0));
    assert!(none > half && half > one, "{none} {half} {one}");
    assert!(margin(0.0, 0.5e-3) < none);
    let verdict = late(1.3e-3, 1.5e-3);
    assert!(!verdict.stable, "{verdict:?}");
    let words = verdict.line();
    assert!(
        words.contains("delay 1.3 samples, current lag 1.5 ms"),
        "{words}"
    );
    // Samples of the line come on top.
    let verdict = wall.verdict(TESTBED, 2).expect("judges");
    assert_eq!(verdict.delay_samples.to_string(), "2");
}

#[test]
fn a_soft_and_plain_wall_is_passive_and_nothing_is_said() {
    let verdict = wall(1.0, 100.0, 0.5).verdict(TESTBED, 0).expect("judges");
    assert!(verdict.stable && verdict.passive, "{verdict:?}");
    assert_eq!(verdict.warning(false), None);
    let mut metadata = BTreeMap::new();
    verdict.describe(&mut metadata);
    assert_eq!(metadata["preflight.stable"], "true");
    assert_eq!(metadata["preflight.delay_samples"], "0");
}

#[test]
fn the_operator_that_runs_is_judged_and_not_the_ideal_one() {
    // Order 1.5 by A₃ is a negative spring at rest, (1−μ)(3−μ)/3 = −1/4.
    let ideal = wall(1.5, 10.0, 1.0);
    let short = Preflight {
        scheme: Scheme::Muir { degree: 3 },
        ..ideal
    };
    assert!(ideal.verdict(TESTBED, 0).expect("judges").stable);
    let verdict = short.verdict(TESTBED, 0).expect("judges");
    assert_eq!((verdict.stable, verdict.required_delta), (false, None));
}

#[test]
fn a_tissue_without_a_spring_drifts_and_is_stable() {
    let tissue = |dissipation: f64| Preflight {
        scheme: "full".parse().expect("a scheme"),
        ..wall(0.2247, 0.0, dissipation)
    };
    let verdict = tissue(174.0).verdict(TESTBED, 0).expect("judges");
    assert!(verdict.stable, "{verdict:?}");
    // These left a negative spring at rest once.
    for order in [0.35, 0.4, 0.45, 0.7, 0.8] {
        for scheme in ["full", "piecewise-linear", "exact"] {
            let tissue = Preflight {
                scheme: scheme.parse().expect("a scheme"),
                ..wall(order, 0.0, 20.0)
            };
            let verdict = tissue.verdict(TESTBED, 0).expect("judges");
            assert!(verdict.stable, "{scheme} {order}: {verdict:?}");
            assert!(
                verdict.required_delta.is_some(),
                "{scheme} {order}: {verdict:?}"
            );
        }
    }
    assert!(
        verdict.margin.is_some_and(|factor| factor > 10.0),
        "{verdict:?}"
    );
    // One that shakes is still told.
    let verdict = tissue(1e6).verdict(TESTBED, 0).expect("judges");
    assert!(!verdict.stable && verdict.margin.is_some(), "{verdict:?}");
}

#[test]
fn delays_are_rounded_up() {
    assert_eq!(delay_samples(0, 1e-3), 1);
    assert_eq!(delay_samples(300, 1e-3), 2);
    assert_eq!(delay_samples(2100, 1e-3), 4);
}
