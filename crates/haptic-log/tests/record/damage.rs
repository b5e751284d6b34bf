//! Logs that are cut off, damaged, or that the disk does not take.

use super::{
    CHUNK_TICKS, closed, fill, finished, finished_bytes,
    order::{options, reasons, reordered},
    parameters, publish,
    schemas::zstd,
    tick, ticks_in, ticks_of,
};
use haptic_log::record::{
    ATTACHMENTS, Damage, Entry, LogReader, LogWriter, NewFileError, RECOVERED, RecordError, Topic,
    export_csv, inspect, recover, skim,
};
use haptic_message::TickMessage;
use std::{
    cell::RefCell,
    fs,
    io::{self, Cursor, Seek, SeekFrom, Write},
    ops::Range,
    path::Path,
    rc::Rc,
};
use testkit::{Folder, Random, Tested, assert_says, broken, cases};

/// A sink that shares its bytes and fails once it holds `limit` of them.
#[derive(Clone)]
struct SmallDisk {
    bytes: Rc<RefCell<Vec<u8>>>,
    limit: usize,
}

impl SmallDisk {
    fn new(limit: usize) -> Self {
        let bytes = Rc::default();
        Self { bytes, limit }
    }
}

impl Write for SmallDisk {
    fn write(&mut self, data: &[u8]) -> io::Result<usize> {
        let mut bytes = self.bytes.borrow_mut();
        let taken = data.len().min(self.limit - bytes.len());
        if taken == 0 && !data.is_empty() {
            return Err(io::Error::from_raw_os_error(28)); // ENOSPC
        }
        bytes.extend_from_slice(&data[..taken]);
        Ok(taken)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for SmallDisk {
    fn seek(&mut self, _: SeekFrom) -> io::Result<u64> {
        Ok(self.bytes.borrow().len() as u64)
    }
}

/// `CAMPAIGN_CASES`: cuts to try, 25 by default.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn what_was_written_100_ms_before_any_cut_survives_it() -> Tested {
    const TICKS: u64 = 20_000;
    // How many ticks the program had produced when the file had grown to so many bytes.
    let disk = SmallDisk::new(usize::MAX);
    let mut writer = LogWriter::with_sink(disk.clone(), Path::new("disk"))?;
    writer.metadata("experiment", parameters())?;
    let mut growth = Vec::new();
    for number in 0..TICKS {
        writer.tick(&tick(number))?;
        growth.push(disk.bytes.borrow().len());
    }
    writer.close()?;
    let whole = disk.bytes.borrow().clone();

    let folder = Folder::empty();
    let mut random = Random(2);
    for round in 0..cases(25) {
        let cut = 1 + random.bits() as usize % (whole.len() - 1);
        let source = folder.join(format!("{round}.mcap.part"));
        let target = folder.join(format!("{round}.mcap"));
        fs::write(&source, &whole[..cut])?;

        let before = inspect(&source)?;
        assert!(!before.complete, "cut at {cut} of {}", whole.len());
        let summary = recover(&source, &target, false)?;
        assert!(!summary.complete && !summary.missing.is_empty());

        let produced = growth.partition_point(|&bytes| bytes <= cut) as u64;
        let kept = summary.samples;
        assert!(
            kept + CHUNK_TICKS >= produced,
            "cut at {cut}: {kept} ticks kept of {produced}"
        );
        let after = inspect(&target)?;
        assert!(after.complete && after.gaps.is_empty() && after.samples == kept);
        let last = (after.metadata.last()).expect("a recovered log is marked");
        assert_eq!(last.name, RECOVERED);
        assert_eq!(last.values["samples_kept"], kept.to_string());
        let expected: Vec<TickMessage> = (0..kept).map(tick).collect();
        assert!(ticks_in(&target) == expected, "cut at {cut}: ticks differ");
        fs::remove_file(&source)?;
        fs::remove_file(&target)?;
    }
    Ok(())
}

#[test]
fn a_killed_writer_leaves_all_but_the_last_100_ms() -> Tested {
    let folder = Folder::empty();
    let path = folder.join("run.mcap");
    let part = folder.join("run.mcap.part");
    let mut writer = LogWriter::create(&path)?;
    fill(&mut writer, 5_050)?;
    let safe = writer.samples_safe();
    // No destructor runs, as when the process is killed.
    std::mem::forget(writer);
    assert!(!path.exists());
    let summary = inspect(&part)?;
    assert!(!summary.complete);
    assert_eq!((summary.samples, safe), (5_000, 5_000));
    assert!(
        summary.damage[0].contains("ends unfinished"),
        "{:?}",
        summary.damage
    );

    // To the system this process still writes it: neither another run nor a recovery gets in its way.
    let saved = folder.join("saved.mcap");
    let tries = [
        LogWriter::create(&path).map(drop),
        recover(&part, &saved, false).map(drop),
    ];
    for error in tries.map(|tried| tried.expect_err("refuses")) {
        assert!(
            matches!(error, RecordError::File(NewFileError::BeingWritten(_))),
            "{error}"
        );
        let text = error.to_string();
        assert_says(&text, "is being written by another run");
    }
    assert!(!saved.exists());

    // A copy is what a killed process leaves. The next run under this name does not destroy it.
    let (path, written) = (folder.join("killed.mcap"), part);
    let part = folder.join("killed.mcap.part");
    fs::copy(&written, &part)?;
    let error = LogWriter::create(&path).expect_err("refuses");
    assert!(matches!(
        error,
        RecordError::File(NewFileError::Leftover(_))
    ));
    assert_says(&error, "log recover");
    let saved = recover(&part, &saved, false)?;
    assert_eq!((saved.samples, saved.events), (5_000, 1));
    Ok(())
}

#[test]
fn a_dropped_writer_keeps_everything_but_does_not_look_finished() -> Tested {
    let folder = Folder::empty();
    let path = folder.join("run.mcap");
    let mut writer = LogWriter::create(&path)?;
    fill(&mut writer, 5_050)?;
    drop(writer);
    assert!(!path.exists());
    let summary = inspect(&folder.join("run.mcap.part"))?;
    assert_eq!((summary.samples, summary.complete), (5_050, false));
    Ok(())
}

#[test]
fn a_damaged_chunk_costs_its_own_100_ms_and_nothing_else() -> Tested {
    let mut bytes = finished_bytes(10_000);
    let middle = bytes.len() / 2;
    // Far from any record header: 100 ticks of 92 random bytes make chunks of several kB.
    bytes[middle] ^= 0x10;
    let mut reader = LogReader::new(bytes.as_slice(), Path::new("memory"))?;
    let entries: Vec<Entry> = reader.by_ref().collect::<Result<_, _>>()?;
    let condition = reader.condition();
    assert!(!condition.complete);
    assert!(
        matches!(condition.damage[0], Damage::Chunk { .. }),
        "{condition:?}"
    );
    assert_eq!(ticks_of(&entries).len() as u64, 10_000 - CHUNK_TICKS);

    let folder = Folder::empty();
    let damaged = folder.join("damaged.mcap");
    fs::write(&damaged, &bytes)?;
    let summary = inspect(&damaged)?;
    assert_eq!(summary.gaps.len(), 1);
    assert_eq!(summary.gaps[0].missing, CHUNK_TICKS);
    let saved = recover(&damaged, &folder.join("saved.mcap"), false)?;
    assert_eq!(saved.samples, 10_000 - CHUNK_TICKS);
    let sentences = saved.missing.join("\n");
    assert_says(&sentences, "100 ticks between");
    Ok(())
}

#[test]
fn bytes_behind_the_records_of_a_chunk_are_none_of_them() {
    // One record of a kind that nobody knows, of two bytes, that says it has more; and bytes behind it.
    for (length, whole) in [(2_u64, true), (3, false), (6, false)] {
        let record = [&[0x88], length.to_le_bytes().as_slice(), &[1, 2]].concat();
        let bytes = packed(1, 0, "", &record, &[7; 5]);
        let mut reader = LogReader::new(bytes.as_slice(), Path::new("padded")).expect("is MCAP");
        assert_eq!((&mut reader).count(), 0);
        let damage = &reader.condition().damage;
        let lost = (damage.iter()).any(|damage| matches!(damage, Damage::Chunk { .. }));
        assert_eq!(lost, !whole, "{length}: {damage:?}");
    }
}

#[test]
fn the_length_of_a_text_is_not_believed() {
    let mut bytes = finished_bytes(10);
    let name = b"\x0a\0\0\0experiment";
    let at = (bytes.windows(name.len()))
        .position(|window| window == name)
        .expect("its metadata");
    // 4 GiB, which nobody should ask the system for.
    bytes[at..at + 4].fill(0xff);
    let mut reader = LogReader::new(Cursor::new(bytes), Path::new("long")).expect("is MCAP");
    let entries: Vec<Entry> = (&mut reader).map(|entry| entry.expect("read")).collect();
    assert_eq!(ticks_of(&entries).len(), 10);
    assert!(
        (reader.condition().damage.iter())
            .any(|damage| damage.to_string().contains("longer than the record")),
        "{:?}",
        reader.condition()
    );
}

#[test]
fn a_full_disk_says_which_file_and_how_much_is_safe_and_loses_no_more() {
    let whole = finished_bytes(3_000).len();
    let mut random = Random(4);
    let limits = std::iter::repeat_with(|| random.bits() as usize % whole);
    let mut limits: Vec<usize> = limits.take(60).collect();
    limits.extend([0, 7, 8, whole - 1]);
    for limit in limits {
        let disk = SmallDisk::new(limit);
        let path = Path::new("run.mcap.part");
        let result = LogWriter::with_sink(disk.clone(), path).and_then(|mut writer| {
            let filled = fill(&mut writer, 3_000);
            if filled.is_err() {
                // The writer stays usable for the same answer, and its drop must not panic.
                assert!(writer.tick(&tick(3_000)).is_err());
                return filled;
            }
            writer.close().map(drop)
        });
        let error = result.expect_err("the disk is too small");
        let RecordError::Write {
            samples_safe,
            source,
            ..
        } = &error
        else {
            panic!("{error:?}");
        };
        assert_eq!(source.raw_os_error(), Some(28));
        let text = error.to_string();
        let safe = match samples_safe {
            0 => "no sample is in it: remove it, make space".to_owned(),
            count => {
                format!(
                    "{count} samples are safe in it; make space, then save them with `host-cli log recover`"
                )
            }
        };
        for part in ["run.mcap.part", &safe, "No space"] {
            assert!(text.contains(part), "`{part}` is not in: {text}");
        }
        assert!(!text.contains('\n'));
        let bytes = disk.bytes.borrow();
        if bytes.is_empty() {
            continue;
        }
        let reader = LogReader::new(bytes.as_slice(), path).expect("opens");
        let entries: Vec<Entry> = reader.collect::<Result<_, _>>().expect("reads");
        let recovered = ticks_of(&entries);
        assert!(recovered.len() as u64 >= *samples_safe, "limit {limit}");
        assert!(recovered == (0..recovered.len() as u64).map(tick).collect::<Vec<_>>());
    }
}

#[test]
fn a_recovered_log_replaces_another_only_when_asked_and_never_its_source() -> Tested {
    let folder = Folder::empty();
    let log = folder.join("run.mcap");
    finished(&log, 10);
    let whole = fs::read(&log)?;
    let old = folder.join("old.mcap");
    fs::write(&old, "old")?;
    recover(&log, &old, false).expect_err("not asked");
    assert_eq!(fs::read(&old)?, b"old");
    assert_eq!(recover(&log, &old, true)?.samples, 10);

    // By its own name, and by another one.
    let link = folder.join("link.mcap");
    fs::hard_link(&log, &link)?;
    for (source, target) in [(&log, &log), (&log, &link)] {
        let errors = [
            recover(source, target, true)
                .map(drop)
                .expect_err("refuses"),
            export_csv(source, target, true)
                .map(drop)
                .expect_err("refuses"),
        ];
        for error in errors {
            let is_own = matches!(error, RecordError::File(NewFileError::OwnSource(_)));
            assert!(is_own, "{error:?}");
        }
        assert_eq!(fs::read(source)?, whole);
    }
    Ok(())
}

#[test]
fn a_log_whose_writer_died_before_the_first_byte_is_an_empty_one() -> Tested {
    let folder = Folder::empty();
    let part = folder.join("run.mcap.part");
    fs::write(&part, "")?;
    let saved = folder.join("saved.mcap");
    let summary = recover(&part, &saved, false)?;
    assert!(!summary.complete && summary.samples == 0, "{summary:?}");
    assert!(inspect(&saved)?.complete);
    Ok(())
}

/// A log of a file, with something done to its unfinished file after so many ticks.
fn meddled(done: impl Fn(&Path)) -> RecordError {
    let folder = Folder::empty();
    let mut writer = LogWriter::create(&folder.join("run.mcap")).expect("creates");
    for n in 0..3 * CHUNK_TICKS {
        if n == 2 * CHUNK_TICKS {
            done(&folder.join("run.mcap.part"));
        }
        writer.tick(&tick(n)).expect("takes it");
    }
    let error = writer.finish().expect_err("it is not whole");
    assert!(!folder.join("run.mcap").exists());
    error
}

#[test]
fn a_log_that_somebody_removes_or_empties_is_not_called_whole() {
    let words = |done: fn(&Path)| {
        let error = meddled(done);
        assert!(matches!(error, RecordError::Lost { .. }), "{error}");
        error.to_string()
    };
    assert!(words(|part| fs::remove_file(part).expect("removes")).contains("was removed"));
    assert!(
        words(|part| drop(fs::File::create(part).expect("empties"))).contains("was emptied or cut")
    );
}

#[test]
fn a_sound_log_of_others_is_not_an_empty_table() -> Tested {
    let folder = Folder::empty();
    let [path, table] = ["theirs.mcap", "table.csv"].map(|name| folder.join(name));
    let mut log = mcap::Writer::new(Cursor::new(Vec::new()))?;
    for (id, topic) in [(7, "/camera/image"), (9, "/joint_states")] {
        log.add_channel_with_id(id, 0, topic, "json", &Default::default())?;
        publish(&mut log, id, 0, 0, b"{}");
    }
    let attached = mcap::Attachment {
        log_time: 0,
        create_time: 0,
        name: "notes.txt".to_owned(),
        media_type: "text/plain".to_owned(),
        data: b"cold".into(),
    };
    log.attach(&attached)?;
    fs::write(&path, closed(log))?;
    let error = export_csv(&path, &table, false).expect_err("has no ticks");
    assert!(matches!(error, RecordError::NoTicks { .. }), "{error:?}");
    let text = error.to_string();
    assert_says(&text, "/camera/image, /joint_states");
    // A copy of it lacks them, and that is said.
    let files = folder.read_dir()?;
    assert_eq!(files.count(), 1, "no table");
    let saved = recover(&path, &table, false)?;
    let words = &saved.missing[0];
    assert!(
        !saved.complete && words.starts_with("3 messages on topics"),
        "{words}"
    );
    let summary = inspect(&path)?;
    assert!(summary.complete && summary.foreign_messages == 3);
    let topics = summary.foreign_topics.keys();
    assert!(topics.eq([ATTACHMENTS, "/camera/image", "/joint_states"]));
    Ok(())
}

/// Every message has its time, read or not: Python writes `NaN`, which is not JSON.
#[test]
fn times_count_from_the_first_message_though_it_is_no_number() -> Tested {
    let folder = Folder::empty();
    let path = folder.join("theirs.mcap");
    for (first, rows) in [
        ("NaN", 2),
        ("null", 3),
        ("{\"x\": \"warm\"}", 3),
        ("{\"x\": 0}", 3),
    ] {
        let mut log = mcap::Writer::new(Cursor::new(Vec::new()))?;
        log.add_channel_with_id(7, 0, "/grip_force", "json", &Default::default())?;
        for (n, text) in [first, "{\"x\": 1}", "{\"x\": 2}"].into_iter().enumerate() {
            let time = 5_000_000_000 + 10_000_000 * n as u64;
            publish(&mut log, 7, n as u32, time, text.as_bytes());
        }
        fs::write(&path, closed(log))?;
        let topic = Topic::read(&path, &[])?;
        let times = [0.0, 0.01, 0.02];
        let (name, column) = &topic.columns[0];
        assert_eq!(
            (name.as_str(), &column[..]),
            ("time_s", &times[3 - rows..]),
            "{first}"
        );
        assert_eq!(topic.notes.len(), 3 - rows, "{first}: {:?}", topic.notes);
    }
    Ok(())
}

/// A log of so many chunks that say to unpack to so many bytes, with something behind their records.
fn packed(chunks: usize, size: u64, compression: &str, records: &[u8], behind: &[u8]) -> Vec<u8> {
    let mut log = b"\x89MCAP0\r\n".to_vec();
    for _ in 0..chunks {
        let mut chunk = vec![0; 16];
        chunk.extend(size.to_le_bytes());
        chunk.extend([0; 4]);
        chunk.extend((compression.len() as u32).to_le_bytes());
        chunk.extend(compression.as_bytes());
        chunk.extend((records.len() as u64).to_le_bytes());
        chunk.extend([records, behind].concat());
        log.push(6);
        log.extend((chunk.len() as u64).to_le_bytes());
        log.extend(chunk);
    }
    log
}

/// A frame of zstd that unpacks to so many zeros, 4 bytes for each 128 kB: RFC 8878, blocks of type 1.
fn zeros(size: u32) -> Vec<u8> {
    let mut frame = b"\x28\xb5\x2f\xfd\xa0".to_vec();
    frame.extend(size.to_le_bytes());
    for at in (0..size).step_by(1 << 17) {
        let block = (size - at).min(1 << 17);
        let is_last = u32::from(at + block == size);
        frame.extend(&(is_last | 2 | block << 3).to_le_bytes()[..3]);
        frame.push(0);
    }
    frame
}

#[test]
fn a_log_that_unpacks_without_an_end_is_left() {
    let read = |log: &[u8]| {
        let mut reader = LogReader::new(log, Path::new("packed")).expect("is MCAP");
        assert_eq!((&mut reader).count(), 0);
        reader.condition().damage.clone()
    };
    // Zeros are given up at the first of them.
    let damage = read(&packed(2, 1 << 22, "zstd", &zeros(1 << 22), &[]));
    assert!(damage[0].to_string().contains("of no kind"), "{damage:?}");
    for compression in ["zstd", "lz4"] {
        // 32 MB a chunk: a GiB is 32 of them, whatever comes of them.
        let damage = read(&packed(50, 1 << 25, compression, b"cut", &[]));
        assert_eq!(damage.len(), 32 + 1, "{compression}");
        let words = damage[32].to_string();
        assert!(
            matches!(damage[32], Damage::Structure { .. }) && words.contains("64 times"),
            "{words}"
        );
        // A length that is not believed does not count.
        let damage = read(&packed(50, 1 << 40, compression, b"cut", &[]));
        assert_eq!(damage.len(), 50 + 1, "{compression}");
        assert!(damage[0].to_string().contains("more than"), "{damage:?}");
    }
}

/// The places of the chunks of a log: MCAP is magic, then records of an opcode, a length and so many bytes.
pub(super) fn chunks(log: &[u8]) -> Vec<Range<usize>> {
    let mut places = Vec::new();
    let mut at = 8;
    while at + 9 < log.len() {
        let length = u64::from_le_bytes(log[at + 1..at + 9].try_into().expect("eight bytes"));
        places.push(at..at + 9 + length as usize);
        at += 9 + length as usize;
    }
    places.retain(|record| log[record.start] == 6);
    places
}

/// A log with one damage, of any file or of one that knows its records.
fn damaged(log: &[u8], random: &mut Random) -> Vec<u8> {
    let (chunks, kind) = (chunks(log), random.bits() % 8);
    if kind < 4 || chunks.len() < 2 {
        return broken(log, random);
    }
    let at = random.bits() as usize % (chunks.len() - 1);
    let behind: Vec<&Range<usize>> = chunks[at + 1..].iter().collect();
    let (one, other) = (chunks[at].clone(), random.one_of(&behind).clone());
    let mut bytes = log.to_vec();
    match kind {
        4 => {
            let between = &log[one.end..other.start];
            let swapped = [&log[other.clone()], between, &log[one.clone()]].concat();
            bytes.splice(one.start..other.end, swapped);
        }
        5 => drop(bytes.drain(one)),
        6 => drop(bytes.splice(one.end..one.end, log[other].iter().copied())),
        // Length of the record, of the chunk once unpacked, of what it is packed to.
        _ => {
            let place = one.start + random.one_of(&[1, 9 + 16, 9 + 32, 9 + 35]);
            let length = (1_u64 << (random.bits() % 64)).wrapping_sub(random.bits() % 3);
            bytes[place..place + 8].copy_from_slice(&length.to_le_bytes());
        }
    }
    bytes
}

/// Logs of every kind, with the number of the ticks of each: ours, repacked by others with and without sums, cut off, theirs.
fn kinds_of_logs() -> Vec<(&'static str, Vec<u8>, u64)> {
    const TICKS: u64 = 600;
    let ours = finished_bytes(TICKS);
    let bare = |options: &mcap::WriteOptions| {
        let options = options.clone().calculate_chunk_crcs(false);
        options
            .calculate_data_section_crc(false)
            .calculate_summary_section_crc(false)
    };
    let [lz4, plain, unchunked] = options();
    let reversed = reordered(&ours, lz4.clone(), |messages| messages.reverse());
    let repacked = [
        ("lz4 without sums", bare(&lz4)),
        ("plain without sums", bare(&plain)),
        ("lz4", lz4),
        ("without chunks", unchunked),
    ];
    let repacked = repacked.map(|(name, options)| (name, reordered(&ours, options, |_| ()), TICKS));
    let mut logs = vec![
        ("reversed", reversed, TICKS),
        ("zstd", fs::read(zstd()).expect("reads"), 2001),
        ("ours", ours, TICKS),
    ];
    logs.extend(repacked);
    logs
}

/// Time of a processor that this thread has taken, s; 0 where the system does not say it.
fn processor_s() -> f64 {
    let words = fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let taken = words
        .split(' ')
        .next()
        .and_then(|ns| ns.parse::<f64>().ok());
    1e-9 * taken.unwrap_or(0.0)
}

/// Counts of a log that is broken, by what reads it: true where something calls it whole.
fn read_in_every_way(path: &Path, folder: &Path) -> [(bool, u64); 3] {
    let Ok(summary) = inspect(path) else {
        return [(false, 0); 3];
    };
    let _ = skim(path, u64::MAX);
    let _ = Topic::read(path, &[]);
    let exported = export_csv(path, &folder.join("a.csv"), true);
    let exported = exported.map_or((false, 0), |table| (table.is_whole(), table.rows));
    let saved = recover(path, &folder.join("saved.mcap"), true);
    let saved = saved.map_or((false, 0), |saved| (saved.complete, saved.samples));
    [
        (reasons(&summary).is_empty(), summary.samples),
        exported,
        saved,
    ]
}

/// `CAMPAIGN_CASES`: broken logs, 42 by default. The smallest damage may hit what nobody needs; a tick that is gone is said.
#[test]
fn broken_logs_never_panic_never_lose_in_silence_and_never_take_long() {
    let folder = Folder::empty();
    let path = folder.join("broken.mcap");
    let (logs, mut random) = (kinds_of_logs(), Random(65));
    let (mut whole, mut slowest_s) = (0, 0.0_f64);
    let cases = cases(42);
    for case in 0..cases {
        let (name, log, ticks) = &logs[case % logs.len()];
        fs::write(&path, damaged(log, &mut random)).expect("writes");
        let before_s = processor_s();
        let found = std::panic::catch_unwind(|| read_in_every_way(&path, &folder));
        let found = found.unwrap_or_else(|_| panic!("case {case}, {name}"));
        slowest_s = slowest_s.max(processor_s() - before_s);
        for (is_whole, samples) in found {
            whole += u32::from(is_whole);
            assert!(
                !is_whole || samples == *ticks,
                "case {case}, {name}: {found:?} of {ticks}"
            );
        }
    }
    let words =
        format!("{cases} broken logs, read as whole {whole} times, slowest {slowest_s:.2} s");
    println!("{words}");
    assert!(slowest_s < 5.0, "{words}");
    assert!(whole > 0 && whole < cases as u32, "{words}");
}
