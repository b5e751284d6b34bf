//! Models as one memory against the sums of their elements.

#![expect(clippy::float_cmp, reason = "exact results are compared exactly")]

use fracdiff::full_memory::{Design, Kernel, MemoryWeights};
use fracdiff::{Differintegrator, FrequencyResponse, FullMemory, Real, Seconds};
use haptic_tissue::{FullHistory, Model, ModelKind, SampledModel};
use testkit::assert_refused;
use testkit::tissue::{KINDS, model, of_two};

const T: Seconds = Seconds(1e-3);

fn sampled(model: &Model) -> SampledModel {
    SampledModel::new(model, T).expect("valid")
}

/// Every model with spring-pots, with a spring, with a dashpot, and classical.
fn models() -> Vec<(String, Model)> {
    let close = [
        ("nearly classical", 0.999, 0.001),
        ("nearly the same", 0.6, 0.599),
    ];
    testkit::tissue::models(876e3, 22.1e3, &[&KINDS[..], &close].concat())
}

/// The law of a sampled model, run in F.
fn law<F: Real>(model: &SampledModel, horizon: f64) -> impl FnMut(f64) -> f64 + use<F> {
    let design = model.design::<16, 112>(1e-6, horizon).expect("modes");
    let memory = FullMemory::<F, 16, 112>::new(&design, T).expect("valid");
    let mut history = memory.at_rest();
    let spring = F::from_f64(model.elastic_modulus_pa());
    let viscosity = F::from_f64(model.viscosity_pa_s_mu());
    move |strain| {
        let strain = F::from_f64(strain);
        (spring * strain + viscosity * memory.step(&mut history, strain)).to_f64()
    }
}

/// Without a spring-pot there is no slow rest: rounding once made one below 0, and refused the model.
#[test]
fn springs_and_dashpots_are_rendered_for_any_length() {
    for e in [1e4, 3e4] {
        for eta in [1e3, 2e3, 9e3] {
            let model = Model::from_parameters(ModelKind::Maxwell, &[e, eta]).expect("valid");
            for length in 1..40 {
                let horizon = 1.5e3 * f64::from(length);
                let design = sampled(&model).design::<16, 112>(1e-6, horizon);
                assert!(design.is_ok(), "{e} {eta} {horizon}: {design:?}");
            }
        }
    }
}

/// Models drawn at random, any motion: the error is a share of what is added up in magnitude, which is the stress of a
/// motion as long in one direction. More of them: `CAMPAIGN_CASES=200`.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn random_models_are_the_sums_of_their_elements() {
    let mut random = testkit::Random(13);
    let cases = testkit::cases(40);
    for case in 0..cases {
        let mut decades = |low: f64, high: f64| 10_f64.powf(random.between(low, high));
        let [v, g, elastic_modulus_pa] = [decades(2.0, 6.0), decades(2.0, 6.0), decades(2.0, 6.0)];
        let beta = random.between(0.0, 0.8);
        let first = (v, random.between(beta + 0.02, 1.0));
        let values = [first.0, first.1, g, beta, elastic_modulus_pa];
        let model = sampled(&of_two(case, values));
        let mut sums = FullHistory::new(&model, 3000).expect("valid");
        let mut one_way = sums.clone();
        let mut law = law::<f64>(&model, 1e5);
        let (mut x, mut moved) = (0.0, 0.0);
        for _ in 0..3000 {
            let last = x;
            x += random.between(-1e-3, 1e-3);
            moved += (x - last).abs();
            let most = one_way.step(moved);
            let (have, want) = (law(x), sums.step(x));
            assert!(
                (have - want).abs() <= 1.01e-6 * most,
                "{case}: {have:e} {want:e} {model:?}"
            );
        }
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn weights_are_the_power_series_of_the_recursion() {
    for (name, model) in models() {
        let model = sampled(&model);
        let weights = MemoryWeights::new(&model, 1e5).expect("smooth");
        // The stress of one increment of strain, that is, of a step.
        let mut sums = FullHistory::new(&model, 10_001).expect("valid");
        let scale = model.viscosity_pa_s_mu() * T.rate_to_the(model.order()).expect("valid");
        let first = weights.weight(0);
        for lag in 0..=10_000 {
            let want = (sums.step(1.0) - model.elastic_modulus_pa()) / scale;
            let have = weights.weight(lag);
            // The recursion itself has rounding errors of all it adds up.
            let most = 1e-10 * want + 1e-13 * (first + model.elastic_modulus_pa() / scale);
            assert!(
                (have - want).abs() <= most,
                "{name} {lag}: {have:e} {want:e}"
            );
        }
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_response_is_that_of_the_weights() {
    for (name, model) in models() {
        let model = sampled(&model);
        let design = model.design::<16, 112>(1e-9, 1e7).expect("modes");
        let memory = FullMemory::<f64, 16, 112>::new(&design, T).expect("valid");
        for theta in [1e-4, 1e-2, 0.3, 2.0, core::f64::consts::PI] {
            let (have, want) = (memory.response(theta), model.response(theta));
            let error = (have - want).norm() / want.norm();
            // Beyond the horizon the modes fade; at these frequencies that is felt little.
            assert!(error < 1e-6, "{name} at {theta}: {have} {want}, {error:e}");
        }
        assert_eq!(model.response(0.0).norm(), 0.0);
    }
}

#[test]
fn no_operator_gives_energy() {
    let mut random = testkit::Random(20_261_120);
    for (name, model) in models() {
        let model = sampled(&model);
        let design = model.design::<16, 112>(1e-6, 1e5).expect("modes");
        let memory = FullMemory::<f64, 16, 112>::new(&design, T).expect("valid");
        for k in 0..=1000 {
            let theta = core::f64::consts::PI * f64::from(k) / 1000.0;
            // Force over velocity: P/(1 − w).
            let slope = num_complex::Complex64::new(1.0 - theta.cos(), theta.sin());
            let real = (memory.response(theta) * slope.conj()).re;
            assert!(
                real >= -1e-12 * memory.response(theta).norm(),
                "{name} at {theta}: {real:e}"
            );
        }
        // To and fro at random, and back to the start.
        let (mut history, mut last, mut energy, mut stored) = (memory.at_rest(), 0.0, 0.0, 0.0);
        for _ in 0..20_000 {
            let x = random.between(-1.0, 1.0);
            let force = memory.step(&mut history, x);
            energy += force * (x - last);
            stored = f64::max(stored, energy);
            assert!(energy >= -1e-9 * stored, "{name}: {energy:e}");
            last = x;
        }
    }
}

#[test]
fn a_model_of_one_spring_pot_has_the_bits_of_its_kernel() {
    let order = fracdiff::Order::new(0.2247).expect("valid");
    let design = Design::<16, 112>::pruned(Kernel::Grunwald, order, 1e-6, 2.1e5).expect("modes");
    for model in [
        model(ModelKind::SpringPot, &[8650.0, 0.2247]),
        model(
            ModelKind::FractionalKelvinVoigt,
            &[8650.0, 0.2247, 700.0, 0.0],
        ),
    ] {
        let sampled = sampled(&model);
        assert_eq!(sampled.design(1e-6, 2.1e5).expect("modes"), design);
        assert_eq!(sampled.viscosity_pa_s_mu(), 8650.0);
    }
}

#[test]
fn what_cannot_be_sampled_is_refused() {
    let muscle = model(ModelKind::FractionalMaxwell, &[876e3, 0.675, 22.1e3, 0.11]);
    for t in [0.0, -1e-3, f64::NAN, 1e7] {
        assert_refused(SampledModel::new(&muscle, Seconds(t)), "sample_time_s");
    }
    let slow = model(ModelKind::SpringPot, &[1e3, 1e-7]);
    assert_refused(SampledModel::new(&slow, T), "at least 1e-6");
    let spring = sampled(&model(ModelKind::Spring, &[1e3]));
    assert_eq!(
        (spring.elastic_modulus_pa(), spring.viscosity_pa_s_mu()),
        (1e3, 0.0)
    );
    assert!(
        spring
            .design::<16, 8>(1e-6, 1e4)
            .expect("nothing")
            .modes()
            .is_empty()
    );
}
