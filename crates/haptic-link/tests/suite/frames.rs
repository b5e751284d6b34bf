//! Short ways to frames.

use haptic_link::{Direction, FRAME_MAX, Header, encode};

/// The connection in all of these frames.
pub(crate) const CONNECTION: u32 = 0x6a5b_4c3d;

pub(crate) fn header(sequence: u16, direction: Direction) -> Header {
    match direction {
        Direction::FromHost => Header::from_host(u32::from(sequence), CONNECTION),
        Direction::FromDevice => Header::from_device(sequence),
    }
}

/// A message as it stands on the line, its closing zero included.
pub(crate) fn line_with(message: &impl serde::Serialize, header: Header) -> Vec<u8> {
    let mut line = [0; FRAME_MAX];
    let length = encode(message, header, &mut line).expect("fits");
    line[..length].to_vec()
}

pub(crate) fn line(
    message: &impl serde::Serialize,
    sequence: u16,
    direction: Direction,
) -> Vec<u8> {
    line_with(message, header(sequence, direction))
}

/// The message in a content.
pub(crate) fn body(content: &[u8], direction: Direction) -> &[u8] {
    let start = match direction {
        Direction::FromHost => 9,
        Direction::FromDevice => 3,
    };
    &content[start..content.len() - 4]
}
