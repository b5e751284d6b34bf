//! A tissue on one device that another presses, over bad lines: the numbers of its report.

use super::Indentation;
use crate::{
    experiment::bounded_tests::{conducted, defaults},
    judge::beginning::Beginning,
};
use core::f64::consts::PI;
use fracdiff::{Channel, Operator, Scheme, Seconds};
use haptic_emulator::LineFaults;
use haptic_judge::modelled_tissue::ModelledTissue;
use haptic_loop::plant::RigDrive;
use haptic_run::{Ran, remote::bad_line_tests::BadPair};
use haptic_tissue::{Material, ModelKind, Source};
use serde_json::Value;
use std::path::Path;
use testkit::{Folder, Random, cases};

/// A spring-pot, whose force depends on all of its past, for two seconds after the ramp.
fn relaxation() -> Indentation {
    let model = testkit::tissue::model(ModelKind::SpringPot, &[22.1e3, 0.3]);
    let gel = Material::new("gel", "a gel", model, Source::default()).expect("a name");
    let mut relaxation = defaults(ModelledTissue::new(gel).expect("sampled"));
    relaxation.scheme = "full:1e-8".parse().expect("a scheme");
    relaxation.duration_s = 3.0;
    relaxation
}

/// A run over these lines, which counts from no farther off the truth than it says, s.
fn ran(relaxation: &Indentation, faults: [LineFaults; 2], seed: u64, folder: &Path) -> (Ran, f64) {
    let RigDrive::Position(ramp) = relaxation.load else {
        panic!("a relaxation");
    };
    let exact: Scheme = "full:1e-9".parse().expect("a scheme");
    let order = relaxation.piece.material.order();
    let operator = exact.build::<f64>(order, Seconds(1e-3), 1e4);
    let mut device: Channel<f64, Operator<f64>> = Channel::new(operator.expect("an operator"));
    let (k, b) = relaxation.piece.spring_and_damper();
    let mut random = Random(seed);
    let pair = BadPair {
        faults,
        bits: &mut || random.bits(),
        samples: 3001,
        // The drive has felt for it before.
        place_m: &|since_s| {
            if (-0.25..-0.05).contains(&since_s) {
                0.02 * ramp.depth().0 * (5.0 * PI * (since_s + 0.25)).sin().powi(2)
            } else {
                ramp.position(since_s - 5e-3)
            }
        },
        force_n: &mut |place_m| {
            let force_n = k * place_m + b * device.output(place_m);
            device.advance(place_m);
            // It pushes only, and only what is in it.
            if place_m > 0.0 { force_n.max(0.0) } else { 0.0 }
        },
    };
    let (ran, late_s) = conducted(folder, |watched| pair.run(watched));
    let within_s = Beginning::of(&ran, 0.0).within_s;
    assert!(late_s.abs() <= within_s, "{seed}: {late_s} {within_s}");
    (ran, within_s)
}

fn reported(relaxation: &Indentation, ran: &Ran) -> Value {
    let (report, _) = relaxation.report(ran).expect("reports");
    serde_json::to_value(report).expect("is JSON")
}

fn number(report: &Value, key: &str) -> Option<f64> {
    report[key].as_f64()
}

/// Numbers that the beginning of a run moves, told as far as the clocks carry them.
const MOVED: [&str; 3] = ["final_over_theory", "rig_error", "closed_form_error"];

#[test]
fn over_quiet_lines_every_number_is_told_from_memory_and_from_the_log() {
    let relaxation = relaxation();
    let folder = Folder::empty();
    let (mut ran, within_s) = ran(&relaxation, Default::default(), 1, &folder);
    assert!(within_s < 1e-5, "{within_s}");
    assert!(!ran.record.approach.is_empty());
    let whole = reported(&relaxation, &ran);
    ran.record.whole = None;
    let logged = reported(&relaxation, &ran);
    for report in [&whole, &logged] {
        assert!(number(report, "max_relative_error").expect("told") < 1e-6);
        let over_theory = number(report, "final_over_theory").expect("told");
        assert!((over_theory - 1.0).abs() < 2e-3, "{over_theory}");
    }
    for key in MOVED {
        let [whole, logged] = [&whole, &logged].map(|report| number(report, key).expect(key));
        assert!((whole - logged).abs() < 1e-6, "{key}: {whole} {logged}");
    }
}

/// A line that stands still, now and then or at every byte, for so long.
fn bad(random: &mut Random) -> LineFaults {
    LineFaults {
        delay_s: random.or_nothing(0.01),
        stall: random.log_between(1e-4, 1.0),
        stall_s: random.log_between(1e-5, 1.5),
        ..LineFaults::default()
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn over_bad_lines_the_force_is_right_and_a_number_is_told_as_far_as_the_clocks_carry_it() {
    let relaxation = relaxation();
    let folder = Folder::empty();
    let (mut known, mut withheld) = ([0; 3], [0; 3]);
    for seed in 0..cases(20) {
        let random = &mut Random(seed);
        let faults = [bad(random), bad(random)];
        let (bad, _) = ran(&relaxation, faults, seed, &folder);
        let report = reported(&relaxation, &bad);
        let error = number(&report, "max_relative_error").expect("told");
        assert!(error < 1e-6, "{seed}: {error}");
        let (quiet, _) = ran(&relaxation, Default::default(), seed, &folder);
        let truth = reported(&relaxation, &quiet);
        let warnings = report["warnings"].to_string();
        for (n, key) in MOVED.into_iter().enumerate() {
            let truth = number(&truth, key).expect("its clocks tell");
            let have = number(&report, key);
            let is_right = match have {
                // The quiet clocks are right to a microsecond.
                Some(have) => (have - truth).abs() <= 0.1 * have + 2e-6,
                None => [key, "the clocks of both devices tell within"]
                    .iter()
                    .all(|words| warnings.contains(words)),
            };
            assert!(is_right, "{seed} {key}: {have:?} {truth} {warnings}");
            known[n] += u32::from(have.is_some());
            withheld[n] += u32::from(have.is_none());
        }
        assert!(
            !warnings.contains("the rig rig_error"),
            "{seed}: {warnings}"
        );
    }
    let both = known[0] > 0 && known[1] + known[2] > 0 && withheld.iter().all(|count| *count > 0);
    assert!(both, "{known:?} {withheld:?}");
}
