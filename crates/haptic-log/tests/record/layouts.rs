//! Logs of every layout so far, frozen in `layouts/`, and logs with other columns than ours: fields are found by their
//! names in the schema that a log holds.

use super::damage::changed;
use super::{closed, noon, publish, ticks_in, ticks_of};
use haptic_log::record::{
    Damage, Entry, EventMessage, LogReader, PerAxis, TickMessage, export_csv, inspect, recover,
};
use mcap::{Compression, WriteOptions};
use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use testkit::{Folder, Random, assert_says, cases};

/// Ticks in each.
const TICKS: u64 = 40;

/// A schema of the ticks, by its date: topic, type, definition. Comments of the definitions are shortened.
struct Layout {
    name: &'static str,
    topic: &'static str,
    kind: &'static str,
    axes: usize,
    fields: &'static str,
}

const TICK: &str = "/haptics/tick";
const VECTOR: &str = "/haptics/vector_tick";

const LAYOUTS: [Layout; 8] = [
    Layout {
        name: "2026-11-20-tick",
        topic: TICK,
        kind: "Tick",
        axes: 1,
        fields: "uint64 tick  # number of the tick\nfloat64 time_s\nfloat64 reference_m\nfloat64 indenter_position_m\n\
                 float64 position_m\nfloat64 environment_force_n\nfloat64 force_n\nfloat64 contact_force_n\nuint8 limiters\n",
    },
    Layout {
        name: "2026-11-20-tick-energy",
        topic: TICK,
        kind: "Tick",
        axes: 1,
        fields: "uint64 tick\nfloat64 time_s\nfloat64 reference_m\nfloat64 indenter_position_m\nfloat64 position_m\n\
                 float64 environment_force_n\nfloat64 force_n\nfloat64 contact_force_n\nuint8 limiters  # bits: 1 magnitude\n\
                 float64 observed_energy_j\n",
    },
    Layout {
        name: "2026-11-21-vector-tick",
        topic: VECTOR,
        kind: "VectorTick",
        axes: 2,
        fields: "uint64 tick\nfloat64 time_s\nfloat64[] reference_m\nfloat64[] indenter_position_m\nfloat64[] position_m\n\
                 float64[] environment_force_n\nfloat64[] force_n\nfloat64[] contact_force_n\nuint8 limiters\n\
                 float64 observed_energy_j\n",
    },
    Layout {
        name: "2026-11-22-tick",
        topic: TICK,
        kind: "Tick",
        axes: 1,
        fields: "uint64 tick\nfloat64 time_s\nfloat64 reference_m\nfloat64 indenter_position_m\nfloat64 position_m\n\
                 float64 environment_force_n\nfloat64 commanded_force_n\nfloat64 applied_force_n\nfloat64 contact_force_n\n\
                 uint8 limiters\nuint8 flaws\nfloat64 observed_energy_j\n",
    },
    Layout {
        name: "2026-11-22-vector-tick",
        topic: VECTOR,
        kind: "VectorTick",
        axes: 3,
        fields: "uint64 tick\nfloat64 time_s\nfloat64[] reference_m\nfloat64[] indenter_position_m\nfloat64[] position_m\n\
                 float64[] environment_force_n\nfloat64[] commanded_force_n\nfloat64[] applied_force_n\n\
                 float64[] contact_force_n\nuint8 limiters\nuint8 flaws\nfloat64 observed_energy_j\n",
    },
    Layout {
        name: "2026-11-23-tick2",
        topic: TICK,
        kind: "Tick2",
        axes: 2,
        fields: "uint64 tick\nfloat64 time_s\nfloat64 reference_x_m\nfloat64 reference_y_m\nfloat64 indenter_position_x_m\n\
                 float64 indenter_position_y_m\nfloat64 position_x_m\nfloat64 position_y_m\nfloat64 environment_force_x_n\n\
                 float64 environment_force_y_n\nfloat64 commanded_force_x_n\nfloat64 commanded_force_y_n\n\
                 float64 applied_force_x_n\nfloat64 applied_force_y_n\nfloat64 contact_force_x_n\nfloat64 contact_force_y_n\n\
                 uint8 limiters\nuint8 flaws\nfloat64 observed_energy_j\n",
    },
    // Never written by us: fields of other types before, between and behind ours, in another order.
    Layout {
        name: "other-fields",
        topic: TICK,
        kind: "Tick",
        axes: 1,
        fields: "string<=12 name  # of the hand\nuint8 COLD=3\nint16 temperature_c\n\nfloat32[2] wrist_rad\nfloat64 position_m 0.0\n\
                 uint64 tick\nfloat32[<=8] spectrum\nuint16[] counts\nbool held\nfloat64 commanded_force_n\nfloat64 time_s\n\
                 string[] notes\nuint8 limiters\n",
    },
    // Fields of ours behind one whose type is defined further down.
    Layout {
        name: "other-types-behind",
        topic: TICK,
        kind: "Tick",
        axes: 1,
        fields: "uint64 tick\nfloat64 time_s\nfloat64 position_m\nfloat64 commanded_force_n\nPose pose\nuint8 flaws\n\
                 ================================================================================\nMSG: haptics_msgs/Pose\n\
                 float64 roll_rad\n",
    },
];

/// A number that tells field, axis and tick.
fn value(field: &str, axis: usize, tick: u64) -> f64 {
    let letters: u32 = field.bytes().map(u32::from).sum();
    f64::from(letters) + 0.25 * axis as f64 + 1e-3 * tick as f64
}

/// Field and axis of a column's name.
fn split(column: &str) -> (String, usize) {
    let axes = ["_x_", "_y_", "_z_"].iter().enumerate();
    let mut found = axes.filter(|(_, letter)| column.contains(**letter));
    (found.next()).map_or((column.to_owned(), 0), |(axis, letter)| {
        (column.replace(letter, "_"), axis)
    })
}

/// CDR bytes of a field, as the standard has them.
fn put(bytes: &mut Vec<u8>, kind: &str, name: &str, axes: usize, tick: u64) {
    fn aligned(bytes: &mut Vec<u8>, number: &[u8]) {
        while !(bytes.len() - 4).is_multiple_of(number.len()) {
            bytes.push(0);
        }
        bytes.extend(number);
    }
    fn text(bytes: &mut Vec<u8>, text: &str) {
        aligned(bytes, &(text.len() as u32 + 1).to_le_bytes());
        bytes.extend(text.as_bytes());
        bytes.push(0);
    }
    let (field, axis) = split(name);
    match kind {
        "uint64" => aligned(bytes, &tick.to_le_bytes()),
        "float64" if name == "time_s" => aligned(bytes, &(1e-3 * tick as f64).to_le_bytes()),
        "float64" => aligned(bytes, &value(&field, axis, tick).to_le_bytes()),
        "float64[]" => {
            aligned(bytes, &(axes as u32).to_le_bytes());
            (0..axes).for_each(|axis| aligned(bytes, &value(name, axis, tick).to_le_bytes()));
        }
        "uint8" | "bool" => bytes.push((tick % 3) as u8),
        "int16" => aligned(bytes, &37_i16.to_le_bytes()),
        "string<=12" => text(bytes, &"grip"[..(tick % 4) as usize]),
        "float32[2]" => (0..2).for_each(|_| aligned(bytes, &1_f32.to_le_bytes())),
        "float32[<=8]" | "uint16[]" => {
            let count = (tick % 5) as u32;
            aligned(bytes, &count.to_le_bytes());
            let item: &[u8] = if kind == "uint16[]" { &[1; 2] } else { &[1; 4] };
            (0..count).for_each(|_| aligned(bytes, item));
        }
        "string[]" => {
            aligned(bytes, &2_u32.to_le_bytes());
            ["a", "bcd"].iter().for_each(|word| text(bytes, word));
        }
        "Pose" => aligned(bytes, &0.5_f64.to_le_bytes()),
        _ => panic!("{kind}"),
    }
}

impl Layout {
    /// Type and name of each field.
    fn lines(&self) -> impl Iterator<Item = (&str, &str)> {
        let lines = self
            .fields
            .lines()
            .take_while(|line| !line.starts_with('='));
        lines.filter_map(|line| {
            let mut words = line.split('#').next()?.split_whitespace();
            Some((words.next()?, words.next()?)).filter(|(_, name)| !name.contains('='))
        })
    }

    /// A log of it.
    fn log(&self) -> Vec<u8> {
        let mut log = WriteOptions::new()
            .profile("ros2")
            .library("host-cli 0.1.0")
            .compression(Some(Compression::Lz4))
            .disable_seeking(true)
            .create(Cursor::new(Vec::new()))
            .expect("starts");
        let none = BTreeMap::new();
        let text = format!(
            "# One control tick of a haptic experiment.\n{}",
            self.fields
        );
        let kind = format!("haptics_msgs/msg/{}", self.kind);
        let schema = log
            .add_schema(&kind, "ros2msg", text.as_bytes())
            .expect("adds");
        log.add_channel_with_id(1, schema, self.topic, "cdr", &none)
            .expect("adds");
        let event = "float64 time_s\nstring kind\nstring text\n";
        let event = log.add_schema("haptics_msgs/msg/Event", "ros2msg", event.as_bytes());
        log.add_channel_with_id(2, event.expect("adds"), "/haptics/event", "cdr", &none)
            .expect("adds");
        let start = noon().since_1970_ns();
        for tick in 0..TICKS {
            let mut bytes = vec![0, 1, 0, 0];
            for (kind, name) in self.lines() {
                put(&mut bytes, kind, name, self.axes, tick);
            }
            let time = start + 1_000_000 * tick;
            publish(&mut log, 1, tick as u32, time, &bytes);
        }
        let event = b"\0\x01\0\0\0\0\0\0\0\0\0\0\x05\0\0\0hold\0\0\0\0\x03\0\0\0on\0";
        publish(&mut log, 2, 0, start, event);
        closed(log)
    }

    fn tick(&self, tick: u64) -> TickMessage {
        let names: Vec<(String, usize)> = self.lines().map(|(_, name)| split(name)).collect();
        let has = |field: &str| names.iter().any(|(name, _)| name == field);
        let axes = |field: &str, former: &str| -> PerAxis {
            let name = if has(field) { field } else { former };
            let number = |axis| {
                if has(name) {
                    value(name, axis, tick)
                } else {
                    f64::NAN
                }
            };
            (0..self.axes).map(number).collect()
        };
        let bits = |field: &str| if has(field) { (tick % 3) as u8 } else { 0 };
        TickMessage {
            tick,
            time_s: 1e-3 * tick as f64,
            reference_m: axes("reference_m", ""),
            indenter_position_m: axes("indenter_position_m", ""),
            position_m: axes("position_m", ""),
            environment_force_n: axes("environment_force_n", ""),
            commanded_force_n: axes("commanded_force_n", "force_n"),
            applied_force_n: axes("applied_force_n", ""),
            contact_force_n: axes("contact_force_n", ""),
            limiters: bits("limiters"),
            flaws: bits("flaws"),
            observed_energy_j: axes("observed_energy_j", "")[0],
            sensed_force_n: has("sensed_force_n").then(|| axes("sensed_force_n", "")),
        }
    }

    fn path(&self) -> PathBuf {
        frozen(self.name)
    }
}

fn frozen(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/record/layouts");
    folder.join(format!("{name}.mcap"))
}

/// Of 2001 ticks, packed by a public tool, whose numbers of channels are not ours.
pub(super) fn zstd() -> PathBuf {
    frozen("zstd")
}

/// `FREEZE_LAYOUTS` writes those that are missing; a frozen one stays as it is.
#[test]
fn every_layout_has_its_frozen_log() {
    for layout in &LAYOUTS {
        if std::env::var_os("FREEZE_LAYOUTS").is_some() && !layout.path().exists() {
            fs::write(layout.path(), layout.log()).expect("writes");
        }
        assert!(layout.path().exists(), "{}", layout.name);
    }
}

/// As text, in which NaN equals NaN.
fn shown(ticks: &[TickMessage]) -> Vec<String> {
    ticks.iter().map(|tick| format!("{tick:?}")).collect()
}

#[test]
fn every_layout_so_far_is_read_checked_exported_and_saved() {
    let folder = Folder::empty();
    for layout in &LAYOUTS {
        let (path, name) = (layout.path(), layout.name);
        let mut reader = LogReader::open(&path).expect("opens");
        let entries: Vec<Entry> = (&mut reader).map(|entry| entry.expect("reads")).collect();
        assert_eq!(reader.condition().damage, [], "{name}");
        let expected: Vec<TickMessage> = (0..TICKS).map(|tick| layout.tick(tick)).collect();
        assert_eq!(shown(&ticks_of(&entries)), shown(&expected), "{name}");
        let event = EventMessage {
            time_s: 0.0,
            kind: "hold".into(),
            text: "on".into(),
        };
        assert_eq!(entries.last(), Some(&Entry::Event(event)), "{name}");

        let summary = inspect(&path).expect("inspects");
        assert!(
            summary.complete && summary.gaps.is_empty(),
            "{name}: {summary:?}"
        );
        assert_eq!(
            (summary.samples, summary.flaws.impossible),
            (TICKS, 0),
            "{name}"
        );
        assert_eq!(summary.foreign_messages, 0, "{name}");

        let [saved, table] = ["mcap", "csv"].map(|end| folder.join(format!("{name}.{end}")));
        let kept = recover(&path, &saved, false).expect("saves");
        assert!(kept.complete && kept.samples == TICKS, "{name}: {kept:?}");
        assert_eq!(shown(&ticks_in(&saved)), shown(&expected), "{name}");
        assert_eq!(
            export_csv(&path, &table, false).expect("exports").rows,
            TICKS,
            "{name}"
        );
    }
}

#[test]
fn a_tick_that_does_not_fit_its_schema_is_damage() {
    // The last byte of the last field is not there, one more is, or an axis is missing in one field.
    let layout = &LAYOUTS[2];
    for (cut, more) in [(1, 0), (0, 1), (8, 0)] {
        let mut log = WriteOptions::new()
            .create(Cursor::new(Vec::new()))
            .expect("starts");
        let schema = log
            .add_schema("VectorTick", "ros2msg", layout.fields.as_bytes())
            .expect("adds");
        log.add_channel_with_id(1, schema, VECTOR, "cdr", &BTreeMap::new())
            .expect("adds");
        let mut bytes = vec![0, 1, 0, 0];
        layout
            .lines()
            .for_each(|(kind, name)| put(&mut bytes, kind, name, 2, 7));
        bytes.truncate(bytes.len() - cut);
        bytes.extend(vec![0; more]);
        publish(&mut log, 1, 0, 0, &bytes);
        let bytes = closed(log);
        let mut reader = LogReader::new(bytes.as_slice(), Path::new("odd")).expect("opens");
        assert_eq!((&mut reader).count(), 0);
        let damage = &reader.condition().damage;
        assert!(matches!(damage[..], [Damage::Chunk { .. }]), "{damage:?}");
    }
}

#[test]
fn a_log_that_a_public_tool_packed_with_zstd_is_read() {
    let path = zstd();
    let summary = inspect(&path).expect("inspects");
    assert!(summary.complete, "{:?}", summary.damage);
    assert_eq!((summary.samples, summary.gaps.len()), (2001, 0));
    assert_eq!((summary.first_s, summary.last_s), (Some(0.0), Some(2.0)));
    let folder = Folder::empty();
    let saved = recover(&path, &folder.join("saved.mcap"), false).expect("saves");
    assert_eq!((saved.samples, saved.complete), (2001, true));
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
    let bytes = oddly_packed(&fs::read(LAYOUTS[0].path()).expect("reads"));
    let mut reader = LogReader::new(bytes.as_slice(), Path::new("xz")).expect("opens");
    reader.by_ref().for_each(drop);
    let damage = reader.condition().damage[0].to_string();
    assert_says(&damage, "format `xz7`");
}

/// `CAMPAIGN_CASES`: changes to each log, 40 by default.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn changed_logs_of_every_layout_never_panic_and_never_lie() {
    let (cases, mut random) = (cases(40), Random(7));
    let paths = LAYOUTS.iter().map(|layout| (Some(layout), layout.path()));
    let mut lost = 0;
    for (layout, path) in paths.chain([(None, zstd())]) {
        let whole = fs::read(&path).expect("reads");
        for _ in 0..cases {
            let bytes = changed(&whole, &mut random);
            let mut reader = LogReader::new(bytes.as_slice(), &path).expect("opens");
            for entry in &mut reader {
                if let (Entry::Tick(tick), Some(layout)) = (entry.expect("is memory"), layout) {
                    let expected = layout.tick(tick.tick);
                    assert_eq!(shown(&[tick]), shown(&[expected]), "{}", layout.name);
                }
            }
            lost += u32::from(!reader.condition().complete);
        }
    }
    assert!(lost > cases, "most changes are seen: {lost}");
}
