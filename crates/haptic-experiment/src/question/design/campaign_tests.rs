//! Random devices: each wall of a design runs for 20 s as it was promised, and where there is none a grid has none.
//!
//! `CAMPAIGN_CASES` sets how many; 12 unless it is given, 200 at night. `CAMPAIGN_FIRST` skips those before.

use super::Design;
use super::bench::Bench;
use crate::ExperimentFile;
use crate::experiment::trial::{Trial as _, dynamics};
use crate::experiment::wall::WallExperiment;
use crate::question::{Asked, Question};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use testkit::Random;

/// Walls on a side of the grid.
const GRID: u32 = 50;

/// 20 g to 2 kg, 0.1 to 10 N·s/m, up to three samples of delay, an encoder of 1 to 100 µm, in every other case a hand's spring, in a third
/// a wall that never pulls; with a limit of noise of 5 mN to 0.5 N, or without.
fn question(case: u64, is_limited: bool) -> Design {
    let mut random = Random(0x6465_7369 + 7919 * case);
    let mut text = format!(
        "[design]\nmass_kg = {:e}\ndamping_n_s_per_m = {:e}\ndelay_s = {:e}\nencoder_resolution_m = {:e}\n",
        random.log_between(0.02, 2.0),
        random.log_between(0.1, 10.0),
        random.between(0.0, 3e-3),
        random.log_between(1e-6, 1e-4),
    );
    if random.chance(0.5) {
        text += &format!(
            "hand_stiffness_n_per_m = {:e}\n",
            random.log_between(30.0, 2000.0)
        );
    }
    if random.chance(1.0 / 3.0) {
        text += "one_sided = true\n";
    }
    let limit = random.log_between(5e-3, 0.5);
    if is_limited {
        text += &format!("force_noise_limit_n = {limit:e}\n");
    }
    match Question::parse(Path::new("form"), &text)
        .expect("a good question")
        .0
    {
        Asked::Design(design) => *design,
        Asked::ZWidth(_) | Asked::Coupler(_) => panic!("a wall was asked for"),
    }
}

/// A wall of the grid that meets the requirement and passes.
fn on_the_grid(design: &Design) -> Option<String> {
    let log =
        |low: f64, high: f64, n: u32| low * (high / low).powf(f64::from(n) / f64::from(GRID - 1));
    for order in &design.orders {
        let bench = Bench::new(design, *order).expect("an order");
        for cell in 0..GRID * GRID {
            let (alpha, beta) = (log(1e-6, 1.0, cell / GRID), log(1e-4, 2.0, cell % GRID));
            let (k, b) = bench.law(alpha, beta);
            let limit = design.force_noise_limit_n.unwrap_or(f64::INFINITY);
            let is_quiet = bench.force_noise_n(alpha, beta) <= limit;
            if is_quiet && bench.allows(alpha, beta).expect("analysed") {
                let tried = design.tried(*order, k, b).expect("tried");
                if design.passes(&tried.settling) {
                    return Some(format!("order {order}, {k} N/m, {b} N·s^μ/m"));
                }
            }
        }
    }
    None
}

/// The wall of a file, in a run of 20 s.
fn for_long(text: &str) -> WallExperiment {
    let line = |line: &str| match line.starts_with("duration_s") {
        true => "duration_s = 20.0".to_owned(),
        false => line.to_owned(),
    };
    let lines: Vec<String> = text.lines().map(line).collect();
    let file = ExperimentFile::parse(Path::new("design.toml"), &lines.join("\n"));
    let file = file.expect("is right");
    file.of::<WallExperiment>().expect("a wall").clone()
}

fn campaign(cases: std::ops::Range<u64>) {
    let (mut walls, mut none, mut weaker, mut bad, mut most) = (0, 0, 0, Vec::new(), 0.0_f64);
    for (case, is_limited) in cases.flat_map(|case| [(case, false), (case, true)]) {
        let design = question(case, is_limited);
        let answer = design
            .answer(&AtomicBool::new(false), &|_| ())
            .expect("an answer");
        let Some(text) = &answer.experiment_text else {
            none += 1;
            println!("case {case} {is_limited}: none, {:?}", answer.notes);
            bad.extend(on_the_grid(&design).map(|wall| format!("{case} {is_limited}: {wall}")));
            continue;
        };
        walls += 1;
        weaker += u32::from(!answer.notes.is_empty());
        let wall = for_long(text);
        let settling = wall.settled().expect("runs");
        let samples = wall.parts().expect("valid").samples;
        let analysis = wall.judge(samples, dynamics(&design.device.plant), 0);
        let over = settling.noise_n.unwrap_or(f64::INFINITY)
            / design.force_noise_limit_n.unwrap_or(f64::INFINITY);
        most = most.max(over);
        if !settling.stable || over > 1.0 || !analysis.expect("analysed").stable {
            println!("case {case} {is_limited}: not as promised");
            bad.push(format!("{case} {is_limited}: {over} {settling:?}\n{text}"));
        }
        println!("case {case} {is_limited}: {over:.3} {:?}", answer.notes);
    }
    println!(
        "{walls} walls, {weaker} not the first, noise at most {most:.4} of its limit, {none} without a wall, {} bad",
        bad.len()
    );
    assert!(bad.is_empty(), "{bad:#?}");
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn what_is_designed_for_random_devices_runs_as_promised() {
    campaign(0..4);
}

#[test]
#[ignore = "by night: `.ci/nightly` does it"]
fn by_night_what_is_designed_for_random_devices_runs_as_promised() {
    let first = std::env::var("CAMPAIGN_FIRST").map_or(0, |first| first.parse().expect("a number"));
    campaign(first..first + testkit::cases(200));
}
