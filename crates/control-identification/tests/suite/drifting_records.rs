//! Records whose noise is slow: plants by closed forms, a third of them beside a disturbance that drifts.
//!
//! `CAMPAIGN_CASES` sets how many; 6 unless it is given.

use crate::fixture::{begun, normal, record};
use control_identification::FreeNumber;
use control_identification::model_search::{Found, InputOutput, nearer_in_simulation};
use fracdiff::Seconds;
use fractional_control::{FractionalTransferFunction, HeldPlant, Plant, PowerMemory, Rule, Term};
use rayon::prelude::*;
use testkit::{Random, assert_relative};

/// `x_n = a·x_(n−1) + e_n` of standard deviation 1, settled when it begins.
fn slow(alike: f64, samples: usize, random: &mut Random) -> Vec<f64> {
    let news = (1.0 - alike * alike).sqrt();
    let mut last = normal(random);
    let mut next = || {
        last = alike * last + news * normal(random);
        last
    };
    (0..samples).map(|_| next()).collect()
}

#[derive(Clone, Copy, Debug)]
enum Input {
    Steps,
    Binary,
    Filtered,
}

impl Input {
    fn signal(self, samples: usize, tau: f64, random: &mut Random) -> Vec<f64> {
        let mut level = random.between(-1.0, 1.0);
        match self {
            Self::Filtered => slow((-1.0 / tau).exp(), samples, random),
            Self::Steps | Self::Binary => (0..samples)
                .map(|_| {
                    let is_step = matches!(self, Self::Steps);
                    if random.chance(if is_step { 0.4 / tau } else { 2.0 / tau }) {
                        level = if is_step {
                            random.between(-1.0, 1.0)
                        } else {
                            -level.signum()
                        };
                    }
                    level
                })
                .collect(),
        }
    }
}

/// A stable plant in units of the sample time, and its record.
struct Case {
    words: String,
    gain: f64,
    drifts: bool,
    record: InputOutput,
}

impl Case {
    fn drawn(number: u64) -> Self {
        let mut random = Random(number + 6_600_000);
        let samples = random.one_of(&[200, 300]);
        let tau = samples as f64 / random.between(15.0, 60.0);
        let gain = random.log_between(0.2, 5.0) * random.one_of(&[1.0, -1.0]);
        let late = tau * random.between(0.2, 2.0) * random.one_of(&[0.0, 1.0]);
        let below = match number / 3 % 3 {
            0 => format!("({tau}s+1)"),
            1 => format!("({tau}s+1)({}s+1)", tau * random.between(0.2, 0.7)),
            _ => {
                let damping = random.between(0.3, 0.8);
                format!("({}s^2+{}s+1)", tau * tau, 2.0 * damping * tau)
            }
        };
        let words = format!("{gain}*exp(-{late}s)/({below})");
        let inputs = [Input::Steps, Input::Binary, Input::Filtered];
        let kind = random.one_of(&inputs);
        let input = kind.signal(samples, tau, &mut random);
        let plant: Plant = words.parse().expect("a plant");
        let memory = PowerMemory::new(Rule::Bdf2, 1e-8, samples as f64);
        let plant = HeldPlant::new(&plant, memory.expect("a memory"), Seconds(1.0));
        let plant = plant.expect("runs");
        let mut state = plant.at_rest();
        let outputs = input.iter().map(|u| plant.step(&mut state, *u));
        let output: Vec<f64> = outputs.collect();
        let mean = output.iter().sum::<f64>() / samples as f64;
        let squares: f64 = output.iter().map(|y| (y - mean) * (y - mean)).sum();
        let deviation = (squares / samples as f64).sqrt();
        let drifts = number.is_multiple_of(3);
        let (share, alike) = if drifts {
            (random.between(0.01, 0.07), random.between(0.5, 0.98))
        } else {
            (random.log_between(1e-6, 1e-3), 0.0)
        };
        let noise = slow(alike, samples, &mut random);
        let offset = random.one_of(&[0.0, 20.0 * deviation]);
        let pairs = output.iter().zip(&noise);
        let output = pairs.map(|(y, noise)| offset + y + share.sqrt() * deviation * noise);
        Self {
            words: format!("{words}, {kind:?}, {samples} samples, {share:.4} of {alike:.2}"),
            gain,
            drifts,
            record: record(1.0, input, output.collect()),
        }
    }
}

fn found(mut record: InputOutput) -> Vec<Found> {
    begun(&mut record).expect("some function fits")
}

/// The gain at rest, and its relative error.
fn rest(found: &Found) -> (f64, f64) {
    let fit = &found.identified;
    let gain = fit.function.gain_at_rest();
    if gain == 0.0 || gain.is_infinite() {
        return (gain, f64::INFINITY);
    }
    let last = FreeNumber::NumeratorCoefficient(fit.function.numerator().terms().len() - 1);
    let mut errors = fit.standard_errors.iter();
    let error = errors.find(|(number, _)| *number == last);
    (gain, error.map_or(0.0, |fit| fit.1))
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn stable_plants_beside_a_drift_do_not_grow_and_keep_their_gain() {
    campaign(testkit::cases(6));
}

#[test]
#[ignore = "by night: `.ci/nightly` does it"]
fn by_night_three_hundred_stable_plants_do_not_grow_and_keep_their_gain() {
    campaign(300);
}

fn campaign(count: u64) {
    let judged = (0..count).into_par_iter().map(|number| {
        let case = Case::drawn(number);
        let found = found(case.record.clone());
        let function = &found[0].identified.function;
        let grows = function.unstable_poles().is_some_and(|poles| poles > 0);
        let (gain, error) = rest(&found[0]);
        let is_right = (gain / case.gain - 1.0).abs() <= 0.3;
        // Said: an error of half of it, or no gain at all.
        let is_said = error > 0.5;
        let closest = found.iter().min_by(|a, b| a.bic.total_cmp(&b.bic));
        let shows = closest.is_some_and(|best| best.shows_a_response(&case.record));
        if grows || !is_right || !shows {
            println!(
                "{number}: {}: {function} behind {:?}, error {error:.2}, shows {shows}",
                case.words, found[0].identified.dead_time
            );
        }
        let counted = |drifts: bool| u64::from(case.drifts == drifts);
        [
            u64::from(grows),
            u64::from(!shows),
            counted(true) * u64::from(is_right || is_said),
            counted(true),
            counted(false) * u64::from(is_right || is_said),
            counted(false),
        ]
    });
    let [grow, silent, drift_right, drifts, white_right, white] =
        judged.reduce(|| [0; 6], |a, b| core::array::from_fn(|n| a[n] + b[n]));
    println!(
        "{grow} grow; {silent} show no response; the gain of {drift_right} of {drifts} that drift, of {white_right} of {white} others"
    );
    assert_eq!([grow, silent], [0; 2], "of {count}");
    assert!(20 * drift_right >= 19 * drifts, "{drift_right} of {drifts}");
    assert!(20 * white_right >= 19 * white, "{white_right} of {white}");
}

/// The gain of a plant beside a slow disturbance, with one that is wrong put first: the right one is nearer in simulation, of this record and of
/// another; put first there is none.
#[test]
fn a_function_with_another_gain_that_is_nearer_in_simulation_is_told() {
    let case = |seed: u64| {
        let mut random = Random(seed);
        let input = Input::Binary.signal(300, 12.0, &mut random);
        let mut x = 0.0;
        let clean = input.iter().map(|u| {
            let now = x;
            x += (u - x) / 12.0;
            2.0 * now
        });
        let clean: Vec<f64> = clean.collect();
        let noise = slow(0.9, 300, &mut random);
        let pairs = clean.iter().zip(&noise);
        let output = pairs.map(|(y, noise)| 20.0 + y + 0.05 * noise).collect();
        record(1.0, input, output)
    };
    let (mut record, other) = (case(1), case(2));
    let right = begun(&mut record).expect("some function fits");
    assert_relative("gain", rest(&right[0]).0, 2.0, 0.1);
    let mut wrong = right[0].clone();
    let halved = [Term::new(1.0, 0.0)];
    let below = [Term::new(12.0, 1.0), Term::new(1.0, 0.0)];
    wrong.identified.function = FractionalTransferFunction::new(&halved, &below).expect("a lag");
    wrong.identified.parts = vec![wrong.identified.function];
    wrong.identified.rms_residual *= 2.0;
    let found = [wrong, right[0].clone()];
    for other in [None, Some(&other)] {
        let (instead, [first, least]) =
            nearer_in_simulation(&found, &record, other, true).expect("another");
        assert_eq!(instead, &right[0]);
        assert!(first > 1.5 * least, "{first} {least}");
        assert_eq!(nearer_in_simulation(&right, &record, other, true), None);
    }
}

/// Twenty rows on steps and on a ramp, with and without noise: whatever the gain, they are an answer.
#[test]
fn a_static_gain_shows_a_response() {
    for gain in [3.0, 0.75, 0.7] {
        for (kind, noise) in [(0, 0.0), (0, 0.1), (1, 0.0), (1, 0.05)] {
            let mut random = Random(7);
            let input = (0..20).map(|n| match kind {
                0 => [0.0, 1.0, 0.5, 2.0, -1.0][n / 4],
                _ => 0.1 * n as f64,
            });
            let input: Vec<f64> = input.collect();
            let outputs = input
                .iter()
                .map(|u| gain * (u + noise * normal(&mut random)));
            let output = outputs.collect();
            let record = record(0.1, input, output);
            let found = found(record.clone());
            let closest = found.iter().min_by(|a, b| a.bic.total_cmp(&b.bic));
            let what = format!("{gain}, {kind}, {noise}: {}", found[0].identified.function);
            assert!(
                closest.expect("a function").shows_a_response(&record),
                "{what}"
            );
        }
    }
}
