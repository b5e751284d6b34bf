//! The self-test on devices that keep their promises and on devices that break one.
#![cfg(unix)]

mod bad_line;
mod board;
mod foreign;
mod late;

use board::{Board, Flaw};
use haptic_experiment::Failure;
use haptic_remote::serial::{ConnectOptions, SerialLink};
use haptic_selftest::{Attendant, EmergencyStop, Notice, Promise, SelfTest, SelfTestReport};
use std::sync::atomic::AtomicBool;

/// What a host sees of a device.
fn tested(
    connect: &dyn Fn() -> Result<SerialLink, Failure>,
    test: SelfTest,
    notice: &dyn Fn(Notice),
) -> SelfTestReport {
    let stop = AtomicBool::new(false);
    let attendant = Attendant {
        connect,
        notice,
        stop: &stop,
    };
    test.run(attendant).expect("the device is there")
}

/// What a host sees of the device at a port.
fn tested_at(path: &str, test: SelfTest, notice: &dyn Fn(Notice)) -> SelfTestReport {
    let options = ConnectOptions {
        patience: std::time::Duration::from_secs(20),
        ..ConnectOptions::default()
    };
    let connect = || SerialLink::connect(path, options).map_err(Failure::input);
    tested(&connect, test, notice)
}

/// The promises that a board with this flaw breaks.
fn broken(flaw: Flaw) -> (Vec<Promise>, SelfTestReport) {
    let board = Board::start(flaw);
    let report = tested_at(board.path(), SelfTest::DEFAULT, &|_| {});
    let checks: Vec<Promise> = report.checks.iter().map(|check| check.check).collect();
    assert_eq!(checks, Promise::ALL, "every promise has its row, in order");
    let wrong = report.checks.iter().filter(|check| check.ok == Some(false));
    (wrong.map(|check| check.check).collect(), report)
}

#[test]
fn a_good_device_keeps_every_promise_and_is_left_as_it_was() {
    let (wrong, report) = broken(Flaw::None);
    assert_eq!(wrong, [], "{report:#?}");
    assert!(report.holds && report.link_lost.is_none());
    // A simulated device has no emergency stop, and nothing is claimed of it.
    let last = report.checks.last().expect("a row");
    assert_eq!((last.ok, last.seen.as_str()), (None, "not there"));
    assert!((report.force_limit_n - 0.1).abs() < 1e-6);
}

#[test]
fn a_watchdog_that_does_not_let_go_is_seen() {
    let (wrong, report) = broken(Flaw::DeafWatchdog);
    // Without a fault there is nothing to record either.
    assert_eq!(
        wrong,
        [Promise::Watchdog, Promise::FlightRecorder],
        "{report:#?}"
    );
    assert_eq!(report.checks[4].seen, "no fault");
}

#[test]
fn a_limit_that_is_not_kept_is_seen() {
    let (wrong, report) = broken(Flaw::StrongForce);
    assert!(wrong.contains(&Promise::ForceLimit), "{report:#?}");
    assert!(
        report.checks[1].seen.starts_with("at most 0.2"),
        "{report:#?}"
    );
    assert!(!report.holds);
}

#[test]
fn a_force_before_it_is_armed_is_seen() {
    let (wrong, report) = broken(Flaw::ForceAtRest);
    assert!(wrong.contains(&Promise::Arm), "{report:#?}");
    assert!(wrong.contains(&Promise::Reconnect), "{report:#?}");
}

#[test]
fn a_force_that_stays_after_a_fault_or_stop_is_seen() {
    let (wrong, report) = broken(Flaw::ForceStays);
    for promise in [Promise::Stop, Promise::FiniteCheck, Promise::Watchdog] {
        assert!(wrong.contains(&promise), "{promise}: {report:#?}");
    }
}

#[test]
fn a_recorder_that_keeps_nothing_is_seen() {
    let (wrong, report) = broken(Flaw::NoRecorder);
    assert_eq!(wrong, [Promise::FlightRecorder], "{report:#?}");
}

#[test]
fn settings_that_a_connection_leaves_behind_are_seen() {
    let (wrong, report) = broken(Flaw::KeepsSettings);
    assert_eq!(wrong, [Promise::Reconnect], "{report:#?}");
    let seen = &report.checks[6].seen;
    assert!(seen.contains("settings are not those"), "{seen}");
}

#[test]
fn an_emergency_stop_is_pressed_and_released_by_somebody() {
    let board = Board::start(Flaw::None);
    let test = SelfTest {
        emergency_stop: EmergencyStop::Pressed,
        ..SelfTest::DEFAULT
    };
    let report = tested_at(board.path(), test, &|notice| match notice {
        Notice::PressEmergencyStop => board.open_stop(true),
        Notice::ReleaseEmergencyStop => board.open_stop(false),
        _ => {}
    });
    assert!(report.holds, "{report:#?}");
    let row = report.checks.last().expect("a row");
    assert_eq!(row.ok, Some(true), "{row:?}");
}

#[test]
fn a_device_that_is_unplugged_in_the_middle_ends_the_table_and_no_more() {
    let board = Board::start(Flaw::None);
    let report = tested_at(board.path(), SelfTest::DEFAULT, &|notice| {
        if notice == Notice::Trying(Promise::Watchdog) {
            board.unplug();
        }
    });
    assert!(!report.holds && report.link_lost.is_some(), "{report:#?}");
    let kept = report.checks.iter().filter(|check| check.ok == Some(true));
    assert_eq!(kept.count(), 4, "{report:#?}");
    assert_eq!(report.checks.len(), Promise::ALL.len());
    assert_eq!(report.checks[5].seen, "not reached");
}

#[test]
fn a_number_outside_its_range_is_refused_before_anything_is_asked() {
    for (test, words) in [
        (
            SelfTest {
                force_limit_n: 5.0,
                ..SelfTest::DEFAULT
            },
            "force_limit_n",
        ),
        (
            SelfTest {
                force_limit_n: f64::NAN,
                ..SelfTest::DEFAULT
            },
            "NaN",
        ),
        (
            SelfTest {
                watchdog_ms: 1,
                ..SelfTest::DEFAULT
            },
            "watchdog_s",
        ),
    ] {
        let stop = AtomicBool::new(false);
        let refused = test.run(Attendant {
            connect: &|| panic!("not asked"),
            notice: &|_| {},
            stop: &stop,
        });
        let error = refused.expect_err("refused");
        assert_eq!(error.exit_code(), 2);
        assert!(error.to_string().contains(words), "{error}");
    }
}
