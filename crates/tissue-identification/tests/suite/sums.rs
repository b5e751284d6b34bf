//! Sums of Maxwell elements found in records: how many, with which numbers, and what becomes of them.

use super::{fit, normal};
use haptic_tissue::{MeasuredLoading, Model, ModelKind, PronyFit};
use num_complex::Complex64;
use testkit::{assert_close, assert_relative};
use tissue_identification::{Options, Provenance, Record, Understood};

const JEFFREYS: [f64; 3] = [4e3, 4e3, 500.0];
const BURGERS: [f64; 5] = [0.0, 4e3, 0.5, 2e3, 20.0];
const THREE: [f64; 7] = [1e3, 5e3, 0.2, 2e3, 3.0, 2e3, 40.0];

fn times(low: f64, count: usize) -> Vec<f64> {
    (0..count)
        .map(|n| low * 10_f64.powf(4.0 * n as f64 / count as f64))
        .collect()
}

fn few_starts() -> Options {
    Options {
        starts: 6,
        ..Options::default()
    }
}

/// A record of each kind, with noise of this share.
fn record(kind: &str, model: &Model, noise: f64) -> Record {
    let mut draw = normal(11);
    let mut noisy = |values: Vec<f64>| -> Vec<f64> {
        let values = values.into_iter();
        values.map(|value| value * (noise * draw()).exp()).collect()
    };
    let times = times(0.02, 120);
    let valid = match kind {
        "relaxation" => {
            let moduli = noisy(model.relaxation_moduli(&times));
            Record::relaxation(times, moduli)
        }
        "creep" => {
            let compliances = noisy(model.creep_compliances(&times));
            Record::creep(times, compliances)
        }
        _ => {
            let moduli = times.iter().map(|omega| model.complex_modulus(*omega));
            let (storage, loss) = moduli.map(|modulus| (modulus.re, modulus.im)).unzip();
            Record::oscillation(times, noisy(storage), noisy(loss))
        }
    };
    valid.expect("a record")
}

fn model(kind: ModelKind, values: &[f64]) -> Model {
    Model::from_parameters(kind, values).expect("valid")
}

#[test]
fn a_sum_is_found_with_its_branches_and_makes_a_tissue_and_a_card() {
    for (kind, values, record_kind) in [
        (ModelKind::Prony, &BURGERS[..], "relaxation"),
        (ModelKind::Prony, &BURGERS, "creep"),
        (ModelKind::Prony, &BURGERS, "oscillation"),
        (ModelKind::Prony, &THREE, "relaxation"),
        (ModelKind::Prony, &THREE, "creep"),
        (ModelKind::Prony, &THREE, "oscillation"),
        (ModelKind::Jeffreys, &JEFFREYS, "creep"),
        (ModelKind::Jeffreys, &JEFFREYS, "oscillation"),
    ] {
        let name = format!("{kind} {values:?} {record_kind}");
        let record = record(record_kind, &model(kind, values), 1e-3);
        let found = fit(&record, &few_starts());
        let best = &found.fits[0];
        assert_eq!(best.kind, kind, "{name}: {:?}", found.warnings);
        let wanted: Vec<f64> = values.iter().copied().filter(|x| *x > 0.0).collect();
        assert_eq!(best.parameters.len(), wanted.len(), "{name}");
        for (estimate, wanted) in best.parameters.iter().zip(wanted) {
            let error = estimate.standard_error.expect("settled");
            // Of some forty numbers with fixed noise the farthest is 3 errors away.
            assert!(
                (estimate.value - wanted).abs() < 3.5 * error,
                "{name} {estimate:?}"
            );
            assert!(error < 0.05 * wanted, "{name} {estimate:?}");
        }
        let said = found.warnings.join(" ");
        assert!(!said.contains("another kind"), "{name}: {said}");
        assert_eq!(
            said.contains("Burgers"),
            values == BURGERS,
            "{name}: {said}"
        );
        let understood = Understood {
            record,
            loading: MeasuredLoading::default(),
            notes: Vec::new(),
            temperature_c: None,
        };
        let provenance = Provenance {
            program: "test",
            record: "made",
            conditions: None,
            date: "2026-11-30",
        };
        let tissue = found
            .tissue("made", &understood, provenance)
            .expect("a tissue");
        assert_eq!(tissue.model.kind(), kind, "{name}");
        let series = PronyFit::new(&tissue.model, 10, 0.02, 200.0);
        if kind == ModelKind::Jeffreys {
            assert!(series.is_err(), "{name}");
        } else {
            let error = series.expect("a series").max_relative_error;
            assert_close(&name, error, 0.0, 0.0);
        }
    }
}

#[test]
fn a_spring_pot_is_no_series_and_what_rings_is_no_sum() {
    let pot = model(ModelKind::SpringPot, &[3e3, 0.25]);
    for noise in [1e-4, 1e-2] {
        let found = fit(&record("relaxation", &pot, noise), &few_starts());
        assert_eq!(found.fits[0].kind, ModelKind::SpringPot, "{noise}");
    }
    let times = times(0.02, 120);
    let mut draw = normal(3);
    let moduli = times.iter().map(|t| {
        let ringing = 0.5 * (-0.1 * t).exp() * (3.0 * t).cos();
        3e3 * t.powf(-0.25) * (1.0 + ringing + 1e-3 * draw())
    });
    let moduli = moduli.collect();
    let found = fit(
        &Record::relaxation(times, moduli).expect("valid"),
        &few_starts(),
    );
    let said = found.warnings.join(" ");
    assert!(said.contains("does not describe the record"), "{said}");
}

/// M = η₀s + E·sτ/(1 + sτ), J = t/(η₀ + η) + J₁·(1 − e^(−rt)) with r = (1 + η/η₀)/τ, J₁ = (η/(η + η₀))²/E.
#[test]
fn a_jeffreys_model_has_its_closed_forms() {
    let [e, eta, beside] = JEFFREYS;
    let one = model(ModelKind::Jeffreys, &JEFFREYS);
    let tau = eta / e;
    for t in [0.0, 1e-3, 0.1, 1.0, 30.0] {
        let rate = (1.0 + eta / beside) / tau;
        let share = eta / (eta + beside);
        let crept = t / (beside + eta) + share * share / e * -(-rate * t).exp_m1();
        assert_relative(
            "J",
            one.creep_compliances(&[t])[0] + 1.0,
            crept + 1.0,
            1e-12,
        );
        let s = Complex64::new(0.0, t);
        let modulus = s * beside + s * tau / (s * tau + 1.0) * e;
        assert_close("M", (one.complex_modulus(t) - modulus).norm(), 0.0, 1e-9);
    }
    // A dashpot beside gives the stress of the rate.
    let (times, strain): (Vec<f64>, Vec<f64>) =
        (0..50).map(|n| 0.1 * f64::from(n)).map(|t| (t, t)).unzip();
    for (t, stress) in times.iter().zip(one.stress(&times, &strain)).skip(1) {
        assert_relative("ramp", stress, beside - eta * (-t / tau).exp_m1(), 1e-12);
    }
}
