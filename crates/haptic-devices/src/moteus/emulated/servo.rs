//! The servo: registers, modes, watchdog, a shaft with inertia and damping.

use super::registers::{Quantity, Registers, answer, is_parsable};
use core::f64::consts::TAU;
use haptic_loop::ParameterError;
use haptic_loop::plant::RampHold;
use haptic_loop::units::{Metres, Seconds};
use moteus_protocol::{
    CanFdFrame, Mode, Register, Subframe, SubframeType, calculate_arbitration_id,
    parse_arbitration_id, parse_frame, scaling,
};

/// Servo time that a servo as delivered takes for a frame that names none, s.
const WATCHDOG_DEFAULT_S: f32 = 0.1;
/// Number that all servos of a bus listen to.
const BROADCAST: i8 = 0x7f;

/// The shaft of an emulated servo and what holds it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shaft {
    /// J, kg·m².
    pub inertia_kg_m2: f64,
    /// b, N·m·s/rad.
    pub damping_n_m_s_per_rad: f64,
    /// A hand that turns it as it will from the first torque command on; `None` for a free shaft.
    pub hand: Option<Hand>,
}

impl Shaft {
    /// A lever of 0.1 kg at 20 mm, turned against 0.5 N·s/m there.
    pub const LEVER: Self = Self {
        inertia_kg_m2: 4e-5,
        damping_n_m_s_per_rad: 2e-4,
        hand: None,
    };
}

/// A hand that turns the shaft by an angle in a time and holds it there, whatever the torque.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hand {
    /// From the first torque command to the begin of the turn, s.
    pub wait_s: f64,
    /// Revolutions.
    pub turn_rev: f64,
    /// s.
    pub ramp_time_s: f64,
}

/// A moteus servo without hardware. Time is an argument, µs.
///
/// ```text
/// J·ω′ = τ − b·ω        exactly from one frame to the next, as τ is constant there
/// ```
/// - *Start-up*: stopped at 0, 24 V, 25 °C.
/// - *Position mode* makes the feed-forward torque, at most the largest torque: gains of its own it has none. Other modes
///   make no torque.
/// - *Watchdog*: after its time the servo is in mode 11 and makes no torque until it is stopped, as a servo does whose
///   `servo.timeout_mode` is 0.
#[derive(Clone, Debug)]
pub struct EmulatedServo {
    id: u8,
    shaft: Shaft,
    profile: Option<RampHold>,
    mode: Mode,
    fault: i8,
    registers: Registers,
    /// rad.
    angle: f64,
    /// rad/s.
    speed: f64,
    now_us: u64,
    /// When the watchdog ends.
    deadline_us: Option<u64>,
    /// When the hand began to turn.
    turned_since_us: Option<u64>,
    torque_peak_nm: f64,
}

impl EmulatedServo {
    /// A servo of this number, 1 to 126, at rest.
    ///
    /// # Errors
    /// A number, inertia, damping or motion outside its range.
    pub fn new(id: u8, shaft: Shaft) -> Result<Self, ParameterError> {
        let range = |what, value, good: bool, allowed, unit| {
            good.then_some(()).ok_or(ParameterError::Range {
                what,
                value,
                allowed,
                unit,
            })
        };
        let number = f64::from(id);
        range(
            "servo id",
            number,
            (1..=126).contains(&id),
            "in [1, 126]",
            "",
        )?;
        let inertia = shaft.inertia_kg_m2;
        let good = (1e-9..=1e3).contains(&inertia);
        range(
            "inertia of the shaft",
            inertia,
            good,
            "in [1e-9, 1e3]",
            "kg·m²",
        )?;
        let damping = shaft.damping_n_m_s_per_rad;
        let good = (0.0..=1e3).contains(&damping);
        range(
            "damping of the shaft",
            damping,
            good,
            "in [0, 1e3]",
            "N·m·s/rad",
        )?;
        let profile = match shaft.hand {
            Some(hand) => {
                let (turn, ramp) = (Metres(hand.turn_rev), Seconds(hand.ramp_time_s));
                Some(RampHold::new(turn, ramp)?)
            }
            None => None,
        };
        Ok(Self {
            id,
            shaft,
            profile,
            mode: Mode::Stopped,
            fault: 0,
            registers: Registers::default(),
            angle: 0.0,
            speed: 0.0,
            now_us: 0,
            deadline_us: None,
            turned_since_us: None,
            torque_peak_nm: 0.0,
        })
    }

    /// Its mode.
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
        let most = f64::from(self.registers.largest_torque_nm().abs());
        let wanted = f64::from(self.registers.feedforward_torque_nm());
        if wanted.is_nan() {
            return 0.0;
        }
        // The largest torque is not a number where the servo's own limit holds, which is out of reach here.
        if most.is_nan() {
            wanted
        } else {
            wanted.clamp(-most, most)
        }
    }

    /// Largest torque it has made so far, N·m.
    #[must_use]
    pub const fn torque_peak_nm(&self) -> f64 {
        self.torque_peak_nm
    }

    /// Turns, revolutions.
    #[must_use]
    pub fn position_rev(&self) -> f64 {
        self.angle / TAU
    }

    /// Fails with a code of the maker's list, as a servo does: no torque, mode 1.
    pub fn fail(&mut self, code: i8) {
        (self.mode, self.fault) = (Mode::Fault, code);
        self.deadline_us = None;
    }

    /// Puts the shaft somewhere, at rest, revolutions.
    pub fn place(&mut self, position_rev: f64) {
        (self.angle, self.speed) = (TAU * position_rev, 0.0);
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

    /// Moves the shaft at a constant torque.
    fn turn(&mut self, now_us: u64) {
        let passed_s = now_us.saturating_sub(self.now_us) as f64 * 1e-6;
        self.now_us = self.now_us.max(now_us);
        if let (Some(profile), Some(since_us)) = (&self.profile, self.turned_since_us) {
            let wait_s = self.shaft.hand.map_or(0.0, |hand| hand.wait_s);
            let turned_s = (self.now_us - since_us) as f64 * 1e-6 - wait_s;
            let ramp_s = profile.ramp_time().0;
            self.angle = TAU * profile.position(turned_s);
            self.speed = if (0.0..ramp_s).contains(&turned_s) {
                TAU * profile.depth().0 / ramp_s
            } else {
                0.0
            };
            return;
        }
        let (inertia, damping) = (self.shaft.inertia_kg_m2, self.shaft.damping_n_m_s_per_rad);
        let torque = self.torque_nm();
        let share = damping * passed_s / inertia;
        // ω = ω₀·e^(−s) + τ/J·t·(1 − e^(−s))/s,   θ = θ₀ + ω₀·t·φ₁(s) + τ/J·t²·φ₂(s)
        let (first, second) = (phi_1(share), phi_2(share));
        let push = torque / inertia * passed_s;
        self.angle += passed_s * (self.speed * first + push * second);
        self.speed = self.speed * libm::exp(-share) + push * first;
    }

    /// Takes a frame, and answers if it asks for that.
    pub fn frame(&mut self, frame: &CanFdFrame, now_us: u64) -> Option<CanFdFrame> {
        self.advance(now_us);
        let (from, to, _) = parse_arbitration_id(frame.arbitration_id);
        if to != self.id.cast_signed() && to != BROADCAST || !is_parsable(frame.payload()) {
            return None;
        }
        self.obey(frame);
        self.torque_peak_nm = self.torque_peak_nm.max(self.torque_nm().abs());
        // The highest bit of the sender asks for an answer.
        if frame.arbitration_id & 0x8000 == 0 {
            return None;
        }
        let mut reply = answer(frame, |register| self.read(register));
        reply.arbitration_id = calculate_arbitration_id(self.id.cast_signed(), from, 0, false);
        Some(reply)
    }

    /// Carries out what a frame writes.
    fn obey(&mut self, frame: &CanFdFrame) {
        let mut commanded = None;
        for subframe in parse_frame(frame.payload()) {
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
                // What a frame does not name is at its default.
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
                self.turned_since_us = None;
            }
            // Only a stop leads out of these.
            Some(_) if matches!(self.mode, Mode::Fault | Mode::Timeout) => {}
            Some(mode) => self.drive(mode),
            None => {}
        }
    }

    fn drive(&mut self, mode: Mode) {
        self.mode = mode;
        self.turned_since_us.get_or_insert(self.now_us);
        let asked = self.registers.watchdog_s();
        // 0 is the servo's own time, and no number stands for none.
        let time_s = if asked > 0.0 {
            asked
        } else {
            WATCHDOG_DEFAULT_S
        };
        self.deadline_us =
            (!asked.is_nan()).then(|| self.now_us + (f64::from(time_s) * 1e6) as u64);
    }

    fn read(&self, register: u16) -> Option<Quantity> {
        Some(match Register::from_address(register)? {
            Register::Mode => Quantity::Whole(i32::from(u8::from(self.mode))),
            Register::Fault => Quantity::Whole(i32::from(self.fault)),
            Register::Position | Register::AbsPosition => Quantity::Position(self.position_rev()),
            Register::Velocity => Quantity::Velocity(self.speed / TAU),
            Register::Torque | Register::ControlTorque => Quantity::Torque(self.torque_nm()),
            Register::QCurrent | Register::DCurrent => Quantity::Current(0.0),
            Register::Voltage => Quantity::Voltage(24.0),
            Register::Temperature | Register::MotorTemperature => Quantity::Temperature(25.0),
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

/// φ₁(s) = (1 − e^(−s))/s
fn phi_1(share: f64) -> f64 {
    if share > 0.0 {
        -libm::expm1(-share) / share
    } else {
        1.0
    }
}

/// φ₂(s) = (1 − φ₁(s))/s; for small s by its series 1/2 − s/6 + s²/24 − …, where the difference has no digits.
fn phi_2(share: f64) -> f64 {
    if share > 1e-3 {
        (1.0 - phi_1(share)) / share
    } else {
        0.5 - share * (1.0 / 6.0 - share * (1.0 / 24.0 - share / 120.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::moteus::frames::Frames;

    fn servo() -> EmulatedServo {
        EmulatedServo::new(1, Shaft::LEVER).expect("a good servo")
    }

    #[test]
    fn the_shaft_moves_as_its_equation_says() {
        // ω(t) = τ/b·(1 − e^(−bt/J)),  θ(t) = τ/b·(t − J/b·(1 − e^(−bt/J)))
        let Shaft {
            inertia_kg_m2: j,
            damping_n_m_s_per_rad: b,
            ..
        } = Shaft::LEVER;
        let (torque, time_s) = (f64::from(0.01_f32), 0.09);
        let decay = libm::exp(-b * time_s / j);
        let speed = torque / b * (1.0 - decay);
        let angle = torque / b * (time_s - j / b * (1.0 - decay));
        for frames in [1, 9, 900] {
            let mut servo = servo();
            for n in 0..frames {
                servo.frame(&Frames::new(1, 0.1).drive(0.01), n * 90_000 / frames);
            }
            servo.advance(90_000);
            assert!(
                (servo.speed / speed - 1.0).abs() < 1e-11,
                "{} {speed}",
                servo.speed
            );
            assert!(
                (servo.angle / angle - 1.0).abs() < 1e-11,
                "{} {angle}",
                servo.angle
            );
        }
    }

    #[test]
    fn without_damping_it_falls_freely() {
        let shaft = Shaft {
            damping_n_m_s_per_rad: 0.0,
            ..Shaft::LEVER
        };
        let mut servo = EmulatedServo::new(1, shaft).expect("a good servo");
        servo.frame(&Frames::new(1, 0.1).drive(0.01), 0);
        servo.advance(50_000);
        // θ = τ·t²/(2J)
        let angle = f64::from(0.01_f32) * 0.05 * 0.05 / 2.0 / 4e-5;
        assert!((servo.angle / angle - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_hand_waits_turns_and_holds() {
        let hand = Hand {
            wait_s: 0.1,
            turn_rev: 0.02,
            ramp_time_s: 0.4,
        };
        let shaft = Shaft {
            hand: Some(hand),
            ..Shaft::LEVER
        };
        let mut servo = EmulatedServo::new(1, shaft).expect("a good servo");
        servo.frame(&Frames::new(1, 1.0).drive(0.05), 1000);
        for (now_ms, turned, speed) in [(51, 0.0, 0.0), (301, 0.01, 0.05), (901, 0.02, 0.0)] {
            servo.advance(1000 * now_ms);
            assert!((servo.position_rev() - turned).abs() < 1e-12, "{now_ms} ms");
            assert!((servo.speed / TAU - speed).abs() < 1e-12, "{now_ms} ms");
        }
    }

    #[test]
    fn a_silent_host_leaves_no_torque() {
        let mut servo = servo();
        servo.frame(&Frames::new(1, 0.1).drive(0.01), 1000);
        servo.advance(100_999);
        assert_eq!(servo.mode(), Mode::Position);
        let before = servo.torque_nm();
        servo.advance(101_001);
        assert_eq!((servo.mode(), servo.torque_nm()), (Mode::Timeout, 0.0));
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
        // The feed-forward torque is the third number of the block.
        frame.data[14..18].copy_from_slice(&5.0_f32.to_le_bytes());
        servo.frame(&frame, 0);
        assert_eq!(servo.torque_nm(), f64::from(0.01_f32));
    }

    #[test]
    fn frames_of_others_and_garbage_are_not_answered() {
        let mut servo = servo();
        assert!(servo.frame(&Frames::new(2, 0.1).stop(), 0).is_none());
        let mut frame = Frames::new(1, 0.1).stop();
        assert!(servo.frame(&frame, 0).is_some());
        // A register number that goes on and on, which the maker's parser overflows on.
        frame.data[..4].copy_from_slice(&[0x11, 0xff, 0xff, 0xff]);
        assert!(servo.frame(&frame, 0).is_none());
    }
}
