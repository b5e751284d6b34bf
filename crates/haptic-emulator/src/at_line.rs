//! A device without hardware at the other end of a line, by the clock.

use crate::{FaultyLine, LineDamage, LineFaults};
use haptic_loop::ParameterError;
use haptic_remote::serial::Line;
use std::io::ErrorKind;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// A read waits so long: the device moves on in steps of it at least.
const PATIENCE: Duration = Duration::from_millis(1);
/// Pause while nobody has the port open.
pub(crate) const NOBODY: Duration = Duration::from_millis(5);

/// A device without hardware that takes bytes and answers in bytes. Time is an argument, µs.
pub trait AtLine {
    /// Lets time pass up to this moment.
    fn advance(&mut self, now_us: u64);

    /// Takes a byte, and appends what there is to say.
    fn receive(&mut self, byte: u8, now_us: u64, out: &mut Vec<u8>);
}

/// What a line did to the bytes of both ways: to the device, and to the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Damage {
    /// To the device.
    pub to_device: LineDamage,
    /// To the host.
    pub to_host: LineDamage,
}

/// Runs a device at this end of a line until it is stopped or its time is over. The faults are those of single bytes.
///
/// # Errors
/// Faults outside their range.
pub fn emulate(
    mut line: Box<dyn Line>,
    device: &mut impl AtLine,
    (faults, seed): (LineFaults, u64),
    duration: Option<Duration>,
    stop: &AtomicBool,
) -> Result<Damage, ParameterError> {
    let [mut to_device, mut to_host] = FaultyLine::both_ways(faults, seed)?;
    // As it was before, if the line has no patience.
    let _ = line.set_patience(PATIENCE);
    let began = Instant::now();
    let mut bytes = [0; 1024];
    let mut answer = Vec::new();
    while !stop.load(Ordering::Relaxed) && duration.is_none_or(|most| began.elapsed() < most) {
        let count = match line.read(&mut bytes) {
            Ok(count) => count,
            Err(error) if error.kind() == ErrorKind::TimedOut => 0,
            Err(_) => {
                std::thread::sleep(NOBODY);
                0
            }
        };
        let now_us = began.elapsed().as_micros() as u64;
        device.advance(now_us);
        // A line without faults carries thousands of bytes a second more cheaply.
        let arrived = if faults.is_ideal() {
            bytes[..count].to_vec()
        } else {
            carried(&mut to_device, &bytes[..count], now_us)
        };
        for byte in arrived {
            device.receive(byte, now_us, &mut answer);
        }
        let said = core::mem::take(&mut answer);
        let through = if faults.is_ideal() {
            said
        } else {
            carried(&mut to_host, &said, now_us)
        };
        // Whoever does not read has lost them.
        let _ = line.write_all(&through);
    }
    Ok(Damage {
        to_device: to_device.damage(),
        to_host: to_host.damage(),
    })
}

/// Puts bytes on a bad line, and takes off what has arrived.
fn carried(line: &mut FaultyLine, bytes: &[u8], now_us: u64) -> Vec<u8> {
    for byte in bytes {
        line.send(core::slice::from_ref(byte), now_us);
    }
    let mut through = Vec::new();
    while let Some(byte) = line.receive(now_us) {
        through.extend(byte);
    }
    through
}
