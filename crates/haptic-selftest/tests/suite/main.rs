//! The self-test on devices that keep their promises and on devices that break one.
#![cfg(unix)]

mod at_once;
mod axes;
mod bad_line;
mod board;
mod foreign;
mod late;

use at_once::at_once;
use board::{Board, Flaw};
use haptic_document::Failure;
use haptic_remote::serial::SerialLink;
use haptic_selftest::{Attendant, EmergencyStop, Notice, Promise, SelfTest, SelfTestReport};
use std::cell::RefCell;
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

/// Functions with their names.
macro_rules! named {
    ($($case:path),* $(,)?) => {
        [$((stringify!($case), Box::new($case) as Box<dyn FnOnce() + Send>)),*]
    };
}

/// A flaw, the promises that a board with it breaks, if it breaks no others, and words in the row of the first.
const FLAWS: [(Flaw, &[Promise], bool, &str); 7] = [
    (
        // Without a fault nothing was recorded: the recorder is not judged.
        Flaw::DeafWatchdog,
        &[Promise::Watchdog],
        true,
        "no fault",
    ),
    (
        Flaw::StrongForce,
        &[Promise::ForceLimit],
        false,
        "at most 0.2",
    ),
    (
        Flaw::ForceAtRest,
        &[Promise::Arm, Promise::Reconnect],
        false,
        "0.05 N",
    ),
    (
        Flaw::ForceStays,
        &[Promise::Stop, Promise::FiniteCheck, Promise::Watchdog],
        false,
        "",
    ),
    (
        Flaw::Reversed,
        &[Promise::Direction],
        true,
        "against its force: try again",
    ),
    (Flaw::NoRecorder, &[Promise::FlightRecorder], true, ""),
    (
        Flaw::KeepsSettings,
        &[Promise::Reconnect],
        true,
        "settings are not those",
    ),
];

fn a_flaw_is_seen((flaw, promises, no_others, words): (Flaw, &[Promise], bool, &str)) {
    let (wrong, report) = broken(flaw);
    for promise in promises {
        assert!(wrong.contains(promise), "{promise}: {report:#?}");
    }
    assert!(
        !report.holds && (!no_others || wrong == promises),
        "{report:#?}"
    );
    let mut rows = report.checks.iter();
    let row = rows
        .find(|check| check.check == promises[0])
        .expect("a row");
    assert!(row.seen.contains(words), "{row:?}");
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn what_each_device_keeps_and_breaks_is_seen() {
    let cases = named![
        a_good_device_keeps_every_promise_and_is_left_as_it_was,
        an_emergency_stop_is_pressed_and_released_by_somebody,
        a_device_that_is_unplugged_in_the_middle_ends_the_table_and_no_more,
        an_emergency_stop_during_another_check_ends_the_test,
        a_device_that_brakes_keeps_every_promise,
        a_limit_of_the_device_breaks_no_promise,
        foreign::a_2diy_keeps_every_promise,
        foreign::a_servo_keeps_every_promise,
        late::a_host_that_was_late_once_tries_again_and_judges,
        late::a_host_that_is_always_late_judges_nothing_that_it_was_too_late_for,
        late::an_adapter_that_goes_away_is_a_link_that_is_lost,
        late::a_silence_of_a_device_that_answers_again_is_tried_again,
    ];
    let cases = cases.map(|(name, case)| (name.to_owned(), case));
    let flaws = FLAWS.map(|flaw| {
        let case: Box<dyn FnOnce() + Send> = Box::new(move || a_flaw_is_seen(flaw));
        (format!("{:?}", flaw.0), case)
    });
    at_once(cases.into_iter().chain(flaws));
}

/// The promises that a board with this flaw breaks.
fn broken(flaw: Flaw) -> (Vec<Promise>, SelfTestReport) {
    let board = Board::start(flaw);
    let report = tested(&|| board.connect(), SelfTest::DEFAULT, &|_| {});
    let checks: Vec<Promise> = report.checks.iter().map(|check| check.check).collect();
    assert_eq!(checks, Promise::ALL, "every promise has its row, in order");
    let wrong = report.checks.iter().filter(|check| check.ok == Some(false));
    (wrong.map(|check| check.check).collect(), report)
}

fn a_good_device_keeps_every_promise_and_is_left_as_it_was() {
    let (wrong, report) = broken(Flaw::None);
    assert_eq!(wrong, [], "{report:#?}");
    assert!(report.holds && report.link_lost.is_none());
    // A simulated device has no emergency stop, and nothing is claimed of it.
    let last = report.checks.last().expect("a row");
    assert_eq!((last.ok, last.seen.as_str()), (None, "not there"));
    assert!((report.force_limit_n - 0.1).abs() < 1e-6);
}

fn an_emergency_stop_is_pressed_and_released_by_somebody() {
    let board = Board::start(Flaw::None);
    let test = SelfTest {
        emergency_stop: EmergencyStop::Pressed,
        ..SelfTest::DEFAULT
    };
    let report = tested(&|| board.connect(), test, &|notice| match notice {
        Notice::PressEmergencyStop => board.open_stop(true),
        Notice::ReleaseEmergencyStop => board.open_stop(false),
        Notice::MayMove(_) | Notice::Trying(_) | Notice::Silent => {}
    });
    assert!(report.holds, "{report:#?}");
    let row = report.checks.last().expect("a row");
    assert_eq!(row.ok, Some(true), "{row:?}");
}

fn a_device_that_is_unplugged_in_the_middle_ends_the_table_and_no_more() {
    let board = Board::start(Flaw::None);
    let report = tested(&|| board.connect(), SelfTest::DEFAULT, &|notice| {
        if notice == Notice::Trying(Promise::Watchdog) {
            board.unplug();
        }
    });
    assert!(!report.holds && report.link_lost.is_some(), "{report:#?}");
    let kept = report.checks.iter().filter(|check| check.ok == Some(true));
    assert_eq!(kept.count(), 5, "{report:#?}");
    assert_eq!(report.checks.len(), Promise::ALL.len());
    assert_eq!(report.checks[6].seen, "not reached");
}

fn an_emergency_stop_during_another_check_ends_the_test() {
    let board = Board::start(Flaw::None);
    let tried = RefCell::new(Vec::new());
    let report = tested(&|| board.connect(), SelfTest::DEFAULT, &|notice| {
        tried.borrow_mut().push(notice);
        if notice == Notice::Trying(Promise::FiniteCheck) {
            board.press_stop_for_a_moment();
        }
    });
    let last = tried.borrow().last().copied();
    assert_eq!(last, Some(Notice::Trying(Promise::FiniteCheck)));
    let fault = report.ended_by_fault.as_deref().expect("a fault");
    assert!(fault.contains("the emergency stop is open"), "{fault}");
    let [.., finite, watchdog, _, _, _] = report.checks.as_slice() else {
        panic!("{report:#?}");
    };
    assert_eq!(
        (finite.check, finite.seen.as_str()),
        (Promise::FiniteCheck, fault)
    );
    assert!(finite.not_judged && !finite.host_late, "{finite:?}");
    assert_eq!(watchdog.seen, "not reached");
    assert!(!report.holds && report.link_lost.is_none());
}

fn a_device_that_brakes_keeps_every_promise() {
    let board = Board::start(Flaw::None);
    board.set(|limits| {
        limits.device_mass_kg = 0.065;
        limits.braking_n_s_per_m = 20.0;
    });
    let report = tested(&|| board.connect(), SelfTest::DEFAULT, &|_| {});
    assert!(report.holds, "{report:#?}");
}

fn a_limit_of_the_device_breaks_no_promise() {
    let board = Board::start(Flaw::None);
    board.set(|limits| {
        limits.speed_soft_m_per_s = 5e-4;
        limits.speed_hard_m_per_s = 1e-3;
    });
    let report = tested(&|| board.connect(), SelfTest::DEFAULT, &|_| {});
    assert!(
        !report.holds && report.ended_by_fault.is_none(),
        "{report:#?}"
    );
    for check in &report.checks {
        assert_ne!(check.ok, Some(false), "{report:#?}");
    }
    let stop = &report.checks[2];
    assert!(stop.not_judged && !stop.host_late, "{stop:?}");
    let words = ["moved faster than its limit", "set a higher speed limit"];
    assert!(
        words.iter().all(|word| stop.seen.contains(word)),
        "{stop:?}"
    );
}

#[test]
fn a_number_outside_its_range_is_refused_before_anything_is_asked() {
    let test = SelfTest::DEFAULT;
    for (force_limit_n, words) in [(5.0, "force_limit_n"), (f64::NAN, "NaN")] {
        let test = SelfTest {
            force_limit_n,
            ..test
        };
        let stop = AtomicBool::new(false);
        let refused = test.run(Attendant {
            connect: &|| panic!("not asked"),
            notice: &|_| {},
            stop: &stop,
        });
        let error = refused.expect_err("refused");
        assert!(matches!(error, Failure::Input(_)));
        assert!(error.to_string().contains(words), "{error}");
    }
}
