//! An emulated board: the same bytes in and out as the maker's firmware. An unknown type is skipped, a cut frame
//! waits for its rest (here for a second), encoders take the present place as home when configured, a torque above
//! [`TORQUE_MAX_NM`] is cut, and nothing lets go when the host falls silent.

use super::body::Body;
use crate::AtLine;
use haptic_devices::haply::{CountingSense, HaplyModel, TORQUE_MAX_NM, counts_at};
use nalgebra::Vector2;

/// Ports for motors and encoders.
const PORTS: usize = 4;
/// Pins that a pulse can go to.
const PINS: usize = 14;
/// Longest wait for the rest of a frame, µs.
const PATIENCE_US: u64 = 1_000_000;

/// The board of a 2DIY, with its body.
#[derive(Clone, Debug)]
pub struct Board {
    wired: HaplyModel,
    body: Body,
    motors: [Port; PORTS],
    encoders: [Encoder; PORTS],
    /// Number of the device that each pin belongs to.
    pins: [u8; PINS],
    frame: Vec<u8>,
    began_us: u64,
    torques_nm: [f64; 2],
    counted: Counted,
}

/// Counts of an emulated board.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counted {
    /// Frames that configured motors and encoders: one each time a host opens it.
    pub configured: u64,
    /// Frames of torques, each of which is answered with angles.
    pub torques: u64,
    /// Number of resets, including the one before each configuration.
    pub resets: u64,
    /// Bytes that did not begin a known frame.
    pub skipped: u64,
    /// Largest torque commanded to a motor, N·m, before clipping.
    pub largest_nm: f64,
}

/// A motor as it is configured. Zero is what the firmware begins with, and the number of a device as any other.
#[derive(Clone, Copy, Debug, Default)]
struct Port {
    device_id: u8,
    direction: u8,
}

#[derive(Clone, Copy, Debug, Default)]
struct Encoder {
    port: Port,
    counts_per_turn: f32,
    /// Counts when it was configured, and the angle of the joint then, rad.
    home: f64,
    angle: f64,
}

impl Board {
    /// A board that has just been switched on, wired as this device.
    #[must_use]
    pub fn new(wired: HaplyModel, body: Body) -> Self {
        Self {
            wired,
            body,
            motors: [Port::default(); PORTS],
            encoders: [Encoder::default(); PORTS],
            pins: [0; PINS],
            frame: Vec::new(),
            began_us: 0,
            torques_nm: [0.0; 2],
            counted: Counted::default(),
        }
    }

    /// Torques that the motors make, N·m.
    #[must_use]
    pub const fn torques_nm(&self) -> [f64; 2] {
        self.torques_nm
    }

    /// The device that it is wired as.
    #[must_use]
    pub const fn wired(&self) -> &HaplyModel {
        &self.wired
    }

    /// Its arms and the hand that holds them, for inspection.
    #[must_use]
    pub const fn body(&self) -> &Body {
        &self.body
    }

    /// Counts since it was switched on.
    #[must_use]
    pub const fn counted(&self) -> Counted {
        self.counted
    }

    /// Bytes that the frame still misses at least.
    fn missing(&self) -> usize {
        let frame = &self.frame;
        let whole = match frame[0] {
            0 => 2,
            1 => configuration_length(frame),
            2 => frame.get(1).map_or(2, |&device_id| {
                let pulses = self.pins.iter().filter(|pin| **pin == device_id).count();
                2 + pulses + 4 * self.motors_of(device_id).count()
            }),
            _ => 1,
        };
        whole.saturating_sub(frame.len())
    }

    fn motors_of(&self, device_id: u8) -> impl Iterator<Item = usize> {
        let motors = self.motors;
        (0..PORTS).filter(move |port| motors[*port].device_id == device_id)
    }

    fn reset(&mut self) {
        self.counted.resets += 1;
        for (motor, encoder) in self.motors.iter_mut().zip(&mut self.encoders) {
            (motor.device_id, encoder.port.device_id) = (0, 0);
        }
        self.pins = [0; PINS];
    }

    fn configure(&mut self, frame: &[u8]) {
        self.reset();
        self.counted.configured += 1;
        let device_id = frame[1];
        let (motors, rest) = listed(&frame[2..]);
        let (encoders, rest) = listed(rest);
        let (_, rest) = counted(rest);
        let (pins, numbers) = counted(rest);
        for &pin in pins {
            if let Some(owner) = self.pins.get_mut(usize::from(pin)) {
                *owner = device_id;
            }
        }
        for (port, direction) in motors {
            self.motors[port] = Port {
                device_id,
                direction,
            };
        }
        self.body.opened();
        let angles = self.body.angles();
        for ((port, direction), number) in encoders.into_iter().zip(numbers.chunks_exact(8)) {
            let float = |at: usize| {
                f32::from_le_bytes([number[at], number[at + 1], number[at + 2], number[at + 3]])
            };
            let counts_per_turn = float(4);
            self.encoders[port] = Encoder {
                port: Port {
                    device_id,
                    direction,
                },
                counts_per_turn,
                // Counts are whole.
                home: f64::from(counts_at(float(0), counts_per_turn)),
                angle: self.joint_at(port).map_or(0.0, |joint| angles[joint]),
            };
        }
    }

    /// The joint that is wired to a port, counted from 0.
    fn joint_at(&self, port: usize) -> Option<usize> {
        let joints = &self.wired.joints;
        joints
            .iter()
            .position(|joint| usize::from(joint.port) == port + 1)
    }

    fn turn(&mut self, frame: &[u8]) {
        self.counted.torques += 1;
        let device_id = frame[1];
        let motors: Vec<usize> = self.motors_of(device_id).collect();
        let numbers = &frame[frame.len() - 4 * motors.len()..];
        for (port, number) in motors.into_iter().zip(numbers.chunks_exact(4)) {
            let torque = f32::from_le_bytes([number[0], number[1], number[2], number[3]]);
            let torque = f64::from(torque);
            let asked = if torque.is_nan() { 0.0 } else { torque };
            let Some(joint) = self.joint_at(port) else {
                continue;
            };
            self.counted.largest_nm = self.counted.largest_nm.max(asked.abs());
            let cut = asked.clamp(-TORQUE_MAX_NM, TORQUE_MAX_NM);
            let as_wired = self.motors[port].direction == self.wired.joints[joint].motor as u8;
            self.torques_nm[joint] = if as_wired { cut } else { -cut };
        }
        let [first, second] = self.torques_nm;
        self.body.turn(Vector2::new(first, second));
    }

    fn answer(&self, device_id: u8, answer: &mut Vec<u8>) {
        answer.push(device_id);
        let angles = self.body.angles();
        for (port, encoder) in self.encoders.iter().enumerate() {
            if encoder.port.device_id != device_id {
                continue;
            }
            let turned = self.joint_at(port).map_or(0.0, |joint| {
                let wired = &self.wired.joints[joint];
                let turns = (angles[joint] - encoder.angle) / core::f64::consts::TAU;
                let counts = turns * f64::from(wired.counts_per_turn);
                let as_wired = encoder.port.direction == wired.encoder as u8;
                if as_wired { counts } else { -counts }
            });
            let counts = encoder.home + turned.round();
            let degrees = 360.0 * counts as f32 / encoder.counts_per_turn;
            answer.extend(degrees.to_le_bytes());
        }
    }
}

impl AtLine for Board {
    fn advance(&mut self, now_us: u64) {
        self.body.advance(now_us as f64 * 1e-6);
        if !self.frame.is_empty() && now_us.saturating_sub(self.began_us) > PATIENCE_US {
            self.frame.clear();
        }
    }

    fn receive(&mut self, byte: u8, now_us: u64, answer: &mut Vec<u8>) {
        self.advance(now_us);
        if self.frame.is_empty() {
            self.began_us = now_us;
        }
        self.frame.push(byte);
        if self.missing() > 0 {
            return;
        }
        let frame = core::mem::take(&mut self.frame);
        match frame[0] {
            0 => self.reset(),
            1 => self.configure(&frame),
            2 => {
                self.turn(&frame);
                self.answer(frame[1], answer);
            }
            _ => self.counted.skipped += 1,
        }
    }
}

/// Length of a configuration, as far as what has come of it says.
fn configuration_length(frame: &[u8]) -> usize {
    let ports = |bits: u8| (bits & 0b1111).count_ones() as usize;
    // Motors and encoders as bits, sensors and pins as counts; behind each a byte for each.
    let (mut at, mut encoders) = (2, 0);
    for list in 0..4 {
        let Some(&head) = frame.get(at) else {
            return at + 1;
        };
        let entries = if list < 2 { ports(head) } else { head.into() };
        if list == 1 {
            encoders = entries;
        }
        at += 1 + entries;
    }
    at + 8 * encoders
}

/// Ports as bits and a direction for each; then the rest.
fn listed(bytes: &[u8]) -> (Vec<(usize, u8)>, &[u8]) {
    let (bits, rest) = (bytes[0], &bytes[1..]);
    let ports: Vec<usize> = (0..PORTS).filter(|port| bits & 1 << port != 0).collect();
    let (directions, rest) = rest.split_at(ports.len());
    (
        ports.into_iter().zip(directions.iter().copied()).collect(),
        rest,
    )
}

/// The bytes behind a count, as many as it says; and the rest.
fn counted(bytes: &[u8]) -> (&[u8], &[u8]) {
    bytes[1..].split_at(usize::from(bytes[0]))
}

const _: () = assert!(
    CountingSense::Clockwise as u8 == 0 && CountingSense::CounterClockwise as u8 == 1,
    "as on the wire"
);
