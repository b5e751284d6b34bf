//! `log check`: what is missing, and where.

use crate::process::{Place, number, row};
use haptic_log::record::RollingLog;
use haptic_message::{END, EndKind, RunEnd, TickMessage, flaw};
use std::collections::BTreeMap;
use testkit::assert_says;

/// A log of these ticks at 1 kHz, of a run that made 1000 of 2000.
fn log_of(place: &Place, ticks: impl Iterator<Item = u64>, ended: EndKind, dropped: u64) {
    let message = |tick| TickMessage {
        tick,
        time_s: 1e-3 * tick as f64,
        ..TickMessage::at_rest(1)
    };
    log_with(place, ticks.map(message), ended, dropped);
}

fn log_with(place: &Place, ticks: impl Iterator<Item = TickMessage>, ended: EndKind, dropped: u64) {
    let path = place.path("made.mcap");
    let mut log = RollingLog::create(&path, BTreeMap::new(), true).expect("starts");
    for message in ticks {
        log.tick(&message).expect("writes");
    }
    let end = RunEnd {
        ended,
        reason: "for a reason".to_owned(),
        planned_samples: 2000,
        made_samples: 1000,
        dropped_samples: dropped,
    };
    log.metadata(END, end.metadata()).expect("writes");
    log.finish().expect("finishes");
}

#[test]
fn check_judges_a_run_up_to_its_end_and_says_that_it_ended_early() {
    let place = Place::new();
    let checked = |ended, dropped| {
        log_of(&place, 0..1000, ended, dropped);
        place.run("log check made.mcap")
    };
    for ended in [EndKind::Interrupted, EndKind::Fault] {
        let check = checked(ended, 0).succeeded();
        let values = ["samples", "complete", "reason", "planned samples"]
            .map(|label| row(&check.stdout, label));
        assert_eq!(values, ["1000", "yes", "for a reason", "2000"], "{check}");
    }
    // Nobody knows how many samples there were; the run knows of more than the log shows.
    assert_says(
        checked(EndKind::Link, 0).failed(4).error(),
        "the link was lost",
    );
    assert_says(checked(EndKind::Finished, 3).failed(4).error(), "counted 3");
}

#[test]
fn check_bears_a_hundredth_of_stale_ticks_and_none_that_cannot_be() {
    let place = Place::new();
    let with = |flawed: u64, flaws: u8, position_m: f64| {
        let ticks = (0..1000).map(|tick| TickMessage {
            tick,
            time_s: 1e-3 * tick as f64,
            flaws: if tick < flawed { flaws } else { 0 },
            position_m: if tick < flawed { position_m } else { 0.0 }.into(),
            ..TickMessage::at_rest(1)
        });
        log_with(&place, ticks, EndKind::Interrupted, 0);
        place.run("log check made.mcap")
    };
    let check = with(10, flaw::UNANSWERED, 0.0).succeeded();
    let values = ["stale", "unanswered"].map(|label| row(&check.stdout, label));
    assert_eq!(values, ["10", "10"], "{check}");
    let check = with(11, flaw::LATE_FORCE, 0.0).failed(4);
    assert_says(
        check.error(),
        "11 of 1000 ticks are stale: in 11 an older force of the host acted",
    );
    with(600, flaw::UNANSWERED | flaw::NOT_TAKEN, 0.0).failed(4);
    let check = place.run("log check made.mcap --json").failed(4).json();
    let keys = ["stale", "unanswered", "forces_not_taken", "late_forces"];
    let counts = keys.map(|key| number(&check, key));
    assert_eq!(counts, [600.0, 600.0, 600.0, 0.0], "{check}");
    // One is too many, whoever saw it.
    for (flaws, position_m) in [(flaw::IMPOSSIBLE, 0.0), (0, f64::NAN)] {
        let check = with(1, flaws, position_m).failed(4);
        assert_says(
            check.error(),
            "of 1 ticks the device reported impossible values",
        );
    }
}
