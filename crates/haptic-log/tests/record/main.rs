//! The run log: what is written is read back, whatever happens to the file in between.

mod damage;

use haptic_log::record::{
    Entry, EventMessage, LogFiles, LogReader, LogWriter, NewFileError, PerAxis, ROLL_LEAST,
    RecordError, RollingLog, StartTime, TickMessage, VectorTick, export_csv, inspect, recover,
};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{BufWriter, Cursor, Seek, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, UNIX_EPOCH};

/// 1 kHz, as in the main job.
const TICK_S: f64 = 1e-3;

/// Ticks per flush.
const CHUNK_TICKS: u64 = 100;

/// A tick whose every field tells its number, with digits that do not compress to nothing.
fn tick(number: u64) -> TickMessage {
    let x = number as f64;
    TickMessage {
        tick: number,
        time_s: x * TICK_S,
        reference_m: 1e-3 * (x * 0.01).sin(),
        indenter_position_m: 1e-3 * (x * 0.011).sin(),
        position_m: 1e-3 * (x * 0.012).cos(),
        environment_force_n: (1.0 + x).powf(-0.2247),
        force_n: 1.1 * (1.0 + x).powf(-0.2247),
        contact_force_n: 1.2 * (1.0 + x).powf(-0.2247),
        limiters: (number % 16) as u8,
        observed_energy_j: 1e-6 * (x * 0.013).sin(),
    }
}

fn event(time_s: f64) -> EventMessage {
    EventMessage {
        time_s,
        kind: "phase".into(),
        text: format!("hold begins at {time_s} s"),
    }
}

fn parameters() -> BTreeMap<String, String> {
    [("order", "0.2247"), ("seed", "7")]
        .map(|(key, value)| (key.to_owned(), value.to_owned()))
        .into()
}

/// Metadata, `ticks` ticks, an event in the middle.
fn fill<W: Write + Seek>(writer: &mut LogWriter<W>, ticks: u64) -> Result<(), RecordError> {
    writer.metadata("experiment", parameters())?;
    for number in 0..ticks {
        if number == ticks / 2 {
            writer.event(&event(number as f64 * TICK_S))?;
        }
        writer.tick(&tick(number))?;
    }
    Ok(())
}

/// The bytes of a finished log.
fn finished_bytes(ticks: u64) -> Vec<u8> {
    let mut writer =
        LogWriter::with_sink(Cursor::new(Vec::new()), Path::new("memory")).expect("starts");
    fill(&mut writer, ticks).expect("fills");
    writer.close().expect("closes").into_inner()
}

fn ticks_of(entries: &[Entry]) -> Vec<TickMessage> {
    (entries.iter())
        .filter_map(|entry| match entry {
            Entry::Tick(message) => Some(*message),
            _ => None,
        })
        .collect()
}

#[test]
fn twenty_thousand_ticks_come_back_identical() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("run.mcap");
    let mut writer = LogWriter::create(&path).expect("creates");
    fill(&mut writer, 20_000).expect("fills");
    assert!(!path.exists(), "an unfinished log has no name yet");
    let finished = writer.finish().expect("finishes");
    assert_eq!(
        (finished.path.as_path(), finished.samples),
        (path.as_path(), 20_000)
    );
    assert_eq!(finished.bytes, fs::metadata(&path).expect("exists").len());
    assert_eq!(fs::read_dir(folder.path()).expect("lists").count(), 1);

    let mut reader = LogReader::open(&path).expect("opens");
    let entries: Vec<Entry> = reader.by_ref().collect::<Result<_, _>>().expect("reads");
    assert!(reader.condition().complete, "{:?}", reader.condition());
    let expected: Vec<TickMessage> = (0..20_000).map(tick).collect();
    assert!(ticks_of(&entries) == expected, "ticks differ");
    assert!(entries.contains(&Entry::Event(event(10.0))));
    assert!(matches!(&entries[0], Entry::Metadata(record) if record.values == parameters()));
}

#[test]
fn a_log_without_samples_is_complete_and_empty() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("empty.mcap");
    LogWriter::create(&path)
        .expect("creates")
        .finish()
        .expect("finishes");
    let summary = inspect(&path).expect("inspects");
    assert!(summary.complete);
    assert_eq!(
        (summary.samples, summary.first_s, summary.last_s),
        (0, None, None)
    );

    let csv = folder.path().join("empty.csv");
    assert_eq!(export_csv(&path, &csv, false).expect("exports").rows, 0);
    let text = fs::read_to_string(&csv).expect("reads");
    assert!(text.starts_with("tick,time_s,reference_m,") && text.lines().count() == 1);
}

#[test]
fn missing_ticks_are_found_by_their_numbers() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("gaps.mcap");
    let mut writer = LogWriter::create(&path).expect("creates");
    for number in (0..100).chain(105..200).chain(201..300).chain(299..301) {
        writer.tick(&tick(number)).expect("tick");
    }
    writer.finish().expect("finishes");
    let summary = inspect(&path).expect("inspects");
    let gaps: Vec<_> = (summary.gaps.iter())
        .map(|gap| (gap.after_tick, gap.before_tick, gap.missing))
        .collect();
    assert_eq!(gaps, [(99, 105, 5), (199, 201, 1)]);
    assert_eq!(summary.out_of_order, 1);
    assert!(summary.complete, "gaps are not damage of the file");
    let json = serde_json::to_value(&summary).expect("serialises");
    for key in ["samples", "first_s", "last_s", "gaps", "complete"] {
        assert!(json.get(key).is_some(), "{key}");
    }
}

#[test]
fn what_is_not_mcap_is_refused_by_name() {
    let folder = tempfile::tempdir().expect("folder");
    for (name, content) in [
        ("a.csv", "tick,time_s\n1,2\n"),
        ("empty.mcap", ""),
        ("b", "\u{89}MC"),
    ] {
        let path = folder.path().join(name);
        fs::write(&path, content).expect("writes");
        let error = inspect(&path).expect_err("refuses");
        assert!(matches!(error, RecordError::NotMcap { .. }), "{error:?}");
        assert!(error.to_string().contains(name), "{error}");
        assert!(recover(&path, &folder.path().join("new.mcap"), false).is_err());
    }
    let missing = folder.path().join("missing.mcap");
    assert!(matches!(inspect(&missing), Err(RecordError::Read { .. })));
}

#[test]
fn nothing_that_exists_is_overwritten() {
    let folder = tempfile::tempdir().expect("folder");
    let log = folder.path().join("run.mcap");
    let mut writer = LogWriter::create(&log).expect("creates");
    fill(&mut writer, 10).expect("fills");
    writer.finish().expect("finishes");
    let taken = folder.path().join("taken");
    fs::write(&taken, "precious").expect("writes");
    let errors = [
        LogWriter::create(&taken).map(drop).expect_err("refuses"),
        recover(&log, &taken, false).map(drop).expect_err("refuses"),
        export_csv(&log, &taken, false)
            .map(drop)
            .expect_err("refuses"),
    ];
    for error in errors {
        assert!(
            matches!(error, RecordError::File(NewFileError::Exists(_))),
            "{error:?}"
        );
    }
    assert_eq!(fs::read_to_string(&taken).expect("reads"), "precious");
    assert_eq!(fs::read_dir(folder.path()).expect("lists").count(), 2);
}

#[test]
fn a_time_no_log_can_hold_is_refused_and_the_log_goes_on() {
    let mut writer =
        LogWriter::with_sink(Cursor::new(Vec::new()), Path::new("memory")).expect("starts");
    for time_s in [f64::NAN, -1e-3, f64::INFINITY] {
        let message = TickMessage { time_s, ..tick(0) };
        assert!(matches!(
            writer.tick(&message),
            Err(RecordError::Time { .. })
        ));
    }
    writer.tick(&tick(0)).expect("goes on");
    assert_eq!(writer.samples(), 1);
}

/// 2026-11-20 12:31:49 UTC and a nanosecond.
fn noon() -> StartTime {
    StartTime::at(UNIX_EPOCH + Duration::new(1_795_177_909, 1))
}

#[test]
fn log_times_are_wall_clock_and_read_back_as_seconds_from_the_start() {
    let folder = tempfile::tempdir().expect("folder");
    let [dated, undated, saved, cut] =
        ["dated", "undated", "saved", "cut"].map(|name| folder.path().join(name));
    for (path, start) in [(&dated, Some(noon())), (&undated, None)] {
        let mut writer = LogWriter::create(path).expect("creates");
        if let Some(start) = start {
            writer.starts_at(start).expect("dates");
        }
        fill(&mut writer, 300).expect("fills");
        writer.finish().expect("finishes");
    }
    let expected = Some("2026-11-20T12:31:49.000000001Z".to_owned());
    let summary = inspect(&dated).expect("inspects");
    assert_eq!(summary.started_utc, expected);
    assert_eq!((summary.first_s, summary.last_s), (Some(0.0), Some(0.299)));
    // A log of an earlier version begins in 1970, which is no date.
    assert_eq!(inspect(&undated).expect("inspects").started_utc, None);

    // Log times themselves, by the MCAP library: start plus device time, to the nanosecond.
    let times = |path: &Path| -> Vec<u64> {
        let bytes = fs::read(path).expect("reads");
        let messages = mcap::MessageStream::new(&bytes).expect("is MCAP");
        messages
            .map(|message| message.expect("is whole"))
            .inspect(|message| assert_eq!(message.log_time, message.publish_time))
            .filter(|message| message.channel.topic == "/haptics/tick")
            .map(|message| message.log_time)
            .collect()
    };
    let whole = times(&dated);
    let expected_ns = (0..300).map(|n| 1_795_177_909_000_000_001 + n * 1_000_000);
    assert_eq!(whole, expected_ns.collect::<Vec<_>>());
    // What is saved of a cut log keeps its date.
    let bytes = fs::read(&dated).expect("reads");
    fs::write(&cut, &bytes[..bytes.len() * 2 / 3]).expect("writes");
    let samples = recover(&cut, &saved, false).expect("recovers").samples;
    assert!((100..300).contains(&samples), "{samples}");
    assert_eq!(inspect(&saved).expect("inspects").started_utc, expected);
    assert_eq!(times(&saved), whole[..samples as usize]);
}

#[test]
fn a_very_long_log_has_no_index_and_is_whole_all_the_same() {
    // A tick in each 100 ms is a chunk each; 65 536 of them have an index.
    let ticks = 150_000;
    let chunked = |number: u64| TickMessage {
        time_s: 0.1 * number as f64,
        ..tick(number)
    };
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("long.mcap");
    let mut writer = LogWriter::create(&path).expect("creates");
    writer.starts_at(noon()).expect("dates");
    writer
        .metadata("experiment", parameters())
        .expect("describes");
    (0..ticks).for_each(|n| writer.tick(&chunked(n)).expect("writes"));
    writer.finish().expect("finishes");

    let summary = inspect(&path).expect("inspects");
    assert!(summary.complete && summary.gaps.is_empty(), "{summary:?}");
    assert_eq!((summary.samples, summary.out_of_order), (ticks, 0));
    // The MCAP library finds no summary to trust, and every message.
    let bytes = fs::read(&path).expect("reads");
    let index = mcap::Summary::read(&bytes).expect("is MCAP");
    assert!(index.is_none_or(|index| index.chunk_indexes.is_empty() && index.stats.is_none()));
    let messages = mcap::MessageStream::new(&bytes).expect("is MCAP");
    let messages = messages.map(|message| message.expect("is whole"));
    assert!(messages.map(|message| message.sequence).eq(0..ticks as u32));
    // A byte that changed is still found by its chunk.
    let mut damaged = bytes;
    let middle = damaged.len() * 2 / 3;
    damaged[middle] ^= 0x40;
    fs::write(&path, damaged).expect("writes");
    let summary = inspect(&path).expect("inspects");
    assert!(
        !summary.complete && summary.samples >= ticks - 2,
        "{}",
        summary.samples
    );
}

#[test]
fn a_log_in_several_files_reads_as_one() {
    let folder = tempfile::tempdir().expect("folder");
    let name = |number: usize| match number {
        1 => folder.path().join("run.mcap"),
        _ => folder.path().join(format!("run-{number:04}.mcap")),
    };
    let write = |ticks: u64, overwrite| {
        let mut log = RollingLog::create(&name(1), parameters(), overwrite).expect("creates");
        log.roll_at(ROLL_LEAST);
        log.starts_at(noon()).expect("dates");
        (0..ticks).for_each(|n| log.tick(&tick(n)).expect("writes"));
        log.finish().expect("finishes")
    };
    let ticks = 60_000;
    let finished = write(ticks, false);
    let files = finished.paths.len();
    assert!((3..12).contains(&files), "{files} files");
    let expected: Vec<PathBuf> = (1..=files).map(name).collect();
    assert_eq!(
        (finished.paths, finished.samples),
        (expected.clone(), ticks)
    );
    for (n, path) in expected.iter().enumerate() {
        let bytes = fs::metadata(path).expect("is there").len();
        // A chunk more than full at most, and the index.
        assert!(bytes < ROLL_LEAST + ROLL_LEAST / 5, "{bytes}");
        assert!(bytes > ROLL_LEAST || n + 1 == files, "{bytes}");
        // Each by itself has an index, metadata and date.
        let bytes = fs::read(path).expect("reads");
        let index = mcap::Summary::read(&bytes).expect("is MCAP");
        assert!(!index.expect("is there").chunk_indexes.is_empty());
        let own: Vec<Entry> = LogReader::open(path)
            .expect("opens")
            .collect::<Result<_, _>>()
            .expect("reads");
        let described = |entry: &&Entry| matches!(entry, Entry::Metadata(record) if record.values == parameters());
        assert_eq!(own.iter().filter(described).count(), 1);
    }
    let all = |path: &Path| -> Vec<TickMessage> {
        let entries = LogFiles::open(path).expect("opens");
        ticks_of(&entries.collect::<Result<Vec<_>, _>>().expect("reads"))
    };
    assert!(all(&name(1)) == (0..ticks).map(tick).collect::<Vec<_>>());
    let summary = inspect(&name(1)).expect("inspects");
    assert!(summary.complete && summary.gaps.is_empty());
    assert_eq!((summary.samples, summary.last_s), (ticks, Some(59.999)));
    let named = summary.metadata.iter().map(|record| record.name.as_str());
    assert_eq!(named.collect::<Vec<_>>(), ["experiment", "clock"]);

    // A file that is gone is missed, one in the middle as well as the last.
    for gone in [2, files] {
        let aside = folder.path().join("aside");
        fs::rename(name(gone), &aside).expect("moves");
        let summary = inspect(&name(1)).expect("inspects");
        assert!(!summary.complete && summary.samples < ticks);
        let missing = format!("run-{gone:04}.mcap");
        assert!(summary.damage[0].contains(&missing), "{:?}", summary.damage);
        fs::rename(&aside, name(gone)).expect("moves back");
    }
    // The file that was being written when the process died is `.part`.
    let part = folder.path().join(format!("run-{files:04}.mcap.part"));
    let bytes = fs::read(name(files)).expect("reads");
    fs::write(&part, &bytes[..bytes.len() / 2]).expect("writes");
    fs::remove_file(name(files)).expect("removes");
    let summary = inspect(&name(1)).expect("inspects");
    assert!(!summary.complete && summary.gaps.is_empty());
    fs::remove_file(part).expect("removes");

    // A shorter log that takes the place of this leaves none of its files.
    let finished = write(10, true);
    assert_eq!(finished.paths, [name(1)]);
    assert_eq!(inspect(&name(1)).expect("inspects").samples, 10);
    assert_eq!(fs::read_dir(folder.path()).expect("lists").count(), 1);
}

#[test]
fn the_csv_has_every_digit() {
    let folder = tempfile::tempdir().expect("folder");
    let (log, csv) = (
        folder.path().join("run.mcap"),
        folder.path().join("run.csv"),
    );
    let mut writer = LogWriter::create(&log).expect("creates");
    fill(&mut writer, 1_000).expect("fills");
    writer.finish().expect("finishes");
    let summary = export_csv(&log, &csv, false).expect("exports");
    assert_eq!((summary.rows, summary.condition.complete), (1_000, true));
    let rows: Vec<TickMessage> = (csv::Reader::from_path(&csv).expect("opens"))
        .deserialize()
        .collect::<Result<_, _>>()
        .expect("parses");
    assert!(rows == (0..1_000).map(tick).collect::<Vec<_>>());
}

/// The reference readers of MCAP and ROS 2 messages understand the log as it was meant.
#[test]
fn foreign_readers_agree_with_the_csv_on_every_value() {
    foreign_readers_agree(|writer| fill(writer, 2_000));
}

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
        force_n: vector(-5.0),
        contact_force_n: vector(f64::NAN),
        limiters: (n % 7) as u8,
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
        ("force_z_n", -4.793),
        ("limiters", 0.0),
    ] {
        assert!((column(name) - want).abs() < 1e-12, "{name}");
    }

    // Both kinds fit in no one table.
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

fn foreign_readers_agree(
    fill: impl FnOnce(&mut LogWriter<BufWriter<File>>) -> Result<(), RecordError>,
) {
    let folder = tempfile::tempdir().expect("folder");
    let (log, csv) = (
        folder.path().join("run.mcap"),
        folder.path().join("run.csv"),
    );
    let mut writer = LogWriter::create(&log).expect("creates");
    writer.starts_at(noon()).expect("dates");
    fill(&mut writer).expect("fills");
    writer.finish().expect("finishes");
    export_csv(&log, &csv, false).expect("exports");

    let script: PathBuf = [env!("CARGO_MANIFEST_DIR"), "tests/read_log.py"]
        .iter()
        .collect();
    let python = std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
    let missing = match std::process::Command::new(&python)
        .arg(script)
        .args([&log, &csv])
        .output()
    {
        Ok(output) if output.status.code() == Some(3) => {
            String::from_utf8_lossy(&output.stderr).trim().to_owned()
        }
        Ok(output) => {
            assert!(
                output.status.success(),
                "{}",
                String::from_utf8_lossy(&output.stderr)
            );
            return;
        }
        Err(error) => format!("{}: {error}", python.display()),
    };
    assert!(
        std::env::var_os("REQUIRE_ALL_CHECKS").is_none(),
        "{missing}; `pip install mcap mcap-ros2-support`, or point PYTHON to a Python that has them"
    );
    println!("skipped: {missing}");
}
