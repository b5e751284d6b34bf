//! Designs of plants of all kinds: each is found or refused with a reason, and none costs much.
//!
//! `CAMPAIGN_CASES` sets how many; 24 unless it is given.

use control_tuning::{
    Specification,
    design::{ControlDesign, SAMPLES_A_RADIAN, usual_sample_time},
};
use core::f64::consts::PI;
use fracdiff::{Scheme, Seconds};
use fractional_control::{
    ControlError, PidParameters, Plant, analysis::analyse, num_complex::Complex, run::samples_for,
};
use rayon::prelude::*;
use testkit::{Random, assert_relative};

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

/// A plant `exp(-dTs)/(a·s^α + b·s^β + c)` behind its hold, sampled with T, and the controller that a design of it found.
struct Exact {
    below: [(f64, f64); 3],
    delay: f64,
    law: PidParameters,
    t: f64,
}

impl Exact {
    fn plant(&self, s: Complex<f64>) -> Complex<f64> {
        let below = self.below.iter().map(|(a, order)| s.powf(*order) * a);
        below.sum::<Complex<f64>>().inv()
    }

    /// ```text
    /// L = C·e^(−jdθ)·(1 − e^(−jθ))·Σ G(s_k)/(s_k·T),   s_k = j(θ + 2πk)/T,   C by δ = (3/2 − 2w + w²/2)/T
    /// ```
    /// The sum beyond |k| = 40 is the integral ∫ G(s)/s ds, along s·e^x.
    fn open(&self, theta: f64) -> Complex<f64> {
        const MOST: i32 = 40;
        let (j, t) = (Complex::i(), self.t);
        let s = |k: f64| j * (theta + 2.0 * PI * k) / t;
        let near = (-MOST..=MOST).map(|k| s(f64::from(k)));
        let near: Complex<f64> = near.map(|s| self.plant(s) / (s * t)).sum();
        let tail = |end: Complex<f64>| -> Complex<f64> {
            let step = 0.05;
            let weight = |n: u32| if n == 0 { 0.5 } else { 1.0 } * step;
            let parts = (0..800).map(|n| self.plant(end * (step * f64::from(n)).exp()) * weight(n));
            parts.sum()
        };
        let edge = f64::from(MOST) + 0.5;
        let beyond = (tail(s(edge)) - tail(s(-edge))) / (2.0 * PI * j);
        let w = (-j * theta).exp();
        let delta = (1.5 - 2.0 * w + 0.5 * w * w) / t;
        let law = &self.law;
        let integral = law.integral * delta.powf(-law.integral_order);
        let derivative = law.derivative * delta.powf(law.derivative_order);
        let held = (1.0 - w) * (near + beyond) * w.powf(self.delay);
        (law.proportional + integral + derivative) * held
    }

    /// The places where this is 0 on a dense row of angles, by halving.
    fn zeros(&self, part: impl Fn(Complex<f64>) -> f64) -> Vec<(f64, Complex<f64>)> {
        let row: Vec<f64> = (0..400)
            .map(|n| PI * (-0.02 * f64::from(n)).exp())
            .collect();
        let signs: Vec<f64> = row.iter().map(|theta| part(self.open(*theta))).collect();
        let pairs = (1..row.len()).filter(|n| signs[*n] * signs[n - 1] < 0.0);
        let halved = pairs.map(|n| {
            let (mut low, mut high) = (row[n], row[n - 1]);
            for _ in 0..40 {
                let middle = 0.5 * (low + high);
                let same = part(self.open(middle)) * signs[n] > 0.0;
                *(if same { &mut low } else { &mut high }) = middle;
            }
            (low, self.open(low))
        });
        halved.collect()
    }
}

/// Plants of fractional orders, half of them late: the margins of a design are those of the analysis, to all digits, and those of the exact
/// response of the plant behind its hold, by a dense search: to 1e-6 the rounding of its sums and the tolerance of the memories.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn margins_are_those_of_the_exact_response() {
    let judged: usize = (0..testkit::cases(12))
        .into_par_iter()
        .map(|number| {
            let mut random = Random(number + 29_000_000);
            let (order, low) = (random.between(0.7, 1.9), random.between(0.1, 0.5));
            let second = random.between(0.1, 1.0);
            let (a, t) = (random.log_between(0.1, 10.0), 0.01);
            let delay = (number % 2) as f64 * 3.0;
            let text = format!("exp(-{}s)/({a}s^{order}+{second}s^{low}+1)", delay * t);
            let plant: Plant = text.parse().expect(&text);
            let design = ControlDesign {
                plant: plant.clone(),
                wishes: Specification {
                    iso_damping: false,
                    ..Specification::new(random.between(0.5, 2.0), 1.0)
                },
                sample_time: Seconds(t),
                scheme: "full-bdf2:1e-9".parse().expect("valid"),
                output_low: None,
                output_high: None,
                step: 1.0,
                samples: 200,
            };
            let found = design.answer().expect(&text).fractional;
            let trial = found.trial.expect("it runs");
            let (analysis, margins) = (&trial.analysis, trial.analysis.margins);
            let again = analyse(&found.setup, &plant).expect("it runs");
            assert_eq!(
                (analysis.margins, &analysis.curve),
                (again.margins, &again.curve),
                "{text}"
            );
            let law = found.setup.pid().expect("a PID");
            let below = [(a, order), (second, low), (1.0, 0.0)];
            let exact = Exact {
                below,
                delay,
                law,
                t,
            };
            let near = |what: &str, have: f64, want: f64| {
                assert_relative(&format!("{what} of {text}"), have, want, 1e-5);
            };
            for point in analysis.curve.iter().step_by(60) {
                let left = (point.open / exact.open(point.omega_rad_s * t) - 1.0).norm();
                assert!(left < 1e-5, "{text}: {left:e} at {}", point.omega_rad_s);
            }
            let crossovers = exact.zeros(|l| l.norm().ln());
            let least = crossovers.iter().map(|(_, l)| (-l).arg().abs());
            let phase = margins.phase.expect("a crossover");
            near(
                "phase",
                phase.value.abs(),
                least.fold(f64::INFINITY, f64::min),
            );
            // At half the sampling rate L is real, whichever sign the rounding of its imaginary part has.
            let mut real = exact.zeros(|l| l.im);
            real.push((PI, exact.open(PI)));
            let gains = real
                .iter()
                .filter(|(_, l)| l.re < 0.0)
                .map(|(_, l)| 1.0 / l.norm());
            let above = gains
                .filter(|gain| *gain > 1.0)
                .fold(f64::INFINITY, f64::min);
            let up = margins.gain_up.map_or(f64::INFINITY, |gain| gain.value);
            if above.is_finite() || up.is_finite() {
                near("gain", up, above);
            }
            usize::from(above.is_finite())
        })
        .sum();
    assert!(judged > 3, "{judged}");
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn plants_of_all_kinds_are_designed_for() {
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
                assert!(why.starts_with("a controller exists"), "{text}: {why}");
                return true;
            }
            Err(error) => panic!("{text}: {error}"),
        };
        for candidate in [Some(&answer.fractional), answer.integer.as_ref().ok()]
            .into_iter()
            .flatten()
        {
            let trial = candidate.trial.as_ref().expect("it runs");
            assert!(trial.analysis.verdict.stable, "{text}");
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
