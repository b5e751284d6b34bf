//! Lines of text from and to an fdcanusb, or a servo that speaks as one over its UART.
//!
//! ```text
//! can send 8001 01000A…50 BF *XX     to the adapter
//! OK *XX                              it took the line
//! rcv 100 2100…0F00 E B F *XX         a frame from the bus
//! ```
//! *Never waits*: it takes what has come, and keeps what finds no room for the next time. *Cost*: some 10 operations a
//! byte; no allocation, no panic.

use core::ops::Range;
use heapless::Vec;
use moteus_protocol::{
    CanFdFrame,
    fdcanusb::{self, EncodeOptions, Line, MAX_LINE_LENGTH},
};
use std::io::{ErrorKind, Read, Write};

const CHUNK: usize = 1024;
/// Chunks taken for one line: more of them without its end are a stream that is no adapter's.
const CHUNKS_MOST: usize = 4;

#[derive(Debug)]
pub(super) struct Gone;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Checksums {
    /// The other end does not know them.
    Unknown,
    /// Ours have them; the first answer shows whether the other end knows them.
    Tried,
    /// Each line has one; a line without is garbage.
    Needed,
}

#[derive(Debug)]
pub(super) enum Heard {
    /// A frame from the bus.
    Frame(CanFdFrame),
    Taken,
    Refused,
    /// Nothing that an adapter says, or damaged.
    Garbage,
}

/// The text of an adapter on a stream of bytes whose reads do not wait.
#[derive(Debug)]
pub(super) struct Adapter<S> {
    pub stream: S,
    checksums: Checksums,
    chunk: [u8; CHUNK],
    /// Unread part of the chunk.
    left: Range<usize>,
    line: Vec<u8, MAX_LINE_LENGTH>,
    /// The line is longer than any valid one, and is garbage.
    overlong: bool,
    sent: [u8; MAX_LINE_LENGTH],
    /// Bytes that the port has not accepted yet.
    unsent: Range<usize>,
}

impl<S: Read + Write> Adapter<S> {
    /// `known` if the other end takes checksums. Else a line with one asks: an adapter that knows them answers with
    /// its own.
    pub(super) fn new(stream: S, known: bool) -> Self {
        Self {
            stream,
            checksums: if known {
                Checksums::Needed
            } else {
                Checksums::Tried
            },
            chunk: [0; CHUNK],
            left: 0..0,
            line: Vec::new(),
            overlong: false,
            sent: [0; MAX_LINE_LENGTH],
            unsent: 0..0,
        }
    }

    /// Sends a frame. While the port has no room for the rest of the last one, this one is dropped: false.
    pub(super) fn send(&mut self, frame: &CanFdFrame) -> Result<bool, Gone> {
        self.push()?;
        if !self.unsent.is_empty() {
            return Ok(false);
        }
        let options = EncodeOptions {
            checksum: self.checksums != Checksums::Unknown,
            ..EncodeOptions::default()
        };
        // The longest frame fits.
        let length = fdcanusb::encode_can_send(frame, &options, &mut self.sent).unwrap_or(0);
        self.unsent = 0..length;
        self.push()?;
        Ok(true)
    }

    fn push(&mut self) -> Result<(), Gone> {
        while !self.unsent.is_empty() {
            match self.stream.write(&self.sent[self.unsent.clone()]) {
                Ok(0) => return Err(Gone),
                Ok(count) => self.unsent.start += count,
                Err(error) if is_not_now(error.kind()) => return Ok(()),
                Err(_) => return Err(Gone),
            }
        }
        Ok(())
    }

    pub(super) fn receive(&mut self) -> Result<Option<Heard>, Gone> {
        for _ in 0..CHUNKS_MOST {
            while let Some(index) = self.left.next() {
                let byte = self.chunk[index];
                if byte != b'\n' && byte != b'\r' {
                    self.overlong |= self.line.push(byte).is_err();
                } else if let Some(heard) = self.end_of_line() {
                    return Ok(Some(heard));
                }
            }
            match self.stream.read(&mut self.chunk) {
                Ok(0) => return Err(Gone),
                Ok(count) => self.left = 0..count,
                Err(error) if is_not_now(error.kind()) => return Ok(None),
                Err(_) => return Err(Gone),
            }
        }
        Ok(None)
    }

    /// The line that ends here; `None` for an empty one.
    fn end_of_line(&mut self) -> Option<Heard> {
        let overlong = core::mem::take(&mut self.overlong);
        let line = core::mem::take(&mut self.line);
        if overlong {
            return Some(Heard::Garbage);
        }
        if line.is_empty() {
            return None;
        }
        let (content, had, valid) = fdcanusb::strip_checksum(&line);
        self.checksums = match (self.checksums, had) {
            (_, true) if !valid => return Some(Heard::Garbage),
            (Checksums::Needed, false) => return Some(Heard::Garbage),
            (_, true) => Checksums::Needed,
            (_, false) => Checksums::Unknown,
        };
        Some(match fdcanusb::parse_line(content) {
            Line::Ok => Heard::Taken,
            Line::Rcv(frame) => Heard::Frame(frame),
            Line::Err(words) => {
                // A servo on a UART that was once spoken to with checksums wants them from then on.
                if fdcanusb::is_checksum_error(words) {
                    self.checksums = Checksums::Needed;
                }
                Heard::Refused
            }
            Line::Other(_) => Heard::Garbage,
        })
    }
}

pub(crate) const fn is_not_now(kind: ErrorKind) -> bool {
    matches!(
        kind,
        ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted
    )
}
