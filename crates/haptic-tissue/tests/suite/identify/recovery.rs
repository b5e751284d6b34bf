//! Synthetic records with noise: the truth lies in the 95 % interval as often as it should.

use super::one;
use haptic_tissue::identify::{IdentifyError, Options, Record, identify, identify_unless};
use haptic_tissue::{Model, ModelKind};
use rand_distr::{Distribution as _, StandardNormal};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng as _;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Model and the values of its parameters; the two elements meet in the middle of the band.
fn truths() -> [(ModelKind, Vec<f64>); 5] {
    [
        (ModelKind::SpringPot, vec![3610.0, 0.2154]),
        (ModelKind::FractionalKelvinVoigt, vec![2e3, 0.7, 2e3, 0.15]),
        (ModelKind::FractionalMaxwell, vec![3e4, 0.7, 3e4, 0.15]),
        (ModelKind::FractionalZener, vec![3e4, 0.75, 3e4, 0.15, 2e3]),
        (
            ModelKind::FractionalPoyntingThomson,
            vec![2e3, 0.7, 2e3, 0.1, 8e3],
        ),
    ]
}

/// Storage and loss modulus over five decades with 1 % of noise, from the library's own complex modulus.
fn record(candidate: ModelKind, parameters: &[f64], seed: u64) -> Record {
    let model = Model::from_parameters(candidate, parameters).expect("valid");
    let mut generator = Pcg64::seed_from_u64(seed);
    let mut noisy = |value: f64| {
        let g: f64 = StandardNormal.sample(&mut generator);
        value * (0.01 * g).exp()
    };
    let omega: Vec<f64> = (0..50)
        .map(|i| 10_f64.powf(-2.5 + 0.1 * f64::from(i)))
        .collect();
    let moduli: Vec<(f64, f64)> = (omega.iter())
        .map(|&w| model.complex_modulus(w))
        .map(|m| (noisy(m.re), noisy(m.im)))
        .collect();
    let (storage, loss) = moduli.into_iter().unzip();
    Record::oscillation(omega, storage, loss).expect("valid")
}

/// 200 records a model by `CAMPAIGN_CASES=200`, and then each parameter by itself; 40 without, all parameters of a model together.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_truth_is_inside_nine_to_ninety_nine_of_a_hundred_intervals() {
    let cases = testkit::cases(40_u64);
    for (candidate, truth) in truths() {
        let mut inside = vec![0_u64; truth.len()];
        for seed in 0..cases {
            let found = one(&record(candidate, &truth, 1000 * seed + 7), candidate);
            for ((count, estimate), truth) in
                inside.iter_mut().zip(&found.fits[0].parameters).zip(&truth)
            {
                let (low, high) = (
                    estimate.low_95.expect("settled"),
                    estimate.high_95.expect("settled"),
                );
                assert!(
                    low < estimate.value && estimate.value < high,
                    "{estimate:?}"
                );
                *count += u64::from((low..=high).contains(truth));
            }
        }
        let share = |count: u64, of: u64| count as f64 / of as f64;
        println!("{}: {inside:?} of {cases}", candidate.name());
        let all = share(inside.iter().sum(), cases * truth.len() as u64);
        assert!((0.90..=0.99).contains(&all), "{}: {all}", candidate.name());
        if cases >= 200 {
            for count in inside {
                assert!(
                    (0.90..=0.99).contains(&share(count, cases)),
                    "{}: {count}",
                    candidate.name()
                );
            }
        }
    }
}

/// The bootstrap agrees with the standard errors where the noise is white, and does not depend on the number of threads.
#[test]
fn bootstrap_intervals_are_those_of_the_standard_errors_for_white_noise() {
    let (candidate, truth) = (ModelKind::FractionalMaxwell, [3e4, 0.7, 3e4, 0.15]);
    let record = record(candidate, &truth, 3);
    let plain = one(&record, candidate);
    let options = Options {
        candidates: vec![candidate],
        bootstrap: 300,
        ..Options::default()
    };
    let done = AtomicUsize::new(0);
    let count = |n: usize| {
        done.fetch_add(n, Ordering::Relaxed);
    };
    let drawn = identify(&record, &options, &count).expect("converges");
    assert_eq!(done.into_inner(), 300);
    for (plain, drawn) in plain.fits[0]
        .parameters
        .iter()
        .zip(&drawn.fits[0].parameters)
    {
        let width = |e: &haptic_tissue::identify::Estimate| {
            e.high_95.expect("there") - e.low_95.expect("there")
        };
        let ratio = width(drawn) / width(plain);
        assert!((0.8..1.2).contains(&ratio), "{}: {ratio}", plain.name);
    }
    assert_eq!(
        drawn,
        identify(&record, &options, &|_| ()).expect("converges")
    );
}

#[test]
fn a_stop_ends_an_identification() {
    let record = record(ModelKind::FractionalMaxwell, &[3e4, 0.7, 3e4, 0.15], 3);
    let options = Options {
        bootstrap: *Options::BOOTSTRAP_ALLOWED.end() as usize,
        ..Options::default()
    };
    let done = AtomicUsize::new(0);
    let stop = AtomicBool::new(false);
    let first = |n: usize| {
        done.fetch_add(n, Ordering::Relaxed);
        stop.store(true, Ordering::Relaxed);
    };
    let ended = identify_unless(&record, &options, &stop, &first);
    assert_eq!(ended, Err(IdentifyError::Stopped));
    assert!(done.into_inner() < options.bootstrap / 10);
    // Before the first start too.
    let never = |_: usize| panic!("stopped before");
    let ended = identify_unless(&record, &options, &stop, &never);
    assert_eq!(ended, Err(IdentifyError::Stopped));
}
