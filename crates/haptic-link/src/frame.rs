//! Frames: where a message begins and ends on a line of bytes, and whether it is whole.
//!
//! ```text
//! from a host:    COBS( version u8 | sequence u32 LE | connection u32 LE | message | CRC-32 LE ) 0x00
//! from a device:  COBS( version u8 | sequence u16 LE | message | CRC-32 LE ) 0x00
//! ```
//! - *COBS* (S. Cheshire, M. Baker, IEEE/ACM Trans. Networking 7(2), 1999) takes all zeros out, so that a
//!   zero byte ends a frame and nothing else does; costs one byte for up to 254.
//! - *CRC-32* as in zlib, PNG and Ethernet, over version, sequence and message. It finds every burst up to
//!   32 bits and, in frames this short, every damage of up to 4 bits (P. Koopman, *32-bit cyclic
//!   redundancy codes for Internet applications*, 2002); of other damage one in 4.3·10⁹ passes. Damage to a
//!   code byte of COBS shifts zeros, so it is of the other kind.
//! - *One form*: a frame counts only if encoding what was decoded gives the same bytes. So no message has a second
//!   spelling, like an overlong number of a variant.
//! - *After damage* the next zero byte begins anew: a good frame behind a bad one is found, unless the
//!   damage took the zero between them.

use crc::{CRC_32_ISO_HDLC, Crc};
use postcard::ser_flavors::Flavor;
use serde::{Serialize, de::DeserializeOwned};

/// Version of the protocol: the low seven bits of the first byte of a frame.
pub const PROTOCOL_VERSION: u8 = 2;

/// Longest frame on the line, the zero at its end included.
pub const FRAME_MAX: usize = 256;

/// Longest content of a frame, before COBS.
const CONTENT_MAX: usize = FRAME_MAX - 2;
const CRC_BYTES: usize = 4;

/// A table takes 1 KiB of a device's flash.
pub(crate) type Table = crc::Table<{ cfg!(feature = "crc-table") as usize }>;
pub(crate) static CRC: Crc<u32, Table> = Crc::<u32, Table>::new(&CRC_32_ISO_HDLC);

/// The side that sent a frame: the highest bit of its first byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Requests, bit 7 clear.
    FromHost,
    /// Reports, bit 7 set.
    FromDevice,
}

impl Direction {
    const fn version_byte(self) -> u8 {
        match self {
            Self::FromHost => PROTOCOL_VERSION,
            Self::FromDevice => PROTOCOL_VERSION | 0x80,
        }
    }

    const fn header_bytes(self) -> usize {
        match self {
            Self::FromHost => 9,
            Self::FromDevice => 3,
        }
    }
}

/// The fields before a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header {
    /// The sending side, which decides how the rest of the header is read.
    pub direction: Direction,
    /// Number of the frame: modulo 2³² from a host, modulo 2¹⁶ from a device.
    pub sequence: u32,
    /// Number of the connection. From a host: the one that the device assigned in its [`Hello`](crate::Hello) (0 in a
    /// hello); from a device always 0, and not on the wire.
    pub connection: u32,
}

impl Header {
    /// The header of a request on a connection that the device has assigned.
    #[must_use]
    pub const fn from_host(sequence: u32, connection: u32) -> Self {
        Self {
            direction: Direction::FromHost,
            sequence,
            connection,
        }
    }

    /// The header of a report, which carries no connection.
    #[must_use]
    pub const fn from_device(sequence: u16) -> Self {
        Self {
            direction: Direction::FromDevice,
            sequence: sequence as u32,
            connection: 0,
        }
    }

    /// Version, sequence, and from a host connection; how many bytes of it count.
    fn bytes(self) -> ([u8; 9], usize) {
        let mut bytes = [0; 9];
        bytes[0] = self.direction.version_byte();
        bytes[1..5].copy_from_slice(&self.sequence.to_le_bytes());
        if self.direction == Direction::FromHost {
            bytes[5..].copy_from_slice(&self.connection.to_le_bytes());
        }
        (bytes, self.direction.header_bytes())
    }

    /// Inverse of `bytes`; the length of the argument is that of this direction.
    fn read(direction: Direction, bytes: &[u8]) -> Self {
        let number = |from: usize, to: usize| {
            let bytes = bytes.get(from..to).unwrap_or_default().iter();
            bytes
                .rev()
                .fold(0, |number, &byte| number << 8 | u32::from(byte))
        };
        match direction {
            Direction::FromHost => Self::from_host(number(1, 5), number(5, 9)),
            Direction::FromDevice => Self::from_device(number(1, 3) as u16),
        }
    }
}

/// Why a message could not be encoded as a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum EncodeError {
    /// It does not fit into a frame, or not into the buffer that was given.
    TooLong,
}

impl core::fmt::Display for EncodeError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("the message does not fit into a frame")
    }
}

impl core::error::Error for EncodeError {}

/// Writes a message as a frame into `line` and returns its length there.
///
/// *Cost*: one pass for the bytes, one for the CRC (eight shifts a byte), one for COBS.
///
/// # Errors
/// [`EncodeError::TooLong`]; every message of this crate fits into [`FRAME_MAX`] bytes.
pub fn encode<M: Serialize>(
    message: &M,
    header: Header,
    line: &mut [u8],
) -> Result<usize, EncodeError> {
    let mut content = [0; CONTENT_MAX];
    let (bytes, start) = header.bytes();
    content[..start].copy_from_slice(&bytes[..start]);
    let body = &mut content[start..CONTENT_MAX - CRC_BYTES];
    let written = written(message, body).ok_or(EncodeError::TooLong)?;
    let end = start + written.len();
    frame(&mut content[..end + CRC_BYTES], line)
}

/// Sets the CRC at the end of a content and writes it as a frame.
fn frame(content: &mut [u8], line: &mut [u8]) -> Result<usize, EncodeError> {
    let Some((covered, crc)) = content.split_last_chunk_mut::<CRC_BYTES>() else {
        return Err(EncodeError::TooLong);
    };
    *crc = CRC.checksum(covered).to_le_bytes();
    let room = line.len().checked_sub(1).ok_or(EncodeError::TooLong)?;
    let length = cobs::try_encode(content, &mut line[..room]).map_err(|_| EncodeError::TooLong)?;
    line[length] = 0;
    Ok(length + 1)
}

/// Why the bytes between two zeros were not a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FrameError {
    /// Damaged, cut, a message that this version does not know, or one that is not written in its one form.
    Corrupt,
    /// More bytes came without a zero than a frame can have.
    Oversize,
    /// Whole, but of another protocol version, or our own echo.
    Foreign {
        /// First byte of the frame: version and direction.
        version: u8,
    },
}

/// Counts of the frames that a receiver got, by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LineCounters {
    /// Frames received intact, whether or not they were acted on.
    pub received: u32,
    /// Frames that were damaged, cut short, of an unknown kind, or not in their only valid form.
    pub corrupt: u32,
    /// Frames longer than [`FRAME_MAX`].
    pub oversize: u32,
    /// Frames of another protocol version or direction.
    pub foreign: u32,
    /// The first byte of the last such frame.
    pub foreign_version: u8,
}

impl LineCounters {
    /// The counts added since `before`, also if they have wrapped around.
    #[must_use]
    pub const fn since(&self, before: &Self) -> Self {
        Self {
            received: self.received.wrapping_sub(before.received),
            corrupt: self.corrupt.wrapping_sub(before.corrupt),
            oversize: self.oversize.wrapping_sub(before.oversize),
            foreign: self.foreign.wrapping_sub(before.foreign),
            foreign_version: self.foreign_version,
        }
    }
}

/// Takes messages out of a line of bytes.
///
/// *Start-up*: bytes before the first zero may be the end of a frame; an incomplete frame counts as
/// corrupt. *Cost*: a byte is one store; the last byte of a frame decodes it, and encodes it again
/// to see that it has its one form.
///
/// ```
/// use haptic_link::{Direction, FRAME_MAX, Header, Receiver, Request, encode};
///
/// let mut frame = [0; FRAME_MAX];
/// let length = encode(&Request::Stop, Header::from_host(1, 42), &mut frame)?;
/// let mut receiver = Receiver::<Request>::new(Direction::FromHost);
/// let arrived = frame[..length].iter().find_map(|&byte| receiver.push(byte));
/// assert_eq!(arrived.map(|(_, request)| request), Some(Request::Stop));
/// # Ok::<(), haptic_link::EncodeError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Receiver<M> {
    direction: Direction,
    buffer: [u8; FRAME_MAX],
    /// Bytes in the buffer; one more than fit if there were too many.
    length: usize,
    counters: LineCounters,
    message: core::marker::PhantomData<fn() -> M>,
}

impl<M: Serialize + DeserializeOwned> Receiver<M> {
    /// A receiver of frames sent in this direction.
    #[must_use]
    pub const fn new(direction: Direction) -> Self {
        Self {
            direction,
            buffer: [0; FRAME_MAX],
            length: 0,
            counters: LineCounters {
                received: 0,
                corrupt: 0,
                oversize: 0,
                foreign: 0,
                foreign_version: 0,
            },
            message: core::marker::PhantomData,
        }
    }

    /// Takes a byte; returns header and message if it ended a good frame.
    pub fn push(&mut self, byte: u8) -> Option<(Header, M)> {
        if byte != 0 {
            if let Some(slot) = self.buffer.get_mut(self.length) {
                *slot = byte;
                self.length += 1;
            } else {
                self.length = FRAME_MAX + 1;
            }
            return None;
        }
        let length = core::mem::take(&mut self.length);
        // Zeros in a row are what an idle sender may put between frames.
        if length == 0 {
            return None;
        }
        match self.decode(length) {
            Ok(message) => {
                self.counters.received = self.counters.received.wrapping_add(1);
                Some(message)
            }
            Err(error) => {
                self.count(error);
                None
            }
        }
    }

    /// Discards a partly received frame, but keeps the counters.
    pub fn forget(&mut self) {
        self.length = 0;
    }

    /// True if bytes have come since the last zero.
    #[must_use]
    pub const fn has_begun(&self) -> bool {
        self.length > 0
    }

    /// Counts of everything received so far.
    #[must_use]
    pub const fn counters(&self) -> LineCounters {
        self.counters
    }

    fn decode(&mut self, length: usize) -> Result<(Header, M), FrameError> {
        let frame = self.buffer.get_mut(..length).ok_or(FrameError::Oversize)?;
        let length = cobs::decode_in_place(frame).map_err(|_| FrameError::Corrupt)?;
        let (content, crc) = frame[..length]
            .split_last_chunk::<CRC_BYTES>()
            .ok_or(FrameError::Corrupt)?;
        if CRC.checksum(content) != u32::from_le_bytes(*crc) {
            return Err(FrameError::Corrupt);
        }
        let version = *content.first().ok_or(FrameError::Corrupt)?;
        if version != self.direction.version_byte() {
            return Err(FrameError::Foreign { version });
        }
        let (header, body) = content
            .split_at_checked(self.direction.header_bytes())
            .ok_or(FrameError::Corrupt)?;
        // Not by `?`, which would move the message once more.
        let Ok(message) = postcard::from_bytes(body) else {
            return Err(FrameError::Corrupt);
        };
        let mut again = [0; CONTENT_MAX];
        if written(&message, &mut again) == Some(body) {
            Ok((Header::read(self.direction, header), message))
        } else {
            Err(FrameError::Corrupt)
        }
    }

    fn count(&mut self, error: FrameError) {
        let counters = &mut self.counters;
        let counter = match error {
            FrameError::Corrupt => &mut counters.corrupt,
            FrameError::Oversize => &mut counters.oversize,
            FrameError::Foreign { version } => {
                counters.foreign_version = version;
                &mut counters.foreign
            }
        };
        *counter = counter.wrapping_add(1);
    }
}

/// Writes a message to the start of `room` and returns its bytes; `None` if they do not fit.
pub(crate) fn written<'a, M: Serialize>(message: &M, room: &'a mut [u8]) -> Option<&'a [u8]> {
    let bytes = Bytes { room, length: 0 };
    postcard::serialize_with_flavor(message, bytes).ok()?
}

/// Bytes into a buffer. Excess bytes are counted, not written, and reported at the end: a check after each number of a message
/// would cost a microcontroller half a kilobyte.
struct Bytes<'a> {
    room: &'a mut [u8],
    /// May be beyond the room.
    length: usize,
}

impl Bytes<'_> {
    #[inline(never)]
    fn put(&mut self, bytes: &[u8]) {
        let end = self.length + bytes.len();
        if let Some(free) = self.room.get_mut(self.length..end) {
            free.copy_from_slice(bytes);
        }
        self.length = end;
    }
}

impl<'a> Flavor for Bytes<'a> {
    type Output = Option<&'a [u8]>;

    fn try_push(&mut self, byte: u8) -> postcard::Result<()> {
        self.put(&[byte]);
        Ok(())
    }

    fn try_extend(&mut self, bytes: &[u8]) -> postcard::Result<()> {
        self.put(bytes);
        Ok(())
    }

    fn finalize(self) -> postcard::Result<Self::Output> {
        let room: &'a [u8] = self.room;
        Ok(room.get(..self.length))
    }
}
