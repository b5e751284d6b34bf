//! `log check`: what is missing, and where.

use super::with_log;
use crate::process::{Place, number};
use haptic_log::record::{END, EndKind, EventMessage, RollingLog, RunEnd, TickMessage, flaw};
use serde_json::Value;
use std::collections::BTreeMap;

#[test]
fn check_finds_a_whole_log_whole() {
    let place = with_log();
    let check = place.run("log check run/relax.mcap").succeeded();
    assert!(check.stdout.contains("whole: 3001 samples"), "{check}");
    let check = place.run("log check run/relax.mcap --json").succeeded();
    assert_eq!(check.json()["complete"], Value::from(true));
}

/// A log of these ticks at 1 kHz, of a run that made 1000 of 2000.
fn log_of(place: &Place, ticks: impl Iterator<Item = u64>, ended: EndKind, dropped: u64) {
    let message = |tick| TickMessage {
        tick,
        time_s: 1e-3 * tick as f64,
        ..TickMessage::default()
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
fn check_counts_what_is_missing_before_the_first_sample_and_after_the_last() {
    let place = Place::new();
    for (lost, [start, between, end]) in [
        (vec![0..100, 100..200], [200, 0, 0]),
        (vec![900..950, 950..1000], [0, 0, 100]),
        (vec![0..1, 7..9, 999..1000], [1, 2, 1]),
        (vec![0..500, 500..1000], [0, 0, 1000]),
    ] {
        let came = (0..1000).filter(|tick| !lost.iter().any(|lost| lost.contains(tick)));
        let missing = start + between + end;
        log_of(&place, came, EndKind::Interrupted, missing);
        let check = place.run("log check made.mcap --json").failed(4).json();
        let counted = ["missing_at_start", "missing_at_end", "missing_samples"];
        let counted = counted.map(|key| number(&check, key) as u64);
        assert_eq!(counted, [start, end, missing], "{check}");
        // What is saved of it lacks the same.
        let saved = place.run("log recover made.mcap saved.mcap --overwrite");
        saved.failed(4);
        let check = place.run("log check saved.mcap --json").failed(4).json();
        assert_eq!(number(&check, "missing_samples") as u64, missing, "{check}");
    }
    let text = place.run("log check made.mcap").failed(4);
    assert!(text.error().contains("1000 ticks missing"), "{text}");
    assert!(text.error().contains("its file is undamaged"), "{text}");
}

#[test]
fn check_judges_a_run_up_to_its_end_and_says_that_it_ended_early() {
    let place = Place::new();
    let early = "ended early: for a reason; 1000 of 2000 planned samples";
    for ended in [EndKind::Interrupted, EndKind::Fault] {
        log_of(&place, 0..1000, ended, 0);
        let check = place.run("log check made.mcap").succeeded();
        assert!(check.stdout.contains("whole: 1000 samples"), "{check}");
        assert!(check.stdout.contains(early), "{check}");
    }
    // Nobody knows how many samples there were.
    log_of(&place, 0..1000, EndKind::Link, 0);
    let check = place.run("log check made.mcap").failed(4);
    assert!(check.stdout.contains(early), "{check}");
    assert!(check.error().contains("the link was lost"), "{check}");
    // The run knows of more than the log shows.
    log_of(&place, 0..1000, EndKind::Finished, 3);
    let check = place.run("log check made.mcap").failed(4);
    assert!(check.error().contains("counted 3"), "{check}");
}

#[test]
fn check_bears_a_hundredth_of_stale_ticks_and_none_that_cannot_be() {
    let place = Place::new();
    let with = |flawed: u64, flaws: u8, position_m: f64| {
        let ticks = (0..1000).map(|tick| TickMessage {
            tick,
            time_s: 1e-3 * tick as f64,
            flaws: if tick < flawed { flaws } else { 0 },
            position_m: if tick < flawed { position_m } else { 0.0 },
            ..TickMessage::default()
        });
        log_with(&place, ticks, EndKind::Interrupted, 0);
        place.run("log check made.mcap")
    };
    let words = [
        (flaw::UNANSWERED, "the board did not answer"),
        (flaw::NOT_TAKEN, "it may not have taken the force before"),
        (flaw::LATE_FORCE, "an older force of the host acted"),
    ];
    for (flaws, words) in words {
        let check = with(10, flaws, 0.0).succeeded();
        let told = format!("stale: 10 of 1000 ticks are stale: in 10 {words}");
        assert!(check.stdout.contains(&told), "{check}");
        let check = with(11, flaws, 0.0).failed(4);
        let told = format!("11 of 1000 ticks are stale: in 11 {words}");
        assert!(check.error().contains(&told), "{check}");
    }
    let both = flaw::UNANSWERED | flaw::NOT_TAKEN;
    with(600, both, 0.0).failed(4);
    let check = place.run("log check made.mcap --json").failed(4).json();
    let keys = ["stale", "unanswered", "forces_not_taken", "late_forces"];
    let counts = keys.map(|key| number(&check, key));
    assert_eq!(counts, [600.0, 600.0, 600.0, 0.0], "{check}");
    // One is too many, whoever saw it.
    for (flaws, position_m) in [(flaw::IMPOSSIBLE, 0.0), (0, f64::NAN), (0, f64::INFINITY)] {
        let check = with(1, flaws, position_m).failed(4);
        let told = "of 1 ticks the device told what cannot be";
        assert!(check.error().contains(told), "{check}");
    }
}

#[test]
fn control_characters_of_a_log_reach_no_terminal() {
    let place = Place::new();
    let evil = "\u{1b}[31mred\u{7}\u{9b}2J\r\nthe end";
    let experiment = [("device".to_owned(), evil.to_owned())];
    let path = place.path("a\u{1b}b.mcap");
    let mut log = RollingLog::create(&path, experiment.into(), false).expect("starts");
    let event = EventMessage {
        time_s: 0.5,
        kind: evil.to_owned(),
        text: evil.to_owned(),
    };
    log.event(&event).expect("writes");
    log.metadata(evil, [(evil.to_owned(), evil.to_owned())].into())
        .expect("writes");
    log.finish().expect("finishes");
    for options in ["", " --json"] {
        let info = place.run(&format!("log info a\u{1b}b.mcap{options}"));
        let said = info.succeeded().stdout;
        let raw = |c: char| c.is_control() && c != '\n';
        assert!(!said.contains(raw), "{said:?}");
        assert!(said.contains("\\u001b[31mred\\u0007\\u009b2J"), "{said}");
        // Nothing of it begins a line.
        assert!(
            !said.lines().any(|line| line.starts_with("the end")),
            "{said}"
        );
    }
    // Nor does an error.
    let error = place.run("log check a\u{1b}c.mcap").failed(2).stderr;
    assert!(
        error.contains("a\\u001bc.mcap") && !error.contains('\u{1b}'),
        "{error:?}"
    );
}
