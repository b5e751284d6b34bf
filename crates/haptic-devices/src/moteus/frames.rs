//! Frames to a servo and its answer, by the maker's own protocol crate.
//!
//! ```text
//! drive:  mode 10 │ kp 0, kd 0 │ largest torque |τ| │ position NaN │ torque τ │ watchdog │ i-limit 0 │ query
//! stop:   mode 0 │ query
//! answer: mode │ position, velocity, torque │ fault
//! ```
//! With kp = kd = 0 the servo makes the commanded torque and nothing else. So these come first, and then the largest torque, in
//! blocks of their own: whatever is lost, shifted or cut off behind them, the servo makes no more than was meant. A drive frame
//! has 40 bytes, an answer 20. *Cost*: some 200 operations each; no allocation, no panic.

use moteus_protocol::{
    CanFdFrame, Mode, Register, Resolution, WriteCanData, WriteCombiner, calculate_arbitration_id,
    command::StopCommand,
    parse_arbitration_id,
    query::{QueryFormat, QueryResult},
};

/// Number of this program on the bus, as with the maker's own clients.
pub(super) const HOST: u8 = 0;
/// The first byte of a block of writes, without resolution and count.
const WRITE: u8 = 0x00;
/// The first byte of a block of answers, without resolution and count.
const REPLY: u8 = 0x20;
/// No operation: fills a frame up to a length that CAN-FD has.
const FILLER: u8 = 0x50;

/// Registers that are asked for, in the order of the answer: the first one of a block, and the resolutions from there on.
const ASKED: [(Register, &[Resolution]); 2] = [
    (
        Register::Mode,
        &[
            Resolution::Int8,
            Resolution::Float,
            Resolution::Float,
            Resolution::Float,
        ],
    ),
    (Register::Fault, &[Resolution::Int8]),
];

#[derive(Debug, PartialEq)]
pub(super) struct Reply {
    /// Number of the mode: an unknown one too.
    pub mode: u8,
    pub position_rev: f32,
    pub velocity_rev_per_s: f32,
    pub torque_nm: f32,
    pub fault: i8,
}

impl Reply {
    pub(super) fn is_finite(&self) -> bool {
        self.position_rev.is_finite()
            && self.velocity_rev_per_s.is_finite()
            && self.torque_nm.is_finite()
    }

    pub(super) fn is_in(&self, mode: Mode) -> bool {
        self.mode == u8::from(mode)
    }
}

/// Speaker and listener of a frame.
#[derive(Debug)]
pub(super) struct Route {
    pub from: u8,
    pub to: u8,
}

impl Route {
    pub(super) fn of(frame: &CanFdFrame) -> Self {
        let (from, to, _) = parse_arbitration_id(frame.arbitration_id);
        Self {
            from: from.cast_unsigned(),
            to: to.cast_unsigned(),
        }
    }
}

/// The frames to one servo, and the format of its answers.
#[derive(Debug)]
pub struct Frames {
    address: u32,
    watchdog_s: f32,
    query: QueryFormat,
    shape: Shape,
}

impl Frames {
    /// Frames for the servo with this number, which lets go after this much silence, s.
    #[must_use]
    pub fn new(id: u8, watchdog_s: f64) -> Self {
        let mut query = QueryFormat::default();
        (query.voltage, query.temperature) = (Resolution::Ignore, Resolution::Ignore);
        Self {
            address: calculate_arbitration_id(HOST.cast_signed(), id.cast_signed(), 0, true),
            watchdog_s: watchdog_s as f32,
            query,
            shape: Shape::new(),
        }
    }

    /// No torque, and a query.
    #[must_use]
    pub fn stop(&self) -> CanFdFrame {
        let mut frame = self.addressed();
        StopCommand::serialize(&mut frame);
        self.query.serialize(&mut frame);
        frame
    }

    /// This torque, N·m, and a query.
    #[must_use]
    pub fn drive(&self, torque_nm: f32) -> CanFdFrame {
        let mut frame = self.addressed();
        let mut writer = WriteCanData::new(&mut frame);
        write(
            &mut writer,
            Register::Mode,
            &[Resolution::Int8],
            &[f32::from(u8::from(Mode::Position))],
        );
        let (byte, float) = ([Resolution::Int8; 2], [Resolution::Float]);
        let most_nm = torque_nm.abs();
        for (first, resolutions, values) in [
            (Register::CommandKpScale, &byte[..], &[0.0, 0.0][..]),
            (Register::CommandPositionMaxTorque, &float, &[most_nm]),
            (Register::CommandPosition, &float, &[f32::NAN]),
            (Register::CommandFeedforwardTorque, &float, &[torque_nm]),
            (Register::CommandTimeout, &float, &[self.watchdog_s]),
            (Register::CommandIlimitScale, &byte[..1], &[0.0]),
        ] {
            write(&mut writer, first, resolutions, values);
        }
        self.query.serialize(&mut frame);
        frame
    }

    fn addressed(&self) -> CanFdFrame {
        let mut frame = CanFdFrame::new();
        frame.arbitration_id = self.address;
        frame
    }

    /// The answer in a frame; `None` for one that answers something else.
    pub(super) fn reply(&self, frame: &CanFdFrame) -> Option<Reply> {
        if !self.shape.fits(frame.payload()) {
            return None;
        }
        let result = QueryResult::parse(frame);
        Some(Reply {
            // Not the parsed mode: that of an unknown number would be "stopped".
            mode: frame.data[self.shape.mode],
            position_rev: result.position,
            velocity_rev_per_s: result.velocity,
            torque_nm: result.torque,
            fault: result.fault,
        })
    }
}

/// The framing of an answer, checked before anything is parsed: the maker's parser overflows on some garbage.
#[derive(Debug)]
struct Shape {
    /// `None` where a value is.
    framing: heapless::Vec<Option<u8>, 64>,
    mode: usize,
}

impl Shape {
    fn new() -> Self {
        let (zeros, ones) = (answer(0), answer(u32::MAX));
        let both = zeros.payload().iter().zip(ones.payload());
        let framing: heapless::Vec<_, 64> = both
            .map(|(zero, one)| (zero == one).then_some(*zero))
            .collect();
        let mode = framing.iter().position(Option::is_none).unwrap_or(0);
        Self { framing, mode }
    }

    fn fits(&self, payload: &[u8]) -> bool {
        let Some((answer, rest)) = payload.split_at_checked(self.framing.len()) else {
            return false;
        };
        let mut bytes = self.framing.iter().zip(answer);
        bytes.all(|(framing, byte)| framing.is_none_or(|framing| framing == *byte))
            && rest.iter().all(|byte| *byte == FILLER)
    }
}

/// Writes a block of registers. Integers are whole numbers here.
fn write(
    writer: &mut WriteCanData<'_>,
    first: Register,
    resolutions: &[Resolution],
    values: &[f32],
) {
    let mut combiner = WriteCombiner::new(WRITE, first.address(), resolutions);
    for (resolution, value) in resolutions.iter().zip(values) {
        if combiner.maybe_write(writer) {
            if matches!(resolution, Resolution::Float) {
                writer.write_f32(*value);
            } else {
                writer.write_int(*value as i32, *resolution);
            }
        }
    }
}

/// An answer whose values all have these bits.
fn answer(bits: u32) -> CanFdFrame {
    let mut frame = CanFdFrame::new();
    let mut writer = WriteCanData::new(&mut frame);
    for (first, resolutions) in ASKED {
        let mut combiner = WriteCombiner::new(REPLY, first.address(), resolutions);
        for resolution in resolutions {
            if combiner.maybe_write(&mut writer) {
                let bytes = bits.to_le_bytes();
                writer.write_bytes(&bytes[..resolution.size()]);
            }
        }
    }
    frame
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frames() -> Frames {
        Frames::new(1, 0.1)
    }

    #[test]
    fn frames_are_short() {
        for (frame, size) in [
            (frames().drive(0.25), 40),
            (frames().stop(), 9),
            (answer(0), 20),
        ] {
            assert_eq!(usize::from(frame.size), size, "{frame:?}");
        }
        assert_eq!(frames().stop().arbitration_id, 0x8001);
    }

    #[test]
    fn a_drive_frame_asks_for_one_torque_and_no_control() {
        // Byte by byte from the maker's description of registers 0x20 to 0x2b.
        let mut expected = vec![0x01, 0x00, 0x0a, 0x02, 0x23, 0x00, 0x00, 0x0d, 0x25];
        expected.extend(0.25_f32.to_le_bytes());
        expected.extend([0x0d, 0x20]);
        expected.extend(f32::NAN.to_le_bytes());
        expected.extend([0x0d, 0x22]);
        expected.extend((-0.25_f32).to_le_bytes());
        expected.extend([0x0d, 0x27]);
        expected.extend(0.1_f32.to_le_bytes());
        expected.extend([0x01, 0x2b, 0x00]);
        expected.extend([0x11, 0x00, 0x1f, 0x01, 0x11, 0x0f]);
        assert_eq!(frames().drive(-0.25).payload(), expected);
    }

    #[test]
    fn an_answer_is_read_and_another_shape_is_none() {
        let mut payload = vec![0x21, 0x00, 0x0a, 0x2f, 0x01];
        for value in [0.5_f32, -2.0, 0.125] {
            payload.extend(value.to_le_bytes());
        }
        payload.extend([0x21, 0x0f, 0x21]);
        let reply = |payload: &[u8]| {
            let mut frame = CanFdFrame::new();
            frame.data[..payload.len()].copy_from_slice(payload);
            frame.size = payload.len() as u8;
            frames().reply(&frame)
        };
        let read = reply(&payload).expect("the shape that was asked for");
        let expected = Reply {
            mode: 10,
            position_rev: 0.5,
            velocity_rev_per_s: -2.0,
            torque_nm: 0.125,
            fault: 33,
        };
        assert_eq!(read, expected);
        for index in [0, 1, 3, 4, 17, 18] {
            let mut other = payload.clone();
            other[index] ^= 0x80;
            assert_eq!(reply(&other), None, "byte {index}");
        }
        assert_eq!(reply(&payload[..19]), None);
        payload.push(FILLER);
        assert!(reply(&payload).is_some());
        payload.push(0xff);
        assert_eq!(reply(&payload), None);
    }
}
