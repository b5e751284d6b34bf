//! Loops by name that were judged wrongly: poles far faster than the sample, dead times alone, gains at once.

use crate::fixture::{bdf2, closed, held, pi, plant};
use fracdiff::Seconds;
use fractional_control::{HeldPlant, Plant, SampledControlLoop};
use testkit::assert_refused;

/// A loop by its notation: plant, `K_p`, `K_i`, T.
fn judged(function: &str, (proportional, integral): (f64, f64), t: f64) -> SampledControlLoop {
    let memory = bdf2(1e-9, 1e6 * t);
    closed(pi(proportional, integral, 1.0), &plant(function), memory, t)
}

/// Loops that were called stable or unstable wrongly, with their true spectral radius: plant, `K_p` `K_i`, T, verdict.
const LOOPS: &str = "
    1/((0.065s^2+3.5s)(0.00006s+1))*exp(-0.0005s) | 4000 0 | 1e-3 | unstable
    # 1.0048
    1/((0.065s^2+3.5s)(0.00005s+1))*exp(-0.0005s) | 4000 0 | 1e-3 | unstable
    # 1.019
    1/((0.065s^2+3.5s)(0.00004s+1))*exp(-0.0005s) | 6000 0 | 1e-3 | unstable
    # 1.017
    1/((s^2+0.2s+1)(0.005s+1)) | 10 0 | 0.1 | unstable
    1/((s^2+0.2s+1)(0.006s+1)) | 10 0 | 0.1 | unstable
    # 0.929
    1/((s+1)(s+2)(0.0025s+1)) | 2 0 | 0.05 | stable
    0.55exp(-s)/((62s+1)(3s+1)(0.05s+1)) | 2 0.03 | 1 | stable
    # −1.01
    1/(0.02s+1) | 1.01 0 | 1 | unstable
    1/(0.02s+1) | 0.99 0 | 1 | stable
    1/(0.001s+1) | 2 0 | 1 | unstable
    # 1.0043
    exp(-0.05s)/((0.0002s+1)(s+1)) | 30 0 | 0.01 | unstable
    exp(-0.005s)/((0.0002s+1)(s+1)) | 30 0 | 0.01 | stable
";

#[test]
fn loops_with_a_pole_far_faster_than_the_sample() {
    for [plant, gains, t, stable] in testkit::table(LOOPS) {
        let number = |text: &str| text.parse().expect("a number");
        let (proportional, integral) = gains.split_once(' ').expect("two");
        let gains = (number(proportional), number(integral));
        let verdict = judged(&plant, gains, number(&t)).verdict();
        assert_eq!(verdict.stable, stable == "stable", "{plant} {gains:?}");
    }
}

#[test]
fn a_dead_time_alone_turns_errors_over_at_a_gain_of_one() {
    for plant in ["exp(-1s)", "exp(-0.5s)", "exp(-3s)", "1", "0.5*exp(-1.2s)"] {
        let unit = if plant.starts_with("0.5") { 2.0 } else { 1.0 };
        let closed = |gain: f64| judged(plant, (gain * unit, 0.0), 1.0);
        assert!(!closed(1.01).verdict().stable, "{plant}");
        assert!(closed(0.9).verdict().stable, "{plant}");
        let up = closed(0.9).margins().gain_up.expect("ends").value;
        assert!((up * 0.9 - 1.0).abs() < 1e-9, "{plant}: {up}");
    }
}

/// (2s + 1)/(s + 1) = 2 − 1/(s + 1), held: its own gain acts on the next measurement.
#[test]
fn what_passes_at_once_is_seen_by_the_next_measurement() {
    let memory = bdf2(1e-9, 100.0);
    for (delay, first) in [(0.0, 1), (0.04, 1), (0.1, 1), (0.13, 2), (0.2, 2)] {
        let plant: Plant = "(2s+1)/(s+1)".parse().expect("valid");
        let plant = plant.delayed(delay).expect("valid");
        let plant = held(&plant, memory, 0.1);
        let mut state = plant.at_rest();
        let y: Vec<f64> = (0..30).map(|_| plant.step(&mut state, 1.0)).collect();
        for (n, y) in y.iter().enumerate() {
            let since = (0.1 * n as f64 - delay).max(0.0);
            let passed = if n < first { 0.0 } else { 2.0 };
            let want = passed - (1.0 - (-since).exp());
            assert!((y - want).abs() < 1e-12, "{delay}, {n}: {y} {want}");
        }
    }
}

#[test]
fn a_pole_beyond_all_bounds_is_refused_with_the_remedy() {
    let memory = bdf2(1e-9, 1e6);
    for text in [
        "1/(1e-12s+1)",
        "1e60/(1e-60s+1)",
        "1/(0.001s-1)",
        "1/(0.0028s-1)",
    ] {
        let refused = HeldPlant::new(&plant(text), memory, Seconds(1.0));
        assert_refused(refused, "sample time 1 s is not within & sample faster");
    }
}
