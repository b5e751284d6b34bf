//! `protocol.md` against the code: lengths, offsets, types, names, enumerations, keys, examples.
//!
//! A message is made twice. The code turns it into bytes; serde tells the names and values of its fields.
//! The tables of the document must find these values in those bytes.

mod examples;
mod reader;

use self::reader::{Document, fields, kebab, variant};
use crate::{
    frames::{body, header, line_with},
    messages::{ack, batch, refusals, reports, requests},
};
use haptic_link::{
    BATCH_MAX, ControllerForm, DeviceReport, Direction, EventKind, FRAME_MAX, Field, GuardKind,
    Header, Limits, LoopMode, OperatorForm, Outcome, PROTOCOL_VERSION, REPORT_KEYS, REQUEST_KEYS,
    Request, SENSED_MAX, Scope, SequenceTracker, SimulationKind, State, SurfaceKind, Trouble,
};
use serde_json::Value;
use std::collections::BTreeMap;

fn frame(
    message: &impl serde::Serialize,
    sequence: u16,
    direction: Direction,
) -> (Vec<u8>, Vec<u8>) {
    frame_with(message, header(sequence, direction))
}

fn frame_with(message: &impl serde::Serialize, header: Header) -> (Vec<u8>, Vec<u8>) {
    let line = line_with(message, header);
    let mut content = line[..line.len() - 1].to_vec();
    let length = cobs::decode_in_place(&mut content).expect("decodes");
    content.truncate(length);
    (content, line)
}

fn message(message: &impl serde::Serialize, direction: Direction) -> Vec<u8> {
    let (content, _) = frame(message, 0, direction);
    body(&content, direction).to_vec()
}

fn check_messages(kind: &str, messages: Vec<(Value, Vec<u8>)>) {
    let document = Document::read();
    for (number, (value, bytes)) in messages.iter().enumerate() {
        let (name, content) = variant(value);
        let heading = format!("{kind} {number}, {}", kebab(name));
        assert_eq!(usize::from(bytes[0]), number, "{heading}");
        let mut found = BTreeMap::new();
        if !content.is_null() {
            fields("", content, &mut found);
        }
        // A list of lone numbers is one field to serde, whatever their number.
        for name in ["force_n", "axes", "sensed_force_n", "sample.sensed_force_n"] {
            if let Some(Value::Array(list)) = found.get(name) {
                let count = list.len().into();
                found.insert(format!("{name}.count"), count);
            }
        }
        // What may be missing is told by a number before it: 0 or 1 of it.
        let map = found.iter().find(|(name, _)| name.ends_with("depth_map"));
        if let Some((name, value)) = map {
            let (given, count) = (!value.is_null(), format!("{name}.count"));
            found.insert(count, u8::from(given).into());
        }
        let length = document.compare(&heading, bytes, &found);
        let want = match name {
            "Force" => "6 + 4·n bytes".to_owned(),
            "Configure" | "Configuration" => {
                let most = bytes.len();
                format!("{} or {most} bytes", most - 32)
            }
            "Workspace" => "2 + 12·n bytes".to_owned(),
            "Controller" => "19 + 4·n bytes".to_owned(),
            "Surface" => "7 + 4·n bytes".to_owned(),
            "Sample" => "11 + 14·n + 4·m bytes".to_owned(),
            "Batch" => "14 + 14·n + 4·m bytes".to_owned(),
            "Flight" => "15 + 14·n + 4·m bytes".to_owned(),
            _ => format!("{} bytes", bytes.len()),
        };
        assert_eq!(length, want, "{heading}");
    }
    let sections = document.sections.keys();
    let sections = sections.filter(|name| name.starts_with(kind)).count();
    assert_eq!(sections, messages.len(), "{kind}s in the document");
}

fn with_bytes<M: serde::Serialize>(
    messages: Vec<M>,
    direction: Direction,
) -> Vec<(Value, Vec<u8>)> {
    let messages = messages.iter().map(|m| {
        let value = serde_json::to_value(m).expect("serialises");
        (value, message(m, direction))
    });
    messages.collect()
}

#[test]
fn every_request_is_as_its_table_says() {
    check_messages("Request", with_bytes(requests(), Direction::FromHost));
    let document = Document::read();
    for request in requests() {
        let heading = format!("Request {}, {}", request.number(), request.name());
        document.section(&heading);
    }
}

#[test]
fn every_report_is_as_its_table_says() {
    check_messages("Report", with_bytes(reports(), Direction::FromDevice));
    for count in 1..=BATCH_MAX {
        let bytes = message(&DeviceReport::Batch(batch(1, count)), Direction::FromDevice);
        let sensed = batch(1, count).sensed_force_n.len();
        assert_eq!(bytes.len(), 14 + 14 * count + 4 * sensed);
    }
}

#[test]
fn every_refusal_is_as_its_table_says() {
    let document = Document::read();
    for (number, refusal) in refusals().into_iter().enumerate() {
        let value = serde_json::to_value(refusal).expect("serialises");
        let (name, content) = variant(&value);
        let heading = format!("Refusal {number}, {name}");
        let bytes = message(&ack(Outcome::Refused(refusal)), Direction::FromDevice);
        assert_eq!(bytes[4..6], [1, number as u8], "{heading}");
        let mut found = BTreeMap::new();
        if content.is_object() {
            fields("", content, &mut found);
        } else if !content.is_null() {
            // A lone value has no name in the code.
            let row = document.section(&heading).rows.last();
            found.insert(row.expect("a row").name.clone(), content.clone());
        }
        let length = document.compare(&heading, &bytes, &found);
        assert_eq!(length, format!("{} bytes", bytes.len()), "{heading}");
    }
    let sections = document.sections.keys();
    let count = sections.filter(|name| name.starts_with("Refusal")).count();
    assert_eq!(count, refusals().len());
}

/// The document's names of an enumeration, against the code's; and that there are no more.
fn check_enumeration<T: serde::Serialize + serde::de::DeserializeOwned>(
    document: &Document,
    name: &str,
) {
    let names = &document.enumerations[name];
    for number in 0..=u8::try_from(names.len()).expect("few") {
        let value: Option<T> = postcard::from_bytes(&[number]).ok();
        let value = value.map(|value| serde_json::to_value(value).expect("serialises"));
        let want = names.get(&number).map(|name| Value::String(name.clone()));
        assert_eq!(value, want, "{name} {number}");
    }
}

#[test]
fn every_enumeration_is_as_its_table_says() {
    let document = Document::read();
    check_enumeration::<State>(&document, "State");
    check_enumeration::<LoopMode>(&document, "LoopMode");
    check_enumeration::<Scope>(&document, "Scope");
    check_enumeration::<OperatorForm>(&document, "OperatorForm");
    check_enumeration::<GuardKind>(&document, "GuardKind");
    check_enumeration::<SimulationKind>(&document, "SimulationKind");
    check_enumeration::<Field>(&document, "Field");
    check_enumeration::<EventKind>(&document, "EventKind");
    check_enumeration::<Trouble>(&document, "Trouble");
    check_enumeration::<ControllerForm>(&document, "ControllerForm");
    check_enumeration::<SurfaceKind>(&document, "SurfaceKind");
    // One of its variants has content, so serde knows it by another form than its name.
    let outcome = &document.enumerations["Outcome"];
    assert_eq!(outcome[&0], "Done");
    assert_eq!(outcome[&1], "Refused");
    // Codes of faults are compared where they are defined.
    assert_eq!(document.enumerations.len(), 13);
}

#[test]
fn constants_are_as_the_document_says() {
    let document = Document::read();
    let words: Vec<&str> = document.text.split_whitespace().collect();
    let flat = words.join(" ");
    let says = |text: String| assert!(flat.contains(&text), "\"{text}\" is not there");
    let keyed = |names: &[&str], keys: &[haptic_link::MessageKey]| {
        for (number, (name, key)) in names.iter().zip(keys).enumerate() {
            says(format!("| {number} | {name} | 0x{:08X} |", key.0));
        }
    };
    keyed(&Request::NAMES, &REQUEST_KEYS);
    keyed(&DeviceReport::NAMES, &REPORT_KEYS);
    // What of the limits is not at power-up as the document says would be told here.
    let limits = Limits::DEFAULT;
    says(format!(
        "| {} N, {} N/s, or",
        limits.force_n, limits.force_rate_n_per_s
    ));
    says(format!(
        "at most {} N, rises in {} s",
        limits.start_force_n, limits.rise_time_s
    ));
    says(format!(
        "at most {} m/s, braked above {} m/s",
        limits.speed_hard_m_per_s, limits.speed_soft_m_per_s
    ));
    says(format!(
        "{} ms, {} ticks, {} ticks",
        limits.watchdog_ms, limits.late_ticks, limits.max_age_ticks
    ));
    says(format!("ticks, 1 to {}", Limits::MAX_AGE_TICKS));
    says(format!("protocol, version {PROTOCOL_VERSION}"));
    says(format!("More than {FRAME_MAX} bytes"));
    says(format!("`batch` from 2 to {BATCH_MAX}"));
    let watchdog = (Limits::WATCHDOG_MIN_MS, Limits::WATCHDOG_MAX_MS);
    says(format!("ms, {} to {}", watchdog.0, watchdog.1));
    says(format!(
        "{} in a device loop, {} in a host loop",
        LoopMode::Device.watchdog_ms(),
        LoopMode::Host.watchdog_ms()
    ));
    assert_eq!(SequenceTracker::RESTART_AFTER, 8);
    says("eight late frames".to_owned());
    let longest = |bytes: Vec<Vec<u8>>| bytes.iter().map(Vec::len).max();
    // Without sensed forces a batch has more items.
    let longer = DeviceReport::Batch(batch(1, BATCH_MAX));
    let reports = reports()
        .into_iter()
        .chain([longer])
        .map(|r| frame(&r, 1, Direction::FromDevice));
    let (contents, lines): (Vec<_>, Vec<_>) = reports.unzip();
    says(format!("and with sensed forces at most {SENSED_MAX}"));
    says(format!(
        "the longest content being {} bytes",
        longest(contents).expect("some")
    ));
    says(format!(
        "With 16 items {} bytes",
        longest(lines).expect("some")
    ));
    let check = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(b"123456789");
    says(format!("CRC-32(\"123456789\") = 0x{check:08X}"));
}
