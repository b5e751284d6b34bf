//! The adapter before the servo: lines of text in and out. As a servo on a UART does, after the first line with a
//! checksum all others need one; or as an old adapter, which knows none.

use super::servo::EmulatedServo;
use crate::at_line::AtLine;
use moteus_protocol::{
    CanFdFrame,
    fdcanusb::{self, MAX_LINE_LENGTH},
};
use std::io::Write as _;

/// Counts of an emulated servo.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ServoCounts {
    /// Frames accepted from the host, for any servo.
    pub frames: u64,
    /// Frames that the servo sent back, for those that asked it.
    pub answers: u64,
    /// Lines that a host does not send, or that were damaged.
    pub refused: u64,
}

/// An emulated servo behind the text of an fdcanusb.
#[derive(Clone, Debug)]
pub struct EmulatedAdapter {
    /// The one servo on its bus, to look at and to push.
    pub servo: EmulatedServo,
    knows_checksums: bool,
    checksum_needed: bool,
    line: Vec<u8>,
    served: ServoCounts,
}

impl EmulatedAdapter {
    /// An adapter with this one servo on its bus.
    #[must_use]
    pub fn new(servo: EmulatedServo) -> Self {
        Self {
            servo,
            knows_checksums: true,
            checksum_needed: false,
            line: Vec::new(),
            served: ServoCounts::default(),
        }
    }

    /// An adapter without checksums: it ignores those that it receives, and
    /// sends none.
    #[must_use]
    pub fn without_checksums(servo: EmulatedServo) -> Self {
        Self {
            knows_checksums: false,
            ..Self::new(servo)
        }
    }

    /// Counts since it was switched on.
    #[must_use]
    pub const fn served(&self) -> ServoCounts {
        self.served
    }

    /// Takes bytes from the host and appends the answers.
    pub fn receive(&mut self, bytes: &[u8], now_us: u64, out: &mut Vec<u8>) {
        for byte in bytes {
            self.take(*byte, now_us, out);
        }
    }

    fn take(&mut self, byte: u8, now_us: u64, out: &mut Vec<u8>) {
        if byte == b'\n' || byte == b'\r' {
            let line = core::mem::take(&mut self.line);
            if !line.is_empty() {
                self.obey(&line, now_us, out);
            }
        } else if self.line.len() <= MAX_LINE_LENGTH {
            self.line.push(byte);
        }
    }

    fn obey(&mut self, line: &[u8], now_us: u64, out: &mut Vec<u8>) {
        let (content, had, valid) = fdcanusb::strip_checksum(line);
        let frame = match (had, valid) {
            _ if !self.knows_checksums => sent(content).ok_or("ERR unknown command"),
            (true, false) => Err("ERR checksum mismatch"),
            (false, _) if self.checksum_needed => Err("ERR checksum required"),
            _ => sent(content).ok_or("ERR unknown command"),
        };
        self.checksum_needed |= had && valid && self.knows_checksums;
        match frame {
            Ok(frame) => {
                self.served.frames += 1;
                self.say(b"OK", out);
                if let Some(answer) = self.servo.frame(&frame, now_us) {
                    self.served.answers += 1;
                    self.say(&received(answer), out);
                }
            }
            Err(words) => {
                self.served.refused += 1;
                self.say(words.as_bytes(), out);
            }
        }
    }
}

impl EmulatedAdapter {
    /// A line, with its checksum if it knows them: that covers the space before the asterisk.
    fn say(&self, line: &[u8], out: &mut Vec<u8>) {
        out.extend(line);
        if self.knows_checksums {
            let covered = [line, b" "].concat();
            // A vector takes all that is written.
            let _ = write!(out, " *{:02X}", fdcanusb::compute_crc8(&covered));
        }
        out.extend(b"\r\n");
    }
}

impl AtLine for EmulatedAdapter {
    fn advance(&mut self, now_us: u64) {
        self.servo.advance(now_us);
    }

    fn receive(&mut self, byte: u8, now_us: u64, out: &mut Vec<u8>) {
        self.take(byte, now_us, out);
    }
}

/// The frame in `can send ID DATA FLAGS`. The maker's crate reads what an adapter says, which differs in its first word.
fn sent(line: &[u8]) -> Option<CanFdFrame> {
    let rest = line.strip_prefix(b"can send ")?;
    fdcanusb::parse_rcv(&[b"rcv ", rest].concat())
}

/// The line for a frame from the bus, with the flags that an adapter gives.
fn received(mut frame: CanFdFrame) -> Vec<u8> {
    frame.pad_to_dlc();
    let mut line = Vec::new();
    // A vector takes all that is written.
    let _ = write!(line, "rcv {:x} ", frame.arbitration_id);
    for byte in frame.payload() {
        let _ = write!(line, "{byte:02X}");
    }
    line.extend(b" E B F");
    line
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::moteus::Shaft;

    fn answer_to(adapter: &mut EmulatedAdapter, line: &[u8]) -> String {
        let mut out = Vec::new();
        adapter.receive(line, 0, &mut out);
        String::from_utf8(out).expect("text")
    }

    #[test]
    fn the_example_of_the_makers_description_is_answered() {
        let servo = EmulatedServo::new(1, Shaft::LEVER).expect("a good servo");
        let mut adapter = EmulatedAdapter::new(servo);
        // Mode and motion as 16-bit numbers, voltage, temperature and fault as 8-bit ones.
        let answer = answer_to(&mut adapter, b"can send 8001 140400130d\n");
        let lines: Vec<&str> = answer.lines().collect();
        assert_eq!(lines[0], "OK *BD");
        assert!(
            lines[1].starts_with("rcv 100 2404000000000000000000230D301900"),
            "{answer}"
        );
    }

    #[test]
    fn after_a_checksum_all_lines_need_one() {
        let servo = EmulatedServo::new(1, Shaft::LEVER).expect("a good servo");
        let mut adapter = EmulatedAdapter::new(servo);
        assert!(answer_to(&mut adapter, b"can send 0001 20\n").starts_with("OK"));
        assert!(answer_to(&mut adapter, b"can send 0001 20 *AE\n").starts_with("OK"));
        assert!(answer_to(&mut adapter, b"can send 0001 20 *AF\n").starts_with("ERR checksum"));
        assert!(answer_to(&mut adapter, b"can send 0001 20\n").starts_with("ERR checksum"));
        assert!(answer_to(&mut adapter, b"hello\n").starts_with("ERR"));
    }
}
