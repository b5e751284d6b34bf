//! The run log: what is written is read back, whatever happens to the file in between.

mod cut;
mod damage;
mod long;
mod order;
mod pair;
mod schemas;

use haptic_log::record::{
    Entry, LogReader, LogWriter, NewFileError, RecordError, StartTime, export_csv, inspect, recover,
};
use haptic_message::{END, EndKind, EventMessage, PerAxis, RunEnd, TickMessage};
use mcap::records::MessageHeader;
use std::{
    collections::BTreeMap,
    fs::{self, File},
    io::{BufWriter, Cursor, Seek, Write},
    path::{Path, PathBuf},
    time::{Duration, UNIX_EPOCH},
};
use testkit::{Folder, Tested, assert_refused, assert_says};

/// 1 kHz, as in the main job.
const TICK_S: f64 = 1e-3;

/// Ticks per flush.
const CHUNK_TICKS: u64 = 100;

/// A tick whose every field and axis tells its number, with digits that do not compress to nothing.
fn tick_of(axes: usize, number: u64) -> TickMessage {
    let x = number as f64;
    let swings = |factor: f64| {
        let axes = (0..axes).map(|axis| 1e-3 * (x * factor + axis as f64).sin());
        axes.collect::<PerAxis>()
    };
    let falls = |factor: f64| {
        let axes = (0..axes).map(|axis| (factor + axis as f64) * (1.0 + x).powf(-0.2247));
        axes.collect::<PerAxis>()
    };
    TickMessage {
        tick: number,
        time_s: x * TICK_S,
        reference_m: swings(0.01),
        indenter_position_m: swings(0.011),
        position_m: swings(0.012),
        environment_force_n: falls(1.0),
        commanded_force_n: falls(1.1),
        applied_force_n: falls(1.15),
        contact_force_n: falls(1.2),
        limiters: (number % 16) as u8,
        flaws: (number % 8) as u8,
        observed_energy_j: 1e-6 * (x * 0.013).sin(),
        sensed_force_n: Some(falls(1.25)),
    }
}

fn tick(number: u64) -> TickMessage {
    tick_of(1, number)
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

/// The bytes of a log that another program has written.
fn closed(mut log: mcap::Writer<Cursor<Vec<u8>>>) -> Vec<u8> {
    log.finish().expect("finishes");
    log.into_inner().into_inner()
}

/// A message of another program, logged when it was published.
fn publish<W: Write + Seek>(
    log: &mut mcap::Writer<W>,
    channel_id: u16,
    sequence: u32,
    log_time: u64,
    bytes: &[u8],
) {
    let header = MessageHeader {
        channel_id,
        sequence,
        log_time,
        publish_time: log_time,
    };
    log.write_to_known_channel(&header, bytes).expect("writes");
}

/// The end of a run that went as planned.
fn end(planned_samples: u64, made_samples: u64) -> RunEnd {
    RunEnd {
        ended: EndKind::Finished,
        reason: String::new(),
        planned_samples,
        made_samples,
        dropped_samples: 0,
    }
}

/// Entries of this file alone.
fn entries_of(path: &Path) -> Vec<Entry> {
    let entries = LogReader::open(path).expect("opens");
    entries.collect::<Result<_, _>>().expect("reads")
}

fn ticks_in(path: &Path) -> Vec<TickMessage> {
    ticks_of(&entries_of(path))
}

fn ticks_of(entries: &[Entry]) -> Vec<TickMessage> {
    (entries.iter())
        .filter_map(|entry| {
            let Entry::Tick(message) = entry else {
                return None;
            };
            Some(*message)
        })
        .collect()
}

/// A finished log of these ticks and nothing else.
fn log_of(path: &Path, ticks: impl IntoIterator<Item = TickMessage>) {
    let mut writer = LogWriter::create(path).expect("creates");
    for tick in ticks {
        writer.tick(&tick).expect("takes");
    }
    writer.finish().expect("finishes");
}

/// A finished log of so many ticks.
fn finished(path: &Path, ticks: u64) {
    let mut writer = LogWriter::create(path).expect("creates");
    fill(&mut writer, ticks).expect("fills");
    writer.finish().expect("finishes");
}

#[test]
fn twenty_thousand_ticks_come_back_identical() -> Tested {
    let folder = Folder::empty();
    let path = folder.join("run.mcap");
    let mut writer = LogWriter::create(&path)?;
    fill(&mut writer, 20_000)?;
    assert!(!path.exists(), "an unfinished log has no name yet");
    let finished = writer.finish()?;
    assert_eq!(
        (finished.path.as_path(), finished.samples),
        (path.as_path(), 20_000)
    );
    assert_eq!(finished.bytes, fs::metadata(&path)?.len());
    assert_eq!(folder.read_dir()?.count(), 1);

    let mut reader = LogReader::open(&path)?;
    let entries: Vec<Entry> = reader.by_ref().collect::<Result<_, _>>()?;
    assert!(reader.condition().complete, "{:?}", reader.condition());
    let expected: Vec<TickMessage> = (0..20_000).map(tick).collect();
    assert!(ticks_of(&entries) == expected, "ticks differ");
    assert!(entries.contains(&Entry::Event(event(10.0))));
    assert!(matches!(&entries[0], Entry::Metadata(record) if record.values == parameters()));
    Ok(())
}

#[test]
fn a_log_without_samples_is_complete_and_empty() -> Tested {
    let folder = Folder::empty();
    let path = folder.join("empty.mcap");
    log_of(&path, []);
    let summary = inspect(&path)?;
    assert!(summary.complete);
    assert_eq!(
        (summary.samples, summary.first_s, summary.last_s),
        (0, None, None)
    );

    let csv = folder.join("empty.csv");
    assert_eq!(export_csv(&path, &csv, false)?.rows, 0);
    let text = fs::read_to_string(&csv)?;
    assert!(text.starts_with("tick,time_s,reference_m,") && text.lines().count() == 1);
    Ok(())
}

#[test]
fn missing_ticks_are_found_by_their_numbers() {
    let folder = Folder::empty();
    let path = folder.join("gaps.mcap");
    let numbers = (0..100).chain(105..200).chain(201..300).chain(299..301);
    log_of(&path, numbers.map(tick));
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

/// Run that made 1000 of 2000 ticks; what is saved of it lacks the same.
#[test]
fn ticks_missing_before_the_first_and_after_the_last_are_counted() -> Tested {
    let folder = Folder::empty();
    let (path, saved) = (folder.join("made.mcap"), folder.join("saved.mcap"));
    for (lost, [start, between, end]) in [
        (vec![0..100, 100..200], [200, 0, 0]),
        (vec![900..950, 950..1000], [0, 0, 100]),
        (vec![0..1, 7..9, 999..1000], [1, 2, 1]),
        (vec![0..500, 500..1000], [0, 0, 1000]),
    ] {
        let _ = fs::remove_file(&path);
        let missing = start + between + end;
        let mut writer = LogWriter::create(&path)?;
        for number in (0..1000).filter(|tick| !lost.iter().any(|lost| lost.contains(tick))) {
            writer.tick(&tick(number))?;
        }
        let run = RunEnd {
            ended: EndKind::Interrupted,
            reason: "for a reason".to_owned(),
            planned_samples: 2000,
            made_samples: 1000,
            dropped_samples: missing,
        };
        writer.metadata(END, run.metadata())?;
        writer.finish()?;
        let recovered = recover(&path, &saved, true)?;
        assert_eq!(recovered.missing_at_ends, [start, end]);
        for log in [&path, &saved] {
            let summary = inspect(log)?;
            let counted = [
                summary.missing_at_start,
                summary.missing_at_end,
                summary.missing_samples,
            ];
            assert_eq!(counted, [start, end, missing]);
        }
    }
    Ok(())
}

#[test]
fn what_is_not_mcap_is_refused_by_name() {
    let folder = Folder::empty();
    for (name, content) in [
        ("a.csv", "tick,time_s\n1,2\n"),
        ("empty.mcap", ""),
        ("b", "\u{89}MC"),
    ] {
        let path = folder.join(name);
        fs::write(&path, content).expect("writes");
        let error = inspect(&path).expect_err("refuses");
        assert!(matches!(error, RecordError::NotMcap { .. }), "{error:?}");
        assert_says(&error, name);
        assert!(recover(&path, &folder.join("new.mcap"), false).is_err());
    }
    let missing = folder.join("missing.mcap");
    assert!(matches!(inspect(&missing), Err(RecordError::Read { .. })));
}

#[test]
fn nothing_that_exists_is_overwritten() -> Tested {
    let folder = Folder::empty();
    let log = folder.join("run.mcap");
    finished(&log, 10);
    let taken = folder.join("taken");
    fs::write(&taken, "precious")?;
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
    assert_eq!(fs::read_to_string(&taken)?, "precious");
    assert_eq!(folder.read_dir()?.count(), 2);
    Ok(())
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
fn log_times_are_wall_clock_and_read_back_as_seconds_from_the_start() -> Tested {
    let folder = Folder::empty();
    let [dated, undated, saved, cut] =
        ["dated", "undated", "saved", "cut"].map(|name| folder.join(name));
    for (path, start) in [(&dated, Some(noon())), (&undated, None)] {
        let mut writer = LogWriter::create(path)?;
        if let Some(start) = start {
            writer.starts_at(start)?;
        }
        fill(&mut writer, 300)?;
        writer.finish()?;
    }
    let expected = Some("2026-11-20T12:31:49.000000001Z".to_owned());
    let summary = inspect(&dated)?;
    assert_eq!(summary.started_utc, expected);
    assert_eq!((summary.first_s, summary.last_s), (Some(0.0), Some(0.299)));
    // It begins in 1970, which is no date.
    assert_eq!(inspect(&undated)?.started_utc, None);

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
    let bytes = fs::read(&dated)?;
    fs::write(&cut, &bytes[..bytes.len() * 2 / 3])?;
    let samples = recover(&cut, &saved, false)?.samples;
    assert!((100..300).contains(&samples), "{samples}");
    assert_eq!(inspect(&saved)?.started_utc, expected);
    assert_eq!(times(&saved), whole[..samples as usize]);
    Ok(())
}

#[test]
fn the_csv_has_every_digit_of_every_axis() -> Tested {
    let folder = Folder::empty();
    for axes in 1..=3 {
        let [log, csv] = ["mcap", "csv"].map(|end| folder.join(format!("run{axes}.{end}")));
        log_of(&log, (0..1_000).map(|n| tick_of(axes, n)));
        let summary = export_csv(&log, &csv, false)?;
        assert_eq!((summary.rows, summary.condition.complete), (1_000, true));
        let columns = TickMessage::columns(axes);
        let mut table = csv::Reader::from_path(&csv)?;
        let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
        assert_eq!(table.headers()?, names);
        for (n, row) in table.deserialize::<Vec<f64>>().enumerate() {
            let tick = tick_of(axes, n as u64);
            let numbers = columns.iter().map(|column| column.value(&tick).to_f64());
            assert_eq!(row?, numbers.collect::<Vec<_>>());
        }
    }
    Ok(())
}

/// The reference readers of MCAP and ROS 2 messages understand the log as it was meant.
#[test]
fn foreign_readers_agree_with_the_csv_on_every_value() {
    foreign_readers_agree(|writer| fill(writer, 2_000));
    for axes in [2, 3] {
        foreign_readers_agree(|writer| (0..2_000).try_for_each(|n| writer.tick(&tick_of(axes, n))));
    }
}

#[test]
fn a_cut_log_of_several_axes_is_counted_and_saved() -> Tested {
    let folder = Folder::empty();
    let path = |name: &str| folder.join(name);
    let mut writer = LogWriter::create(&path("run.mcap"))?;
    for n in (0..500).filter(|n| *n != 250) {
        writer.tick(&tick_of(3, n))?;
    }
    assert_refused(writer.tick(&tick(500)), "same number of axes");
    writer.finish()?;
    let summary = inspect(&path("run.mcap"))?;
    assert_eq!((summary.samples, summary.gaps.len()), (499, 1));
    assert_eq!(summary.foreign_messages, 0);

    let bytes = fs::read(path("run.mcap"))?;
    fs::write(path("cut.mcap"), &bytes[..bytes.len() / 2])?;
    let saved = recover(&path("cut.mcap"), &path("saved.mcap"), false)?;
    assert!(saved.samples > 100 && !saved.complete);
    let [all, kept] = ["run.mcap", "saved.mcap"].map(|log| ticks_in(&path(log)));
    assert_eq!(kept.len() as u64, saved.samples);
    assert_eq!(all[..kept.len()], kept);
    Ok(())
}

fn foreign_readers_agree(
    fill: impl FnOnce(&mut LogWriter<BufWriter<File>>) -> Result<(), RecordError>,
) {
    let folder = Folder::empty();
    let (log, csv) = (folder.join("run.mcap"), folder.join("run.csv"));
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
    testkit::skip(&format!(
        "{missing}; `pip install mcap mcap-ros2-support`, or point PYTHON to a Python that has them"
    ));
}
