//! Designs of plants of all kinds: each is found or refused with a reason, and none costs much.
//!
//! `CAMPAIGN_CASES` sets how many; 24 unless it is given.

use fracdiff::{Scheme, Seconds};
use fractional_control::design::{ControlDesign, SAMPLES_A_RADIAN, usual_sample_time};
use fractional_control::run::samples_for;
use fractional_control::tuning::Specification;
use fractional_control::{ControlError, Margins, Plant};
use rayon::prelude::*;
use testkit::Random;

/// Evaluations of the response of a plant for one controller, some 0.2 µs each. The dearest of 200 takes 438 450.
const MOST: u64 = 600_000;

/// An integrator behind a lag; a lag behind a dead time; one fractional pole; two powers; a pole that grows; a swing that hardly decays; four poles; a
/// fractional integrator. Plant, crossover in rad/s and margin in degrees.
fn drawn(number: u64) -> (String, f64, f64) {
    let mut random = Random(number + 35_000_000);
    let gain = random.log_between(0.1, 10.0);
    let tau = random.log_between(0.01, 100.0);
    let margin = random.between(45.0, 70.0);
    let mut share = |low, high| random.between(low, high);
    let (below, times) = match number % 8 {
        0 => (format!("{}s^2+s", tau * share(0.01, 0.5)), share(0.3, 1.0)),
        1 => {
            let late = share(0.01, 0.4);
            let below = format!("{tau}s+1)*exp(-{}s", late * tau);
            (below, share(0.1, 0.5) / late)
        }
        2 => {
            let order = share(0.3, 1.9);
            let below = format!("{}s^{order}+1", tau.powf(order));
            (below, share(1.0, 5.0))
        }
        3 => {
            let (high, low) = (share(1.0, 1.95), share(0.3, 0.9));
            let second = share(0.2, 2.0) * tau.powf(low);
            let below = format!("{}s^{high}+{second}s^{low}+1", tau.powf(high));
            (below, share(1.0, 5.0))
        }
        4 => (format!("{tau}s-1"), share(2.0, 10.0)),
        5 => {
            let damped = 2.0 * share(0.01, 0.2) * tau;
            let below = format!("{}s^2+{damped}s+1", tau * tau);
            (below, share(1.5, 4.0))
        }
        6 => {
            let lags = [(); 4].map(|()| format!("({}s+1)", tau * share(0.1, 1.0)));
            (lags.concat(), share(0.3, 1.2))
        }
        _ => (format!("s^{:.1}", share(1.1, 1.9)), share(0.3, 3.0)),
    };
    (format!("{gain}/({below})"), times / tau, margin)
}

#[test]
fn a_sample_time_is_a_round_number() {
    for (time_s, round_s) in [
        (0.2, 0.2),
        (0.19, 0.1),
        (4e-4, 2e-4),
        (1e-3, 1e-3),
        (7.0, 5.0),
    ] {
        let usual = usual_sample_time(1.0 / (SAMPLES_A_RADIAN * time_s));
        assert_eq!(usual, Seconds(round_s), "{time_s}");
    }
}

#[test]
fn a_glance_sees_what_the_answer_says() {
    for plant in ["0.55exp(-s)/(62s+1)", "1/(0.2s^1.4+1)", "1/(s^2-1)"] {
        let design = ControlDesign {
            plant: plant.parse().expect("valid"),
            wishes: Specification::new(if plant.starts_with('1') { 5.0 } else { 0.1 }, 1.0),
            sample_time: Seconds(if plant.starts_with('1') { 2e-3 } else { 0.2 }),
            scheme: "full-bdf2".parse().expect("valid"),
            output_low: None,
            output_high: None,
            step: 1.0,
            samples: 600,
        };
        let answer = design.answer().expect("found");
        let pairs = [
            (design.glance(), Ok(answer.fractional)),
            (design.integer_glance(), answer.integer),
        ];
        for (glance, whole) in pairs {
            let (Ok(glance), Ok(whole)) = (glance, whole) else {
                continue;
            };
            let trial = whole.trial.expect("runs");
            assert_eq!(glance.setup, whole.setup);
            assert_eq!(glance.run.verdict, trial.verdict);
            assert_eq!(glance.run.response, trial.step);
            // The loop that runs, and the plant behind its hold: the same to the error of a rule.
            let phase = |margins: &Margins| margins.phase.map_or(0.0, |phase| phase.value);
            let (have, want) = (phase(&glance.margins), phase(&trial.margins));
            assert!((have - want).abs() < 0.02, "{plant}: {have} {want}");
        }
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn plants_of_all_kinds_are_designed_for_at_little_cost() {
    let count: u64 = testkit::cases(24);
    let not_met = (0..count).into_par_iter().filter(|number| {
        let (text, omega, margin) = drawn(*number);
        let plant: Plant = text.parse().expect(&text);
        let t = 0.02 / omega;
        let design = ControlDesign {
            plant,
            wishes: Specification::new(omega, margin.to_radians()),
            sample_time: Seconds(t),
            scheme: Scheme::FullBdf2 {
                tolerance: fracdiff::scheme::DEFAULT_TOLERANCE,
            },
            output_low: None,
            output_high: None,
            step: 1.0,
            samples: samples_for(Some(omega), t) as usize,
        };
        let answer = match design.answer() {
            Ok(answer) => answer,
            // Of those that grow some have no flat phase there, or no other margin as large.
            Err(ControlError::NotFound { why, .. }) if number % 8 == 4 => {
                assert!(why.starts_with("there is one"), "{text}: {why}");
                return true;
            }
            Err(error) => panic!("{text}: {error}"),
        };
        for candidate in [Some(&answer.fractional), answer.integer.as_ref().ok()]
            .into_iter()
            .flatten()
        {
            let trial = candidate.trial.as_ref().expect("it runs");
            assert!(trial.verdict.stable, "{text}");
            assert!(trial.evaluations < MOST, "{text}: {}", trial.evaluations);
            println!("{number} {} {text}", trial.evaluations);
        }
        let missed = answer.fractional.wishes.iter().any(|wish| !wish.is_met());
        assert!(
            !missed || number % 8 == 4,
            "{text}: {:?}",
            answer.fractional.wishes
        );
        missed
    });
    let not_met = not_met.count() as u64;
    assert!(16 * not_met <= count, "{not_met} of {count}");
}
