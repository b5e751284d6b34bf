//! Registers of the emulated servo: what a frame sets, how a value is written into an answer.

use moteus_protocol::{
    CanFdFrame, Register, Resolution, Subframe, SubframeType, Value, WriteCanData, WriteCombiner,
    parse_frame,
    scaling::{self, Scaling},
};

/// First and last register of a position command.
const COMMAND: core::ops::RangeInclusive<u16> = 0x20..=0x2d;
/// The first byte of a block of answers, without resolution and count.
const REPLY: u8 = 0x20;
/// The first byte of a register that cannot be read, and the reason "no such register".
const READ_ERROR: (u8, u32) = (0x31, 1);
/// Room that a servo keeps free at the end of an answer.
const RESERVE: usize = 23;

/// A value with the scale that it has as an integer.
#[derive(Clone, Copy, Debug)]
pub(super) enum Quantity {
    Whole(i32),
    Scaled(f64, &'static Scaling),
}

/// Registers of a position command; those that it omits are at their default.
#[derive(Clone, Debug)]
pub(super) struct Registers([f32; 14]);

impl Default for Registers {
    fn default() -> Self {
        let mut values = [f32::NAN; 14];
        for (register, value) in [
            (Register::CommandPosition, 0.0),
            (Register::CommandVelocity, 0.0),
            (Register::CommandFeedforwardTorque, 0.0),
            (Register::CommandKpScale, 1.0),
            (Register::CommandKdScale, 1.0),
            (Register::CommandTimeout, 0.0),
            (Register::CommandIlimitScale, 1.0),
            (Register::CommandIgnorePositionBounds, 0.0),
        ] {
            values[usize::from(register.address() - COMMAND.start())] = value;
        }
        Self(values)
    }
}

/// The scale of a register of a position command: those that are no quantity are shares.
const fn scale(register: Option<Register>) -> &'static Scaling {
    match register {
        Some(Register::CommandPosition | Register::CommandStopPosition) => &scaling::POSITION,
        Some(Register::CommandVelocity | Register::CommandVelocityLimit) => &scaling::VELOCITY,
        Some(Register::CommandFeedforwardTorque | Register::CommandPositionMaxTorque) => {
            &scaling::TORQUE
        }
        Some(Register::CommandTimeout) => &scaling::TIME,
        Some(Register::CommandAccelLimit) => &scaling::ACCELERATION,
        Some(Register::CommandFixedVoltageOverride) => &scaling::VOLTAGE,
        Some(Register::CommandFixedCurrentOverride) => &scaling::CURRENT,
        _ => &scaling::PWM,
    }
}

impl Registers {
    pub(super) fn command(&self, register: Register) -> f64 {
        f64::from(self.0[usize::from(register.address() - COMMAND.start())])
    }

    pub(super) fn write(&mut self, register: u16, value: Value) {
        if COMMAND.contains(&register) {
            let scale = scale(Register::from_address(register));
            self.0[usize::from(register - COMMAND.start())] = value.to_f32(scale);
        }
    }

    pub(super) fn read(&self, register: Register) -> Option<Quantity> {
        let is_there = COMMAND.contains(&register.address());
        is_there.then(|| Quantity::Scaled(self.command(register), scale(Some(register))))
    }
}

/// The answer to what a frame asks, block by block as it asks. A block with a register that is not there is an error.
pub(super) fn answer(asked: &[u8], read: impl Fn(u16) -> Option<Quantity>) -> CanFdFrame {
    let mut frame = CanFdFrame::new();
    let mut block: Vec<(u16, Resolution)> = Vec::new();
    for subframe in parse_frame(asked) {
        let Subframe::Register {
            subframe_type: SubframeType::Read,
            register,
            resolution,
            ..
        } = subframe
        else {
            continue;
        };
        let follows =
            |(last, same): &(u16, Resolution)| *last + 1 == register && *same == resolution;
        if !block.last().is_none_or(follows) {
            answer_block(&mut frame, &block, &read);
            block.clear();
        }
        block.push((register, resolution));
    }
    answer_block(&mut frame, &block, &read);
    frame
}

fn answer_block(
    frame: &mut CanFdFrame,
    block: &[(u16, Resolution)],
    read: impl Fn(u16) -> Option<Quantity>,
) {
    let Some((first, resolution)) = block.first() else {
        return;
    };
    let mut writer = WriteCanData::new(frame);
    let framing = 3 + usize::from(*first > 0x7f);
    if writer.remaining() < RESERVE.max(framing + block.len() * resolution.size()) {
        return;
    }
    let missing = block.iter().find(|(register, _)| read(*register).is_none());
    if let Some((register, _)) = missing {
        let (code, reason) = READ_ERROR;
        writer.write_u8(code);
        writer.write_varuint(u32::from(*register));
        writer.write_varuint(reason);
        return;
    }
    let resolutions = vec![*resolution; block.len()];
    let mut combiner = WriteCombiner::new(REPLY, *first, &resolutions);
    for (register, resolution) in block {
        if combiner.maybe_write(&mut writer)
            && let Some(quantity) = read(*register)
        {
            match quantity {
                Quantity::Whole(value) => writer.write_int(value, *resolution),
                Quantity::Scaled(value, scale) => {
                    writer.write_mapped(value as f32, scale, *resolution);
                }
            }
        }
    }
}

/// The bytes up to the first block that the maker's parser cannot take: it overflows on register numbers beyond 16
/// bits. Walks the blocks as it does: a head, perhaps a count, a number of at most two bytes, values.
pub(super) fn parsable(payload: &[u8]) -> &[u8] {
    let mut bytes = payload.iter().copied().enumerate();
    while let Some((start, head)) = bytes.next() {
        let size = match head {
            0x50 => continue,
            0x00..=0x0f => [1, 2, 4, 4][usize::from(head >> 2 & 3)],
            0x10..=0x1f => 0,
            _ => return &payload[..start],
        };
        let mut next = || bytes.next().map(|(_, byte)| byte);
        let count = match head & 3 {
            0 => next(),
            count => Some(count),
        };
        let (Some(count), Some(low)) = (count, next()) else {
            return &payload[..start];
        };
        let high = if low & 0x80 == 0 { Some(0) } else { next() };
        if high.is_none_or(|high| high >= 0x10) || count == 0 {
            return &payload[..start];
        }
        let values = usize::from(count) * size;
        if values > 0 && bytes.nth(values - 1).is_none() {
            return payload;
        }
    }
    payload
}
