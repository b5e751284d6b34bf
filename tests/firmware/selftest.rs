//! The firmware keeps its promises: the self-test through the UART of the emulated device.

use super::board::Emulator;
use super::image::{Image, built};
use haptic_experiment::Failure;
use haptic_selftest::{Attendant, Check, SelfTest};
use std::sync::atomic::AtomicBool;
use testkit::skip;

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_firmware_keeps_what_it_promises() {
    let Some(images) = built() else { return };
    let emulator = Emulator::start(&images.path(Image::Device));
    let connect = || emulator.connected().map_err(Failure::input);
    let stop = AtomicBool::new(false);
    let attendant = Attendant {
        connect: &connect,
        notice: &|_| {},
        stop: &stop,
    };
    let test = SelfTest {
        // The emulated line takes bytes one by one.
        period_us: 4000,
        ..SelfTest::DEFAULT
    };
    let report = test.run(attendant).expect("it is there");
    for check in &report.checks {
        println!(
            "{:?} {}: {} / {}",
            check.ok, check.check, check.promised, check.seen
        );
    }
    assert_eq!(report.board, "mps2-an386");
    let late = |check: &&Check| check.not_judged && check.host_late;
    if let Some(late) = report.checks.iter().find(late) {
        // By the clock of an emulator that shares this machine; none of the others may be broken.
        let broken = report.checks.iter().any(|check| check.ok == Some(false));
        assert!(!broken, "{report:#?}");
        return skip(&format!("this machine was too busy: {}", late.seen));
    }
    assert!(report.holds, "{report:#?}");
}
