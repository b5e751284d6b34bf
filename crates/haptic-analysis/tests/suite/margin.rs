//! Margins against bisection of verdicts, whole delays, and dense sampling.

use haptic_analysis::{SampledLoop, SampledPlant};
use proptest::prelude::*;
use std::f64::consts::PI;
use testkit::operator::{operator, path, wall};

#[test]
fn a_spring_and_damper_on_a_free_mass_have_their_margins_in_closed_form() {
    let operator = operator("exact", 1.0);
    // (α, β) = g·(0.3, 0.6) meets α = 2β(2 − β)/(2 + β) at 0.3g(2 + 0.6g) = 1.2g(2 − 0.6g): g = 2.
    let subject = SampledLoop::new(wall(0.3, 0.6, 0.0, 0.0), &operator, 0).expect("in range");
    let margins = subject.margins().expect("stable");
    let up = margins.gain_up.expect("there is one");
    assert!((up.value - 2.0).abs() < 1e-12, "{up:?}");
    assert_eq!(margins.gain_down, None);
    // GH = −1 with so much delay.
    let delay = margins.delay.expect("there is one");
    let plant = SampledPlant::behind(0.0, 0.0, path(delay.value, 0.0)).expect("in range");
    let late = SampledLoop::with_plant(plant, 0.3, 0.6, &operator).expect("in range");
    let left = (late.loop_gain(delay.theta) + 1.0).norm();
    assert!(left < 1e-9, "{left}");
}

#[test]
fn a_loop_that_is_not_stable_has_no_margins_and_says_so() {
    let operator = operator("exact", 1.0);
    let subject = SampledLoop::new(wall(3.0, 0.6, 0.0, 0.0), &operator, 0).expect("in range");
    let words = subject.margins().expect_err("refused").to_string();
    assert_eq!(words, "the loop is not stable: it has no margins");
    let words = subject.sensitivity_peak().expect_err("refused").to_string();
    assert_eq!(words, "the loop is not stable: it has no sensitivity peak");
}

#[test]
fn without_feedback_the_sensitivity_is_one() {
    let operator = operator("exact", 0.5);
    let subject = SampledLoop::new(wall(0.0, 0.0, 0.5, 0.5), &operator, 0).expect("in range");
    let margins = subject.margins().expect("stable");
    assert!((margins.sensitivity.value - 1.0).abs() < 1e-15);
    assert_eq!(
        (margins.gain_up, margins.gain_down, margins.delay),
        (None, None, None)
    );
}

#[test]
fn a_spurious_negative_spring_of_the_muir_polynomial_gives_a_lower_limit_too() {
    // μ = 2: P(1) = −1/3, so γ + α + βP(1) > 0 bounds the gain from above at θ = 0.
    let operator = operator("muir:3", 2.0);
    let subject = SampledLoop::new(wall(0.0, 0.1, 0.5, 0.1), &operator, 0).expect("in range");
    let up = subject
        .margins()
        .expect("stable")
        .gain_up
        .expect("there is one");
    assert!((up.value - 3.0).abs() < 1e-12 && up.theta == 0.0, "{up:?}");
}

/// Scheme and μ; α, β, δ from `least_delta` on and γ; the delay: a loop that may be stable or not.
fn any_loop(least_delta: f64) -> impl Strategy<Value = (&'static str, f64, [f64; 4], usize)> {
    let schemes = vec![
        "exact",
        "muir:3",
        "grunwald:20",
        "tustin-muir:5",
        "full:1e-3",
    ];
    let numbers = [0.001..1.0, 0.0..1.0, least_delta..1.0, 0.0..1.0_f64];
    (
        prop::sample::select(schemes),
        0.0..=2.0_f64,
        numbers,
        0..3_usize,
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    #[ignore = "long: `.ci/run` does it, or --include-ignored"]
    fn just_inside_every_margin_is_stable_and_just_outside_is_not(
        (scheme, mu, [alpha, beta, delta, gamma], delay) in any_loop(0.01),
    ) {
        let operator = operator(scheme, mu);
        let at = |gain: f64, delay| {
            SampledLoop::new(wall(gain * alpha, gain * beta, delta, gamma), &operator, delay).expect("in range")
        };
        let subject = at(1.0, delay);
        prop_assume!(subject.is_stable());
        let margins = subject.margins().expect("stable");
        if let Some(up) = margins.gain_up {
            prop_assert!(at(1.0 + 0.999 * (up.value - 1.0), delay).is_stable(), "{:?}", up);
            prop_assert!(at(1.0 + 0.5 * (up.value - 1.0), delay).is_stable(), "{:?}", up);
            prop_assert!(!at(up.value * (1.0 + 1e-6), delay).is_stable(), "{:?}", up);
        } else {
            prop_assert!(at(1e3, delay).is_stable());
        }
        if let Some(down) = margins.gain_down {
            prop_assert!(at(1.0 - 0.999 * (1.0 - down.value), delay).is_stable(), "{:?}", down);
            prop_assert!(!at(down.value * (1.0 - 1e-6), delay).is_stable(), "{:?}", down);
        } else {
            prop_assert!(at(1e-3, delay).is_stable());
        }
        match margins.delay {
            None => prop_assert!((1..5).all(|more| at(1.0, delay + more).is_stable())),
            Some(most) => {
                for more in 1..6 {
                    if (more as f64) < most.value - 1e-6 {
                        prop_assert!(at(1.0, delay + more).is_stable(), "{} of {:?}", more, most);
                    }
                }
            }
        }
    }

    #[test]
    #[ignore = "long: `.ci/run` does it, or --include-ignored"]
    fn no_sample_of_the_sensitivity_is_above_its_peak(
        (scheme, mu, [alpha, beta, delta, gamma], delay) in any_loop(0.0),
    ) {
        let operator = operator(scheme, mu);
        let subject = SampledLoop::new(wall(alpha, beta, delta, gamma), &operator, delay).expect("in range");
        prop_assume!(subject.is_stable());
        let peak = subject.sensitivity_peak().expect("stable");
        prop_assert!((subject.sensitivity(peak.theta) / peak.value - 1.0).abs() < 1e-12);
        let mut most: f64 = 0.0;
        // From rest on: evenly, and by ratios, as slow resonances are narrow.
        let even = (0..=4000_u32).map(|i| PI * f64::from(i) / 4000.0);
        let by_ratio = (1..=4000_u32).map(|i| PI * (-0.005 * f64::from(i)).exp());
        for theta in even.chain(by_ratio) {
            let sensitivity = subject.sensitivity(theta);
            prop_assert!(sensitivity <= peak.value * (1.0 + 2e-6), "{} {:?}", theta, peak);
            most = most.max(sensitivity);
        }
        // A peak that is not too narrow for these samples is met by one of them.
        if peak.value < 50.0 {
            prop_assert!(most > 0.98 * peak.value, "{} {:?}", most, peak);
        }
        let direct = 1.0 / (subject.loop_gain(1.0) + 1.0).norm();
        prop_assert!((subject.sensitivity(1.0) / direct - 1.0).abs() < 1e-10);
    }
}

#[test]
fn a_wall_of_the_smallest_number_there_is_does_not_hang() {
    let operator = operator("muir:3", 0.9);
    let subject = SampledLoop::new(wall(0.0, 5e-324, 0.1, 1.0), &operator, 0).expect("in range");
    // No wall at all: the device alone is stable, and no gain or delay takes it to the boundary.
    let margins = subject.margins().expect("stable");
    assert_eq!((margins.gain_up, margins.delay), (None, None));
}
