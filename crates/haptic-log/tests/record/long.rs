//! Logs too long for one index or one file.

use super::{noon, parameters, tick, ticks_of};
use haptic_log::record::{
    Entry, LogFiles, LogReader, LogWriter, ROLL_LEAST, RollingLog, TickMessage, inspect,
};
use std::fs;
use std::path::{Path, PathBuf};

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
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
    let place = within_chunk(&bytes, 100_000);
    let mut damaged = bytes;
    damaged[place] ^= 0x40;
    fs::write(&path, damaged).expect("writes");
    let summary = inspect(&path).expect("inspects");
    assert!(
        !summary.complete && summary.samples >= ticks - 2,
        "{}",
        summary.samples
    );
}

/// A byte of the records in a chunk: MCAP is magic, then records of an opcode, a length and so many bytes.
fn within_chunk(bytes: &[u8], number: usize) -> usize {
    const CHUNK: u8 = 6;
    let (mut at, mut chunks) = (8, 0);
    loop {
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().expect("eight bytes"));
        let end = at + 9 + length as usize;
        chunks += usize::from(bytes[at] == CHUNK);
        if chunks == number {
            return end - length as usize / 4;
        }
        at = end;
    }
}

/// The file has an index, metadata and date by itself.
fn assert_stands_alone(path: &Path) {
    let bytes = fs::read(path).expect("reads");
    let index = mcap::Summary::read(&bytes).expect("is MCAP");
    assert!(!index.expect("is there").chunk_indexes.is_empty());
    let own: Vec<Entry> = LogReader::open(path)
        .expect("opens")
        .collect::<Result<_, _>>()
        .expect("reads");
    let described =
        |entry: &&Entry| matches!(entry, Entry::Metadata(record) if record.values == parameters());
    assert_eq!(own.iter().filter(described).count(), 1);
}

/// A log that misses a file of its `files` is incomplete, and says which: one in the middle as well as the last.
fn assert_missed(files: usize, ticks: u64, name: impl Fn(usize) -> PathBuf) {
    for gone in [2, files] {
        let aside = name(1).with_file_name("aside");
        fs::rename(name(gone), &aside).expect("moves");
        let summary = inspect(&name(1)).expect("inspects");
        assert!(!summary.complete && summary.samples < ticks);
        let missing = format!("run-{gone:04}.mcap");
        assert!(summary.damage[0].contains(&missing), "{:?}", summary.damage);
        fs::rename(&aside, name(gone)).expect("moves back");
    }
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
        assert_stands_alone(path);
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

    assert_missed(files, ticks, name);
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
