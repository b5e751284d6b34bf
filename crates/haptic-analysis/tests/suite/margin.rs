//! Margins against bisection of verdicts, whole delays, and dense sampling.

use haptic_analysis::{ForcePath, SampledLoop, SampledPlant};
use proptest::prelude::*;
use std::f64::consts::PI;
use testkit::operator::{operator, path, wall};
use testkit::{Random, assert_close, assert_relative};

#[test]
fn a_spring_and_damper_on_a_free_mass_have_their_margins_in_closed_form() {
    let operator = operator("exact", 1.0);
    // (α, β) = g·(0.3, 0.6) meets α = 2β(2 − β)/(2 + β) at 0.3g(2 + 0.6g) = 1.2g(2 − 0.6g): g = 2.
    let subject = SampledLoop::new(wall(0.3, 0.6, 0.0, 0.0), &operator, 0).expect("in range");
    let margins = subject.margins().expect("stable");
    let up = margins.gain_up.expect("there is one");
    assert_close("up.value", up.value, 2.0, 1e-12);
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
    assert_close(
        "margins.sensitivity.value",
        margins.sensitivity.value,
        1.0,
        1e-15,
    );
    let edges = (margins.gain_up, margins.gain_down, margins.delay);
    assert_eq!(edges, (None, None, None));
}

#[test]
fn a_spurious_negative_spring_of_the_muir_polynomial_gives_a_lower_limit_too() {
    // μ = 2: P(1) = −1/3, so γ + α + βP(1) > 0 bounds the gain from above at θ = 0.
    let operator = operator("muir:3", 2.0);
    let subject = SampledLoop::new(wall(0.0, 0.1, 0.5, 0.1), &operator, 0).expect("in range");
    let margins = subject.margins().expect("stable");
    let up = margins.gain_up.expect("there is one");
    assert!((up.value - 3.0).abs() < 1e-12 && up.theta == 0.0, "{up:?}");
}

/// Scheme and μ; α, β, δ from `least_delta` on and γ; the delay: a loop that may be stable or not.
fn any_loop(least_delta: f64) -> impl Strategy<Value = (&'static str, f64, [f64; 4], usize)> {
    let schemes = [
        "exact",
        "muir:3",
        "grunwald:20",
        "tustin-muir:5",
        "full:1e-3",
    ];
    let numbers = [0.001..1.0, 0.0..1.0, least_delta..1.0, 0.0..1.0_f64];
    (
        prop::sample::select(schemes.to_vec()),
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

/// All g with 1 + g·GH = 0 on the circle, g > 0, by sign changes of Im GH on a grid and bisection.
fn crossings(subject: &SampledLoop) -> Vec<f64> {
    let gain = |theta: f64| subject.loop_gain(theta);
    let count = 4000;
    let at = |k: u32| PI * (f64::from(k) + 0.37) / f64::from(count);
    let mut found: Vec<f64> = [0.0, PI].map(|theta| -1.0 / gain(theta).re).to_vec();
    for k in 0..count - 1 {
        let (mut low, mut high) = (at(k), at(k + 1));
        if (gain(low).im > 0.0) == (gain(high).im > 0.0) {
            continue;
        }
        for _ in 0..80 {
            let middle = 0.5 * (low + high);
            if (gain(middle).im > 0.0) == (gain(low).im > 0.0) {
                low = middle;
            } else {
                high = middle;
            }
        }
        found.push(-1.0 / gain(low).re);
    }
    found.retain(|g| g.is_finite() && *g > 0.0);
    found
}

/// A falling mass, 1/(s² − p²), felt through two lags ((s + z)/(s + q))²: stable only with enough gain, and
/// with less of it first as slow motion, then as falling.
fn falling(random: &mut Random) -> SampledPlant {
    let (p, q) = (random.between(1.0, 8.0), random.between(1.0, 4.0));
    let z = q * random.between(3.0, 10.0);
    #[rustfmt::skip]
    let a = [
        0.0,   1.0, 0.0,   0.0,
        p * p, 0.0, 0.0,   0.0,
        z - q, 0.0, -q,    0.0,
        z - q, 0.0, z - q, -q,
    ];
    let path = ForcePath::new(random.between(0.0, 0.9), 0.0).expect("in range");
    let (input, output) = ([0.0, 1.0, 0.0, 0.0], [1.0, 0.0, 1.0, 1.0]);
    SampledPlant::linear(&a, &input, &output, 1e-3, 1.0, path).expect("samples")
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn of_several_gain_margins_the_nearest_counts_on_both_sides() {
    let mut random = Random(6);
    let (mut several_up, mut several_down, mut stable) = (0, 0, 0);
    for case in 0..900 {
        let operator = operator("exact", 1.0);
        let (plant, alpha, beta) = if case % 3 == 0 {
            // A late loop turns many times.
            let path = ForcePath::new(random.between(3.0, 9.0), 0.0).expect("in range");
            let plant = SampledPlant::behind(random.between(0.05, 1.0), 0.0, path);
            let (alpha, beta) = (random.between(1e-4, 0.01), random.between(0.0, 0.05));
            (plant.expect("in range"), alpha, beta)
        } else {
            let beta = random.between(0.05, 0.6);
            let plant = falling(&mut random);
            (plant, beta * random.between(0.005, 0.1), beta)
        };
        let subject = SampledLoop::with_plant(plant, alpha, beta, &operator).expect("in range");
        let Ok(margins) = subject.margins() else {
            continue;
        };
        stable += 1;
        let found = crossings(&subject);
        let (up, down): (Vec<f64>, Vec<f64>) = found.into_iter().partition(|g| *g > 1.0);
        several_up += usize::from(up.len() > 1);
        several_down += usize::from(down.len() > 1);
        let near = |have: Option<f64>, want: Option<f64>| match (have, want) {
            (Some(have), Some(want)) => (have / want - 1.0).abs() < 1e-6,
            (None, None) => true,
            _ => false,
        };
        let least = up.iter().copied().min_by(f64::total_cmp);
        let most = down.iter().copied().max_by(f64::total_cmp);
        let what = format!("case {case}: {margins:?}, up {up:?}, down {down:?}");
        assert!(near(margins.gain_up.map(|at| at.value), least), "{what}");
        assert!(near(margins.gain_down.map(|at| at.value), most), "{what}");
    }
    let several = several_up > 100 && several_down > 100;
    assert!(several, "{stable}: {several_up} {several_down}");
}

#[test]
fn a_crossing_close_to_rest_is_not_overlooked() {
    // A damper of the device and a soft spring: |GH| = 1 at θ = α/δ, phase −π/2 − atan(θ/δ) − θ/2.
    let operator = operator("exact", 1.0);
    for (alpha, delta) in [(3e-9, 2e-3), (3e-8, 1e-3), (1e-6, 0.01)] {
        let subject = SampledLoop::new(wall(alpha, 0.0, delta, 0.0), &operator, 0);
        let margins = subject.expect("in range").margins().expect("stable");
        let delay = margins.delay.expect("a crossing");
        assert_relative("θ", delay.theta, alpha / delta, 1e-3);
        let want = (0.5 * PI - (delay.theta / delta).atan()) / delay.theta - 0.5;
        assert_relative("delay", delay.value, want, 1e-6);
    }
}
