//! The servo: registers, modes, watchdog, a shaft with inertia and damping.

use super::{
    registers::{Quantity, Registers, answer, parsable},
    shaft::{Shaft, Turning},
};
use core::f64::consts::TAU;
use haptic_loop::{LoopParameterError, RangeError};
use moteus_protocol::{
    CanFdFrame, Mode, Register, Subframe, SubframeType, calculate_arbitration_id,
    parse_arbitration_id, parse_frame, scaling,
};

/// Servo time that a servo as delivered takes for a frame that names none, s.
const WATCHDOG_DEFAULT_S: f64 = 0.1_f32 as f64;
/// Largest torque of the motor, N·m.
const TORQUE_MOST_NM: f64 = 1.7;
/// Number that all servos of a bus listen to.
const BROADCAST: i8 = 0x7f;

/// A moteus servo without hardware. Time is an argument, µs.
///
/// ```text
/// J·ω′ = τ − b·ω        exactly from one frame to the next, as τ is constant there
/// ```
/// - *Start-up*: stopped at 0, 24 V, 25 °C.
/// - *Position mode* controls place and speed with the gains of its shaft, scaled as the frame says, and adds the feed-forward
///   torque; at most the largest torque. Other modes make no torque.
/// - *Watchdog*: after its time the servo is in mode 11 and makes no torque until it is stopped, as a servo does whose
///   `servo.timeout_mode` is 0.
#[derive(Clone, Debug)]
pub struct EmulatedServo {
    id: u8,
    turning: Turning,
    mode: Mode,
    fault: i8,
    registers: Registers,
    now_us: u64,
    deadline_us: Option<u64>,
    /// Commands since the last stop.
    commands: u32,
    /// When the hand began to turn.
    turned_since_us: Option<u64>,
    /// Place that its own control holds.
    control_rev: f64,
    torque_peak_nm: f64,
}

impl EmulatedServo {
    /// A servo of this number, 1 to 126, at rest.
    ///
    /// # Errors
    /// A number, inertia, damping or motion outside its range.
    pub fn new(id: u8, shaft: Shaft) -> Result<Self, LoopParameterError> {
        if !(1..=126).contains(&id) {
            return Err(RangeError::new("servo id", id.into(), "in [1, 126]", "").into());
        }
        let turning = Turning::new(shaft)?;
        Ok(Self {
            id,
            turning,
            mode: Mode::Stopped,
            fault: 0,
            registers: Registers::default(),
            now_us: 0,
            deadline_us: None,
            commands: 0,
            turned_since_us: None,
            control_rev: 0.0,
            torque_peak_nm: 0.0,
        })
    }

    /// The mode that it reports; it makes torque only in position mode.
    #[must_use]
    pub const fn mode(&self) -> Mode {
        self.mode
    }

    /// The torque that it makes, N·m.
    #[must_use]
    pub fn torque_nm(&self) -> f64 {
        if self.mode != Mode::Position {
            return 0.0;
        }
        let command = |register| self.registers.command(register);
        let (kp_full, kd_full) = self.turning.gains();
        let kp = command(Register::CommandKpScale).clamp(0.0, 1.0);
        let kd = command(Register::CommandKdScale).clamp(0.0, 1.0).min(kp);
        let speed = command(Register::CommandVelocity);
        let speed_off =
            if speed.is_nan() { 0.0 } else { speed } - self.turning.speed_rad_per_s / TAU;
        // τ = k_p·(p* − p) + k_d·(v* − v) + feed-forward
        let control =
            kp * kp_full * (self.control_rev - self.position_rev()) + kd * kd_full * speed_off;
        let wanted = control + command(Register::CommandFeedforwardTorque);
        let most = command(Register::CommandPositionMaxTorque)
            .abs()
            .min(TORQUE_MOST_NM);
        if wanted.is_nan() {
            return 0.0;
        }
        wanted.clamp(-most, most)
    }

    /// Largest torque it has made so far, N·m.
    #[must_use]
    pub const fn torque_peak_nm(&self) -> f64 {
        self.torque_peak_nm
    }

    /// Angle of the shaft from where it was switched on or set, revolutions.
    #[must_use]
    pub fn position_rev(&self) -> f64 {
        self.turning.angle_rad / TAU
    }

    /// Fails with a code of the maker's list, as a servo does: no torque, mode 1.
    pub fn fail(&mut self, code: i8) {
        (self.mode, self.fault) = (Mode::Fault, code);
        self.deadline_us = None;
    }

    /// Moves the shaft to this position, at rest, revolutions.
    pub fn place(&mut self, position_rev: f64) {
        self.turning.place(TAU * position_rev);
    }

    /// Lets time pass up to this moment.
    pub fn advance(&mut self, now_us: u64) {
        if let Some(deadline_us) = self.deadline_us.filter(|deadline| *deadline <= now_us) {
            self.turn(deadline_us);
            self.deadline_us = None;
            self.mode = Mode::Timeout;
        }
        self.turn(now_us);
    }

    fn turn(&mut self, now_us: u64) {
        let passed_s = now_us.saturating_sub(self.now_us) as f64 * 1e-6;
        self.now_us = self.now_us.max(now_us);
        let turned = self.turned_since_us;
        let turned_s = turned.map(|since_us| (self.now_us - since_us) as f64 * 1e-6);
        self.turning.step(self.torque_nm(), passed_s, turned_s);
    }

    /// Takes a frame, and answers if it asks for that.
    pub fn frame(&mut self, frame: &CanFdFrame, now_us: u64) -> Option<CanFdFrame> {
        self.advance(now_us);
        let (from, to, _) = parse_arbitration_id(frame.arbitration_id);
        if to != self.id.cast_signed() && to != BROADCAST {
            return None;
        }
        let payload = parsable(frame.payload());
        self.obey(payload);
        self.torque_peak_nm = self.torque_peak_nm.max(self.torque_nm().abs());
        // The highest bit of the sender asks for an answer.
        if frame.arbitration_id & 0x8000 == 0 {
            return None;
        }
        let mut reply = answer(payload, |register| self.read(register));
        reply.arbitration_id = calculate_arbitration_id(self.id.cast_signed(), from, 0, false);
        Some(reply)
    }

    fn obey(&mut self, payload: &[u8]) {
        let mut commanded = None;
        for subframe in parse_frame(payload) {
            let Subframe::Register {
                subframe_type: SubframeType::Write,
                register,
                value: Some(value),
                ..
            } = subframe
            else {
                continue;
            };
            if register == Register::Mode.address() {
                commanded = Mode::try_from(value.to_i32() as u8).ok();
                // Registers that a frame omits are at their default.
                self.registers = Registers::default();
            } else if register == Register::SetOutputExact.address()
                || register == Register::SetOutputNearest.address()
            {
                self.place(f64::from(value.to_f32(&scaling::POSITION)));
            } else {
                self.registers.write(register, value);
            }
        }
        match commanded {
            Some(Mode::Stopped) => {
                (self.mode, self.fault, self.deadline_us) = (Mode::Stopped, 0, None);
                (self.commands, self.turned_since_us) = (0, None);
            }
            // Only a stop leads out of these.
            Some(_) if matches!(self.mode, Mode::Fault | Mode::Timeout) => {}
            Some(mode) => self.drive(mode),
            None => {}
        }
    }

    fn drive(&mut self, mode: Mode) {
        self.mode = mode;
        let place = self.registers.command(Register::CommandPosition);
        self.control_rev = if place.is_nan() {
            self.position_rev()
        } else {
            place
        };
        self.commands = self.commands.saturating_add(1);
        if self.commands > self.turning.wait_commands() {
            self.turned_since_us.get_or_insert(self.now_us);
        }
        let asked = self.registers.command(Register::CommandTimeout);
        // Both 0 and NaN stand for the servo's default time.
        let time_s = if asked > 0.0 {
            asked
        } else {
            WATCHDOG_DEFAULT_S
        };
        self.deadline_us =
            (!asked.is_nan()).then(|| self.now_us.saturating_add((time_s * 1e6) as u64));
    }

    #[expect(
        clippy::wildcard_enum_match_arm,
        reason = "what else the maker numbers is not there"
    )]
    fn read(&self, register: u16) -> Option<Quantity> {
        Some(match Register::from_address(register)? {
            Register::Mode => Quantity::Whole(i32::from(u8::from(self.mode))),
            Register::Fault => Quantity::Whole(i32::from(self.fault)),
            Register::Position | Register::AbsPosition => {
                Quantity::Scaled(self.position_rev(), &scaling::POSITION)
            }
            Register::Velocity => {
                Quantity::Scaled(self.turning.speed_rad_per_s / TAU, &scaling::VELOCITY)
            }
            Register::Torque | Register::ControlTorque => {
                Quantity::Scaled(self.torque_nm(), &scaling::TORQUE)
            }
            Register::QCurrent | Register::DCurrent => Quantity::Scaled(0.0, &scaling::CURRENT),
            Register::Voltage => Quantity::Scaled(24.0, &scaling::VOLTAGE),
            Register::Temperature | Register::MotorTemperature => {
                Quantity::Scaled(25.0, &scaling::TEMPERATURE)
            }
            Register::TrajectoryComplete => Quantity::Whole(1),
            Register::HomeState | Register::ModelNumber => Quantity::Whole(0),
            Register::RegisterMapVersion => {
                Quantity::Whole(i32::from(moteus_protocol::CURRENT_REGISTER_MAP_VERSION))
            }
            Register::MultiplexId => Quantity::Whole(i32::from(self.id)),
            register => return self.registers.read(register),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptic_devices::moteus::Frames;

    fn servo() -> EmulatedServo {
        EmulatedServo::new(1, Shaft::LEVER).expect("a good servo")
    }

    #[test]
    fn a_silent_host_leaves_no_torque() {
        let mut servo = servo();
        servo.frame(&Frames::new(1, 0.1).drive(0.01), 1000);
        servo.advance(100_999);
        assert_eq!(servo.mode(), Mode::Position);
        let before = servo.torque_nm();
        servo.advance(101_001);
        assert_eq!(servo.mode(), Mode::Timeout);
        assert!(servo.torque_nm().abs() <= 0.0);
        assert!(before > 0.0);
        // Another command does not wake it, a stop does.
        let frames = Frames::new(1, 0.1);
        servo.frame(&frames.drive(0.01), 102_000);
        assert_eq!(servo.mode(), Mode::Timeout);
        servo.frame(&frames.stop(), 103_000);
        servo.frame(&frames.drive(0.01), 104_000);
        assert_eq!(servo.mode(), Mode::Position);
    }

    #[test]
    fn the_largest_torque_bounds_the_other() {
        let mut servo = servo();
        let mut frame = Frames::new(1, 0.1).drive(0.01);
        // The feed-forward torque stands behind mode, gains, largest torque and place.
        frame.data[21..25].copy_from_slice(&5.0_f32.to_le_bytes());
        servo.frame(&frame, 0);
        assert!((servo.torque_nm() - f64::from(0.01_f32)).abs() < 1e-15);
    }

    #[test]
    fn frames_of_others_and_garbage_are_not_answered() {
        let mut servo = servo();
        assert!(servo.frame(&Frames::new(2, 0.1).stop(), 0).is_none());
        let mut frame = Frames::new(1, 0.1).stop();
        assert!(servo.frame(&frame, 0).is_some());
        // A register number that goes on and on, which the maker's parser overflows on.
        frame.data[..4].copy_from_slice(&[0x11, 0xff, 0xff, 0xff]);
        let answer = servo.frame(&frame, 0).expect("it was asked");
        assert!(answer.is_empty(), "{answer:?}");
    }
}
