//! Logs whose messages have other fields than ours: ours are found by their names in the schema that a log holds.

use super::{closed, finished_bytes, publish, ticks_in, ticks_of};
use haptic_log::record::{Damage, Entry, LogReader, inspect, recover};
use haptic_message::TickMessage;
use mcap::WriteOptions;
use std::{
    collections::BTreeMap,
    fs,
    io::Cursor,
    path::{Path, PathBuf},
};
use testkit::{Folder, Tested, assert_says};

/// Fields of other types before, between and behind ours, in another order; the type of one is defined further down.
const FIELDS: &str = "string<=12 name  # of the hand\nuint8 COLD=3\nint16 temperature_c\n\nfloat32[2] wrist_rad\n\
     float64 position_m 0.0\nuint64 tick\nfloat32[<=8] spectrum\nuint16[] counts\nbool held\nfloat64 commanded_force_n\n\
     float64 time_s\nstring[] notes\nuint8 limiters\nPose pose\nuint8 flaws\n\
     ================================================================================\n\
     MSG: haptics_msgs/Pose\nfloat64 roll_rad\n";
/// Bytes behind the last of ours that is read in its place: `pose` and `flaws`.
const BEHIND: usize = 9;

/// A tick in CDR, with texts and lists that are longer from tick to tick.
fn message(tick: u64) -> Vec<u8> {
    fn put(bytes: &mut Vec<u8>, size: usize, number: &[u8]) {
        let missing = (4 + size - bytes.len() % size) % size;
        bytes.extend(vec![0; missing]);
        bytes.extend(number);
    }
    fn text(bytes: &mut Vec<u8>, text: &str) {
        put(bytes, 4, &(text.len() as u32 + 1).to_le_bytes());
        bytes.extend(text.as_bytes());
        bytes.push(0);
    }
    let x = tick as f64;
    let count = (tick % 4) as u32;
    let mut bytes = vec![0, 1, 0, 0];
    text(&mut bytes, &"grip"[..count as usize]);
    put(&mut bytes, 2, &37_i16.to_le_bytes());
    (0..2).for_each(|_| put(&mut bytes, 4, &1_f32.to_le_bytes()));
    put(&mut bytes, 8, &(0.5 + x).to_le_bytes());
    put(&mut bytes, 8, &tick.to_le_bytes());
    put(&mut bytes, 4, &count.to_le_bytes());
    (0..count).for_each(|_| put(&mut bytes, 4, &1_f32.to_le_bytes()));
    put(&mut bytes, 4, &count.to_le_bytes());
    (0..count).for_each(|_| put(&mut bytes, 2, &1_u16.to_le_bytes()));
    bytes.push(1);
    put(&mut bytes, 8, &(-x).to_le_bytes());
    put(&mut bytes, 8, &(1e-3 * x).to_le_bytes());
    put(&mut bytes, 4, &2_u32.to_le_bytes());
    ["a", "bcd"].iter().for_each(|word| text(&mut bytes, word));
    bytes.push(3);
    put(&mut bytes, 8, &0.5_f64.to_le_bytes());
    bytes.push(5);
    bytes
}

fn log_of(messages: impl IntoIterator<Item = Vec<u8>>) -> Vec<u8> {
    let mut log = WriteOptions::new()
        .create(Cursor::new(Vec::new()))
        .expect("starts");
    let schema = log.add_schema("Tick", "ros2msg", FIELDS.as_bytes());
    let none = BTreeMap::new();
    log.add_channel_with_id(1, schema.expect("adds"), "/haptics/tick", "cdr", &none)
        .expect("adds");
    for (number, message) in messages.into_iter().enumerate() {
        publish(
            &mut log,
            1,
            number as u32,
            1_000_000 * number as u64,
            &message,
        );
    }
    closed(log)
}

/// Ticks as text, in which NaN equals NaN.
fn shown(ticks: &[TickMessage]) -> Vec<String> {
    ticks.iter().map(|tick| format!("{tick:?}")).collect()
}

#[test]
fn fields_are_found_by_their_names_and_what_is_not_there_is_no_number() -> Tested {
    let expected: Vec<TickMessage> = (0..40)
        .map(|tick| {
            let x = tick as f64;
            TickMessage {
                tick,
                time_s: 1e-3 * x,
                position_m: [0.5 + x].into_iter().collect(),
                commanded_force_n: [-x].into_iter().collect(),
                limiters: 3,
                flaws: 5,
                ..TickMessage::unknown(1)
            }
        })
        .collect();
    let folder = Folder::empty();
    let [path, saved] = ["a.mcap", "b.mcap"].map(|name| folder.join(name));
    fs::write(&path, log_of((0..40).map(message)))?;
    assert_eq!(shown(&ticks_in(&path)), shown(&expected));
    let summary = inspect(&path)?;
    assert!(summary.complete && summary.gaps.is_empty(), "{summary:?}");
    let kept = recover(&path, &saved, false)?;
    assert!(kept.complete && kept.samples == 40, "{kept:?}");
    assert_eq!(shown(&ticks_in(&saved)), shown(&expected));
    Ok(())
}

#[test]
fn a_tick_that_does_not_fit_its_schema_is_damage() {
    // The last byte is not there, one more is, or the fields end before the type that is defined further down.
    for (cut, more) in [(1, 0), (0, 1), (BEHIND, 0)] {
        let mut bytes = message(7);
        bytes.truncate(bytes.len() - cut);
        bytes.extend(vec![0; more]);
        let bytes = log_of([bytes]);
        let mut reader = LogReader::new(bytes.as_slice(), Path::new("odd")).expect("opens");
        let entries: Vec<Entry> = (&mut reader).map(|entry| entry.expect("reads")).collect();
        assert!(ticks_of(&entries).is_empty());
        let damage = &reader.condition().damage;
        assert!(matches!(damage[..], [Damage::Chunk { .. }]), "{damage:?}");
    }
}

/// A log of 2001 ticks, packed by a public tool, whose numbers of channels are not ours.
pub(super) fn zstd() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/record/zstd.mcap")
}

#[test]
fn a_log_that_a_public_tool_packed_with_zstd_is_read() {
    let path = zstd();
    let summary = inspect(&path).expect("inspects");
    assert!(summary.complete, "{:?}", summary.damage);
    assert_eq!((summary.samples, summary.gaps.len()), (2001, 0));
    assert_eq!((summary.first_s, summary.last_s), (Some(0.0), Some(2.0)));
}

/// The log with a compression that nobody can unpack.
pub(super) fn oddly_packed(log: &[u8]) -> Vec<u8> {
    let mut bytes = log.to_vec();
    for at in 0..log.len() - 7 {
        if &log[at..at + 7] == b"\x03\0\0\0lz4" {
            bytes[at + 4..at + 7].copy_from_slice(b"xz7");
        }
    }
    bytes
}

#[test]
fn a_compression_that_is_not_read_is_named() {
    let bytes = oddly_packed(&finished_bytes(100));
    let mut reader = LogReader::new(bytes.as_slice(), Path::new("xz")).expect("opens");
    reader.by_ref().for_each(drop);
    let damage = reader.condition().damage[0].to_string();
    assert_says(&damage, "format `xz7`");
}
