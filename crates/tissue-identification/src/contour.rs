//! The contour of `spring-pots` against closed forms and the library.

use super::elements::Candidate;
use haptic_tissue::{Model, ModelKind};
use spring_pots::{Contour, Elements, Quantity};

/// V, α and G, β: t₀ is 1 s, so aᵢ = ln Vᵢ.
const ELEMENTS_OF_TEST: [(f64, f64); 3] = [(876e3, 0.675), (22.1e3, 0.11), (900.0, 0.0)];

fn elements(parts: [(f64, f64); 3]) -> Elements {
    Elements {
        ln_modulus: parts.map(|e| libm::log(e.0)),
        order: parts.map(|e| e.1),
    }
}

fn relaxation((v, a): (f64, f64), t: f64) -> f64 {
    v * t.powf(-a) / libm::tgamma(1.0 - a)
}

fn compliance((v, a): (f64, f64), t: f64) -> f64 {
    t.powf(a) / (v * libm::tgamma(1.0 + a))
}

fn near(have: f64, want: f64) {
    assert!((have / want - 1.0).abs() < 1e-11, "{have} {want}");
}

/// Sums of power laws, whose closed forms need no Mittag-Leffler function, over twelve decades.
#[test]
fn sums_of_power_laws_are_met() {
    let parts = ELEMENTS_OF_TEST;
    for decade in -6..=6 {
        let t = 10_f64.powi(decade);
        let at = |kind, quantity| {
            let contour = Contour::new(Candidate::of(kind).joint(), quantity, elements(parts));
            contour.at(t.ln()).value
        };
        let pot = |quantity| at(ModelKind::SpringPot, quantity);
        near(pot(Quantity::Relaxation), relaxation(parts[0], t));
        near(pot(Quantity::Creep), compliance(parts[0], t));
        let integral = relaxation(parts[0], t) * t / (1.0 - parts[0].1);
        near(pot(Quantity::Integral), integral);
        let sum = |f: fn((f64, f64), f64) -> f64| f(parts[0], t) + f(parts[1], t);
        let parallel = at(ModelKind::FractionalKelvinVoigt, Quantity::Relaxation);
        near(parallel, sum(relaxation));
        let behind = at(ModelKind::FractionalMaxwell, Quantity::Creep);
        near(behind, sum(compliance));
    }
}

/// A spring and a dashpot in series: e^(−t/τ), until it is lost in rounding.
#[test]
fn a_classical_maxwell_model_decays_exponentially() {
    let parts = elements([(100.0, 1.0), (50.0, 0.0), (1.0, 0.0)]);
    let contour = Contour::new(
        Candidate::of(ModelKind::FractionalMaxwell).joint(),
        Quantity::Relaxation,
        parts,
    );
    for t in [1e-3, 0.1, 1.0, 5.0, 20.0_f64] {
        let error = contour.at(t.ln()).value - 50.0 * (-t / 2.0).exp();
        assert!(error.abs() < 1e-10, "{t}: {error}");
    }
}

/// The closed forms of the library, which are held against mpmath, for all models, ten decades around where their elements meet.
#[test]
fn the_closed_forms_of_the_library_are_met() {
    let parts = [(3e4, 0.7), (2e4, 0.15), (5e3, 0.0)];
    for candidate in Candidate::fractional() {
        let mut parameters = vec![parts[0].0, parts[0].1, parts[1].0, parts[1].1, parts[2].0];
        parameters.truncate(candidate.parameters());
        let model = Model::from_parameters(candidate.kind(), &parameters).expect("valid");
        for decade in -5..=5 {
            let t = 3.0 * 10_f64.powi(decade);
            let at = |quantity| {
                Contour::new(candidate.joint(), quantity, elements(parts))
                    .at(t.ln())
                    .value
            };
            near(at(Quantity::Relaxation), model.relaxation_moduli(&[t])[0]);
            near(at(Quantity::Creep), model.creep_compliances(&[t])[0]);
        }
    }
}

#[test]
fn derivatives_are_those_of_the_values() {
    const STEP: f64 = 1e-5;
    for candidate in Candidate::fractional() {
        for quantity in [Quantity::Relaxation, Quantity::Creep, Quantity::Integral] {
            let values = elements(ELEMENTS_OF_TEST).variables(candidate.joint());
            let at = |values: &[f64], ln_time: f64| {
                Contour::new(
                    candidate.joint(),
                    quantity,
                    Elements::from_variables(values),
                )
                .at(ln_time)
            };
            for ln_time in [-6.0, 0.3, 5.0] {
                let slope = at(&values, ln_time);
                for v in 0..values.len() {
                    let neighbours = [-STEP, STEP].map(|step| {
                        let mut values = values.clone();
                        values[v] += step;
                        at(&values, ln_time).value
                    });
                    let want = (neighbours[1] - neighbours[0]) / (2.0 * STEP);
                    let error = (slope.by[v] - want).abs();
                    assert!(
                        error <= 1e-8 * slope.value.abs(),
                        "{candidate:?} {quantity:?} {v}: {} {want}",
                        slope.by[v]
                    );
                }
            }
        }
    }
}
