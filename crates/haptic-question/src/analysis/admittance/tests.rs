//! A robot that moves, asked as a person asks.

use crate::analysis::admittance::best::candidates;
use crate::analysis::admittance::moving::MovingDevice;
use crate::analysis::{ADMITTANCE, Analysed};
use haptic_document::{Document, Failure};
use haptic_trial::device_table::with_devices;
use serde_json::Value;
use std::path::Path;
use std::sync::atomic::AtomicBool;

const ROBOT: &str =
    "sample_time_s = 0.002\nbandwidth_hz = 10\ndead_time_s = 0.004\nforce_cutoff_hz = 30\n";
const LIGHT: &str =
    "body_order = 0.8\nbody_inertance_n_s_mu_per_m = 1.16\nbody_damping_n_s_per_m = 1\n";
const HAND: &str = "hand_mass_kg = 1.5\nhand_damping_n_s_per_m = 20\n";

fn ask(keys: &str) -> Result<Analysed, Failure> {
    device(keys)?.answer(&|_| {}, &AtomicBool::new(false))
}

fn device(keys: &str) -> Result<MovingDevice, Failure> {
    let text = format!("[analyze-admittance]\n{keys}");
    let document = Document::of_text(Path::new("form"), &text);
    let document = document.parse()?;
    let (_, table, _) = document.one_of(&["analyze-admittance"], &[], "question", "one table")?;
    MovingDevice::of(&with_devices(table.with_keys(ADMITTANCE)?)?)
}

fn number(report: &Analysed, key: &str) -> f64 {
    report
        .report
        .get(key)
        .and_then(Value::as_f64)
        .expect("a number")
}

#[test]
fn a_body_that_is_stable_in_free_space_is_refused_for_a_soft_wall() {
    let free = ask(&format!(
        "{ROBOT}{LIGHT}{HAND}hand_stiffness_n_per_m = [0, 300]\n"
    ))
    .expect("an answer");
    assert_eq!(free.verdict(), "stable");
    // Theory 39: unstable for springs from 230 N/m to 10 kN/m in a hand of 300 N/m.
    let soft = ask(&format!(
        "{ROBOT}{LIGHT}{HAND}hand_stiffness_n_per_m = [0, 300]\nstiffness_n_per_m = 1000\n"
    ));
    let soft = soft.expect("an answer");
    assert_eq!(soft.verdict(), "not stable");
    let member = &soft.report["unstable_hand"];
    assert!(
        member["wall_stiffness_n_per_m"]
            .as_f64()
            .is_some_and(|k| (100.0..=1000.0).contains(&k)),
        "{member}"
    );
    assert!(number(&soft, "largest_spring_n_per_m") < 132.0);
}

#[test]
fn a_tissue_that_creeps_is_proved_down_to_rest() {
    // Towards rest its force falls as a power below 1, far above the damping of body and hand.
    let keys = "body_order = 0.7\nbody_inertance_n_s_mu_per_m = 4\nbody_damping_n_s_per_m = 0.5\ntissue = \"prostate-healthy\"\n";
    let found = ask(&format!("{ROBOT}{keys}")).expect("an answer");
    assert_eq!(found.verdict(), "stable");
}

#[test]
fn a_box_of_hands_has_its_largest_stiffness() {
    let keys = "body_order = 0.7\nbody_inertance_n_s_mu_per_m = 4\nbody_damping_n_s_per_m = 0.5\nhand_mass_kg = [0.5, 3]\nhand_damping_n_s_per_m = [5, 60]\n";
    let found = ask(&format!("{ROBOT}{keys}")).expect("an answer");
    assert_eq!(found.verdict(), "stable");
    let most = number(&found, "largest_hand_stiffness_n_per_m");
    assert!((most / 599.057 - 1.0).abs() < 1e-5, "{most}");
    // A body that is lighter than the least one is not proved.
    let least = number(&found, "least_body_factor");
    for (factor, verdict) in [(1.0, "stable"), (0.999, "not stable")] {
        let scaled = keys
            .replace("= 4", &format!("= {}", 4.0 * factor * least))
            .replace("= 0.5\nh", &format!("= {}\nh", 0.5 * factor * least));
        let found = ask(&format!("{ROBOT}{scaled}")).expect("an answer");
        assert_eq!(found.verdict(), verdict, "{factor} of {least}");
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn no_body_of_a_front_is_beaten_and_each_is_proved_for_its_hands() {
    let keys =
        format!("{ROBOT}{HAND}hand_stiffness_n_per_m = [0, 2000]\nbest = true\nfront = true\n");
    let found = ask(&keys).expect("a front");
    let front: Vec<Value> = found.report["front"].as_array().expect("bodies").clone();
    let of = |body: &Value, key: &str| body[key].as_f64().expect("a number");
    let merits = |body: &Value| {
        let keys = ["effort_n_s_per_m", "command_noise", "hand_margin"];
        let [effort, noise, margin] = keys.map(|key| of(body, key));
        [effort, noise, 1.0 / margin]
    };
    for (n, body) in front.iter().enumerate() {
        let mut others = front.iter().enumerate().filter(|(k, _)| *k != n);
        let beats = |other: &Value| merits(other).iter().zip(merits(body)).all(|(a, b)| *a <= b);
        assert!(!others.any(|(_, other)| beats(other)), "{body}");
        assert_eq!(body["settled"], true, "{body}");
        // Asked alone, in hands as much heavier as it is said to bear, it is proved.
        let margin = of(body, "hand_margin");
        let kind = match body["body_lag_s"].as_f64() {
            Some(lag) => format!("body_lag_s = {lag:?}"),
            None => format!("body_order = {:?}", of(body, "body_order")),
        };
        let keys = format!(
            "{ROBOT}{kind}\nbody_inertance_n_s_mu_per_m = {:?}\nbody_damping_n_s_per_m = {:?}\nhand_mass_kg = [1.5, {:?}]\n\
             hand_damping_n_s_per_m = [20, {:?}]\nhand_stiffness_n_per_m = [0, {:?}]\n",
            of(body, "body_inertance_n_s_mu_per_m"),
            of(body, "body_damping_n_s_per_m"),
            1.5 * margin,
            20.0 * margin,
            2000.0 * margin,
        );
        let around = device(&keys).expect("a device");
        let alone = around.body.as_ref().expect("a body");
        assert!(
            around.around.all(alone).expect("a box").is_proved(),
            "{keys}"
        );
    }
    // The best of all orders is one of them, as is the best lagged mass.
    let least = |is_lagged: bool| {
        let of_kind = front
            .iter()
            .filter(|body| body["body_lag_s"].is_null() != is_lagged);
        of_kind
            .map(|body| of(body, "effort_n_s_per_m"))
            .fold(f64::INFINITY, f64::min)
    };
    let candidates = found.report["candidates"].as_array().expect("bodies");
    let lagged = candidates.iter().find(|body| !body["body_lag_s"].is_null());
    assert!(least(true) <= of(lagged.expect("one"), "effort_n_s_per_m"));
    assert!(least(false) <= number(&found, "effort_n_s_per_m"));
    assert!(front.len() > 20 && front.iter().any(|body| of(body, "hand_margin") > 2.9));
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_best_bodies_need_what_theory_says() {
    // Hands of 1.5 kg and 20 N·s/m in free space: mass and damper, fractional, lagged mass, N·s/m.
    for (stiffness, mass, fractional, lagged) in
        [(2000.0, 5.56, 4.30, 2.63), (4000.0, 21.98, 10.4, 5.3)]
    {
        let keys = format!("{ROBOT}{HAND}hand_stiffness_n_per_m = [0, {stiffness}]\nbest = true\n");
        let around = device(&keys).expect("a device").around;
        let found = candidates(&around, 1.0, &|_| {}, &AtomicBool::new(false)).expect("bodies");
        let effort = |is_kind: &dyn Fn(f64, bool) -> bool| {
            let of_kind = found
                .iter()
                .filter(|(body, point)| is_kind(point.body_order, body.lag_s.is_some()));
            of_kind
                .map(|(_, point)| point.effort_n_s_per_m)
                .fold(f64::INFINITY, f64::min)
        };
        let is = |order: f64, of: f64| (order - of).abs() < 1e-9;
        for (have, want) in [
            (effort(&|order, lagged| is(order, 1.0) && !lagged), mass),
            (
                effort(&|order, lagged| !is(order, 1.0) && !lagged),
                fractional,
            ),
            (effort(&|_, lagged| lagged), lagged),
        ] {
            assert!(
                (have / want - 1.0).abs() < 0.03,
                "{stiffness}: {have} for {want}"
            );
        }
    }
}

/// Bandwidth Hz, damping ratio, dead time ms, corner of the force filter Hz, sample time ms; mass kg, damping N·s/m and largest stiffness N/m of
/// the hand: light and heavy cobots, joints with springs, a slow lift.
const ROBOTS: [[f64; 8]; 10] = [
    [10.0, 0.8, 4.0, 30.0, 2.0, 1.5, 20.0, 2000.0],
    [25.0, 0.7, 2.0, 100.0, 1.0, 1.0, 10.0, 1000.0],
    [5.0, 0.9, 8.0, 20.0, 4.0, 2.0, 30.0, 800.0],
    [40.0, 0.6, 1.0, 200.0, 1.0, 0.5, 5.0, 3000.0],
    [8.0, 0.7, 12.0, 50.0, 8.0, 1.5, 20.0, 500.0],
    [15.0, 1.0, 3.0, 15.0, 2.0, 3.0, 40.0, 1500.0],
    [12.0, 0.5, 6.0, 60.0, 2.0, 0.8, 8.0, 600.0],
    [3.0, 0.8, 20.0, 30.0, 10.0, 2.0, 20.0, 300.0],
    [20.0, 0.8, 10.0, 80.0, 1.0, 1.2, 15.0, 1000.0],
    [60.0, 0.7, 0.5, 300.0, 1.0, 1.0, 20.0, 5000.0],
];

/// C18, that the order buys effort at equal robustness: of least effort with a fifth more of the hands proved, and settled in trials.
///
/// Per robot, less effort than a mass and damper by an order below 1 and by one above 1; less than a lagged mass by any order.
const BUYS: [[bool; 3]; 10] = [
    [true, false, false],
    [false, true, true],
    [false, false, false],
    [true, false, false],
    [false, true, true],
    [false, true, false],
    [false, false, false],
    [true, false, false],
    [false, true, true],
    [false, true, true],
];

#[test]
#[ignore = "by night: `.ci/nightly` does it"]
fn by_night_the_order_buys_effort_on_some_robots_and_quiet_on_all() {
    for ([bandwidth, ratio, dead, cutoff, t, mass, damping, stiffest], buys) in
        ROBOTS.into_iter().zip(BUYS)
    {
        let keys = format!(
            "sample_time_s = {}\nbandwidth_hz = {bandwidth}\ndamping_ratio = {ratio}\ndead_time_s = {}\nforce_cutoff_hz = {cutoff}\n\
             hand_mass_kg = {mass}\nhand_damping_n_s_per_m = {damping}\nhand_stiffness_n_per_m = [0, {stiffest}]\nbest = true\n",
            1e-3 * t,
            1e-3 * dead
        );
        let around = device(&keys).expect("a device").around;
        let found = candidates(&around, 1.2, &|_| {}, &AtomicBool::new(false)).expect("bodies");
        let best = |is_kind: &dyn Fn(f64, Option<f64>) -> bool| {
            let settled = found.iter().map(|(_, point)| point);
            let settled = settled.filter(|point| point.settled == Some(true));
            let of_kind = settled.filter(|point| is_kind(point.body_order, point.body_lag_s));
            let least = of_kind.min_by(|a, b| a.effort_n_s_per_m.total_cmp(&b.effort_n_s_per_m));
            *least.expect("one that settles")
        };
        let plain = best(&|order, lag| (order - 1.0).abs() < 0.05 && lag.is_none());
        let below = best(&|order, lag| order < 0.95 && lag.is_none());
        let above = best(&|order, lag| order > 1.05 && lag.is_none());
        let lagged = best(&|_, lag| lag.is_some());
        let [of_plain, of_below, of_above, of_lagged] =
            [plain, below, above, lagged].map(|point| point.effort_n_s_per_m);
        println!("{bandwidth} Hz: {of_plain:.3} {of_below:.3} {of_above:.3} {of_lagged:.3} N·s/m");
        // What rounds to nothing buys nothing.
        let is_less = |one: f64, other: f64| one < 0.99 * other;
        let bought = [
            is_less(of_below, of_plain),
            is_less(of_above, of_plain),
            is_less(of_below.min(of_above), of_lagged),
        ];
        assert_eq!(bought, buys, "{bandwidth} Hz");
        let noise = below.command_noise.max(above.command_noise);
        assert!(lagged.command_noise > 1.5 * noise, "{bandwidth} Hz");
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_best_body_has_room_for_a_heavier_hand_and_settles() {
    let keys = format!("{ROBOT}{HAND}hand_stiffness_n_per_m = [0, 500]\nbest = true\n");
    let found = ask(&keys).expect("a body");
    assert_eq!(found.verdict(), "stable");
    assert_eq!(found.report["trials"], found.report["settled_trials"]);
    assert!(
        number(&found, "hand_up") >= 1.2,
        "{}",
        number(&found, "hand_up")
    );
    assert!(number(&found, "least_body_factor") < 1.0);
}

#[test]
fn what_is_no_robot_is_refused_in_a_line() {
    for (keys, words) in [
        ("bandwidth_hz = 10", "missing key `sample_time_s`"),
        ("sample_time_s = 0.002", "missing key `bandwidth_hz`"),
        (
            "sample_time_s = 0.002\nbandwidth_hz = 10",
            "missing key `dead_time_s`",
        ),
        (
            "sample_time_s = 0.002\nbandwidth_hz = 10\ndead_time_s = 0.004",
            "missing key `body_inertance_n_s_mu_per_m`",
        ),
        (
            "sample_time_s = 0.002\nbandwidth_hz = 10\ndead_time_s = 0.004\nbody_inertance_n_s_mu_per_m = 0",
            "a body of nothing moves without end",
        ),
        (
            "sample_time_s = 0.002\nbandwidth_hz = 10\ndead_time_s = 0.004\nbody_inertance_n_s_mu_per_m = 1\nbody_lag_s = 0.01\nbody_order = 0.5",
            "a lagged mass has order 1",
        ),
        (
            "sample_time_s = 0.002\nbandwidth_hz = 10\ndead_time_s = 0.004\nbody_inertance_n_s_mu_per_m = 1\nhand_mass_kg = [3, 1]",
            "the least and the largest",
        ),
        (
            "sample_time_s = 0.002\nbandwidth_hz = 10\ndead_time_s = 0.004\nbest = true\nbody_order = 0.5",
            "which looks for it",
        ),
        (
            "sample_time_s = 0.002\nbandwidth_hz = 10\ndead_time_s = 0.004\nforce_lags = 1",
            "no effect without",
        ),
        (
            "sample_time_s = 0.002\nbandwidth_hz = 10\ndead_time_s = 0.004\nbody_inertance_n_s_mu_per_m = 1\norder = 0.5",
            "of the dissipation of a wall",
        ),
        (
            "sample_time_s = 0.5\nbandwidth_hz = 10\ndead_time_s = 0.004",
            "half the sample rate",
        ),
    ] {
        let error = ask(keys).expect_err("refused").to_string();
        assert!(
            error.contains(words) && !error.contains('\n'),
            "{keys}: {error}"
        );
    }
}
