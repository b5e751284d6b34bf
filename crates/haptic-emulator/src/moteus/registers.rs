//! Registers of the emulated servo: what a frame sets, how a value is written into an answer.

use moteus_protocol::{
    CanFdFrame, Register, Resolution, Subframe, SubframeType, Value, WriteCanData, WriteCombiner,
    parse_frame, scaling,
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
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Quantity {
    Whole(i32),
    /// Revolutions.
    Position(f64),
    /// Revolutions per second.
    Velocity(f64),
    /// Revolutions per second².
    Acceleration(f64),
    /// N·m.
    Torque(f64),
    /// A share of the full scale.
    Share(f64),
    /// V.
    Voltage(f64),
    /// °C.
    Temperature(f64),
    /// s.
    Time(f64),
    /// A.
    Current(f64),
}

impl Quantity {
    fn write(self, writer: &mut WriteCanData<'_>, resolution: Resolution) {
        match self {
            Self::Whole(value) => writer.write_int(value, resolution),
            Self::Position(value) => writer.write_position(value as f32, resolution),
            Self::Velocity(value) => writer.write_velocity(value as f32, resolution),
            Self::Acceleration(value) => writer.write_accel(value as f32, resolution),
            Self::Torque(value) => writer.write_torque(value as f32, resolution),
            Self::Share(value) => writer.write_pwm(value as f32, resolution),
            Self::Voltage(value) => writer.write_voltage(value as f32, resolution),
            Self::Temperature(value) => writer.write_temperature(value as f32, resolution),
            Self::Time(value) => writer.write_time(value as f32, resolution),
            Self::Current(value) => writer.write_current(value as f32, resolution),
        }
    }
}

/// What a position command sets; what it does not name is at its default.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Registers {
    feedforward_torque_nm: f32,
    largest_torque_nm: f32,
    watchdog_s: f32,
    /// The others, of no effect: they are only read back.
    others: [f32; 14],
}

impl Default for Registers {
    fn default() -> Self {
        let mut others = [f32::NAN; 14];
        for (register, value) in [
            (Register::CommandPosition, 0.0),
            (Register::CommandVelocity, 0.0),
            (Register::CommandKpScale, 1.0),
            (Register::CommandKdScale, 1.0),
            (Register::CommandIlimitScale, 1.0),
            (Register::CommandIgnorePositionBounds, 0.0),
        ] {
            others[usize::from(register.address() - COMMAND.start())] = value;
        }
        Self {
            feedforward_torque_nm: 0.0,
            largest_torque_nm: f32::NAN,
            watchdog_s: 0.0,
            others,
        }
    }
}

impl Registers {
    pub(super) const fn feedforward_torque_nm(&self) -> f32 {
        self.feedforward_torque_nm
    }

    pub(super) const fn largest_torque_nm(&self) -> f32 {
        self.largest_torque_nm
    }

    /// A command of a gain, or of a place or speed, by its register.
    pub(super) fn command(&self, register: Register) -> f64 {
        f64::from(self.others[usize::from(register.address() - COMMAND.start())])
    }

    pub(super) const fn watchdog_s(&self) -> f32 {
        self.watchdog_s
    }

    /// Whether there is such a register.
    pub(super) fn write(&mut self, register: u16, value: Value) -> bool {
        if !COMMAND.contains(&register) {
            return false;
        }
        let place = match Register::from_address(register) {
            Some(Register::CommandFeedforwardTorque) => &mut self.feedforward_torque_nm,
            Some(Register::CommandPositionMaxTorque) => &mut self.largest_torque_nm,
            Some(Register::CommandTimeout) => &mut self.watchdog_s,
            _ => &mut self.others[usize::from(register - COMMAND.start())],
        };
        let scale = match Register::from_address(register) {
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
        };
        *place = value.to_f32(scale);
        true
    }

    pub(super) fn read(&self, register: Register) -> Option<Quantity> {
        let address = register.address();
        if !COMMAND.contains(&address) {
            return None;
        }
        let other = self.command(register);
        Some(match register {
            Register::CommandFeedforwardTorque => {
                Quantity::Torque(self.feedforward_torque_nm.into())
            }
            Register::CommandPositionMaxTorque => Quantity::Torque(self.largest_torque_nm.into()),
            Register::CommandTimeout => Quantity::Time(self.watchdog_s.into()),
            Register::CommandPosition | Register::CommandStopPosition => Quantity::Position(other),
            Register::CommandVelocity | Register::CommandVelocityLimit => Quantity::Velocity(other),
            Register::CommandAccelLimit => Quantity::Acceleration(other),
            Register::CommandFixedVoltageOverride => Quantity::Voltage(other),
            Register::CommandFixedCurrentOverride => Quantity::Current(other),
            _ => Quantity::Share(other),
        })
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
            quantity.write(&mut writer, *resolution);
        }
    }
}

/// The bytes up to the first block that the maker's parser cannot take: it overflows on register numbers beyond 16 bits. A
/// servo obeys what stands before, too.
///
/// Walks the blocks as it does: a head, perhaps a count, a number of at most two bytes, values.
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
