//! The examples of the document, byte by byte.

use super::{frame, frame_with, reader::Document};
use crate::frames::CONNECTION;
use haptic_link::{
    Ack, BatchItem, CoefficientBlock, Configuration, DeviceReport, DigestBuilder, Direction, Field,
    Header, Hello, Outcome, Refusal, Request, Sample, SampleBatch, Scope, SerialNumber, Simulation,
    Start, Status, SurfaceKind, SurfaceShape,
};

pub(super) fn hex(bytes: &[u8]) -> String {
    let bytes: Vec<String> = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
    bytes.join(" ")
}

/// Labels and bytes, 24 on a line.
pub(super) fn example(name: &str, parts: &[(&str, &[u8])]) -> String {
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

pub(super) fn framed(
    name: &str,
    message: &impl serde::Serialize,
    sequence: u16,
    from: Direction,
) -> String {
    let (content, _) = frame(message, sequence, from);
    example(name, &[("content", &content)])
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

/// Examples in the order of the document.
pub(super) fn examples() -> Vec<String> {
    [opening(), configuring(), running()].concat()
}

/// Two zeros on a line, and a host that greets a device.
fn opening() -> Vec<String> {
    vec![
        cobs_of(&[0x11, 0x22, 0x00, 0x33]),
        cobs_of(&[0, 0]),
        hello(),
        framed(
            "its answer, sequence number 0: connection 0x6A5B4C3D, firmware 0.1.0, boot 77, Idle, no fault, serial number E6612483CB1B9221",
            &DeviceReport::Hello(Hello {
                nonce: 0x1234_5678,
                connection: CONNECTION,
                firmware: [0, 1, 0],
                boot: 77,
                status: Status::default(),
                serial_number: SerialNumber::named("E6612483CB1B9221")
                    .expect("a number")
                    .bytes(),
            }),
            0,
            Direction::FromDevice,
        ),
    ]
}

/// A spring is committed.
fn configuring() -> Vec<String> {
    let (configuration, values) = spring();
    let digest = DigestBuilder::new(&configuration).coefficients(&values);
    let digest = digest.finish();
    let number = digest.to_le_bytes();
    let answer = |outcome| {
        DeviceReport::Ack(Ack {
            sequence: 3,
            request: 4,
            outcome,
        })
    };
    let done = answer(Outcome::Done);
    let refused = answer(Outcome::Refused(Refusal::Range {
        field: Field::ForceLimit,
        value: 50.0,
        least: f32::MIN_POSITIVE,
        most: 40.0,
    }));
    let (device, host) = (Direction::FromDevice, Direction::FromHost);
    vec![
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
            "digest of these two: CRC-32 of bytes 11 to 182 of the first and 13 to 16 of the second, from 1",
            &[("CRC-32", &number)],
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
        framed("its answer, sequence number 3", &done, 3, device),
        framed(
            "another answer: refused, Range, ForceLimit, 50 N is not in (0, 40] N",
            &refused,
            3,
            device,
        ),
    ]
}

/// A tick of the spring.
const fn item(position_m: f32) -> BatchItem {
    BatchItem {
        position_m,
        environment_force_n: -500.0 * position_m,
        force_n: -500.0 * position_m,
        limiters: 0,
        flaws: 0,
    }
}

/// A run, and its end.
fn running() -> Vec<String> {
    let (device, host) = (Direction::FromDevice, Direction::FromHost);
    vec![
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
            "surface, sequence number 6: a ball of 20 mm about (50, −3) mm, for a device of two axes",
            &Request::Surface(SurfaceShape {
                kind: SurfaceKind::Ball,
                distance_m: 0.02,
                axes: [0.05, -0.003].into_iter().collect(),
            }),
            6,
            host,
        ),
        framed(
            "sample, sequence number 300: tick 256, 1 000 000 µs, 1 mm, −0.5 N wanted and applied",
            &DeviceReport::Sample(Sample {
                tick: 256,
                time_us: 1_000_000,
                axes: [item(1e-3)].into_iter().collect(),
                sensed_force_n: heapless::Vec::new(),
            }),
            300,
            device,
        ),
        framed(
            "batch of two, sequence number 301",
            &DeviceReport::Batch(SampleBatch {
                tick: 257,
                time_us: 1_001_000,
                every: 1,
                axes: 1,
                items: [1e-3, 2e-3].map(item).into_iter().collect(),
                sensed_force_n: heapless::Vec::new(),
            }),
            301,
            device,
        ),
        framed(
            "sample, sequence number 302: tick 259, 1 003 000 µs, 1 mm, 0.75 N at the force sensor",
            &DeviceReport::Sample(Sample {
                tick: 259,
                time_us: 1_003_000,
                axes: [item(1e-3)].into_iter().collect(),
                sensed_force_n: [0.75].into_iter().collect(),
            }),
            302,
            device,
        ),
    ]
}

/// A host that has no connection yet.
pub(super) fn hello() -> String {
    let nonce = 0x1234_5678;
    let (content, line) = frame_with(&Request::Hello { nonce }, Header::from_host(0, 0));
    example(
        "hello, sequence number 0, nonce 0x12345678",
        &[("content", &content), ("line", &line)],
    )
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
