//! `log plot` of several runs and of parts, and `log cut`.

use crate::process::{Place, number};
use haptic_log::record::LogWriter;
use haptic_message::{PerAxis, TickMessage};
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
