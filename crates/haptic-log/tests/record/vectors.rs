//! Ticks with vectors: read, counted, saved, tabled.

use super::{fill, foreign_readers_agree, tick};
use haptic_log::record::{
    Entry, LogReader, LogWriter, PerAxis, VectorTick, export_csv, inspect, recover,
};
use std::fs;
use std::io::Cursor;
use std::path::Path;

#[test]
fn foreign_readers_agree_on_ticks_with_two_and_three_axes() {
    for axes in [2, 3] {
        foreign_readers_agree(|writer| {
            (0..2_000).try_for_each(|n| writer.vector_tick(&vector_tick(n, axes)))
        });
    }
}

/// A tick whose numbers tell fields and axes apart.
fn vector_tick(n: u64, axes: usize) -> VectorTick {
    let vector = |field: f64| {
        let axis = |axis: usize| field + 0.1 * axis as f64 + 1e-3 * n as f64;
        let numbers: Vec<f64> = (0..axes).map(axis).collect();
        PerAxis::new(&numbers).expect("three at most")
    };
    VectorTick {
        tick: n,
        time_s: 1e-3 * n as f64,
        reference_m: vector(1.0),
        indenter_position_m: vector(2.0),
        position_m: vector(3.0),
        environment_force_n: vector(-4.0),
        commanded_force_n: vector(-5.0),
        applied_force_n: vector(-5.5),
        contact_force_n: vector(f64::NAN),
        limiters: (n % 7) as u8,
        flaws: (n % 3) as u8,
        observed_energy_j: 1e-9 * n as f64,
    }
}

#[test]
fn ticks_with_vectors_are_read_counted_saved_and_tabled() {
    let folder = tempfile::tempdir().expect("folder");
    let path = |name: &str| folder.path().join(name);
    let mut writer = LogWriter::create(&path("run.mcap")).expect("creates");
    for n in (0..500).filter(|n| *n != 250) {
        writer.vector_tick(&vector_tick(n, 3)).expect("takes");
    }
    writer.finish().expect("finishes");
    let summary = inspect(&path("run.mcap")).expect("reads");
    assert_eq!((summary.samples, summary.gaps.len()), (499, 1));
    assert_eq!(summary.foreign_messages, 0);

    // Cut in the middle, and saved.
    let bytes = fs::read(path("run.mcap")).expect("reads");
    fs::write(path("cut.mcap"), &bytes[..bytes.len() / 2]).expect("writes");
    let saved = recover(&path("cut.mcap"), &path("saved.mcap"), false).expect("saves");
    assert!(saved.samples > 100 && saved.lost_data());
    let ticks = |log: &str| -> Vec<Entry> {
        let entries = LogReader::open(&path(log))
            .expect("opens")
            .map(Result::unwrap);
        entries
            .filter(|entry| matches!(entry, Entry::Vector(_)))
            .collect()
    };
    let (all, kept) = (ticks("run.mcap"), ticks("saved.mcap"));
    assert_eq!(kept.len() as u64, saved.samples);
    // As text, for NaN.
    assert_eq!(format!("{:?}", &all[..kept.len()]), format!("{kept:?}"));

    let table = export_csv(&path("run.mcap"), &path("run.csv"), false).expect("exports");
    assert_eq!(table.rows, 499);
    let mut table = csv::Reader::from_path(path("run.csv")).expect("opens");
    assert_eq!(table.headers().expect("has one"), VectorTick::columns(3));
    let row = table.records().nth(7).expect("rows").expect("parses");
    let column = |name: &str| {
        let place = VectorTick::columns(3)
            .iter()
            .position(|column| column == name);
        row[place.expect("is there")]
            .parse::<f64>()
            .expect("a number")
    };
    for (name, want) in [
        ("position_x_m", 3.007),
        ("position_y_m", 3.107),
        ("commanded_force_z_n", -4.793),
        ("limiters", 0.0),
    ] {
        assert!((column(name) - want).abs() < 1e-12, "{name}");
    }
}

#[test]
fn ticks_of_both_kinds_fit_in_no_one_table() {
    let folder = tempfile::tempdir().expect("folder");
    let path = |name: &str| folder.path().join(name);
    let mut mixed = LogWriter::create(&path("mixed.mcap")).expect("creates");
    mixed.vector_tick(&vector_tick(0, 2)).expect("takes");
    mixed.tick(&tick(1)).expect("takes");
    mixed.finish().expect("finishes");
    let error = export_csv(&path("mixed.mcap"), &path("mixed.csv"), false).expect_err("refused");
    assert!(
        error.to_string().contains("ticks of 2 and of 1 axes"),
        "{error}"
    );
    assert!(!path("mixed.csv").exists());
}

#[test]
fn a_log_of_one_axis_says_nothing_of_vectors() {
    let mut log = Cursor::new(Vec::new());
    let mut writer = LogWriter::with_sink(&mut log, Path::new("run")).expect("begins");
    fill(&mut writer, 100).expect("fills");
    writer.close().expect("closes");
    let bytes = log.into_inner();
    let words = b"VectorTick";
    assert!(!bytes.windows(words.len()).any(|window| window == words));
}
