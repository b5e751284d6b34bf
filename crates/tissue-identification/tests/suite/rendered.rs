//! What the loop rendered is identified as what it was: its errors are those of sampling, no noise.

use super::{among, fit, largest, normal};
use fracdiff::Seconds;
use haptic_tissue::{FullHistory, Library, Model, ModelKind, SampledModel};
use testkit::{Random, assert_relative, tissue::model};
use tissue_identification::{Options, Record};

/// Record as `relax` imposes it: a ramp to 5 % in a second, then held until 4 s, of a tissue that is rendered at this sample time.
fn rendered(tissue: &Model, sample_time_s: f64) -> Record {
    relaxed(tissue, sample_time_s, 1.0, 4.0)
}

/// The full history before its first sample, and the times of all.
fn at_rest(tissue: &Model, sample_time_s: f64, count: usize) -> (FullHistory, Vec<f64>) {
    let sampled = SampledModel::new(tissue, Seconds(sample_time_s)).expect("valid");
    let history = FullHistory::new(&sampled, count + 1).expect("valid");
    let times = (0..=count).map(|n| n as f64 * sample_time_s).collect();
    (history, times)
}

fn relaxed(tissue: &Model, sample_time_s: f64, ramp_s: f64, duration_s: f64) -> Record {
    let count = (duration_s / sample_time_s) as usize;
    let (mut history, times) = at_rest(tissue, sample_time_s, count);
    let strains: Vec<f64> = times.iter().map(|t| 0.05 * (t / ramp_s).min(1.0)).collect();
    let stresses = strains.iter().map(|strain| history.step(*strain)).collect();
    Record::history(times, strains, stresses)
        .expect("valid")
        .of_own_log()
}

/// Record as `creep` imposes it: a stress from the first sample on.
fn crept(tissue: &Model, sample_time_s: f64, count: usize) -> Record {
    let (mut history, times) = at_rest(tissue, sample_time_s, count);
    let strains = times.iter().map(|_| {
        let strain = (100.0 - history.past()) / history.gain();
        history.advance(strain);
        strain
    });
    let strains = strains.collect();
    Record::creep_under(times, strains, vec![100.0; count + 1])
        .expect("valid")
        .of_own_log()
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn rendered_creep_is_of_the_model_that_crept() {
    for (kind, parameters) in [
        (ModelKind::SpringPot, &[20_000.0, 0.5][..]),
        (ModelKind::SpringPot, &[8650.0, 0.2247]),
        (ModelKind::Spring, &[5550.0]),
        (ModelKind::Dashpot, &[5000.0]),
        (ModelKind::FractionalMaxwell, &[876e3, 0.675, 22.1e3, 0.11]),
    ] {
        let candidates = [
            &FEWEST[..],
            &[ModelKind::Dashpot, ModelKind::FractionalMaxwell],
        ]
        .concat();
        let record = crept(&model(kind, parameters), 1e-3, 600);
        let found = fit(&record, &among(&candidates));
        let fit = &found.fits[0];
        assert_eq!(fit.kind, kind, "{parameters:?}: {:?}", fit.parameters);
        for (found, truth) in fit.parameters.iter().zip(parameters) {
            assert_relative(found.name, found.value, *truth, 0.02);
        }
    }
}

/// An instrument that samples evenly renders nothing: 24 records of its creep, with noise of 1e-5 of the largest strain.
#[test]
fn evenly_sampled_creep_of_others_is_not_rendered() {
    const NOISE: f64 = 1e-5;
    for number in 0..24 {
        let mut random = Random(number);
        let order = random.between(0.3, 0.6);
        let size = 10_f64.powf(random.between(3.0, 5.0));
        let [second, third] =
            [random.between(0.2, 2.0), random.between(0.1, 1.0)].map(|x| x * size);
        let (kind, parameters) = match number % 4 {
            0 => (
                ModelKind::FractionalMaxwell,
                vec![9.0 * size, 1.0, second, order],
            ),
            1 => (
                ModelKind::FractionalZener,
                vec![9.0 * size, 0.9, second, order, third],
            ),
            2 => (
                ModelKind::FractionalKelvinVoigt,
                vec![size, order, second, 0.1],
            ),
            _ => (
                ModelKind::FractionalMaxwell,
                vec![9.0 * size, 0.8, second, 0.1],
            ),
        };
        let times: Vec<f64> = (1..=50).map(|n| 0.5 * f64::from(n)).collect();
        let mut strains = model(kind, &parameters).creep_compliances(&times);
        let (mut normal, most) = (normal(number), largest(&strains));
        strains
            .iter_mut()
            .for_each(|strain| *strain += NOISE * most * normal());
        let record = Record::creep_under(times, strains, vec![1.0; 50]).expect("valid");
        let found = fit(&record, &Options::default());
        let best = &found.fits[0];
        let pairs = best.predicted.iter().zip(&found.measured);
        let squares: f64 = pairs
            .map(|(model, measured)| (model - measured).powi(2))
            .sum();
        let left = (squares / 50.0).sqrt() / most;
        assert!(
            left < 1.5 * NOISE,
            "{number} {kind}: {left:e} of {}",
            best.kind
        );
    }
}

const FEWEST: [ModelKind; 4] = [
    ModelKind::Spring,
    ModelKind::SpringPot,
    ModelKind::FractionalKelvinVoigt,
    ModelKind::FractionalZener,
];

/// Both leave less than any instrument tells, with as many parameters.
#[test]
fn of_models_with_the_same_bic_the_closest_comes_first() {
    let tissue = model(ModelKind::SpringPot, &[52.4, 0.2857]);
    let candidates = [
        ModelKind::FractionalZener,
        ModelKind::FractionalPoyntingThomson,
    ];
    let found = fit(&rendered(&tissue, 1e-3), &among(&candidates));
    let [first, second] = &found.fits[..] else {
        panic!("two fits: {found:?}");
    };
    assert_eq!(first.bic.to_bits(), second.bic.to_bits());
    assert!(first.rms < second.rms, "{} {}", first.rms, second.rms);
}

/// Every tissue of the library as `relax` imposes it, at two sample times and by few starts too: each is what it is, and each of all
/// candidates has a minimum.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn every_tissue_of_the_library_is_identified_as_what_it_is() {
    let library = Library::load(None).expect("built in");
    let ways = [(1e-3, 4.0, 40), (5e-3, 20.0, 4), (5e-3, 5.0, 4)];
    let all = library.materials().iter();
    let all = all.flat_map(|material| ways.map(|way| (material, way)));
    for (material, way) in all {
        let (sample_time_s, duration_s, starts) = way;
        let record = relaxed(&material.model, sample_time_s, 1.0, duration_s);
        let options = Options {
            starts,
            ..Options::default()
        };
        let found = fit(&record, &options);
        let name = &material.name;
        assert_eq!(found.fits[0].kind, material.model.kind(), "{name} {way:?}");
        // A sum of Maxwell elements is one only where the record shows its modes.
        let single = |kind: &ModelKind| !kind.is_sum();
        let wanted = options.candidates.iter().copied().filter(single).count();
        let fitted = found.fits.iter().map(|fit| fit.kind).filter(single).count();
        assert_eq!(fitted, wanted, "{name} {way:?}: {:?}", found.warnings);
    }
}
