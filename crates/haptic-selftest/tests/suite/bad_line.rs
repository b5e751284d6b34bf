//! The self-test of a board on a line that loses, damages and repeats frames.

use crate::at_once::at_once;
use crate::board::{Board, Flaw};
use crate::tested;
use haptic_document::Failure;
use haptic_emulator::{LineDamage, LineFaults};
use haptic_selftest::SelfTest;

/// Lines; the promise is of 30, which `CAMPAIGN_CASES=30` tries in half a minute.
const LINES: u64 = 2;
/// Lines that are tried at the same time.
const AT_ONCE: usize = 5;
/// Chance that a frame is lost, of another that it is damaged, of a third that it comes twice.
const CHANCE: f64 = 0.01;
/// A greeting may be lost as often as it is said again; not so many in a row.
const GREETINGS: usize = 20;

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn whatever_a_bad_line_loses_every_promise_is_seen_to_be_kept() {
    let lines = std::env::var("CAMPAIGN_CASES").map_or(LINES, |cases| {
        cases.parse::<u64>().expect("a number").min(30)
    });
    let seeds: Vec<u64> = (0..lines).collect();
    for seeds in seeds.chunks(AT_ONCE) {
        at_once(seeds.iter().map(|&seed| {
            let case = move || every_promise_is_kept(seed);
            (format!("line {seed}"), case)
        }));
    }
}

fn every_promise_is_kept(seed: u64) {
    let faults = LineFaults {
        drop: CHANCE,
        corrupt: CHANCE,
        duplicate: CHANCE,
        ..LineFaults::default()
    };
    let board = Board::on_line(Flaw::None, faults, seed);
    let connect = || {
        let link = (1..GREETINGS).find_map(|_| board.greet().ok());
        link.map_or_else(|| board.greet(), Ok)
            .map_err(Failure::input)
    };
    let report = tested(&connect, SelfTest::DEFAULT, &|_| {});
    assert!(report.holds, "{report:#?}");
    for damage in board.damage() {
        let LineDamage {
            dropped, corrupted, ..
        } = damage;
        assert!(dropped > 0 && corrupted > 0, "{damage:?}");
    }
}
