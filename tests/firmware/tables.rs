//! Tables that are kept in files: operators as lists for the target, instructions of a tick.

use super::{firmware, updating};
use fracdiff::portable::Form;
use fracdiff::{Operator, Order, Scheme, Seconds};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Change of a count that needs no new table.
const TOLERANCE: f64 = 0.05;
/// Instructions by which two builds of the same source differ: names of symbols hold the folder of the clone, and the order of functions
/// follows them. Seen: 8 on a path of 141.
const LAYOUT: f64 = 10.0;

/// Name, scheme, order, horizon in samples at 1 kHz.
const LISTED: [(&str, &str, f64, f64); 9] = [
    ("spring", "grunwald:1", 0.0, 2e5),
    ("grunwald:17", "grunwald:17", 0.5, 2e5),
    ("grunwald:256", "grunwald:256", 0.5, 2e5),
    ("muir:3", "muir:3", 0.5, 2e5),
    ("tustin-muir:9", "tustin-muir:9", 0.5, 2e5),
    ("oustaloup:9", "oustaloup:9:0.01:100", 0.5, 2e5),
    ("full 200 s", "full", 0.2247, 2e5),
    ("full 24 h", "full", 0.2247, 8.64e7),
    ("full 24 h, order 1.5", "full", 1.5, 8.64e7),
];

/// Name and horizon in samples of a model with two elements in series: fish muscle.
const MUSCLE: (&str, f64) = ("fractional Maxwell 200 s", 2e5);

/// Name and operator of each list.
fn listed() -> Vec<(&'static str, Operator<f32>)> {
    let scheme = |&(name, scheme, mu, horizon): &(&'static str, &str, f64, f64)| {
        let scheme: Scheme = scheme.parse().expect("valid");
        let order = Order::new(mu).expect("valid");
        let operator = scheme.build(order, Seconds(1e-3), horizon).expect("fits");
        (name, operator)
    };
    let (name, horizon) = MUSCLE;
    let muscle = super::muscle::operator(Seconds(1e-3), horizon);
    LISTED.iter().map(scheme).chain([(name, muscle)]).collect()
}

/// `firmware/tests/lists.txt`, made anew.
fn lists() -> String {
    let line = |(name, operator): (&str, Operator<f32>)| {
        let list = operator.list().expect("portable");
        let form = match list.form {
            Form::Taps => "taps",
            Form::Modes => "modes",
            Form::Recursion => "recursion",
        };
        let bits = list.values.iter().map(|value| value.to_bits());
        let bits: String = bits.map(|bits| format!(" {bits:08x}")).collect();
        format!("{name} | {form} | {} |{bits}\n", list.integer)
    };
    listed().into_iter().map(line).collect()
}

pub(crate) fn check_lists() {
    let path = firmware().join("tests/lists.txt");
    let want = lists();
    if updating() {
        std::fs::write(&path, &want).expect("writable");
    }
    let have = std::fs::read_to_string(&path).expect("readable");
    assert!(
        have == want,
        "{} is not what the schemes make: UPDATE_FIRMWARE_TABLES=1 cargo test --test firmware",
        path.display()
    );
    let compiled = super::lists::all().count();
    assert!(compiled == LISTED.len() + 1 || updating());
}

/// Names of controllers begin so.
pub(crate) const CONTROLLER: &str = "PI";
/// Robots in the table.
const ROBOTS: usize = 3;
/// Controllers in the table.
const CONTROLLERS: usize = 3;

/// Instructions of one operator or controller.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Count {
    /// The whole tick.
    pub(crate) tick: u32,
    /// Instructions from sensor to force.
    pub(crate) path: u32,
}

const HEADER: &str = "\
# Instructions of a tick on a Cortex-M4F, counted in QEMU, where each takes the same time: the longest of
# 400 ticks of a whole device (TickSide::tick: one-sided wall, safety chain, states, flight recorder, a
# sample for the host; with a map of the depth, as told, to 3 mm), and in it the path from the end of `read` to the start of `write`. Of a
# robot, behind its motion chain and a body that is a mass unless told, the path ends with its command. Of a controller, PI^λD^μ in f32 in
# the loop of a mass, the longest of 3200 ticks of its command and its history, and in it the command alone.
# A change of more than 5 %, and more than 10, has to be declared here: UPDATE_FIRMWARE_TABLES=1 cargo test --test firmware.

";

/// Compares with the table and returns what was counted.
pub(crate) fn check_instructions(printed: &BTreeMap<String, String>) -> BTreeMap<String, Count> {
    let counts: BTreeMap<String, Count> = printed
        .iter()
        .map(|(name, value)| {
            let numbers: Vec<u32> = value
                .split(' ')
                .map(|number| number.parse().expect("a number"))
                .collect();
            let [tick, path] = numbers[..] else {
                panic!("{name}: {value}");
            };
            (name.clone(), Count { tick, path })
        })
        .collect();
    // Each list and the muscle; one of them again behind the whole safety chain, with energy bounding and two maps; the robots; the controllers.
    let all = LISTED.len() + 5 + ROBOTS + CONTROLLERS;
    assert_eq!(counts.len(), all, "{printed:?}");
    let path = firmware().join("instructions.toml");
    if updating() {
        let mut text = HEADER.to_owned();
        for (name, Count { tick, path }) in &counts {
            writeln!(
                text,
                "\"{name}\" = {{ tick = {tick}, sensor_to_force = {path} }}"
            )
            .expect("a string");
        }
        std::fs::write(&path, text).expect("writable");
    }
    let table = std::fs::read_to_string(&path).expect("readable");
    let table: toml::Table = table.parse().expect("TOML");
    let mut wrong = String::new();
    for (name, count) in &counts {
        for (key, have) in [("tick", count.tick), ("sensor_to_force", count.path)] {
            let want = table
                .get(name)
                .and_then(|entry| entry.get(key))
                .and_then(toml::Value::as_integer);
            let agrees = want.is_some_and(|want| {
                let want = want as f64;
                (f64::from(have) - want).abs() <= (TOLERANCE * want).max(LAYOUT)
            });
            if !agrees {
                let _ = writeln!(wrong, "{name}, {key}: {have}, in the table {want:?}");
            }
        }
    }
    assert!(
        wrong.is_empty(),
        "{wrong}if that is meant: UPDATE_FIRMWARE_TABLES=1 cargo test --test firmware"
    );
    assert_eq!(
        table.len(),
        counts.len(),
        "an operator of the table is gone"
    );
    counts
}
