//! Logs too long for one index or one file.

use super::{damage::chunks, entries_of, noon, parameters, tick, ticks_in, ticks_of};
use haptic_log::record::{
    Damage, Entry, LogFiles, LogWriter, NEXT, ROLL_LEAST, RollingLog, export_csv, inspect, recover,
};
use haptic_message::TickMessage;
use std::{
    fs,
    path::{Path, PathBuf},
};
use testkit::{Folder, Tested};

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_very_long_log_has_an_index_of_all_of_it() -> Tested {
    // A tick in each 100 ms is a chunk each; the library keeps the index of 65 536 of them.
    let ticks = 150_000;
    let chunked = |number: u64| TickMessage {
        time_s: 0.1 * number as f64,
        ..tick(number)
    };
    let folder = Folder::empty();
    let path = folder.join("long.mcap");
    let mut writer = LogWriter::create(&path)?;
    writer.starts_at(noon())?;
    writer.metadata("experiment", parameters())?;
    (0..ticks).for_each(|n| writer.tick(&chunked(n)).expect("writes"));
    writer.finish()?;

    let summary = inspect(&path)?;
    assert!(summary.complete && summary.gaps.is_empty(), "{summary:?}");
    assert_eq!((summary.samples, summary.out_of_order), (ticks, 0));
    let bytes = fs::read(&path)?;
    let found = mcap::Summary::read(&bytes)?.expect("is there");
    let stats = found.stats.as_ref().expect("are there");
    assert_eq!((stats.message_count, stats.metadata_count), (ticks, 2));
    // 65 536 chunks of 100 ms, 32 768 of 200 ms, and the rest of 400 ms; the event channel stands in one of its own.
    let expected = 65_536 + 32_768 + (ticks - 2 * 65_536) / 4;
    let indexed = found.chunk_indexes.len() as u64;
    assert!(indexed.abs_diff(expected) < 8, "{indexed}, not {expected}");
    // Any tick is found by its time, and every one by the chunk that the index names.
    let mut sequences = Vec::new();
    for chunk in &found.chunk_indexes {
        let messages = found.stream_chunk(&bytes, chunk)?;
        sequences.extend(messages.map(|message| message.expect("is whole").sequence));
    }
    assert!(sequences.into_iter().eq(0..ticks as u32));
    assert_eq!(found.metadata_indexes.len(), 2);

    // A byte that changed is still found by its chunk.
    let chunk = chunks(&bytes)[80_000].clone();
    let mut damaged = bytes;
    damaged[chunk.end - chunk.len() / 4] ^= 0x40;
    fs::write(&path, damaged)?;
    let summary = inspect(&path)?;
    assert!(
        !summary.complete && summary.samples >= ticks - 2,
        "{}",
        summary.samples
    );
    Ok(())
}

/// The file has an index, metadata and date by itself.
fn assert_stands_alone(path: &Path) {
    let bytes = fs::read(path).expect("reads");
    let index = mcap::Summary::read(&bytes).expect("is MCAP");
    assert!(!index.expect("is there").chunk_indexes.is_empty());
    let entries = entries_of(path);
    let described = |entry: &&Entry| matches!(entry, Entry::Metadata(record) if parameters().iter().all(|(key, value)| record.values.get(key) == Some(value)));
    assert_eq!(entries.iter().filter(described).count(), 1);
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
fn a_log_in_several_files_reads_as_one() -> Tested {
    let folder = Folder::empty();
    let name = |number: usize| match number {
        1 => folder.join("run.mcap"),
        _ => folder.join(format!("run-{number:04}.mcap")),
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
        let bytes = fs::metadata(path)?.len();
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
    let summary = inspect(&name(1))?;
    assert!(summary.complete && summary.gaps.is_empty());
    assert_eq!((summary.samples, summary.last_s), (ticks, Some(59.999)));
    let named = summary.metadata.iter().map(|record| record.name.as_str());
    assert_eq!(named.collect::<Vec<_>>(), ["experiment", "clock"]);

    assert_missed(files, ticks, name);
    // Saved, all of it is one log.
    let saved = folder.join("saved.mcap");
    let summary = recover(&name(1), &saved, false)?;
    assert!(
        summary.complete && summary.missing.is_empty(),
        "{summary:?}"
    );
    assert_eq!(summary.samples, ticks);
    assert_eq!(ticks_in(&saved), all(&name(1)));
    // Nothing is written over one of its files.
    assert!(recover(&name(1), &name(2), true).is_err());
    assert!(export_csv(&name(1), &name(2), true).is_err());
    fs::rename(name(2), folder.join("aside"))?;
    let summary = recover(&name(1), &saved, true)?;
    assert!(!summary.complete && summary.missing[0].contains("run-0002.mcap"));
    fs::rename(folder.join("aside"), name(2))?;
    fs::remove_file(saved)?;
    // The file that was being written when the process died is `.part`.
    let part = folder.join(format!("run-{files:04}.mcap.part"));
    let bytes = fs::read(name(files))?;
    fs::write(&part, &bytes[..bytes.len() / 2])?;
    fs::remove_file(name(files))?;
    let summary = inspect(&name(1))?;
    assert!(!summary.complete && summary.gaps.is_empty());
    fs::remove_file(part)?;

    // A shorter log that takes the place of this leaves none of its files.
    let finished = write(10, true);
    assert_eq!(finished.paths, [name(1)]);
    assert_eq!(inspect(&name(1))?.samples, 10);
    assert_eq!(folder.read_dir()?.count(), 1);
    Ok(())
}

/// A log of so many ticks in files of 1 MB; `dies` at its last tick.
fn rolled(first: &Path, ticks: u64, overwrite: bool, dies: bool) {
    let mut log = RollingLog::create(first, parameters(), overwrite).expect("creates");
    log.roll_at(ROLL_LEAST);
    (0..ticks).for_each(|n| log.tick(&tick(n)).expect("writes"));
    if dies {
        drop(log);
    } else {
        drop(log.finish().expect("finishes"));
    }
}

#[test]
fn a_run_that_dies_over_an_older_one_is_not_continued_by_it() {
    let folder = Folder::empty();
    let name = |name: &str| folder.join(name);
    rolled(&name("run.mcap"), 60_000, false, false);
    rolled(&name("run.mcap"), 20_000, true, true);
    let summary = inspect(&name("run.mcap")).expect("inspects");
    assert!(!summary.complete, "it was cut");
    assert_eq!((summary.samples, summary.out_of_order), (20_000, 0));
    assert!(!name("run-0003.mcap").exists(), "of the old run");
}

#[test]
fn files_of_another_run_are_not_read_as_one_with_these() -> Tested {
    let folder = Folder::empty();
    let name = |name: &str| folder.join(name);
    rolled(&name("run.mcap"), 40_000, false, false);
    rolled(&name("other.mcap"), 40_000, false, false);
    fs::copy(name("other-0002.mcap"), name("run-0002.mcap"))?;
    let mut files = LogFiles::open(&name("run.mcap"))?;
    let ticks = files
        .by_ref()
        .filter(|entry| matches!(entry, Ok(Entry::Tick(_))))
        .count();
    assert!(ticks < 40_000, "{ticks}");
    let condition = files.condition();
    let other = |damage: &Damage| matches!(damage, Damage::Next { file, .. } if file.ends_with("run-0002.mcap"));
    assert!(
        !condition.complete && condition.damage.iter().any(other),
        "{condition:?}"
    );
    let kept = recover(&name("run.mcap"), &name("saved.mcap"), false)?;
    assert_eq!((kept.samples, kept.complete), (ticks as u64, false));
    Ok(())
}

/// A log of so many ticks that goes on in a file of this name.
fn goes_on(path: &Path, ticks: u64, next: Option<&str>) {
    let _ = fs::remove_file(path);
    let mut log = LogWriter::create(path).expect("creates");
    (0..ticks).for_each(|n| log.tick(&tick(n)).expect("writes"));
    let next = next.map(|name| ("file".to_owned(), name.to_owned()));
    log.metadata(NEXT, next.into_iter().collect())
        .expect("writes");
    log.finish().expect("finishes");
}

#[test]
fn a_log_that_goes_on_under_a_name_of_its_own_or_none_ends() {
    let folder = Folder::empty();
    let names = ["a.mcap", "b.mcap"].map(|name| folder.join(name));
    let nowhere = ["", ".", "..", "/", "a/.."].map(Some);
    let nowhere = nowhere.into_iter().chain([None]);
    let nowhere = nowhere.map(|name| (name, "is no name of a file"));
    let again = ["a.mcap", "b.mcap"].map(|name| (Some(name), "one of its files already"));
    for (next, words) in nowhere.chain(again) {
        goes_on(&names[0], 1, next);
        goes_on(&names[1], 1, Some("a.mcap"));
        let summary = inspect(&names[0]).expect("inspects");
        let files = 1 + u64::from(next == Some("b.mcap"));
        assert!(
            !summary.complete && summary.samples <= files,
            "{next:?}: {summary:?}"
        );
        assert!(
            summary.samples > 0 && summary.damage[0].contains(words),
            "{next:?}: {summary:?}"
        );
    }
}
