//! `log check`: what is missing, and where.

use super::with_log;
use crate::process::{Place, number};
use haptic_log::record::{END, EndKind, RollingLog, RunEnd, TickMessage};
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
    let path = place.path("made.mcap");
    let mut log = RollingLog::create(&path, BTreeMap::new(), true).expect("starts");
    for tick in ticks {
        let message = TickMessage {
            tick,
            time_s: 1e-3 * tick as f64,
            ..TickMessage::default()
        };
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
