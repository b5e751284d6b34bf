//! Specimens of one tissue: their mean and spread are those of the specimens, not of the fits.

use super::{among, candidate, normal};
use haptic_tissue::{Model, ModelKind};
use std::sync::atomic::AtomicBool;
use testkit::{assert_refused, assert_relative};
use tissue_identification::{IdentifyError, Options, Record, Replicates, replicates};

/// A spring-pot with noise of so much.
fn specimen(viscosity: f64, order: f64, noise: f64, seed: u64) -> Record {
    let mut normal = normal(seed);
    let model = Model::from_parameters(ModelKind::SpringPot, &[viscosity, order]).expect("valid");
    let times: Vec<f64> = (0..60).map(|n| 0.1 * 1.1_f64.powi(n)).collect();
    let moduli = model.relaxation_moduli(&times).into_iter();
    let moduli = moduli.map(|modulus| modulus * (noise * normal()).exp());
    let moduli = moduli.collect();
    Record::relaxation(times, moduli).expect("valid")
}

fn fitted(records: &[Record], options: &Options) -> Result<Replicates, IdentifyError> {
    replicates(records, options, &AtomicBool::new(false), &|_| ())
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_mean_and_the_spread_of_specimens_come_out() {
    let values = [(2000.0, 0.2), (2600.0, 0.22), (2300.0, 0.27)];
    let records = values.map(|(viscosity, order)| specimen(viscosity, order, 0.0, 0));
    let found = fitted(&records, &Options::default()).expect("fits");
    let fit = &found.all.fits[0];
    assert_eq!(
        (fit.kind, found.specimens.len()),
        (candidate("spring-pot"), 3)
    );
    // Mean 2300 and 0.23, s = 300 and √(0.0026/2), t of 2 degrees of freedom 4.3027.
    for (spread, [mean, deviation]) in found
        .spreads
        .iter()
        .zip([[2300.0, 300.0], [0.23, 0.0013_f64.sqrt()]])
    {
        assert_relative("mean", spread.mean.value, mean, 1e-6);
        assert_relative("s", spread.standard_deviation, deviation, 1e-5);
        assert_relative("between", spread.between, deviation, 1e-4);
        let error = spread.mean.standard_error.expect("one");
        assert_relative("s/√n", error, deviation / 3_f64.sqrt(), 1e-5);
    }
    let reach = 4.3027 * 300.0 / 3_f64.sqrt() / 2300.0;
    let mean = &found.spreads[0].mean;
    assert_relative(
        "low",
        mean.low_95.expect("bound"),
        2300.0 * (-reach).exp(),
        1e-4,
    );
    assert_relative(
        "high",
        mean.high_95.expect("bound"),
        2300.0 * reach.exp(),
        1e-4,
    );
    assert_eq!(fit.parameters[0], *mean);
    assert!(fit.is_settled() && fit.to_model().is_ok());
    assert_eq!(
        [
            found.all.x.len(),
            found.all.measured.len(),
            fit.predicted.len()
        ],
        [180; 3]
    );
    // Each specimen by its own parameters.
    assert!(fit.rms < 1e-6, "{}", fit.rms);
}

/// Specimens that are alike: the spread is that of the noise alone, and what is left for them is next to nothing.
#[test]
fn the_noise_of_fits_is_no_spread_of_specimens() {
    let alike: Vec<Record> = (0..60)
        .map(|seed| specimen(2000.0, 0.2, 0.05, seed))
        .collect();
    let found = fitted(&alike, &among(&[candidate("spring-pot")])).expect("fits");
    let spread = &found.spreads[0];
    // ln V = ln G + α·ln t + ln Γ(1 − α) of 60 samples in x = ln t: 0.05·√(1/60 + (x̄ − ψ(0.8))²/Σ(x − x̄)²) = 0.865 %, with
    // x̄ = 0.509, ψ(0.8) = −0.965 and Σ(x − x̄)²/60 = 2.724; s of 60 specimens is within a quarter of that.
    assert_relative("s", spread.standard_deviation, 17.3, 0.25);
    // What the fits leave of s² is within three of its standard errors, s²·√(2/59).
    let left = spread.between * spread.between;
    assert!(
        left < 0.55 * spread.standard_deviation.powi(2),
        "{spread:?}"
    );
    assert_relative("spread.mean.value", spread.mean.value, 2000.0, 0.005);
}

#[test]
fn what_is_no_replicate_is_refused_with_a_remedy() {
    let one = specimen(2000.0, 0.2, 0.0, 0);
    assert_refused(
        fitted(std::slice::from_ref(&one), &Options::default()),
        "`replicates` needs records of two specimens at least",
    );
    let creep = Record::creep(vec![1.0, 2.0, 3.0, 4.0], vec![1.0, 2.0, 3.0, 4.0]).expect("valid");
    assert_refused(
        fitted(&[one, creep], &Options::default()),
        "relaxation and creep",
    );
}
