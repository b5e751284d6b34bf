//! `docs/protocol.md` against the code: lengths, offsets, types, names, enumerations, keys, examples.
//!
//! A message is made twice. The code turns it into bytes; serde tells the names and values of its fields.
//! The tables of the document must find these values in those bytes.

use haptic_link::{
    Ack, Alive, BATCH_MAX, Batch, BatchItem, Capabilities, CoefficientBlock, Configuration,
    DigestBuilder, Direction, Event, EventKind, FRAME_MAX, FaultReport, Field, Flight, Guard,
    GuardKind, Header, Hello, Keys, Limits, LoopMode, OperatorForm, OperatorShape, Outcome,
    PROTOCOL_VERSION, REPORT_KEYS, REQUEST_KEYS, Refusal, Report, Request, Sample, Scope,
    SequenceTracker, Simulation, SimulationKind, Start, State, Statistics, Status, encode,
    greet_version_1,
};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// A row of a table of fields.
#[derive(Clone, Debug)]
struct Row {
    offset: usize,
    kind: String,
    name: String,
}

/// A section `### Kind …, LENGTH` with its table.
#[derive(Debug)]
struct Section {
    length: String,
    rows: Vec<Row>,
}

/// The document, taken apart.
struct Document {
    text: String,
    /// By heading up to the last comma, as "Request 9, start".
    sections: BTreeMap<String, Section>,
    /// By name, each number with its name.
    enumerations: BTreeMap<String, BTreeMap<u8, String>>,
}

impl Document {
    fn read() -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("protocol.md");
        let text = std::fs::read_to_string(path).expect("the document is there");
        let (mut sections, mut enumerations) = (BTreeMap::new(), BTreeMap::new());
        for part in text.split("\n### ").skip(1) {
            let part = part.split("\n## ").next().unwrap_or(part);
            let (heading, body) = part.split_once('\n').expect("a heading ends");
            let cells = body.lines().filter(|line| line.starts_with("| "));
            let cells = cells.map(|line| line.split(" | ").map(cell).collect::<Vec<_>>());
            let cells: Vec<Vec<String>> = cells.skip(1).collect();
            if let Some(name) = heading.strip_prefix("Enumeration ") {
                let names = cells.iter().map(|row| (number(&row[0]), row[1].clone()));
                enumerations.insert(name.to_owned(), names.collect());
            } else {
                let (name, length) = heading.rsplit_once(", ").expect("a length");
                let rows = cells.iter().map(|row| Row {
                    offset: number(&row[0]),
                    kind: row[1].clone(),
                    name: row[2].clone(),
                });
                let section = Section {
                    length: length.to_owned(),
                    rows: rows.collect(),
                };
                sections.insert(name.to_owned(), section);
            }
        }
        Self {
            text,
            sections,
            enumerations,
        }
    }

    fn section(&self, name: &str) -> &Section {
        let section = self.sections.get(name);
        section.unwrap_or_else(|| panic!("no section \"{name}\""))
    }

    /// Length of one value of this type.
    fn size(&self, kind: &str) -> usize {
        let basic = [
            ("u8", 1),
            ("i8", 1),
            ("bool", 1),
            ("u16", 2),
            ("u32", 4),
            ("u64", 8),
            ("f32", 4),
        ];
        if let Some((_, size)) = basic.iter().find(|(name, _)| *name == kind) {
            return *size;
        }
        if let Some((element, count)) = kind.strip_suffix(']').and_then(|k| k.split_once('[')) {
            return self.size(element) * number::<usize>(count);
        }
        if self.enumerations.contains_key(kind) || kind == "Refusal" {
            return 1;
        }
        let rows = &self.section(&format!("Structure {kind}")).rows;
        let last = rows.last().expect("a structure has fields");
        last.offset + self.size(&last.kind)
    }

    /// Rows with structures resolved, for a message of these bytes; checks that they lie end to end.
    fn resolve(&self, rows: &[Row], bytes: &[u8]) -> Vec<Row> {
        let mut resolved: Vec<Row> = Vec::new();
        for row in rows {
            let at = resolved
                .last()
                .map_or(row.offset, |r| r.offset + self.size(&r.kind));
            assert_eq!(row.offset, at, "{row:?} begins where the one before ends");
            let (kind, count) = match row.kind.strip_suffix(" × n") {
                Some(kind) => (kind, usize::from(bytes[row.offset - 1])),
                None => (row.kind.as_str(), 1),
            };
            let name = format!("Structure {kind}");
            if !self.sections.contains_key(&name) {
                resolved.push(row.clone());
                continue;
            }
            let (inner, size) = (&self.section(&name).rows, self.size(kind));
            for n in 0..count {
                resolved.extend(inner.iter().map(|field| Row {
                    offset: row.offset + n * size + field.offset,
                    kind: field.kind.clone(),
                    name: match row.name.as_str() {
                        "–" => field.name.clone(),
                        // A structure around one value has no name for it.
                        outer if kind == "key" => format!("{outer}.{n}"),
                        outer if count == 1 && kind == row.kind => {
                            format!("{outer}.{}", field.name)
                        }
                        outer => format!("{outer}.{n}.{}", field.name),
                    },
                }));
            }
        }
        resolved
    }

    /// True if the bytes at this row are the value.
    fn holds(&self, row: &Row, bytes: &[u8], value: &Value) -> bool {
        let bytes = &bytes[row.offset..row.offset + self.size(&row.kind)];
        let float = |bytes: &[u8]| f32::from_le_bytes(bytes.try_into().expect("four bytes"));
        match (row.kind.as_str(), value) {
            ("u8", Value::Number(n)) => n.as_u64() == Some(u64::from(bytes[0])),
            ("i8", Value::Number(n)) => n.as_i64() == Some(i64::from(bytes[0].cast_signed())),
            ("bool", Value::Bool(b)) => bytes[0] == u8::from(*b),
            ("f32", Value::Number(n)) => {
                n.as_f64().map(|n| (n as f32).to_bits()) == Some(float(bytes).to_bits())
            }
            ("f32[16]", Value::Array(list)) => list
                .iter()
                .zip(bytes.chunks(4))
                .all(|(n, b)| n.as_f64().map(|n| (n as f32).to_bits()) == Some(float(b).to_bits())),
            // Integers of fixed length are little-endian bytes to serde.
            (_, Value::Array(list)) => {
                let list = list.iter().map(Value::as_u64);
                list.eq(bytes.iter().map(|&b| Some(u64::from(b))))
            }
            (kind, Value::String(name)) => {
                let names = self.enumerations.get(kind);
                names.is_some_and(|names| names.get(&bytes[0]) == Some(name))
            }
            _ => false,
        }
    }

    /// Compares the table with the message, and returns the stated length.
    fn compare(&self, heading: &str, bytes: &[u8], fields: &BTreeMap<String, Value>) -> String {
        let section = self.section(heading);
        let rows = self.resolve(&section.rows, bytes);
        let last = rows.last().expect("a number at least");
        assert_eq!(
            last.offset + self.size(&last.kind),
            bytes.len(),
            "{heading}"
        );
        let rows = &rows[1..];
        assert_eq!(rows.len(), fields.len(), "{heading}: {rows:#?} {fields:#?}");
        for row in rows {
            let value = fields.get(&row.name);
            let value = value.unwrap_or_else(|| panic!("{heading} has no {}", row.name));
            let holds = self.holds(row, bytes, value);
            assert!(holds, "{heading}: {row:?} is not {value}");
        }
        section.length.clone()
    }
}

fn cell(text: &str) -> String {
    text.trim_matches(['|', ' ']).to_owned()
}

fn number<T: std::str::FromStr>(text: &str) -> T {
    let parsed = text.parse().ok();
    parsed.unwrap_or_else(|| panic!("\"{text}\" is no number"))
}

/// Every field of a message by its name.
fn fields(name: &str, value: &Value, found: &mut BTreeMap<String, Value>) {
    let inner = |key: &str| match name {
        "" => key.to_owned(),
        name => format!("{name}.{key}"),
    };
    match value {
        Value::Object(object) => {
            for (key, value) in object {
                fields(&inner(key), value, found);
            }
        }
        Value::Array(list) if list.iter().any(|item| item.is_object() || item.is_array()) => {
            found.insert(inner("count"), list.len().into());
            for (n, item) in list.iter().enumerate() {
                fields(&inner(&n.to_string()), item, found);
            }
        }
        leaf => {
            found.insert(name.to_owned(), leaf.clone());
        }
    }
}

/// Name and content of a variant.
fn variant(value: &Value) -> (&str, &Value) {
    match value {
        Value::Object(object) if object.len() == 1 => {
            let (name, content) = object.iter().next().expect("one");
            (name, content)
        }
        Value::String(name) => (name, &Value::Null),
        other => panic!("{other} is no variant"),
    }
}

/// A name as the document writes those of messages.
fn kebab(name: &str) -> String {
    let mut kebab = String::new();
    for letter in name.chars() {
        if letter.is_uppercase() && !kebab.is_empty() {
            kebab.push('-');
        }
        kebab.extend(letter.to_lowercase());
    }
    kebab
}

/// The connection in the examples.
const CONNECTION: u32 = 0x6a5b_4c3d;

fn frame(
    message: &impl serde::Serialize,
    sequence: u16,
    direction: Direction,
) -> (Vec<u8>, Vec<u8>) {
    let header = match direction {
        Direction::FromHost => Header::from_host(u32::from(sequence), CONNECTION),
        Direction::FromDevice => Header::from_device(sequence),
    };
    frame_with(message, header)
}

fn frame_with(message: &impl serde::Serialize, header: Header) -> (Vec<u8>, Vec<u8>) {
    let mut line = [0; FRAME_MAX];
    let length = encode(message, header, &mut line).expect("fits");
    let line = line[..length].to_vec();
    let mut content = line[..length - 1].to_vec();
    let length = cobs::decode_in_place(&mut content).expect("decodes");
    content.truncate(length);
    (content, line)
}

fn message(message: &impl serde::Serialize, direction: Direction) -> Vec<u8> {
    let (content, _) = frame(message, 0, direction);
    let start = match direction {
        Direction::FromHost => 9,
        Direction::FromDevice => 3,
    };
    content[start..content.len() - 4].to_vec()
}

fn status() -> Status {
    Status {
        state: State::Stopping,
        fault: 2,
        faults: 0x0403,
    }
}

fn sample() -> Sample {
    Sample {
        tick: 0x0403_0201,
        time_us: 0x0807_0605,
        position_m: 1.5,
        environment_force_n: -2.5,
        force_n: 3.5,
        limiters: 9,
    }
}

fn block() -> CoefficientBlock {
    CoefficientBlock {
        offset: 0x0201,
        values: core::array::from_fn(|i| i as f32 + 0.5),
    }
}

/// Every field another value.
fn configuration() -> Configuration {
    Configuration {
        loop_mode: LoopMode::Host,
        tick_period_us: 0x0403_0201,
        stiffness_n_per_m: 1.25,
        dissipation_n_s_mu_per_m: 2.25,
        order: 3.25,
        one_sided: true,
        surface_m: -4.25,
        operator: OperatorShape {
            form: OperatorForm::Sections,
            integer: -2,
            count: 0x0605,
        },
        limits: Limits {
            force_n: 5.25,
            force_rate_n_per_s: 6.25,
            watchdog_ms: 0x0807,
            late_ticks: 0x0a09,
            max_age_ticks: 0x0c0b,
            start_force_n: 13.25,
            rise_time_s: 14.25,
            workspace_low_m: -15.25,
            workspace_high_m: 16.25,
            workspace_soft_m: 17.25,
            speed_soft_m_per_s: 18.25,
            speed_hard_m_per_s: 19.25,
            velocity_bandwidth_hz: 20.25,
            braking_n_s_per_m: 21.25,
            stop_time_s: 22.25,
            brake_force_n: 26.25,
            device_mass_kg: 27.25,
            device_delay_ticks: 4,
            stuck_force_n: 28.25,
            stuck_time_s: 29.25,
            jump_m: 30.25,
            guard: Guard {
                kind: GuardKind::EnergyBounding,
                damping_n_s_per_m: 23.25,
                share: 24.25,
                forget_s: 25.25,
                delay_least_samples: 26.25,
                delay_most_samples: 27.25,
                lag_s: 28.25,
                noise_m: 29.25,
            },
        },
        simulation: Simulation {
            kind: SimulationKind::RigidIndentation,
            mass_kg: 7.25,
            damping_n_s_per_m: 8.25,
            hand_stiffness_n_per_m: 9.25,
            push_n: 10.25,
            depth_m: 11.25,
            ramp_time_s: 12.25,
        },
    }
}

fn requests() -> Vec<Request> {
    vec![
        Request::Hello { nonce: 0x0403_0201 },
        Request::GetCapabilities,
        Request::Configure(configuration()),
        Request::Coefficients(block()),
        Request::Commit {
            digest: 0x0403_0201,
            scope: Scope::Lasting,
        },
        Request::GetConfiguration,
        Request::GetCoefficients { offset: 0x0201 },
        Request::Arm { faults: 0x0201 },
        Request::Disarm,
        Request::Start(Start {
            run: 0x0403_0201,
            ticks: 0x0807_0605,
            every: 0x0a09,
            batch: 11,
        }),
        Request::Stop,
        Request::Force {
            tick: 0x0403_0201,
            force_n: -0.5,
        },
        Request::KeepAlive { token: 0x0403_0201 },
        Request::GetStatistics,
        Request::ReadFlight { index: 0x0201 },
        Request::Stream {
            every: 0x0201,
            batch: 3,
        },
        Request::GetKeys,
    ]
}

fn batch(count: usize) -> Batch {
    let item = |n: usize| BatchItem {
        position_m: n as f32 + 0.5,
        environment_force_n: n as f32 + 100.5,
        force_n: n as f32 + 200.5,
        limiters: n as u8,
    };
    Batch {
        tick: 0x0403_0201,
        time_us: 0x0807_0605,
        every: 0x0a09,
        items: (0..count).map(item).collect(),
    }
}

fn statistics() -> Statistics {
    Statistics {
        ticks: 1,
        overruns: 2,
        tick_cycles_max: 3,
        tick_cycles_last: 4,
        stale_forces: 5,
        samples_dropped: 6,
        sent: 7,
        received: 8,
        corrupt: 9,
        oversize: 10,
        foreign: 11,
        lost: 12,
        duplicate: 13,
        late: 14,
        bytes_overrun: 15,
        strangers: 16,
    }
}

fn ack(outcome: Outcome) -> Report {
    Report::Ack(Ack {
        sequence: 0x0201,
        request: 4,
        outcome,
    })
}

fn reports() -> Vec<Report> {
    let time_us = 0x0807_0605_0403_0201;
    vec![
        Report::Hello(Hello {
            nonce: 0x0403_0201,
            connection: 0x0807_0605,
            firmware: [1, 2, 3],
            boot: 0x0403_0201,
            status: status(),
        }),
        Report::Capabilities(Capabilities {
            board: Capabilities::board_name("sixteen letters!"),
            axes: 2,
            simulated: true,
            tick_period_min_us: 0x0403_0201,
            tick_period_max_us: 0x0807_0605,
            force_max_n: 1.5,
            force_rate_max_n_per_s: 2.5,
            position_resolution_m: 3.5,
            coefficients_max: 0x0201,
            modes_max: 0x0403,
            degree_max: 0x0605,
            flight_samples: 0x0807,
        }),
        ack(Outcome::Done),
        Report::Configuration {
            configuration: configuration(),
            digest: 0x0403_0201,
        },
        Report::Coefficients(block()),
        Report::Sample(sample()),
        Report::Batch(batch(BATCH_MAX)),
        Report::Event(Event {
            kind: EventKind::Stopped,
            tick: 0x0403_0201,
            time_us,
        }),
        Report::Fault(FaultReport {
            status: status(),
            tick: 0x0403_0201,
            time_us,
        }),
        Report::Statistics(statistics()),
        Report::Alive(Alive {
            token: 0x0403_0201,
            time_us,
            status: status(),
            observed_energy_j: -4.5,
        }),
        Report::Flight(Flight {
            index: 0x0201,
            count: 0x0403,
            sample: sample(),
        }),
        Report::Keys(Keys::current()),
    ]
}

fn refusals() -> Vec<Refusal> {
    vec![
        Refusal::State(State::Running),
        Refusal::Range {
            field: Field::ForceLimit,
            value: 50.0,
            least: 0.5,
            most: 20.0,
        },
        Refusal::Digest,
        Refusal::Incomplete,
        Refusal::Unsupported(Field::Every),
        Refusal::UnknownFault,
        Refusal::ForceNotZero,
        Refusal::ForceNotSmall {
            wanted_n: 2.0,
            allowed_n: 1.0,
        },
        Refusal::FaultPersists(4),
        Refusal::Connection,
        Refusal::Looser(Field::RiseTime),
    ]
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
        let length = document.compare(&heading, bytes, &found);
        let want = match name {
            "Batch" => "12 + 13·n bytes".to_owned(),
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
        let bytes = message(&Report::Batch(batch(count)), Direction::FromDevice);
        assert_eq!(bytes.len(), 12 + 13 * count);
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
        match content {
            Value::Null => {}
            Value::Object(_) => fields("", content, &mut found),
            // A lone value has no name in the code.
            lone => {
                let row = document.section(&heading).rows.last();
                found.insert(row.expect("a row").name.clone(), lone.clone());
            }
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
    // One of its variants has content, so serde knows it by another form than its name.
    let outcome = &document.enumerations["Outcome"];
    assert_eq!(outcome[&0], "Done");
    assert_eq!(outcome[&1], "Refused");
    // Codes of faults are compared where they are defined.
    assert_eq!(document.enumerations.len(), 10);
}

fn hex(bytes: &[u8]) -> String {
    let bytes: Vec<String> = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
    bytes.join(" ")
}

/// Labels and bytes, 24 on a line.
fn example(name: &str, parts: &[(&str, &[u8])]) -> String {
    let mut text = if name.is_empty() {
        String::new()
    } else {
        format!("{name}\n")
    };
    for (label, bytes) in parts {
        for (n, chunk) in bytes.chunks(24).enumerate() {
            let label = if n == 0 { label } else { "" };
            text += format!("{label:<9}{}\n", hex(chunk)).as_str();
        }
    }
    text
}

fn framed(name: &str, message: &impl serde::Serialize, sequence: u16, from: Direction) -> String {
    let (content, line) = frame(message, sequence, from);
    example(name, &[("content", &content), ("line", &line)])
}

/// A spring of 500 N/m on a simulated mass that a hand pushes with 1 N.
fn spring() -> (Configuration, [f32; 1]) {
    let configuration = Configuration {
        stiffness_n_per_m: 500.0,
        simulation: Simulation {
            push_n: 1.0,
            ..Simulation::TESTBED
        },
        ..Configuration::PASSIVE
    };
    (configuration, [0.0])
}

fn cobs_of(content: &[u8]) -> String {
    let mut line = [0; 16];
    let length = cobs::encode(content, &mut line);
    example("", &[("content", content), ("line", &line[..=length])])
}

fn examples() -> Vec<String> {
    let (configuration, values) = spring();
    let digest = DigestBuilder::new(&configuration).coefficients(&values);
    let digest = digest.finish();
    let configure = message(&Request::Configure(configuration), Direction::FromHost);
    let mut digested = configure[1..].to_vec();
    digested.extend(values[0].to_le_bytes());
    let number = digest.to_le_bytes();
    let device = Direction::FromDevice;
    let host = Direction::FromHost;
    let idle = Status::default();
    vec![
        cobs_of(&[0x11, 0x22, 0x00, 0x33]),
        cobs_of(&[0, 0]),
        hello(),
        framed(
            "its answer, sequence number 0: connection 0x6A5B4C3D, firmware 0.1.0, boot 77, Idle, no fault",
            &Report::Hello(Hello {
                nonce: 0x1234_5678,
                connection: CONNECTION,
                firmware: [0, 1, 0],
                boot: 77,
                status: idle,
            }),
            0,
            device,
        ),
        framed(
            "configure, sequence number 1: device loop, 1000 µs, K = 500 N/m, MassDamper of 65 g and 3.5 N·s/m, \
             push 1 N",
            &Request::Configure(configuration),
            1,
            host,
        ),
        framed(
            "coefficients, sequence number 2: the only one is 0",
            &Request::Coefficients(CoefficientBlock::of(&values, 0)),
            2,
            host,
        ),
        example(
            "digest of these two: 155 bytes of the configuration, one coefficient",
            &[("bytes", &digested), ("CRC-32", &number)],
        ),
        framed(
            "commit, sequence number 3, Lasting",
            &Request::Commit {
                digest,
                scope: Scope::Lasting,
            },
            3,
            host,
        ),
        framed(
            "its answer, sequence number 3",
            &Report::Ack(Ack {
                sequence: 3,
                request: 4,
                outcome: Outcome::Done,
            }),
            3,
            device,
        ),
        framed(
            "another answer: refused, Range, ForceLimit, 50 N is not in (0, 40] N",
            &Report::Ack(Ack {
                sequence: 3,
                request: 4,
                outcome: Outcome::Refused(Refusal::Range {
                    field: Field::ForceLimit,
                    value: 50.0,
                    least: f32::MIN_POSITIVE,
                    most: 40.0,
                }),
            }),
            3,
            device,
        ),
        framed(
            "arm, sequence number 4",
            &Request::Arm { faults: 0 },
            4,
            host,
        ),
        framed(
            "start, sequence number 5: run 1, 10 000 ticks, each one sent, one to a frame",
            &Request::Start(Start {
                run: 1,
                ticks: 10_000,
                every: 1,
                batch: 1,
            }),
            5,
            host,
        ),
        framed(
            "sample, sequence number 300: tick 256, 1 000 000 µs, 1 mm, −0.5 N wanted and applied",
            &Report::Sample(Sample {
                tick: 256,
                time_us: 1_000_000,
                position_m: 1e-3,
                environment_force_n: -0.5,
                force_n: -0.5,
                limiters: 0,
            }),
            300,
            device,
        ),
        framed(
            "batch of two, sequence number 301",
            &Report::Batch(Batch {
                tick: 257,
                time_us: 1_001_000,
                every: 1,
                items: [1e-3, 2e-3]
                    .map(|position_m| BatchItem {
                        position_m,
                        environment_force_n: -500.0 * position_m,
                        force_n: -500.0 * position_m,
                        limiters: 0,
                    })
                    .into_iter()
                    .collect(),
            }),
            301,
            device,
        ),
        framed(
            "keep-alive, sequence number 6",
            &Request::KeepAlive { token: 1 },
            6,
            host,
        ),
        framed("disarm, sequence number 7", &Request::Disarm, 7, host),
        example(
            "a hello of version 1, to find out about an old device",
            &[("line", &old_hello())],
        ),
    ]
}

/// A host that has no connection yet.
fn hello() -> String {
    let nonce = 0x1234_5678;
    let (content, line) = frame_with(&Request::Hello { nonce }, Header::from_host(0, 0));
    example(
        "hello, sequence number 0, nonce 0x12345678",
        &[("content", &content), ("line", &line)],
    )
}

fn old_hello() -> Vec<u8> {
    let mut line = [0; FRAME_MAX];
    let length = greet_version_1(&mut line).expect("fits");
    line[..length].to_vec()
}

#[test]
fn every_example_is_what_the_code_sends() {
    let document = Document::read();
    let examples = examples();
    let blocks = document.text.split("```hex\n").skip(1);
    let blocks = blocks.map(|rest| rest.split("```").next().unwrap_or_default());
    let found: Vec<&str> = blocks.flat_map(|block| block.split("\n\n")).collect();
    let found: Vec<String> = found
        .iter()
        .map(|part| format!("{}\n", part.trim_end()))
        .collect();
    assert!(
        found == examples,
        "the examples are, in this order:\n\n{}",
        examples.join("\n")
    );
}

#[test]
fn constants_are_as_the_document_says() {
    let document = Document::read();
    let says = |text: String| assert!(document.text.contains(&text), "\"{text}\" is not there");
    let rows = |names: &[&str], keys: &[haptic_link::MessageKey]| {
        let rows = names.iter().zip(keys);
        let rows: Vec<String> = rows
            .map(|(name, key)| format!("| {name} | 0x{:08X} |", key.0))
            .collect();
        rows.join("\n")
    };
    says(rows(&Request::NAMES, &REQUEST_KEYS));
    says(rows(&Report::NAMES, &REPORT_KEYS));
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
        "at most {} m/s, soft from {} m/s on",
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
    let reports = reports()
        .into_iter()
        .map(|r| frame(&r, 1, Direction::FromDevice));
    let (contents, lines): (Vec<_>, Vec<_>) = reports.unzip();
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
