//! Tissue that stiffens: the least sum of squares over b and the memory together, and the choice between memories.
#![expect(clippy::float_cmp, reason = "values of a list are compared")]

use super::{among, evenly, fit, largest, normal, said, values};
use haptic_loop::Specimen;
use haptic_tissue::{Model, ModelKind};
use testkit::{assert_relative, assert_says};
use tissue_identification::{Identification, Options, Record};

fn stiffened(record: &Record, candidates: &[ModelKind]) -> Identification {
    let options = Options {
        stiffening: true,
        ..among(candidates)
    };
    fit(record, &options)
}

/// V = Σsσ/Σs² of s = (exp(bε) − 1)/b, and the rms of what is left of all samples but the first, which is at rest.
fn elastic(b: f64, strain: &[f64], stress: &[f64]) -> (f64, f64) {
    let seen: Vec<f64> = strain.iter().map(|e| libm::expm1(b * e) / b).collect();
    let both = || seen.iter().zip(stress);
    let square: f64 = seen.iter().map(|s| s * s).sum();
    let modulus = both().map(|(s, stress)| s * stress).sum::<f64>() / square;
    let left = both().map(|(s, stress)| (modulus * s - stress) * (modulus * s - stress));
    (
        modulus,
        libm::sqrt(left.sum::<f64>() / (strain.len() - 1) as f64),
    )
}

/// b of the least rms, by the golden section.
fn least(strain: &[f64], stress: &[f64]) -> f64 {
    let (mut low, mut high, share) = (0.1_f64, 40.0_f64, 0.618_033_988_749_895);
    while high - low > 1e-9 {
        let [first, second] = [1.0 - share, share].map(|share| low + share * (high - low));
        if elastic(first, strain, stress).1 < elastic(second, strain, stress).1 {
            high = second;
        } else {
            low = first;
        }
    }
    low
}

/// Record in which compression is written below 0, in both columns.
#[test]
fn a_convex_record_of_two_negative_columns_is_turned() {
    let times = evenly(0.1, 51);
    let strain: Vec<f64> = times.iter().map(|t| 0.03 * t).collect();
    let stress: Vec<f64> = strain
        .iter()
        .map(|e| 2e3 / 9.0 * (9.0 * e).exp_m1())
        .collect();
    let turned = |values: &[f64]| values.iter().map(|value| -value).collect::<Vec<f64>>();
    let record = Record::history(times, turned(&strain), turned(&stress)).expect("valid");
    let found = stiffened(&record, &[ModelKind::Spring]);
    assert_relative("E", values(&found)[0], 2e3, 1e-3);
    assert_relative("b", values(&found)[1], 9.0, 1e-3);
    assert_says(&said(&found), "with the other sign");
}

/// A slow pull of tissue without memory, with an error that hangs together over the whole record: some four residuals of 150 are
/// independent, so no interval ends a search for the least sum early.
#[test]
fn the_least_sum_of_an_elastic_record_is_found_whatever_its_interval() {
    for (b, error, rate) in [(8.0, -0.05, 0.1), (15.0, -0.02, 0.1), (7.0, 0.02, 0.07)] {
        let times = evenly(0.4, 151);
        let strain: Vec<f64> = times.iter().map(|t| 0.173 * t / 60.0).collect();
        let most = libm::expm1(b * 0.173);
        let stress: Vec<f64> = (times.iter().zip(&strain))
            .map(|(t, e)| {
                3e5 / b * (libm::expm1(b * e) + error * most * libm::sin(rate * t) * t / 60.0)
            })
            .collect();
        let record = Record::history(times, strain.clone(), stress.clone()).expect("valid");
        let found = stiffened(&record, &[ModelKind::SpringPot]);
        let fit = &found.fits[0];
        let wanted = least(&strain, &stress);
        let (modulus, rms) = elastic(wanted, &strain, &stress);
        let have = fit.stiffening().expect("looked for").value;
        println!("b {have} {wanted}, rms {} {rms}", fit.rms);
        assert_eq!(fit.parameters[1].value.to_bits(), 0.0_f64.to_bits());
        assert_relative("b", have, wanted, 1e-4);
        assert_relative("V", fit.parameters[0].value, modulus, 1e-3);
        // The memory is interpolated within 1e-6 of the stress, of which the residuals are a hundredth.
        assert_relative("rms", fit.rms, rms, 1e-4);
        // The interval of the first reaches b = 0, but tissue that does not stiffen is not as good.
        let linear = elastic(1e-9, &strain, &stress).1;
        let message = said(&found);
        assert!(!message.contains("as good"), "{message}");
        let both = format!(
            "fits worse (rms residual {} Pa against {} Pa)",
            digits(linear),
            digits(rms)
        );
        assert_eq!(message.contains(&both), b == 8.0, "{both} {message}");
    }
}

/// Three digits.
fn digits(value: f64) -> f64 {
    format!("{value:.2e}").parse().expect("a number")
}

/// Two elements that stiffen, pressed by a sphere to three depths and held, with noise of 1 % of the largest force.
fn record(case: u64) -> (Record, ModelKind) {
    let pick = |values: [f64; 3], step: u64| values[(case / step % 3) as usize];
    let kinds = [
        ModelKind::FractionalKelvinVoigt,
        ModelKind::FractionalMaxwell,
    ];
    let kind = kinds[case as usize % 2];
    let sizes = [[2e3, 3e3], [8e3, 4e3]][case as usize % 2];
    let orders = [pick([0.6, 0.8, 0.5], 1), pick([0.15, 0.05, 0.25], 3)];
    let parameters = [sizes[0], orders[0], sizes[1], orders[1]];
    let model = Model::from_parameters(kind, &parameters).expect("valid");
    let specimen = |b: f64| Specimen::new(super::sphere(9.945e-3), 0.5, b).expect("valid");
    let (plain, stiff) = (specimen(0.0), specimen(pick([6.0, 12.0, 20.0], 2)));
    let map = stiff.depth_map().expect("a sphere");
    let shape = stiff.shape(stiff.loading().kind.modulus());
    let mut normal = normal(100 + case);
    let records = [1e-3, 2e-3, 3e-3].map(|depth| {
        // Straight between 20 times as many times.
        let fine: Vec<f64> = (0..=2000).map(|n| f64::from(n) / 200.0).collect();
        let depths: Vec<f64> = fine.iter().map(|t| depth * t.min(1.0)).collect();
        let seen: Vec<f64> = depths.iter().map(|depth| map.at(*depth)).collect();
        let forces = model.stress(&fine, &seen);
        let most = largest(&forces);
        let every = |values: &[f64]| values.iter().copied().step_by(20).collect::<Vec<f64>>();
        let noisy = every(&forces).into_iter();
        let noisy = noisy.map(|force| shape * (force + 0.01 * most * normal()));
        let forces = noisy.collect();
        Record::pressed(every(&fine), every(&depths), forces, &plain).expect("valid")
    });
    (Record::together(records.into()).expect("valid"), kind)
}

/// Every candidate converges, each at its own b, and the one with the least BIC of the table is chosen, or one with fewer
/// parameters within 2 of it.
fn chosen(cases: std::ops::Range<u64>) {
    let options = Options::default();
    for case in cases {
        let (record, kind) = record(case);
        let found = stiffened(&record, &options.candidates);
        // A sum of Maxwell elements has no stiffening.
        let single = options.candidates.iter().filter(|kind| !kind.is_sum());
        assert_eq!(found.fits.len(), single.count(), "{case}");
        let least = found
            .fits
            .iter()
            .map(|fit| fit.bic)
            .fold(f64::INFINITY, f64::min);
        let table: Vec<String> = (found.fits.iter())
            .map(|fit| {
                format!(
                    "{} {:.1} b {:.3}",
                    fit.kind,
                    fit.bic,
                    fit.parameters.last().expect("b").value
                )
            })
            .collect();
        println!("{case} {kind}: {}", table.join(", "));
        let message = said(&found);
        assert!(!message.contains("no minimum"), "{case}: {message}");
        assert!(found.fits[0].bic <= least + 2.0, "{case}: {table:?}");
        let candidate = found.fits.iter().find(|fit| fit.kind == kind);
        assert!(
            candidate.expect("a candidate").bic <= least + 10.0,
            "{case}: {table:?}"
        );
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_choice_is_that_of_the_table() {
    chosen(0..2);
}

#[test]
#[ignore = "by night: `.ci/nightly` does it"]
fn by_night_the_choice_is_that_of_the_table_for_two_dozen_tissues() {
    chosen(2..testkit::cases(26_u64));
}
