//! An emulated board at a line, by the clock.

use super::board::{Board, Counted};
use crate::at_line::run;
use crate::{LineDamage, LineFaults};
use haptic_loop::ParameterError;
use haptic_remote::serial::Line;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

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
    line: Box<dyn Line>,
    mut board: Board,
    faults: LineFaults,
    seed: u64,
    duration: Option<Duration>,
    stop: &AtomicBool,
) -> Result<Emulated, ParameterError> {
    let damage = run(line, &mut board, (faults, seed), duration, stop)?;
    Ok(Emulated {
        board: board.counted(),
        torques_nm: board.torques_nm(),
        place_m: board.body().place_m().into(),
        to_board: damage.to_device,
        to_host: damage.to_host,
    })
}
