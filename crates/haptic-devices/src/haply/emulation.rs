//! An emulated board at a line, by the clock.

use super::board::{Board, Counted};
use haptic_loop::ParameterError;
use haptic_remote::serial::Line;
use haptic_remote::{FaultyLine, LineDamage, LineFaults};
use std::io::ErrorKind;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// A read waits so long: the body moves on in steps of it at least.
const PATIENCE: Duration = Duration::from_millis(1);
/// Pause while nobody has the port open.
const NOBODY: Duration = Duration::from_millis(5);

/// What an emulated board and its line have done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emulated {
    /// Counts of the board.
    pub board: Counted,
    /// Torques of both motors at the end, N·m.
    pub torques_nm: [f64; 2],
    /// Place of the handle at the end, m.
    pub place_m: [f64; 2],
    /// Bytes that the line lost, damaged and so on, to the board.
    pub to_board: LineDamage,
    /// The same to the host.
    pub to_host: LineDamage,
}

/// Runs a board at this end of a line until it is stopped or its time is over. The faults are those of single bytes.
///
/// # Errors
/// Faults outside their range.
pub fn emulate(
    mut line: Box<dyn Line>,
    mut board: Board,
    faults: LineFaults,
    seed: u64,
    duration: Option<Duration>,
    stop: &AtomicBool,
) -> Result<Emulated, ParameterError> {
    let mut to_board = FaultyLine::new(faults, seed)?;
    let mut to_host = FaultyLine::new(faults, seed.wrapping_add(1))?;
    // As it was before, if the line has no patience.
    let _ = line.set_patience(PATIENCE);
    let began = Instant::now();
    let mut bytes = [0; 256];
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
        board.advance(now_us);
        for byte in &bytes[..count] {
            to_board.send(core::slice::from_ref(byte), now_us);
        }
        while let Some(through) = to_board.receive(now_us) {
            for byte in through {
                board.receive(byte, now_us, &mut answer);
            }
        }
        for byte in answer.drain(..) {
            to_host.send(core::slice::from_ref(&byte), now_us);
        }
        let mut through = Vec::new();
        while let Some(byte) = to_host.receive(now_us) {
            through.extend(byte);
        }
        // Whoever does not read has lost them.
        let _ = line.write_all(&through);
    }
    Ok(Emulated {
        board: board.counted(),
        torques_nm: board.torques_nm(),
        place_m: board.body().place_m().into(),
        to_board: to_board.damage(),
        to_host: to_host.damage(),
    })
}
