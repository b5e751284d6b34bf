//! An emulated servo at a line, by the clock.

use super::adapter::{EmulatedAdapter, Served};
use super::servo::EmulatedServo;
use crate::at_line::run;
use crate::{LineDamage, LineFaults};
use haptic_loop::ParameterError;
use haptic_remote::serial::Line;
use moteus_protocol::Mode;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// What an emulated servo and its line have done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emulated {
    /// Counts of frames.
    pub served: Served,
    /// Number of the mode at the end.
    pub mode: u8,
    /// Torque at the end, N·m.
    pub torque_nm: f64,
    /// Largest torque it has made, N·m.
    pub torque_peak_nm: f64,
    /// Place of the shaft at the end, revolutions.
    pub position_rev: f64,
    /// Bytes that the line lost, damaged and so on, to the servo.
    pub to_servo: LineDamage,
    /// The same to the host.
    pub to_host: LineDamage,
}

/// Runs a servo at this end of a line until it is stopped or its time is over. The faults are those of single bytes.
///
/// # Errors
/// Faults outside their range.
pub fn emulate(
    line: Box<dyn Line>,
    servo: EmulatedServo,
    faults: (LineFaults, u64),
    duration: Option<Duration>,
    stop: &AtomicBool,
) -> Result<Emulated, ParameterError> {
    let mut adapter = EmulatedAdapter::new(servo);
    let damage = run(line, &mut adapter, faults, duration, stop)?;
    let servo = &adapter.servo;
    Ok(Emulated {
        served: adapter.served(),
        mode: Mode::into(servo.mode()),
        torque_nm: servo.torque_nm(),
        torque_peak_nm: servo.torque_peak_nm(),
        position_rev: servo.position_rev(),
        to_servo: damage.to_device,
        to_host: damage.to_host,
    })
}
