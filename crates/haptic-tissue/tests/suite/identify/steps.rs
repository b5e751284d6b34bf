//! Steps of the stress of a creep between two rows: made records, from closed forms that need no library.

use super::{fit, normal};
use haptic_tissue::ModelKind;
use haptic_tissue::identify::{Options, Record};
use testkit::Random;

/// J of a model.
type Compliance = Box<dyn Fn(f64) -> f64>;

fn model(number: u64) -> (ModelKind, Vec<f64>, Compliance) {
    match number {
        0 => {
            let (v, a) = (5e3, 0.3);
            let j = move |t: f64| t.powf(a) / (v * libm::tgamma(1.0 + a));
            (ModelKind::SpringPot, vec![v, a], Box::new(j))
        }
        1 => {
            let (e, g, n) = (2e3, 3e3, 1.2e4);
            let time = n * (e + g) / (e * g);
            let j = move |t: f64| (1.0 - g / (e + g) * (-t / time).exp()) / e;
            (ModelKind::Zener, vec![e, g, n], Box::new(j))
        }
        2 => {
            let (e, n) = (2e3, 1e4);
            let j = move |t: f64| (1.0 - (-t * e / n).exp()) / e;
            (ModelKind::KelvinVoigt, vec![e, n], Box::new(j))
        }
        _ => {
            let (e, n) = (2e3, 5e4);
            let j = move |t: f64| 1.0 / e + t / n;
            (ModelKind::Maxwell, vec![e, n], Box::new(j))
        }
    }
}

/// Creep and recovery, also with some rows at rest before, whose steps are anywhere between two rows.
fn made(seed: u64) -> (Record, ModelKind, Vec<f64>) {
    let (mut random, mut draw) = (Random(seed), normal(seed));
    let (kind, truth, compliance) = model(seed % 4);
    let row_s = random.log_between(0.1, 1.0);
    let noise = random.log_between(1e-3, 2e-2);
    let rest = if random.chance(0.5) { 3 } else { 0 };
    let first_s = if rest > 0 {
        row_s * random.share()
    } else {
        0.0
    };
    let end_s = first_s + row_s * random.between(39.0, 40.0);
    let at = |t: f64| if t > 0.0 { 100.0 * compliance(t) } else { 0.0 };
    let most = at(end_s - first_s);
    let (mut times, mut strains, mut stresses) = (vec![], vec![], vec![]);
    for n in -rest..=100 {
        let t = row_s * f64::from(n);
        let quiet = if n <= -rest { 0.0 } else { noise * most };
        times.push(t);
        strains.push(at(t - first_s) - at(t - end_s) + quiet * draw());
        stresses.push(if t > first_s && t <= end_s {
            100.0
        } else {
            0.0
        });
    }
    let record = Record::creep_under(times, strains, stresses).expect("valid");
    (record, kind, truth)
}

#[test]
fn intervals_know_that_steps_are_between_two_rows() {
    let (mut held, mut all) = (0, 0);
    for seed in 0..60 {
        let (record, kind, truth) = made(seed);
        let options = Options {
            candidates: vec![kind],
            starts: 6,
            ..Options::default()
        };
        let found = fit(&record, &options);
        for (one, truth) in found.fits[0].parameters.iter().zip(&truth) {
            let [low, high] = [one.low_95, one.high_95].map(|end| end.expect("an end"));
            held += usize::from((low..=high).contains(truth));
            all += 1;
        }
        let warnings = found.warnings.concat();
        assert!(
            warnings.contains("taken where it most likely was"),
            "{warnings}"
        );
    }
    println!("{held} of {all} parameters");
    assert!(
        (93 * all..=97 * all).contains(&(100 * held)),
        "{held} of {all}"
    );
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_step_between_two_rows_is_no_element() {
    let is_right = |seed: &u64| {
        let (record, kind, _) = made(*seed);
        let options = Options {
            starts: 8,
            ..Options::default()
        };
        fit(&record, &options).fits[0].kind == kind
    };
    let right = (0..60).filter(is_right).count();
    println!("{right} of 60 models");
    assert!(right >= 56, "{right} of 60");
}
