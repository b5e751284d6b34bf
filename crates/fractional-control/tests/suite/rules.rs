//! How far a rule may stand for its plant: half an integrator behind a hold, whose step is 2√(t/π) at each sample.

use crate::fixture::{of_impulse_response, p};
use core::f64::consts::PI;
use fracdiff::Seconds;
use fractional_control::{HeldPlant, PidParameters, Plant, PowerMemory, Rule, SampledControlLoop};
use num_complex::Complex;

/// A gain on a plant of 1 s a sample.
fn closed(plant: &str, gain: f64) -> SampledControlLoop {
    sampled(plant, p(gain), Rule::Bdf2, Seconds(1.0))
}

fn sampled(
    plant: &str,
    gains: PidParameters,
    rule: Rule,
    sample_time: Seconds,
) -> SampledControlLoop {
    let memory = PowerMemory::new(rule, 1e-9, 1e6 * sample_time.0).expect("valid");
    let plant: Plant = plant.parse().expect("valid");
    let plant = HeldPlant::new(&plant, memory, sample_time).expect("runs");
    SampledControlLoop::new(gains.into(), memory, &plant).expect("valid")
}

/// The loop of the plant itself.
fn truth(sampled_loop: &SampledControlLoop) -> SampledControlLoop {
    sampled_loop.of_plant().expect("a rule")
}

/// The gain above 1 at which that is lost.
fn lost_at(sampled_loop: &SampledControlLoop) -> f64 {
    truth(sampled_loop).margins().gain_up.expect("ends").value
}

/// The answer of 1/s^order to one held sample, late by this.
fn weights(order: f64, delay: f64) -> Vec<f64> {
    let step = |n: usize| libm::pow((n as f64 - delay).max(0.0), order) / libm::tgamma(1.0 + order);
    (0..100_000)
        .map(|n| if n == 0 { 0.0 } else { step(n) - step(n - 1) })
        .collect()
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_response_behind_a_hold_is_that_of_the_weights() {
    for order in [0.18, 0.5, 1.3] {
        for delay in [0.0, 1e-4, 0.01, 0.05, 0.3, 0.9, 0.99, 0.9999, 1.9, 2.0, 2.3] {
            let plant = format!("exp(-{delay}s)/s^{order}");
            let held = closed(&plant, 1.0).of_plant().expect("follows a rule");
            let weights = weights(order, delay);
            for theta in [0.05, 0.5, 1.5, 2.5, PI] {
                let (have, want) = (held.open(theta), of_impulse_response(&weights, theta));
                // The sum of the weights is cut off.
                let cut = 0.51 * weights.last().expect("some") / libm::sin(0.5 * theta);
                assert!(
                    (have - want).norm() < 1e-3 * want.norm() + cut,
                    "{plant} {theta}: {have} {want}"
                );
            }
        }
    }
}

/// A dead time of a hundredth of a sample: the plant answers to the sample before it with nearly all that it has.
#[test]
fn a_short_dead_time_of_a_low_order_is_seen() {
    let gain = 0.015 * libm::pow(0.01, 0.18);
    let gains = PidParameters {
        proportional: gain,
        derivative: gain * 100.0,
        derivative_order: 1.0,
        ..PidParameters::NONE
    };
    let sampled_loop = sampled("exp(-0.01s)/s^0.18", gains, Rule::Bdf2, Seconds(1.0));
    // It grows from a gain of 0.39 times that on.
    let up = sampled_loop.of_plant().expect("a rule").gain_crossings();
    let crossings = up.iter().map(|gain| gain.value);
    let first = crossings.fold(f64::INFINITY, f64::min);
    assert!((0.37..0.40).contains(&first), "{first}");
    assert!(!truth(&sampled_loop).verdict().stable);
}

/// The loop u[n] = −K·y[n] by the weights: its swing at the end over that in the middle.
fn grows(gain: f64) -> bool {
    let (weights, mut u) = (weights(0.5, 0.0), vec![1.0]);
    for n in 1..2000 {
        let y: f64 = (1..=n).map(|j| weights[j] * u[n - j]).sum();
        u.push(-gain * y);
    }
    let most = |part: &[f64]| part.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
    most(&u[1500..]) > most(&u[500..1000])
}

#[test]
fn the_verdict_on_a_plant_behind_its_hold_is_that_of_the_weights() {
    let up = lost_at(&closed("1/s^0.5", 0.55));
    assert!(!grows(0.55 * 0.99 * up) && grows(0.55 * 1.01 * up), "{up}");
    // 1.2 and 1.3 are stable by the rule.
    for gain in [0.05, 0.2, 0.4, 0.55, 0.9, 1.05, 1.2, 1.3] {
        let verdict = truth(&closed("1/s^0.5", gain)).verdict();
        assert_eq!(
            verdict.unstable_poles,
            Some(usize::from(grows(gain))),
            "{gain}"
        );
    }
    let soft = truth(&closed("1/s^0.5", 0.2));
    let [low, high] = soft.gain_interval(&soft.margins()).expect("stable");
    let up = 0.55 * up / 0.2;
    assert!(
        low < 0.011 && (0.99 * up..up).contains(&high),
        "{low} {high}"
    );
    assert!(closed("1/(s+1)", 1.0).of_plant().is_none());
}

/// What a fractional function passes on at once turns errors over at the next sample, however fast that comes.
#[test]
fn a_gain_at_once_is_not_halved_by_the_rule() {
    let sampled_loop = closed("(2s^0.5+0.001)/(s^0.5+0.001)", 0.7);
    assert!(sampled_loop.verdict().stable && !truth(&sampled_loop).verdict().stable);
    let gains = truth(&sampled_loop).gain_crossings();
    let half_rate = |gain: f64| (gain - 1.0 / 1.4).abs() < 0.02;
    assert!(gains.iter().any(|gain| half_rate(gain.value)), "{gains:?}");
}

/// What the sampled plant makes of a resonance that hardly decays: the share of the pole's move that the loop gives it.
///
/// ```text
/// s² + εs + ω² + K·e^(−sτ)·h(s)/(0.01s^0.5 + 1) = 0,   s = jω + δ:   Re δ = −ε/2 − K/(2ω)·Im(e^(−jωτ)·h(jω)/(…)),   h the hold
/// ```
fn pushed_apart(omega: f64, gain: f64) -> f64 {
    let half = 0.05 * omega;
    let hold = Complex::from_polar(half.sin() / half, -half);
    let slow = Complex::new(0.0, omega).powf(0.5) * 0.01 + 1.0;
    -gain / (2.0 * omega) * (Complex::from_polar(1.0, -0.3 * omega) * hold / slow).im
}

/// A gain on a plant of 0.1 s a sample.
fn swinging(plant: &str, gain: f64, rule: Rule) -> SampledControlLoop {
    sampled(plant, p(gain), rule, Seconds(0.1))
}

/// A rule damps a resonance, which its plant does not: the spike of the plant would lie between any angles that could be looked at.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_resonance_that_the_rule_damps_is_not_proved_stable() {
    let (damping, gain) = (2e-7, 1e-4);
    for rule in [Rule::Bdf2, Rule::Grunwald] {
        let (mut damped, mut apart) = (0, 0);
        for k in 0..6 {
            let omega = 0.6 * 1.23_f64.powi(k);
            assert!(
                pushed_apart(omega, gain) > damping,
                "the plant's loop grows"
            );
            let square = omega * omega;
            let text = format!("exp(-0.3s)/(s^2+{damping}s+{square})/(0.01s^0.5+1)");
            let sampled_loop = swinging(&text, gain, rule);
            damped += usize::from(sampled_loop.verdict().stable);
            apart += usize::from(!truth(&sampled_loop).verdict().stable);
        }
        assert_eq!((damped, apart), (6, 6), "{rule:?}");
    }
}

/// One that decays by itself is proved, with its interval of gains.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_resonance_that_decays_by_itself_is_proved() {
    let sampled_loop = truth(&swinging(
        "exp(-0.3s)/(s^2+0.2s+1)/(0.01s^0.5+1)",
        0.1,
        Rule::Bdf2,
    ));
    let up = lost_at(&sampled_loop);
    let [low, high] = sampled_loop
        .gain_interval(&sampled_loop.margins())
        .expect("stable");
    assert!(
        low < 0.011 && high > 0.99 * up && high < up,
        "{low} {high} {up}"
    );
}
