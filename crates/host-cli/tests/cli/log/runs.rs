//! `log plot` of several runs and of parts, and `log cut`.

use crate::process::{Place, number};
use haptic_log::record::{LogWriter, StartTime};
use haptic_message::{END, EndKind, EventMessage, PerAxis, RunEnd, TickMessage};
use serde_json::Value;
use std::time::{Duration, UNIX_EPOCH};
use testkit::{assert_close, assert_says};

const TICK_S: f64 = 1e-3;

/// A log of these ticks.
fn made(place: &Place, name: &str, ticks: impl Iterator<Item = TickMessage>) {
    let mut log = LogWriter::create(&place.path(name)).expect("creates");
    ticks.for_each(|tick| log.tick(&tick).expect("takes"));
    log.finish().expect("finishes");
}

/// A tick at a time at which position and force are straight lines, of which this much is added.
fn straight(tick: u64, time_s: f64, more: f64) -> TickMessage {
    TickMessage {
        tick,
        time_s,
        position_m: (1e-3 * time_s + more).into(),
        commanded_force_n: (-2.0 * time_s - 100.0 * more).into(),
        ..TickMessage::at_rest(1)
    }
}

fn at(tick: u64) -> f64 {
    TICK_S * tick as f64
}

#[test]
fn a_difference_is_that_of_its_closed_form() {
    let place = Place::new();
    // B is A and 0.1 mm·cos(2πt) over whole periods, so the rms is 0.1 mm/√2.
    let wave = |n: u64| 1e-4 * (std::f64::consts::TAU * at(n)).cos();
    made(&place, "a.mcap", (0..2000).map(|n| straight(n, at(n), 0.0)));
    made(
        &place,
        "b.mcap",
        (0..3000).map(|n| straight(n, at(n), wave(n))),
    );
    let found = place.json("log plot a.mcap b.mcap --difference");
    assert_eq!(found["difference"], "b.mcap − a.mcap");
    let counts = ["compared", "interpolated"].map(|key| number(&found, key));
    assert_eq!(counts, [2000.0, 0.0]);
    let close = |key: &str, want: f64| {
        let have = number(&found, key);
        assert!((have / want - 1.0).abs() < 1e-9, "{key}: {have} {want}");
    };
    close("position_rms_m", 1e-4 / 2_f64.sqrt());
    close("position_largest_m", 1e-4);
    close("force_rms_n", 1e-2 / 2_f64.sqrt());
    close("force_largest_n", 1e-2);
    // Of half a period: the cosine is largest at its start, and −1 at its end is as large.
    let half = place.json("log plot a.mcap b.mcap --difference --overwrite --from 0.25s --to 0.5s");
    assert_eq!(number(&half, "position_largest_at_s"), 0.5);
    assert_eq!(number(&half, "compared"), 251.0);
    let svg = place.text("a.runs.svg");
    assert!(svg.contains(">b.mcap − a.mcap<") && svg.contains("difference of force"));
}

#[test]
fn unequal_times_are_joined_by_straight_lines_and_that_is_said() {
    let place = Place::new();
    made(&place, "a.mcap", (0..900).map(|n| straight(n, at(n), 0.0)));
    // Every 0.7 ms, and one tick is missing.
    let ticks = (0..2000).filter(|n| *n != 500);
    made(
        &place,
        "b.mcap",
        ticks.map(|n| straight(n, 0.7e-3 * n as f64, 1e-5)),
    );
    let ended = place.run("log plot a.mcap b.mcap --difference --json");
    let ended = ended.succeeded_with_warnings();
    assert_says(
        &ended.stderr,
        "samples of a.mcap are between two of b.mcap & straight line",
    );
    let found = ended.json();
    // A straight line is its own interpolation.
    let rms_m = number(&found, "position_rms_m");
    assert_close("rms_m", rms_m, 1e-5, 1e-12);
    // 350 ms is the missing one, and across it nothing is made up.
    assert_eq!(number(&found, "compared"), 899.0);
    // One in seven is at a sample of both.
    assert_eq!(number(&found, "interpolated"), (900 - 129) as f64);
}

#[test]
fn runs_begin_together_and_what_was_shifted_is_said() {
    let place = Place::new();
    made(&place, "a.mcap", (0..1000).map(|n| straight(n, at(n), 0.0)));
    made(
        &place,
        "b.mcap",
        (0..1000).map(|n| straight(n, 5.0 + at(n), -5e-3)),
    );
    let ended = place.run("log plot a.mcap b.mcap --difference --json");
    let ended = ended.succeeded_with_warnings();
    assert_says(
        &ended.stderr,
        "b.mcap begins at 5 s & drawn from 0 s on, as the first",
    );
    let found = ended.json();
    assert_eq!(number(&found["runs"][1], "shifted_s"), 5.0);
    // Times that were added and subtracted again agree to less than a nanosecond.
    let counts = ["compared", "interpolated"].map(|key| number(&found, key));
    assert_eq!(counts, [1000.0, 0.0]);
    assert!(number(&found, "position_largest_m") < 1e-15);
}

#[test]
fn two_axes_have_panels_of_their_own() {
    let place = Place::new();
    let tick = |n: u64, radius: f64| TickMessage {
        tick: n,
        time_s: at(n),
        position_m: PerAxis::new(&[radius * at(n).cos(), radius * at(n).sin()]),
        commanded_force_n: PerAxis::new(&[0.0, 1.0]),
        ..TickMessage::at_rest(2)
    };
    made(&place, "a.mcap", (0..1000).map(|n| tick(n, 0.01)));
    made(&place, "b.mcap", (0..1000).map(|n| tick(n, 0.02)));
    let found = place.json("log plot a.mcap b.mcap --difference");
    // Of the second axis: 10 mm·sin(0.999).
    let largest_m = number(&found, "position_largest_y_m");
    assert_close("largest_m", largest_m, 0.01 * at(999).sin(), 1e-12);
    let svg = place.text("a.runs.svg");
    assert!(svg.contains("(h) difference of force y"), "{}", svg.len());
    place.json("log plot a.mcap b.mcap --over-depth");
    made(&place, "c.mcap", (0..10).map(|n| straight(n, at(n), 0.0)));
    let ended = place.run("log plot a.mcap c.mcap --overwrite");
    ended.refused(2, &["c.mcap", "1 axes", "a.mcap has 2"]);
    made(&place, "empty.mcap", std::iter::empty());
    let ended = place.run("log plot c.mcap empty.mcap");
    ended.refused(2, &["empty.mcap", "no ticks"]);
    let ended = place.run("log cut empty.mcap d.mcap --from 0s");
    ended.refused(2, &["no sample"]);
}

/// A run with metadata, events and an end, which has lost these ticks.
fn run(place: &Place, lost: std::ops::Range<u64>) {
    let mut log = LogWriter::create(&place.path("run.mcap")).expect("creates");
    let values = [("mass_kg".to_owned(), "0.065".to_owned())];
    log.metadata("experiment", values.into()).expect("takes");
    let start = UNIX_EPOCH + Duration::from_secs(1_795_177_909);
    log.starts_at(StartTime::at(start)).expect("takes");
    for n in (0..2000).filter(|n| !lost.contains(n)) {
        if n % 500 == 0 {
            let event = EventMessage {
                time_s: at(n),
                kind: "phase".to_owned(),
                text: format!("at {n}"),
            };
            log.event(&event).expect("takes");
        }
        log.tick(&straight(n, at(n), 0.0)).expect("takes");
    }
    let end = RunEnd {
        ended: EndKind::Finished,
        reason: String::new(),
        planned_samples: 2000,
        made_samples: 2000,
        dropped_samples: lost.end - lost.start,
    };
    log.metadata(END, end.metadata()).expect("takes");
    log.finish().expect("finishes");
}

#[test]
fn a_cut_shows_what_is_missing_within_it() {
    let place = Place::new();
    run(&place, 700..710);
    let cut = place.run("log cut run.mcap hole.mcap --from 0.5s --to 1s --json");
    let cut = cut.failed(4).json();
    assert_eq!(cut["gaps"][0]["missing"], Value::from(10));
    place.run("log check hole.mcap").failed(4);
    place.json("log cut run.mcap whole.mcap --from 1s");
    place.json("log check whole.mcap");
    // Of a damaged log too, and that is said.
    let bytes = place.read("run.mcap");
    place.write("torn.mcap", &bytes[..bytes.len() / 2]);
    let torn = place
        .run("log cut torn.mcap --from 0.1s --to 0.3s")
        .failed(4);
    assert_says(torn.error(), "torn.mcap & not whole");
    place.json("log check torn.cut.mcap");
}
