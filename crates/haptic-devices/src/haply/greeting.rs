//! Opening a 2DIY: the board is configured, and its first answers are checked.

use super::{
    hardware::Haply2Diy,
    model::{HaplyName, Home},
    protocol::{ANSWER_BYTES, HaplyTrouble, configuration, judged, resynchronise, torques},
};
use haptic_loop::realtime::Moment;
use haptic_remote::{
    Patience,
    serial::{Line, SerialError},
};
use std::{io::ErrorKind, time::Duration};
use thiserror::Error;

/// Bits per second; a USB port of the board's own has no speed.
const BAUD: u32 = 115_200;

/// The board takes some milliseconds to be configured; more than this is silence.
const FIRST_ANSWER: Duration = Duration::from_millis(500);
/// Nothing for so long is quiet: several times what the board takes for an answer.
const QUIET: Duration = Duration::from_millis(20);
/// More bytes than a board ever has on its way: it speaks unasked.
const THROWN_MOST: usize = 4096;
/// Answers that are checked before the device counts as a 2DIY.
const FIRST_ANSWERS: usize = 3;

/// Nobody is at the other end of the line.
const GONE: HaplyOpenError = HaplyOpenError::First(HaplyTrouble::Gone);

/// A 2DIY that cannot be opened.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum HaplyOpenError {
    /// Its port cannot be opened.
    #[error(transparent)]
    Port(#[from] SerialError),
    /// Not one whole answer came in time.
    #[error(
        "no 2DIY answered: only {bytes} of the 9 bytes of an answer arrived in 0.5 s; check the port, and that the board is on"
    )]
    Mute {
        /// Bytes of that answer which did come; 0 if nothing is there.
        bytes: usize,
    },
    /// It answers as a board that has lost its home, or never had one.
    #[error(
        "home=before is refused: no command has configured this board since it was switched on or reset ({bytes} of the 9 bytes of an answer came); \
         hold the handle at its home and omit home=before"
    )]
    NoHome {
        /// Bytes of that answer which did come; 0 if nothing is there.
        bytes: usize,
    },
    /// Something sends without being asked, which no 2DIY does.
    #[error("something at this port sends without being asked, which no 2DIY does: check the port")]
    Talks,
    /// A line of the plane was chosen for an experiment with both axes.
    #[error(
        "axis and zero choose a line for an experiment with one axis, and this one uses both: omit them"
    )]
    Line,
    /// Its first answers cannot be those of such a device.
    #[error("the first answer is not from a working 2DIY: {0}")]
    First(HaplyTrouble),
    /// Its first answers, by the home of an earlier command.
    #[error(
        "with home=before the first answer is not from a working 2DIY: {0}; if the handle was not at its home then, or the board was \
         switched off since, hold it there and omit home=before"
    )]
    FirstSinceBefore(HaplyTrouble),
}

impl HaplyName {
    /// Opens the port, configures the board and checks its first answers; with one axis along a line, with two in the plane.
    ///
    /// # Errors
    /// A port that cannot be opened; a board that does not answer as a 2DIY does; a line for two axes.
    pub fn open<const D: usize>(&self) -> Result<Haply2Diy<Box<dyn Line>, D>, HaplyOpenError> {
        if D > 1 && self.chooses_line() {
            return Err(HaplyOpenError::Line);
        }
        let line = haptic_remote::serial::open(&self.path, BAUD)?;
        Haply2Diy::greet(line, self)
    }
}

/// Translates the error of a board that keeps an earlier home, which needs another remedy.
fn since(home: Home, error: HaplyOpenError) -> HaplyOpenError {
    match (home, error) {
        (Home::Before, HaplyOpenError::Mute { bytes }) if bytes > 0 => {
            HaplyOpenError::NoHome { bytes }
        }
        (Home::Before, HaplyOpenError::First(trouble)) if trouble != HaplyTrouble::Gone => {
            HaplyOpenError::FirstSinceBefore(trouble)
        }
        (_, error) => error,
    }
}

impl<L: Line, const D: usize> Haply2Diy<L, D> {
    /// Configures the board at the other end of a line, unless it should keep its earlier home, and
    /// checks its first answers. There is no torque meanwhile.
    ///
    /// # Errors
    /// No answer, or one that such a device cannot give.
    pub fn greet(mut line: L, name: &HaplyName) -> Result<Self, HaplyOpenError> {
        let model = name.version.model();
        if name.home == Home::Now {
            line.write_all(&resynchronise()).map_err(|_| GONE)?;
            line.write_all(&configuration(&model)).map_err(|_| GONE)?;
        }
        quiet(&mut line)?;
        let mut posture = None;
        for _ in 0..FIRST_ANSWERS {
            let nothing = torques(&model, [0.0; 2]);
            line.write_all(&nothing).map_err(|_| GONE)?;
            let answer = first_answer(&mut line).map_err(|error| since(name.home, error))?;
            let seen = judged(&model, answer, None).map_err(HaplyOpenError::First);
            let (_, seen) = seen.map_err(|error| since(name.home, error))?;
            posture = Some(seen);
        }
        let posture = posture.ok_or(GONE)?;
        Ok(Self::new(line, model, posture, name))
    }
}

/// Discards earlier bytes, until no more arrive.
fn quiet(line: &mut impl Line) -> Result<(), HaplyOpenError> {
    line.set_patience(QUIET).map_err(|_| GONE)?;
    let mut bytes = [0; 64];
    let (mut thrown, mut patience) = (0, Patience::new(FIRST_ANSWER));
    while thrown < THROWN_MOST && !patience.is_over() {
        let began = Moment::now();
        let read = line.read(&mut bytes);
        patience.waited(QUIET, began.elapsed());
        match read {
            Ok(0) => return Err(GONE),
            Ok(count) => thrown += count,
            Err(error) if error.kind() == ErrorKind::TimedOut => {
                return line
                    .set_patience(Duration::from_millis(1))
                    .map_err(|_| GONE);
            }
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(_) => return Err(GONE),
        }
    }
    Err(HaplyOpenError::Talks)
}

/// Waits for the whole answer to a first frame, and not more.
fn first_answer(line: &mut impl Line) -> Result<[u8; ANSWER_BYTES], HaplyOpenError> {
    let mut patience = Patience::new(FIRST_ANSWER);
    let mut bytes = [0; 64];
    let mut filled = 0;
    while filled < ANSWER_BYTES {
        let began = Moment::now();
        match line.read(&mut bytes[filled..]) {
            Ok(0) => return Err(GONE),
            Ok(count) => filled += count,
            Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => {}
            Err(_) => return Err(GONE),
        }
        // A read waits for a millisecond, and on a socket for some more.
        patience.waited(QUIET, began.elapsed());
        if filled < ANSWER_BYTES && patience.is_over() {
            return Err(HaplyOpenError::Mute { bytes: filled });
        }
    }
    if filled > ANSWER_BYTES {
        return Err(HaplyOpenError::First(HaplyTrouble::TooMuch {
            bytes: filled as u8,
            expected: ANSWER_BYTES as u8,
        }));
    }
    let mut answer = [0; ANSWER_BYTES];
    answer.copy_from_slice(&bytes[..ANSWER_BYTES]);
    Ok(answer)
}
