//! Any motion: the strain that really was.

use super::{candidate, evenly, largest, one, said, values};
use haptic_tissue::{Model, ModelKind};
use testkit::{Random, assert_close, assert_relative, assert_says};
use tissue_identification::Record;

/// A spring-pot under ramp and hold in closed form: σ = V·r·(t^(1−α) − (t − T₀)^(1−α))/Γ(2−α).
fn ramp_and_hold(times: &[f64], viscosity: f64, order: f64) -> (Vec<f64>, Vec<f64>) {
    let (held, ramp) = (0.05, 1.0);
    let rate = held / ramp;
    let power = |t: f64| if t > 0.0 { t.powf(1.0 - order) } else { 0.0 };
    let gamma = libm::tgamma(2.0 - order);
    let strain = times.iter().map(|&t| rate * t.min(ramp)).collect();
    let stress = times
        .iter()
        .map(|&t| viscosity * rate * (power(t) - power(t - ramp)) / gamma)
        .collect();
    (strain, stress)
}

/// The spring-pot that a record without noise is of.
fn assert_found(record: &Record, viscosity_pa_s_alpha: f64, order: f64) {
    let found = one(record, candidate("spring-pot"));
    let have = values(&found);
    assert!(
        (have[0] / viscosity_pa_s_alpha - 1.0).abs() < 1e-5 && (have[1] - order).abs() < 1e-5,
        "{have:?}"
    );
}

#[test]
fn a_finite_ramp_costs_nothing() {
    let times = evenly(0.01, 2001);
    let (strain, stress) = ramp_and_hold(&times, 8650.0, 0.2247);
    let record = Record::history(times.clone(), strain, stress.clone()).expect("valid");
    let largest = largest(&stress);
    let rms = one(&record, candidate("spring-pot")).fits[0].rms;
    assert!(rms < 1e-6 * largest, "{rms} of {largest}");
    assert_found(&record, 8650.0, 0.2247);
}

/// σ = E·ε + η·dε/dt of a cycle that begins with its speed or at rest: a quarter of the error with half the step.
#[test]
fn a_dashpot_has_the_slope_of_a_smooth_cycle_at_its_samples() {
    let (modulus, viscosity, omega) = (1000.0, 50.0, 2.0 * core::f64::consts::PI);
    for begins_at_rest in [false, true] {
        let wrong = |samples: u32| {
            let times: Vec<f64> = (0..=5 * samples)
                .map(|i| f64::from(i) / f64::from(samples))
                .collect();
            let (strain, rate): (Vec<f64>, Vec<f64>) = (times.iter())
                .map(|t| (omega * t).sin_cos())
                .map(|(sin, cos)| {
                    if begins_at_rest {
                        (0.025 * (1.0 - cos), 0.025 * omega * sin)
                    } else {
                        (0.05 * sin, 0.05 * omega * cos)
                    }
                })
                .unzip();
            let stress = strain
                .iter()
                .zip(&rate)
                .map(|(strain, rate)| modulus * strain + viscosity * rate);
            let stress = stress.collect();
            let record = Record::history(times, strain, stress).expect("valid");
            let found = one(&record, candidate("kelvin-voigt"));
            let have = values(&found);
            (have[0] / modulus - 1.0)
                .abs()
                .max((have[1] / viscosity - 1.0).abs())
        };
        let errors = [20, 40, 80].map(wrong);
        assert!(errors[1] < 5e-3, "{errors:?}");
        for pair in errors.windows(2) {
            assert!((3.0..5.0).contains(&(pair[0] / pair[1])), "{errors:?}");
        }
    }
}

/// A long record with a strain that never rests: some samples are compared, with the strain of all.
#[test]
fn a_long_record_is_thinned_but_not_its_strain() {
    let rate = 0.01;
    let times = evenly(1e-3, 30_001);
    // Strain t² has the stress 2·V·t^(2−α)/Γ(3−α).
    let strain = times.iter().map(|t| rate * t * t).collect();
    let gamma = libm::tgamma(3.0 - 0.3);
    let stress = times
        .iter()
        .map(|t| 2.0 * 5e3 * rate * t.powf(1.7) / gamma)
        .collect();
    let record = Record::history(times, strain, stress).expect("valid");
    let found = one(&record, candidate("spring-pot"));
    assert_relative("V", values(&found)[0], 5e3, 1e-4);
    assert_close("order", values(&found)[1], 0.3, 1e-4);
    assert!(found.x.len() < 2500, "{}", found.x.len());
    assert_says(&said(&found), "of 30001 samples");
}

/// Elastic tissue whose stress grows faster than its strain: any memory would bend the curve the other way, so the order is 0, and
/// V = Σεσ/Σε² in closed form.
#[test]
fn a_convex_record_is_an_elastic_one() {
    let (mut worst, mut all) = (0.0_f64, 0);
    for stiffening in [1.0, 3.0, 8.0, 20.0] {
        for samples in [30, 100, 300] {
            for deepest in [0.02, 0.1, 0.3] {
                let times: Vec<f64> = (0..=samples).map(|n| f64::from(n) / 30.0).collect();
                let strain: Vec<f64> = (0..=samples)
                    .map(|n| deepest * f64::from(n) / f64::from(samples))
                    .collect();
                let stress: Vec<f64> = (strain.iter())
                    .map(|e| 1e5 * libm::expm1(stiffening * e) / stiffening)
                    .collect();
                let both = strain.iter().zip(&stress);
                let (es, ee) = both.fold((0.0, 0.0), |sum, (e, s)| (sum.0 + e * s, sum.1 + e * e));
                let record = Record::history(times, strain, stress).expect("valid");
                let found = values(&one(&record, candidate("spring-pot")));
                assert_eq!(
                    found[1].to_bits(),
                    0.0_f64.to_bits(),
                    "{stiffening} {samples}"
                );
                worst = worst.max((found[0] * ee / es - 1.0).abs());
                all += 1;
            }
        }
    }
    println!("{all} records, worst {worst:.1e}");
    assert!(worst < 1e-5, "{worst}");
}

/// A hand presses a spring-pot: noise of its strain moves the fit, noise of the stress alone or a strain that is quiet does not.
#[test]
fn noise_of_the_strain_is_named_where_it_moves_a_parameter() {
    let gel = Model::from_parameters(ModelKind::SpringPot, &[2000.0, 0.5]).expect("valid");
    let times = evenly(0.02, 400);
    let by_hand = |t: &f64| 0.05 * (1.0 - (0.9 * t).cos()) + 0.01 * (3.1 * t).sin();
    let strain: Vec<f64> = times.iter().map(by_hand).collect();
    let stress = gel.stress(&times, &strain);
    for seed in 0..5 {
        for (of_strain, is_named) in [(0.0, false), (1e-5, false), (2e-4, true)] {
            let mut random = Random(seed);
            let mut noisy = |values: &[f64], size: f64| -> Vec<f64> {
                let noise = values.iter().map(|value| {
                    value + size * (0..12).map(|_| random.between(-0.5, 0.5)).sum::<f64>()
                });
                noise.collect()
            };
            let stress = noisy(&stress, 1.0);
            let mut strain = noisy(&strain, of_strain);
            strain[0] = 0.0;
            let record = Record::history(times.clone(), strain, stress);
            let found = one(&record.expect("valid"), candidate("spring-pot"));
            let named = found
                .warnings
                .iter()
                .find(|one| one.contains("strain has noise"));
            assert_eq!(
                named.is_some(),
                is_named,
                "{of_strain}: {:?}",
                found.warnings
            );
            if let Some(named) = named {
                println!("{named}");
                let size = named
                    .split("about ")
                    .nth(1)
                    .and_then(|rest| rest.split(',').next());
                let size: f64 = size.expect("a size").parse().expect("a number");
                assert_relative("noise", size, of_strain, 0.2);
            }
        }
    }
}
