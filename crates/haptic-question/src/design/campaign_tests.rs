//! Random devices: each wall of a design passes at seeds and pushes that were not tried, and no wall of a grid is stiffer by 5 %.
//!
//! `CAMPAIGN_CASES` sets how many; 40 at night. `CAMPAIGN_FIRST` skips those before.

use crate::bench::BENCH;
use crate::design::bench::Bench;
use crate::design::search::{LONGEST, Try};
use crate::design::{DESIGN, WallDesign, reading};
use crate::one_table::read;
use fracdiff::Order;
use haptic_judge::pushed_trial::PushedTrial as _;
use haptic_judge::setup::Beside;
use haptic_judge::wall::wall;
use haptic_trial::device_table::dynamics;
use haptic_trial::keys::wall::WALL_TABLES;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, AtomicUsize};
use testkit::Random;

/// Walls on a side of the grid.
const GRID: u32 = 30;
/// Its orders.
const ORDERS: [f64; 5] = [0.0, 0.5, 1.0, 1.5, 2.0];
/// A wall of the grid may be stiffer by so much.
const NEAR: f64 = 1.05;

/// 20 g to 2 kg, 0.1 to 10 N·s/m, up to three samples of delay, an encoder of 1 to 100 µm, in every other case noise of the sensor, a hand's
/// spring, a limit of noise of 5 mN to 0.5 N, and in a third a wall that never pulls.
fn question(case: u64) -> WallDesign {
    let mut random = Random(0x6465_7369 + 7919 * case);
    let mut text = format!(
        "[design]\nmass_kg = {:e}\ndamping_n_s_per_m = {:e}\ndelay_s = {:e}\nencoder_resolution_m = {:e}\n",
        random.log_between(0.02, 2.0),
        random.log_between(0.1, 10.0),
        random.between(0.0, 3e-3),
        random.log_between(1e-6, 1e-4),
    );
    let mut some = |chance: f64, key: &str, value: f64| {
        if random.chance(chance) {
            text += &format!("{key} = {value:e}\n");
        }
    };
    let mut other = Random(0x6e6f_6973 + 7919 * case);
    some(
        0.5,
        "hand_stiffness_n_per_m",
        other.log_between(30.0, 2000.0),
    );
    some(0.5, "sensor_noise_m", other.log_between(3e-7, 1e-5));
    some(0.5, "force_noise_limit_n", other.log_between(5e-3, 0.5));
    if random.chance(1.0 / 3.0) {
        text += "one_sided = true\n";
    }
    asked(&text)
}

fn asked(text: &str) -> WallDesign {
    let keys = [("design", DESIGN), ("bench", BENCH)];
    read(text, ("design", &keys), |table| {
        reading::design(table, reading::wish(table)?)
    })
}

/// A wall of the grid that meets the requirement, is stiffer than this and passes all trials of a design: B/K is a time to the order,
/// of a twentieth of a sample to a hundred samples.
fn on_the_grid(design: &WallDesign, stiffest: f64) -> Option<String> {
    let t = design.device.plant.sample_time.0;
    let log = |low: f64, times: f64, n: u32| low * times.powf(f64::from(n) / f64::from(GRID - 1));
    let hardest = AtomicUsize::new(0);
    let wall = |(order, cell): (f64, u32)| {
        let order = Order::new(order).expect("an order");
        let bench = Bench::new(design, order).expect("an order");
        let time = log(t / 20.0, 2000.0, cell % GRID);
        let k = log(NEAR * stiffest, 10.0, cell / GRID);
        let law = (k, k * time.powf(order.get()));
        let units = (bench.law(1.0, 1.0).0, bench.law(1.0, 1.0).1);
        let allows = || {
            Ok(bench
                .allows(law.0 / units.0, law.1 / units.1)
                .expect("analysed"))
        };
        let limit_n = design.noise_limit_n();
        let outcome = design
            .outcome(order, law, LONGEST, limit_n, &hardest, allows)
            .expect("tried");
        (outcome.is_some_and(|one| one.passes)).then(|| format!("order {order}, {law:?}"))
    };
    let cells = ORDERS.map(|order| (0..GRID * GRID).map(move |cell| (order, cell)));
    let cells: Vec<_> = cells.into_iter().flatten().collect();
    cells.into_par_iter().find_map_first(wall)
}

/// All that is wrong with an answer.
fn wrong(design: &WallDesign, text: &str) -> Vec<String> {
    let wall = read(text, ("wall", WALL_TABLES), |table| {
        wall(table, Beside::default(), [None, None])
    });
    let law = (wall.stiffness_n_per_m, wall.dissipation_n_s_mu_per_m);
    let samples = wall.parts().expect("valid").samples;
    let analysis = wall.judge(samples, dynamics(&design.device.plant), 0);
    let mut wrong = Vec::new();
    let (stable, settling) = (
        analysis.expect("analysed").stable,
        wall.settled().expect("runs"),
    );
    if !(stable && settling.stable) {
        wrong.push(format!("its own file: {stable}, {settling:?}"));
    }
    let limit_n = design.noise_limit_n().unwrap_or(f64::INFINITY);
    let noisy = design.is_noisy();
    let mut all = 0;
    for push in [0.6, 0.95, 1.0, 1.5] {
        let mut loud = Vec::new();
        for n in 0..10 {
            let one = Try {
                push,
                seed: if noisy { 100 + n } else { 0 },
                moved: if noisy { 0.0 } else { f64::from(n) / 10.0 },
                ..Try::usual(LONGEST)
            };
            let settling = design.tried_once(wall.order, law, &one).expect("tried");
            if !settling.stable {
                wrong.push(format!("push {push}, {n}: {settling:?}"));
            }
            loud.extend(settling.noise_n.filter(|noise| *noise > limit_n));
            // Without noise the first is the push itself.
            if n == 0 && !noisy && !loud.is_empty() {
                wrong.push(format!("push {push} itself: {loud:?} N"));
            }
        }
        all += loud.len();
        // Nine of ten at each push; of places between two steps nine of ten in all.
        if all > 4 || noisy && loud.len() > 1 {
            wrong.push(format!("push {push}: {loud:?} N"));
        }
    }
    wrong
}

fn campaign(cases: std::ops::Range<u64>) {
    let answers = cases.map(|case| {
        let design = question(case);
        let begin = haptic_loop::realtime::Moment::now();
        let answer = design
            .answer(&AtomicBool::new(false), &|_| ())
            .expect("an answer");
        let took = begin.elapsed();
        let mut bad = Vec::new();
        if let Some(text) = &answer.experiment_text {
            bad = wrong(&design, text);
        }
        let best = answer.best.as_ref().and_then(|best| best.stiffness_n_per_m);
        // The softest of the grid where there is none.
        let stiffest = best.unwrap_or(1.0);
        bad.extend(on_the_grid(&design, stiffest).map(|wall| format!("{stiffest} N/m: {wall}")));
        println!(
            "case {case}: {best:?} N/m in {took:?}, all {:?}, {:?}, {bad:#?}",
            begin.elapsed(),
            answer.trials
        );
        bad.into_iter()
            .map(move |bad| format!("case {case}: {bad}"))
    });
    let bad: Vec<String> = answers.flatten().collect();
    assert!(bad.is_empty(), "{bad:#?}");
}

/// Walls that one trial called stable, or quiet enough: each fails at another push or seed, or with something in hand.
#[test]
fn walls_that_one_trial_takes_do_not_pass_all() {
    let device = |m: f64, b: f64, t: f64, delay: f64, step: f64, noise: f64| {
        asked(&format!(
            "[design]\nmass_kg = {m}\ndamping_n_s_per_m = {b}\nsample_time_s = {t}\ndelay_s = {delay}\n\
             encoder_resolution_m = {step}\nsensor_noise_m = {noise}\n"
        ))
    };
    let heavy = device(0.371_413_8, 0.775_455_6, 5e-4, 5e-4, 2.000_059e-5, 0.0);
    let noisy = device(
        0.092_036,
        1.336_534_3,
        5e-4,
        5e-4,
        2.788_606e-6,
        2.089_717e-6,
    );
    let coarse = device(0.12, 1.9, 5e-4, 2.5e-4, 7.2e-5, 1.4e-6);
    let usual = device(0.065, 3.5, 1e-3, 1e-3, 20e-6, 0.0);
    for (design, order, law, limit_n, passes) in [
        // It swings over 0.97 of 1 N, and is unstable at half the push.
        (&usual, 1.5, (9390.855, 0.609_774_2), None, false),
        // Over 0.94 of 0.5 N.
        (&heavy, 1.0, (10_832.397, 9.018_547), None, false),
        (&usual, 1.0, (2000.0, 3.0), Some(0.05), true),
        // Unstable at 24 of 30 seeds.
        (&noisy, 1.12, (19_100.48, 7.462_796_8), None, false),
        // 54 to 85 mN at other seeds.
        (&coarse, 0.5, (3516.79, 21.626_185), Some(0.05), false),
    ] {
        let order = Order::new(order).expect("an order");
        let outcome = design.outcome(order, law, LONGEST, limit_n, &AtomicUsize::new(0), || {
            Ok(true)
        });
        let outcome = outcome.expect("tried").expect("allowed");
        assert_eq!(outcome.passes, passes, "{law:?}: {outcome:?}");
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn what_is_designed_for_random_devices_runs_as_promised() {
    campaign(0..2);
}

/// A prototype of these trials, at one place between two encoder steps and with nothing in hand on the noise, ended near 3.4 and 4.3 kN/m.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_best_walls_of_two_devices_are_nearly_those_of_a_prototype() {
    for (device, want) in [
        (
            "mass_kg = 0.065\ndamping_n_s_per_m = 3.5\ndelay_s = 1e-3",
            3400.0,
        ),
        (
            "mass_kg = 0.371413819\ndamping_n_s_per_m = 0.775455619\nsample_time_s = 5e-4\ndelay_s = 5e-4\nforce_limit_n = 20",
            4300.0,
        ),
    ] {
        let text = format!("[design]\n{device}\nencoder_resolution_m = 20e-6\n");
        let answer = asked(&text).answer(&AtomicBool::new(false), &|_| ());
        let best = answer.expect("an answer").best.expect("a wall");
        let stiffness = best.stiffness_n_per_m.expect("is one");
        assert!((stiffness / want - 1.0).abs() < 0.05, "{stiffness} {want}");
    }
}

#[test]
#[ignore = "by night: `.ci/nightly` does it"]
fn by_night_what_is_designed_for_random_devices_runs_as_promised() {
    let first = std::env::var("CAMPAIGN_FIRST").map_or(0, |first| first.parse().expect("a number"));
    campaign(first..first + testkit::cases(40));
}
