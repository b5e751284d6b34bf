//! Messages in another order than the ticks: MCAP allows it, and recorders that merge topics write it.

use super::{
    closed, end, finished_bytes,
    schemas::{oddly_packed, zstd},
    tick, ticks_in, ticks_of,
};
use haptic_log::record::{Entry, LogFiles, LogSummary, export_csv, inspect, recover, skim};
use haptic_message::{END, TickMessage};
use mcap::{Compression, Message, MessageStream, WriteOptions, records::Metadata};
use std::{fs, io::Cursor};
use testkit::{Folder, Random, Tested};

/// The messages of a log in another order, in the chunks of a public writer. It says how its run ended.
pub(super) fn reordered(
    log: &[u8],
    options: WriteOptions,
    order: impl FnOnce(&mut Vec<Message<'_>>),
) -> Vec<u8> {
    let mut messages: Vec<Message<'_>> = MessageStream::new(log)
        .expect("is MCAP")
        .collect::<Result<_, _>>()
        .expect("is whole");
    let ticks = messages.iter().filter(|message| message.channel.id == 1);
    let made_samples = ticks.count() as u64;
    order(&mut messages);
    let mut writer = options.create(Cursor::new(Vec::new())).expect("starts");
    for message in &messages {
        writer.write(message).expect("writes");
    }
    let end = Metadata {
        name: END.to_owned(),
        metadata: end(made_samples, made_samples).metadata(),
    };
    writer.write_metadata(&end).expect("writes");
    closed(writer)
}

/// Other writers: in small chunks with and without a compression, and in none.
pub(super) fn options() -> [WriteOptions; 3] {
    let small = WriteOptions::new().chunk_size(Some(4096));
    [
        small.clone().compression(Some(Compression::Lz4)),
        small.compression(None),
        WriteOptions::new().use_chunks(false),
    ]
}

/// Why it is not whole, but for the flaws that the ticks of these tests have.
pub(super) fn reasons(summary: &LogSummary) -> Vec<String> {
    let mut reasons = summary.reasons();
    reasons.retain(|reason| !reason.contains("stale"));
    reasons
}

#[test]
fn ticks_are_read_by_their_numbers_wherever_their_messages_stand() -> Tested {
    const TICKS: u64 = 1000;
    let (whole, mut random) = (finished_bytes(TICKS), Random(65));
    let folder = Folder::empty();
    let [path, saved, table] = ["a.mcap", "b.mcap", "a.csv"].map(|name| folder.join(name));
    for case in 0..12 {
        let options = options()[case % 3].clone();
        let bytes = reordered(&whole, options, |messages| match case / 3 {
            0 => messages.reverse(),
            1 => messages.rotate_left(700),
            // Each 40 among themselves, and all.
            kind => messages
                .chunks_mut(if kind == 2 { 40 } else { usize::MAX })
                .for_each(|near| near.sort_by_cached_key(|_| random.bits())),
        });
        fs::write(&path, bytes)?;
        let summary = inspect(&path)?;
        assert_eq!(reasons(&summary), [""; 0], "{case}");
        assert_eq!(
            (summary.samples, summary.missing_samples),
            (TICKS, 0),
            "{case}"
        );
        assert_eq!((summary.first_s, summary.last_s), (Some(0.0), Some(0.999)));
        assert!(
            summary.sorted_ticks.is_some_and(|ticks| ticks > 100),
            "{case}: it is said"
        );
        let entries = LogFiles::open(&path)?;
        let entries: Vec<Entry> = entries.collect::<Result<_, _>>()?;
        let expected: Vec<TickMessage> = (0..TICKS).map(tick).collect();
        assert!(ticks_of(&entries) == expected, "{case}: ticks differ");

        let exported = export_csv(&path, &table, true)?;
        assert!(exported.is_whole(), "{case}");
        let rows = fs::read_to_string(&table)?;
        let mut numbered = rows.lines().skip(1).zip(0..TICKS);
        assert!(
            numbered.all(|(row, tick)| row.starts_with(&format!("{tick},"))),
            "{case}"
        );
        assert_eq!(rows.lines().count() as u64, 1 + TICKS, "{case}");

        let kept = recover(&path, &saved, true)?;
        assert!(kept.complete, "{case}: {kept:?}");
        assert!(ticks_in(&saved) == expected, "{case}: not saved in order");
    }
    Ok(())
}

/// A log in order is given out as it is read, and a gap holds nothing back for good.
#[test]
fn what_is_in_order_is_not_called_sorted() {
    let folder = Folder::empty();
    let path = folder.join("a.mcap");
    for gap in [0..0, 0..500, 300..400, 1..1999] {
        let bytes = reordered(&finished_bytes(2000), WriteOptions::new(), |messages| {
            messages.retain(|message| !gap.contains(&message.sequence) || message.channel.id != 1);
        });
        fs::write(&path, bytes).expect("writes");
        let summary = inspect(&path).expect("inspects");
        assert_eq!((summary.sorted_ticks, summary.out_of_order), (None, 0));
        assert_eq!(summary.samples, 2000 - gap.len() as u64);
    }
}

/// Memory is bounded, so there is a tick too late: it is not missing, and the log does not pass for one in order.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn ticks_too_late_to_be_sorted_are_said_and_not_called_missing() -> Tested {
    const TICKS: u64 = 140_000;
    let folder = Folder::empty();
    let [path, table] = ["a.mcap", "a.csv"].map(|name| folder.join(name));
    let bytes = reordered(&finished_bytes(TICKS), WriteOptions::new(), |messages| {
        messages[1..].rotate_left(TICKS as usize / 2);
    });
    fs::write(&path, bytes)?;
    let summary = inspect(&path)?;
    assert_eq!((summary.samples, summary.missing_samples), (TICKS, 0));
    assert_eq!(summary.gaps, []);
    let reasons = reasons(&summary);
    assert!(
        reasons.len() == 1 && reasons[0].contains("too late"),
        "{reasons:?}"
    );
    assert!(!export_csv(&path, &table, false)?.is_whole());
    Ok(())
}

#[test]
fn a_list_reads_no_sample() -> Tested {
    let folder = Folder::empty();
    let path = folder.join("a.mcap");
    let whole = finished_bytes(2000);
    let packed = fs::read(zstd())?;
    // The last has a compression that nobody can unpack, so no byte of a chunk is looked at; its sum is wrong.
    for (bytes, whole, ticks) in [
        (packed, (true, 3), (Some(2001), Some(2.0))),
        (whole.clone(), (true, 1), (Some(2000), Some(1.999))),
        (oddly_packed(&whole), (false, 1), (Some(2000), Some(1.999))),
    ] {
        fs::write(&path, bytes)?;
        let all = skim(&path, u64::MAX)?;
        assert_eq!((all.samples, all.duration_s), ticks);
        assert_eq!((all.complete, all.metadata.len()), whole);
    }
    assert!(!inspect(&path)?.complete);
    // Of a part, and of one that was cut off: the metadata stand in front.
    fs::write(&path, &whole[..whole.len() / 2])?;
    for most in [1, 100_000] {
        let part = skim(&path, most)?;
        assert!(
            !part.complete && part.metadata.len() == usize::from(most > 1),
            "{most}"
        );
    }
    Ok(())
}
