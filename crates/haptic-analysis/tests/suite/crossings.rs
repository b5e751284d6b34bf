//! Margins of loops with many crossings, against every crossing found on a dense grid: the nearest counts.

use haptic_analysis::{ForcePath, Nondimensional, SampledLoop, SampledPlant};
use std::f64::consts::PI;
use testkit::Random;
use testkit::operator::operator;

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
    SampledPlant::linear(
        &a,
        &[0.0, 1.0, 0.0, 0.0],
        &[1.0, 0.0, 1.0, 1.0],
        1e-3,
        1.0,
        path,
    )
    .expect("samples")
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
            let plant =
                SampledPlant::behind(random.between(0.05, 1.0), 0.0, path).expect("in range");
            (plant, random.between(1e-4, 0.01), random.between(0.0, 0.05))
        } else {
            let beta = random.between(0.05, 0.6);
            (
                falling(&mut random),
                beta * random.between(0.005, 0.1),
                beta,
            )
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
    println!("{stable} stable, {several_up} with several up, {several_down} with several down");
    assert!(
        several_up > 100 && several_down > 100,
        "{several_up} {several_down}"
    );
}

#[test]
fn a_crossing_close_to_rest_is_not_overlooked() {
    // A damper of the device and a soft spring: |GH| = 1 at θ = α/δ, phase −π/2 − atan(θ/δ) − θ/2.
    let operator = operator("exact", 1.0);
    for (alpha, delta) in [(3e-9, 2e-3), (3e-8, 1e-3), (1e-6, 0.01)] {
        let wall = Nondimensional {
            alpha,
            beta: 0.0,
            delta,
            gamma: 0.0,
        };
        let subject = SampledLoop::new(wall, &operator, 0).expect("in range");
        let delay = subject
            .margins()
            .expect("stable")
            .delay
            .expect("a crossing");
        let theta = alpha / delta;
        assert!(
            (delay.theta / theta - 1.0).abs() < 1e-3,
            "{delay:?} {theta}"
        );
        let want = (0.5 * PI - (delay.theta / delta).atan()) / delay.theta - 0.5;
        assert!((delay.value / want - 1.0).abs() < 1e-6, "{delay:?} {want}");
    }
}
