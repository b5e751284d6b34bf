//! Records that are refused.

use super::{candidate, fit, one, said};
use haptic_tissue::ModelKind;
use testkit::{assert_refused, assert_relative, assert_says};
use tissue_identification::{Options, Record, identify};

/// The kind of a record, its columns, and what is said of them.
const REFUSED: &str = r"
    relaxation | 0 1 ; 2 1 | sample 1: time 0 s is not above 0 s
    relaxation | 1 -1 ; 2 1 | sample 2: time -1 s
    relaxation | 2 1 ; 2 1 | sample 2: time 1 s comes after 2 s and is not above it: sort
    relaxation | 1 2 ; 2 -1 | sample 2: modulus -1 Pa is not above 0 Pa
    relaxation | 1 2 ; 2 NaN | sample 2: modulus NaN Pa
    relaxation | 1 2 3 ; 2 2 2 | modulus is 2 Pa in every sample
    relaxation | 1 2 ; 2 | different lengths
    relaxation | ; | no sample
    relaxation | 1 2 4 ; 1 2 4 | the modulus grows with time
    creep | 1 2 4 ; 4 2 1 | the compliance falls with time
    oscillation | 1 2 ; 1 2 ; 1 0 | sample 2: loss modulus 0 Pa
    history | 0 1 2 ; 0 0 0 ; 0 1 2 | the strain stays at 0
    history | 0 1 2 ; 0.5 0.5 1 ; 0 1 2 | begins at 0.5, not at 0
    history | 0 1 2 ; 0 0.5 1 ; 1 1 1 | the stress is 1 Pa in every sample
    history | 0 1 2 ; 0 0.5 inf ; 1 1 1 | sample 3
    # A compression whose strain is told as negative and stress as positive.
    history | 0 1 2 ; 0 -0.5 -1 ; 0 1 2 | strain and stress have opposite signs
";

#[test]
fn a_bad_record_is_refused_with_its_sample_and_the_remedy() {
    for [kind, columns, wanted] in testkit::table(REFUSED) {
        let columns = columns.split(';').map(|column| -> Vec<f64> {
            let cells = column.split_whitespace();
            cells.map(|cell| cell.parse().expect("a number")).collect()
        });
        let columns: Vec<Vec<f64>> = columns.collect();
        let record = match (kind.as_str(), &columns[..]) {
            ("relaxation", [x, y]) => Record::relaxation(x.clone(), y.clone()),
            ("creep", [x, y]) => Record::creep(x.clone(), y.clone()),
            ("oscillation", [x, y, z]) => Record::oscillation(x.clone(), y.clone(), z.clone()),
            (_, [x, y, z]) => Record::history(x.clone(), y.clone(), z.clone()),
            _ => panic!("{kind} {columns:?}"),
        };
        assert_refused(record, &wanted);
    }
}

/// n > k + 1, where k counts the noise: below that the criterion of small samples says nothing.
#[test]
fn a_record_without_a_number_to_spare_is_too_short_for_a_model() {
    let few = |count: usize| {
        let modulus = [4.0, 3.3, 2.6, 2.2, 1.7, 1.5, 1.2];
        let time = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0];
        Record::relaxation(time[..count].to_vec(), modulus[..count].to_vec()).expect("valid")
    };
    let options = Options {
        chosen: Some(ModelKind::FractionalMaxwell),
        ..Options::default()
    };
    assert_refused(
        identify(&few(5), &options, &|_| ()),
        "5 numbers are too few for fractional-maxwell: give at least 7",
    );
    // What the smallest model needs.
    assert_refused(
        identify(&few(3), &Options::default(), &|_| ()),
        "3 numbers are too few for spring: give at least 4",
    );
    // The others are no reason to refuse what can be fitted, but are named.
    let found = fit(&few(7), &Options::default());
    assert_eq!(found.fits[0].kind, ModelKind::SpringPot);
    let short = |words: &&String| words.contains("too few");
    assert_eq!(found.warnings.iter().filter(short).count(), 2);
}

/// Kelvin–Voigt by frequency, E = 5 kPa and η = 200 Pa·s, with 3 % of noise that a generator draws.
fn kelvin_voigt_sweep(seed: u64) -> Record {
    let mut state = seed;
    let mut noise = || {
        let mut sum = -6.0;
        for _ in 0..12 {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            sum += (state >> 11) as f64 / (1_u64 << 53) as f64;
        }
        1.0 + 0.03 * sum
    };
    let omega: Vec<f64> = (0..40)
        .map(|i| 0.1 * 10_f64.powf(f64::from(i) / 10.0))
        .collect();
    let storage = omega.iter().map(|_| 5000.0 * noise()).collect();
    let loss = omega.iter().map(|w| 200.0 * w * noise()).collect();
    Record::oscillation(omega, storage, loss).expect("valid")
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_parameter_at_the_end_of_its_range_makes_no_model_better() {
    let mut right = 0;
    for seed in 1..=20 {
        let found = identify(&kelvin_voigt_sweep(seed), &Options::default(), &|_| ());
        let chosen = &found.expect("fits").fits[0];
        assert!(
            chosen.is_settled() && chosen.to_model().is_ok(),
            "{seed}: {chosen:?}"
        );
        right += usize::from(chosen.kind.name() == "kelvin-voigt");
    }
    // BIC takes a needless parameter for noise in some 4 of 100 records; two models have one more.
    assert!(right >= 18, "{right} of 20");
}

#[test]
fn orders_next_to_whole_ones_become_springs_and_dashpots() {
    let omega: Vec<f64> = (0..40)
        .map(|i| 0.1 * 10_f64.powf(f64::from(i) / 10.0))
        .collect();
    let storage = omega
        .iter()
        .map(|w| 5000.0 * (1.0 + 1e-3 * (7.0 * w).sin()))
        .collect();
    let loss = omega.iter().map(|w| 200.0 * w).collect();
    let record = Record::oscillation(omega, storage, loss).expect("valid");
    let found = one(&record, candidate("fractional-kelvin-voigt"));
    let model = found.fits[0].to_model().expect("a model");
    assert_eq!(model.kind().name(), "kelvin-voigt", "{:?}", found.fits[0]);
}

/// A rheometer that rings for the first half of a creep test, by so much; white noise as large is none of it.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_record_that_no_model_describes_is_said_to_be_one() {
    let times: Vec<f64> = (1..=400).map(|n| 0.005 * f64::from(n)).collect();
    let compliance = |left: &dyn Fn(f64, usize) -> f64| {
        let at = times.iter().enumerate();
        at.map(|(n, &t)| 1e-3 * t.powf(0.2) * left(t, n).exp())
            .collect()
    };
    let rings = |t: f64, _: usize| 0.6 * (-t).exp() * (20.0 * t).sin();
    // Of a low-discrepancy sequence: as even as noise, and as unlike its neighbours.
    let noisy = |_: f64, n: usize| (n as f64 * 0.618_033_988_749_895).fract() - 0.5;
    let warned = |compliance: Vec<f64>| {
        let record = Record::creep(times.clone(), compliance).expect("a record");
        let found = fit(&record, &Options::default());
        let warning = found
            .warnings
            .into_iter()
            .find(|words| words.contains("does not describe"));
        println!("{} {warning:?}", found.fits[0].rms);
        assert!(found.fits[0].rms > 0.1);
        warning
    };
    let words = warned(compliance(&rings)).expect("a warning");
    assert!(
        words.contains("it leaves ") && words.ends_with("with `from_s`"),
        "{words}"
    );
    assert_eq!(warned(compliance(&noisy)), None);
}

/// 1000 Pa·e^(−t) over a hundred time constants: beyond 1e-9 of it there is nothing to measure.
#[test]
fn a_modulus_that_has_decayed_to_rounding_does_not_count() {
    for even in [true, false] {
        let times: Vec<f64> = (1..=400)
            .map(|n| {
                if even {
                    0.25 * f64::from(n)
                } else {
                    1e-2 * 1e4_f64.powf(f64::from(n) / 400.0)
                }
            })
            .collect();
        let moduli = times.iter().map(|t| 1000.0 * libm::exp(-t)).collect();
        let record = Record::relaxation(times, moduli).expect("valid");
        let found = fit(&record, &Options::default());
        let fit = &found.fits[0];
        assert_eq!(fit.kind, ModelKind::Maxwell);
        for estimate in &fit.parameters {
            assert_relative(estimate.name, estimate.value, 1000.0, 1e-6);
        }
        assert_says(&said(&found), "below 1e-9 of the largest modulus");
    }
}
