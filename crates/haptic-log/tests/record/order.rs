//! Messages in another order than the ticks: MCAP allows it, and recorders that merge topics write it.

use super::{finished_bytes, tick, ticks_of};
use haptic_log::record::{
    END, EndKind, Entry, LogFiles, LogReader, LogSummary, RunEnd, Skimmed, TickMessage, export_csv,
    inspect, recover, skim,
};
use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, Message, MessageStream, WriteOptions};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng as _, SeedableRng as _};
use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::path::Path;

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
    let mut known = BTreeMap::new();
    for message in &messages {
        let (channel, bytes) = (&message.channel, &message.data);
        known.entry(channel.id).or_insert_with(|| {
            let schema = channel.schema.as_ref().expect("has one");
            let schema = writer.add_schema(&schema.name, &schema.encoding, &schema.data);
            let none = BTreeMap::new();
            writer
                .add_channel_with_id(
                    channel.id,
                    schema.expect("adds"),
                    &channel.topic,
                    "cdr",
                    &none,
                )
                .expect("adds");
        });
        let header = MessageHeader {
            channel_id: channel.id,
            sequence: message.sequence,
            log_time: message.log_time,
            publish_time: message.publish_time,
        };
        writer
            .write_to_known_channel(&header, bytes)
            .expect("writes");
    }
    let end = RunEnd {
        ended: EndKind::Finished,
        reason: String::new(),
        planned_samples: made_samples,
        made_samples,
        dropped_samples: 0,
    };
    let metadata = end.metadata();
    let end = Metadata {
        name: END.to_owned(),
        metadata,
    };
    writer.write_metadata(&end).expect("writes");
    writer.finish().expect("finishes");
    writer.into_inner().into_inner()
}

fn shuffle<T>(items: &mut [T], random: &mut Pcg64) {
    for last in (1..items.len()).rev() {
        items.swap(last, random.next_u64() as usize % (last + 1));
    }
}

/// Why it is not whole, but for the flaws that the ticks of these tests have.
fn reasons(summary: &LogSummary) -> Vec<String> {
    let mut reasons = summary.reasons();
    reasons.retain(|reason| !reason.contains("stale"));
    reasons
}

#[test]
fn ticks_are_read_by_their_numbers_wherever_their_messages_stand() {
    const TICKS: u64 = 1000;
    let (whole, mut random) = (finished_bytes(TICKS), Pcg64::seed_from_u64(65));
    let folder = tempfile::tempdir().expect("folder");
    let [path, saved, table] = ["a.mcap", "b.mcap", "a.csv"].map(|name| folder.path().join(name));
    let small = || WriteOptions::new().chunk_size(Some(4096));
    for case in 0..12 {
        let options = match case % 3 {
            0 => small().compression(Some(Compression::Lz4)),
            1 => small().compression(None),
            _ => WriteOptions::new().use_chunks(false),
        };
        let bytes = reordered(&whole, options, |messages| match case / 3 {
            0 => messages.reverse(),
            1 => messages.rotate_left(700),
            2 => messages
                .chunks_mut(40)
                .for_each(|near| shuffle(near, &mut random)),
            _ => shuffle(messages, &mut random),
        });
        fs::write(&path, bytes).expect("writes");
        let summary = inspect(&path).expect("inspects");
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
        let entries = LogFiles::open(&path).expect("opens");
        let entries: Vec<Entry> = entries.map(|entry| entry.expect("reads")).collect();
        let expected: Vec<TickMessage> = (0..TICKS).map(tick).collect();
        assert!(ticks_of(&entries) == expected, "{case}: ticks differ");

        let exported = export_csv(&path, &table, true).expect("exports");
        assert!(exported.is_whole(), "{case}");
        let rows = fs::read_to_string(&table).expect("reads");
        let numbers = rows
            .lines()
            .skip(1)
            .map(|row| row.split(',').next().expect("a cell"));
        assert!(
            numbers.eq((0..TICKS).map(|tick| tick.to_string())),
            "{case}"
        );

        let kept = recover(&path, &saved, true).expect("saves");
        assert!(kept.complete, "{case}: {kept:?}");
        let entries = LogReader::open(&saved).expect("opens");
        let entries: Vec<Entry> = entries.map(|entry| entry.expect("reads")).collect();
        assert!(
            ticks_of(&entries) == expected,
            "{case}: what is saved is in order"
        );
    }
}

/// A log in order is given out as it is read, and a gap holds nothing back for good.
#[test]
fn what_is_in_order_is_not_called_sorted() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("a.mcap");
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
fn ticks_too_late_to_be_sorted_are_said_and_not_called_missing() {
    const TICKS: u64 = 140_000;
    let folder = tempfile::tempdir().expect("folder");
    let [path, table] = ["a.mcap", "a.csv"].map(|name| folder.path().join(name));
    let bytes = reordered(&finished_bytes(TICKS), WriteOptions::new(), |messages| {
        messages[1..].rotate_left(TICKS as usize / 2);
    });
    fs::write(&path, bytes).expect("writes");
    let summary = inspect(&path).expect("inspects");
    assert_eq!((summary.samples, summary.missing_samples), (TICKS, 0));
    assert_eq!(summary.gaps, []);
    let reasons = reasons(&summary);
    assert!(
        reasons.len() == 1 && reasons[0].contains("too late"),
        "{reasons:?}"
    );
    assert!(
        !export_csv(&path, &table, false)
            .expect("exports")
            .is_whole()
    );
}

/// Of a log that a public tool packed, whose numbers of channels are not ours.
#[test]
fn a_list_reads_no_sample() {
    let layouts = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/record/layouts");
    let packed = skim(&layouts.join("zstd.mcap"), u64::MAX).expect("skims");
    let ticks = |skimmed: &Skimmed| (skimmed.samples, skimmed.duration_s);
    assert_eq!(
        (ticks(&packed), packed.complete),
        ((Some(2001), Some(2.0)), true)
    );
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("a.mcap");
    let whole = finished_bytes(2000);
    fs::write(&path, &whole).expect("writes");
    let all = skim(&path, u64::MAX).expect("skims");
    assert_eq!(
        (ticks(&all), all.complete),
        ((Some(2000), Some(1.999)), true)
    );
    assert_eq!(all.metadata.len(), 1);
    // A compression that nobody can unpack, so no byte of a chunk is looked at.
    let mut packed = whole.clone();
    for at in 0..packed.len() - 7 {
        if &packed[at..at + 7] == b"\x03\0\0\0lz4" {
            packed[at + 4..at + 7].copy_from_slice(b"xz7");
        }
    }
    fs::write(&path, packed).expect("writes");
    let odd = skim(&path, u64::MAX).expect("skims");
    assert_eq!(ticks(&odd), ticks(&all));
    assert!(!inspect(&path).expect("inspects").complete);
    // Of a part, and of one that was cut off: the metadata stand in front.
    fs::write(&path, &whole[..whole.len() / 2]).expect("writes");
    for most in [1, 100_000] {
        let part = skim(&path, most).expect("skims");
        assert!(
            !part.complete && part.metadata.len() == usize::from(most > 1),
            "{most}"
        );
    }
}
