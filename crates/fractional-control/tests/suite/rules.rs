//! How far a rule may stand for its plant: half an integrator behind a hold, whose step is 2√(t/π) at each sample.

use crate::fixture::{of_impulse_response, p};
use core::f64::consts::PI;
use fracdiff::Seconds;
use fractional_control::{Memory, PidParameters, Plant, Rule, SampledLoop, SampledPlant};
use num_complex::Complex;

/// A gain on a plant of 1 s a sample.
fn closed(plant: &str, gain: f64) -> SampledLoop {
    sampled(plant, p(gain), Rule::Bdf2, Seconds(1.0))
}

fn sampled(plant: &str, gains: PidParameters, rule: Rule, sample_time: Seconds) -> SampledLoop {
    let memory = Memory::new(rule, 1e-9, 1e6 * sample_time.0).expect("valid");
    let plant: Plant = plant.parse().expect("valid");
    let plant = SampledPlant::new(&plant, memory, sample_time).expect("runs");
    SampledLoop::new(gains.into(), memory, &plant).expect("valid")
}

/// The gain above 1 at which the loop of the plant itself is lost.
fn lost_at(own: &SampledLoop) -> f64 {
    let truth = own.of_plant().expect("a rule");
    truth.margins().gain_up.expect("ends").value
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
    let own = sampled("exp(-0.01s)/s^0.18", gains, Rule::Bdf2, Seconds(1.0));
    // It grows from a gain of 0.39 times that on.
    let up = own.of_plant().expect("a rule").gain_crossings();
    let crossings = up.iter().map(|gain| gain.value);
    let first = crossings.fold(f64::INFINITY, f64::min);
    assert!((0.37..0.40).contains(&first), "{first}");
    assert!(!own.verdict().stable || !own.rule_error().expect("a rule").holds());
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
fn where_a_rule_stands_for_its_plant_its_verdict_is_that_of_the_weights() {
    let up = lost_at(&closed("1/s^0.5", 0.55));
    assert!(!grows(0.55 * 0.99 * up) && grows(0.55 * 1.01 * up), "{up}");
    for gain in [0.05, 0.2, 0.4, 0.55, 0.9, 1.05, 1.2, 1.3, 2.0, 10.0] {
        let own = closed("1/s^0.5", gain);
        let holds = own.rule_error().expect("a rule").holds();
        assert!(!holds || own.verdict().stable != grows(gain), "{gain}");
        assert!(holds || gain > 0.5, "{gain}");
    }
    // Not even at the gain of 1.3 that was called stable.
    assert!(!closed("1/s^0.5", 1.3).rule_error().expect("a rule").holds());
    let soft = closed("1/s^0.5", 0.2);
    let rule = soft.rule_error().expect("a rule");
    let [low, high] = rule.within([0.01, 100.0]);
    assert!(low < 0.011 && (2.0..5.5).contains(&high), "{low} {high}");
    assert!(closed("1/(s+1)", 1.0).rule_error().is_none());
}

/// What a fractional function passes on at once turns errors over at the next sample, however fast that comes.
#[test]
fn a_gain_at_once_is_not_halved_by_the_rule() {
    let own = closed("(2s^0.5+0.001)/(s^0.5+0.001)", 0.7);
    assert!(own.verdict().stable && !own.rule_error().expect("a rule").holds());
    let gains = own.of_plant().expect("a rule").gain_crossings();
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
fn swinging(plant: &str, gain: f64, rule: Rule) -> SampledLoop {
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
            let own = swinging(&text, gain, rule);
            let holds = own.rule_error().expect("a rule").holds();
            damped += usize::from(own.verdict().stable);
            apart += usize::from(!holds);
            assert!(!own.verdict().stable || !holds, "{rule:?} {omega}");
        }
        assert_eq!((damped, apart), (6, 6), "{rule:?}");
    }
}

/// One that decays as fast as the rule has it is proved, with its interval of gains.
#[test]
fn a_resonance_that_decays_by_itself_is_proved() {
    let own = swinging("exp(-0.3s)/(s^2+0.2s+1)/(0.01s^0.5+1)", 0.1, Rule::Bdf2);
    let rule = own.rule_error().expect("a rule");
    assert!(own.verdict().stable && rule.holds());
    let up = lost_at(&own);
    let [low, high] = rule.within([0.01, up]);
    let reaches = high > 0.8 * up && high < up;
    assert!(low < 0.011 && reaches, "{low} {high} {up}");
}

/// Where the arcs say that a rule holds, it does at each of some hundred angles, and at each gain of the interval.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn what_is_said_of_arcs_is_so_at_the_angles_on_them() {
    let mut held = 0;
    for plant in [
        "1/s^0.5",
        "exp(-0.3s)/s^1.2",
        "(s^0.3+2)/(0.8s^2.2+0.5s^0.9+1)",
        "(2s^0.5+0.1)/(s^0.5+1)",
        "exp(-0.25s)*(3s^1.5+1)/(s^1.5+20s+5)",
        "1/(40s^2+0.2s+1)/(s^0.5+1)",
        "1/(9s^2+0.001s+1)/(s^0.5+1)",
        "1/(40s^1.5-10s+1)",
    ] {
        for gain in [1e-3, 0.03, 0.3, 3.0] {
            let own = closed(plant, gain);
            let rule = own.rule_error().expect("a rule");
            if !rule.holds() {
                continue;
            }
            held += 1;
            let truth = own.of_plant().expect("a rule");
            let gains = rule.within([0.1, 10.0]);
            for k in 0..=250 {
                let theta = PI * libm::pow(1e-4 / PI, f64::from(k) / 250.0);
                let open = own.open(theta);
                let wrong = (truth.open(theta) - open).norm();
                for gain in [gains[0], 1.0, gains[1]] {
                    let room = (open * gain + 1.0).norm();
                    assert!(wrong * gain < 0.71 * room, "{plant} {theta} {gain}");
                }
            }
        }
    }
    assert!(held >= 12, "{held}");
}
