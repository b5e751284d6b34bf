//! `device emulate --kind moteus`.

use crate::output::note;
use crate::whole::whole;
use crate::within::in_range;
use clap::Args;
use haptic_devices::moteus::MoteusSettings;
use haptic_emulator::LineFaults;
use haptic_emulator::moteus::{Emulated, EmulatedServo, Hand, Shaft, emulate};
use haptic_experiment::failure::Failure;
use haptic_experiment::parameters::range;
use haptic_quantity::{Length, Time};
use haptic_remote::serial::Line;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Ticks: longer than a force takes to rise to its full size at 1 kHz.
const WAIT_COMMANDS: u32 = 600;

/// Options of an emulated servo.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "moteus")]
pub struct MoteusArguments {
    /// Number of the servo on its bus [default: 1]
    #[arg(long, value_name = "ID", value_parser = whole::<u8>(0..=u8::MAX))]
    servo_id: Option<u8>,
    /// A hand that turns the shaft by a length, at a radius of 20 mm, in a time, and holds it there, as 2mm:0.5s; it begins
    /// with command 600 [default: nobody holds the shaft]
    #[arg(long, value_name = "LENGTH:TIME", value_parser = turn)]
    turn: Option<Hand>,
}

fn turn(text: &str) -> Result<Hand, String> {
    let read = |text: &str| {
        let (length, time) = text.split_once(':')?;
        Some((length.parse::<Length>().ok()?, time.parse::<Time>().ok()?))
    };
    let (length, time) =
        read(text).ok_or_else(|| format!("\"{text}\" is not LENGTH:TIME, as in 2mm:0.5s"))?;
    Ok(Hand {
        wait_commands: WAIT_COMMANDS,
        turn_rev: in_range(length, range::ARM_PLACES)?.0
            / MoteusSettings::DEFAULT.metres_per_revolution(),
        ramp_time_s: in_range(time, range::DURATIONS)?.0,
    })
}

impl MoteusArguments {
    /// True if any of them was given.
    pub(super) const fn is_given(&self) -> bool {
        self.servo_id.is_some() || self.turn.is_some()
    }

    /// The servo.
    pub(super) fn servo(&self) -> Result<EmulatedServo, Failure> {
        let shaft = Shaft {
            hand: self.turn,
            ..Shaft::LEVER
        };
        let id = self.servo_id.unwrap_or(MoteusSettings::DEFAULT.id);
        EmulatedServo::new(id, shaft).map_err(Failure::input)
    }
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
    let done = emulate(line, servo, faults, duration, stop).map_err(Failure::input)?;
    if !quiet {
        note("emulated", in_words(&done));
    }
    Ok(())
}

fn in_words(done: &Emulated) -> String {
    let lost = done.to_servo.dropped + done.to_host.dropped;
    let damaged = done.to_servo.corrupted + done.to_host.corrupted;
    format!(
        "{} frames, {} answers, {} lines refused; mode {} at the end, shaft at {:.6} revolutions, torque {:.6} N·m, the \
         largest {:.6} N·m; the line lost {lost} bytes, damaged {damaged}",
        done.served.frames,
        done.served.answers,
        done.served.refused,
        done.mode,
        done.position_rev,
        done.torque_nm,
        done.torque_peak_nm
    )
}
