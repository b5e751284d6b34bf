//! Frames with a right CRC that no host of a connection has sent.

use super::loose;
use crate::line::{Bench, START};
use haptic_link::{DigestBuilder, FRAME_MAX, Header, Request, Scope, Start, encode};
use serde::ser::{Serialize, SerializeTuple as _, Serializer};
use testkit::Random;

fn below(random: &mut Random, end: usize) -> usize {
    (random.bits() % end as u64) as usize
}

/// Bytes that are a message on their own.
struct Raw(Vec<u8>);

impl Serialize for Raw {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut tuple = serializer.serialize_tuple(self.0.len())?;
        for byte in &self.0 {
            tuple.serialize_element(byte)?;
        }
        tuple.end()
    }
}

fn framed(message: &impl Serialize, sequence: u32, connection: u32) -> Vec<u8> {
    let mut line = [0; FRAME_MAX];
    let header = Header::from_host(sequence, connection);
    let length = encode(message, header, &mut line).expect("fits");
    line[..length].to_vec()
}

/// What is in a frame and a zero, by the definition of COBS.
fn content_of(frame: &[u8]) -> Vec<u8> {
    let (mut content, mut at) = (Vec::new(), 0);
    while frame[at] != 0 {
        let next = at + usize::from(frame[at]);
        content.extend_from_slice(&frame[at + 1..next]);
        content.push(0);
        at = next;
    }
    content
}

/// The header in a frame.
pub(super) fn header_of(frame: &[u8]) -> (u32, u32) {
    let content = content_of(frame);
    let number =
        |from: usize| u32::from_le_bytes(content[from..from + 4].try_into().expect("four bytes"));
    (number(1), number(5))
}

fn any_request(random: &mut Random, faults: u16, tick: u32) -> Request {
    let (configuration, values) = loose();
    match below(random, 9) {
        0 | 1 => Request::Arm { faults },
        2 => Request::Start(Start {
            run: (random.bits() as u32),
            ..START
        }),
        3 => Request::Force {
            tick,
            force_n: [-100.0].into_iter().collect(),
        },
        4 => Request::KeepAlive { token: 1 },
        5 => Request::Configure(configuration),
        6 => Request::Coefficients(haptic_link::CoefficientBlock::of(&values, 0)),
        7 => Request::Commit {
            digest: DigestBuilder::new(&configuration)
                .coefficients(&values)
                .finish(),
            scope: Scope::Lasting,
        },
        _ => Request::GetConfiguration,
    }
}

/// A message written with a number that is longer than it has to be.
fn misspelt(request: &Request, random: &mut Random) -> Raw {
    let frame = framed(request, 0x0101_0101, 0x0101_0101);
    // Version and header have no zeros, so the first code byte skips what has none.
    let content = content_of(&frame);
    let mut body = content[9..content.len() - 5].to_vec();
    let at = if below(random, 2) == 0 {
        0
    } else {
        below(random, body.len())
    };
    let byte = body[at];
    body[at] = byte | 0x80;
    body.insert(at + 1, byte >> 7);
    for _ in 0..below(random, 3) {
        body[at + 1] |= 0x80;
        body.insert(at + 2, 0);
    }
    Raw(body)
}

/// A frame with a right CRC that no host of this connection has sent.
pub(super) fn forged(
    bench: &Bench,
    capture: &[Vec<u8>],
    live: (u32, u32),
    random: &mut Random,
) -> Vec<u8> {
    let device = bench.device.borrow();
    let (faults, tick) = (device.status().faults, device.newest().tick);
    let (sequence, connection) = live;
    let request = any_request(random, faults, tick);
    match below(random, 4) {
        0 => capture[below(random, capture.len())].clone(),
        // Right in everything else.
        1 => framed(&misspelt(&request, random), sequence + 1, connection),
        2 => {
            let other = match below(random, 5) {
                0 => 0,
                1 => connection ^ (1 << below(random, 32)),
                2 => connection.wrapping_add(1),
                3 => header_of(&capture[below(random, capture.len())]).1,
                _ => (random.bits() as u32),
            };
            let other = if other == connection { !other } else { other };
            framed(&request, sequence + 1 + (random.bits() as u32) % 100, other)
        }
        // Behind what the host has said already.
        _ => {
            let back = (random.bits() as u32) % 0x8000_0000;
            framed(&request, sequence.wrapping_sub(back), connection)
        }
    }
}
