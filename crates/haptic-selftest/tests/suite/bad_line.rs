//! The self-test of the emulated device on a line that loses, damages and repeats frames.

use crate::tested_at;
use haptic_remote::LineFaults;
use haptic_remote::emulator::{Emulation, Terminal, emulate};
use haptic_selftest::SelfTest;
use std::sync::atomic::{AtomicBool, Ordering};

/// Lines; the promise is of 30, which `CAMPAIGN_CASES=30` tries in three minutes.
const LINES: u64 = 2;

#[test]
fn whatever_a_bad_line_loses_every_promise_is_seen_to_be_kept() {
    let lines = std::env::var("CAMPAIGN_CASES").map_or(LINES, |cases| {
        cases.parse::<u64>().expect("a number").min(30)
    });
    for seed in 0..lines {
        let terminal = Terminal::open(None).expect("a pseudo-terminal");
        let chance = 0.01;
        let emulation = Emulation {
            speed: 1.0,
            faults: LineFaults {
                drop: chance,
                corrupt: chance,
                duplicate: chance,
                ..LineFaults::default()
            },
            seed,
            axes: 1,
            link: None,
            duration: None,
        };
        let over = AtomicBool::new(false);
        std::thread::scope(|scope| {
            let emulator = scope.spawn(|| emulate(&terminal, &emulation, &over));
            let path = terminal.path().display().to_string();
            let report = std::panic::catch_unwind(|| tested_at(&path, SelfTest::DEFAULT, &|_| {}));
            over.store(true, Ordering::Relaxed);
            let done = emulator.join().expect("no panic").expect("emulates");
            let report = report.expect("no panic");
            assert!(done.dropped > 0 && done.corrupted > 0, "{done:?}");
            assert!(report.holds, "line {seed}: {report:#?}");
        });
    }
}
