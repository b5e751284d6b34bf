//! `device emulate --kind moteus`.

use super::key_value::in_range;
use crate::output::note;
use haptic_devices::moteus::MoteusSettings;
use haptic_emulator::moteus::{EmulatedAdapter, EmulatedServo, Hand, Shaft};
use haptic_emulator::{Damage, LineFaults, emulate};
use haptic_experiment::Failure;
use haptic_experiment::parameters::range;
use haptic_remote::serial::Line;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Ticks: longer than a force takes to rise to its full size at 1 kHz.
const WAIT_COMMANDS: u32 = 600;

/// A hand that turns the shaft: `LENGTH:TIME`.
pub(super) fn turn(text: &str) -> Result<Hand, String> {
    let (length, time) = text
        .split_once(':')
        .ok_or("is not LENGTH:TIME, as in 2mm:0.5s")?;
    Ok(Hand {
        wait_commands: WAIT_COMMANDS,
        turn_rev: in_range("turn_m", range::ARM_PLACES, length)?
            / MoteusSettings::DEFAULT.metres_per_revolution(),
        ramp_time_s: in_range("turn_s", range::DURATIONS, time)?,
    })
}

/// A servo with this number on its bus, and this hand.
pub(super) fn servo(id: Option<u8>, hand: Option<Hand>) -> Result<EmulatedServo, Failure> {
    let shaft = Shaft {
        hand,
        ..Shaft::LEVER
    };
    let id = id.unwrap_or(MoteusSettings::DEFAULT.id);
    EmulatedServo::new(id, shaft).map_err(Failure::input)
}

/// Runs the servo until it is stopped or its time is over.
pub(super) fn run(
    line: Box<dyn Line>,
    servo: EmulatedServo,
    faults: (LineFaults, u64),
    duration: Option<Duration>,
    stop: &AtomicBool,
    quiet: bool,
) -> Result<(), Failure> {
    let mut adapter = EmulatedAdapter::new(servo);
    let damage = emulate(line, &mut adapter, faults, duration, stop).map_err(Failure::input)?;
    if !quiet {
        note("emulated", in_words(&adapter, &damage));
    }
    Ok(())
}

fn in_words(adapter: &EmulatedAdapter, Damage { to_device, to_host }: &Damage) -> String {
    let (served, servo) = (adapter.served(), &adapter.servo);
    let lost = to_device.dropped + to_host.dropped;
    let damaged = to_device.corrupted + to_host.corrupted;
    format!(
        "{} frames, {} answers, {} lines refused; mode {} at the end, shaft at {:.6} revolutions, torque {:.6} N·m, the \
         largest {:.6} N·m; the line lost {lost} bytes, damaged {damaged}",
        served.frames,
        served.answers,
        served.refused,
        u8::from(servo.mode()),
        servo.position_rev(),
        servo.torque_nm(),
        servo.torque_peak_nm()
    )
}
