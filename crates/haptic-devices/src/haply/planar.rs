//! The 2DIY with both axes: positions and forces in its plane, a frame there and an answer back in each tick.

use super::kinematics::Posture;
use super::model::Model;
use super::plausible::{Trouble, judged};
use super::protocol::{ANSWER_BYTES, TORQUE_MAX_NM, configuration, reset, resynchronise, torques};
use haptic_remote::Exchange;
use haptic_remote::serial::Line;
use nalgebra::Vector2;
use std::io::ErrorKind;
use std::time::Duration;

/// Ticks without a whole answer that are borne; the next is a fault.
pub const LATE_MOST: u32 = 3;
/// Part of a period that a tick waits for an answer.
const WAITING: u32 = 4;
/// Bytes that are looked at in a tick: more than ever are due.
const ROOM: usize = 64;
/// More answers than ever are due: the room for one more byte than theirs is there.
const DUE_MOST: u8 = 6;

/// A 2DIY on a line, with both axes, m and N in the plane of the maker: x along the base, y away from it.
///
/// A force goes out in a write, and the place of the handle in that moment comes back with the next
/// read: a delay of one tick. A frame is sent only when the answer to the last has come whole, so that a lost byte
/// leaves the board waiting instead of reading torques from the wrong place; a tick whose answer is late keeps the last place,
/// and the board the last torque.
///
/// *Torques* beyond what the board makes are scaled down together: the force keeps its direction and is the smaller.
#[derive(Debug)]
pub struct Planar<L: Line> {
    line: L,
    model: Model,
    period_s: f64,
    bytes: [u8; ROOM],
    filled: usize,
    /// Frames that were sent and whose answers have not come: one, and a second where the board was told to let go meanwhile.
    due: u8,
    exchange: Exchange,
    posture: Posture,
    trouble: Option<Trouble>,
    /// The line took every byte that told a board in trouble to let go.
    told: bool,
    /// Torques beyond the board's, scaled down.
    scaled: u64,
}

impl<L: Line> Planar<L> {
    /// A device that has answered, with the posture of its answer.
    pub(super) fn new(line: L, model: Model, posture: Posture) -> Self {
        Self {
            line,
            model,
            period_s: 1e-3,
            bytes: [0; ROOM],
            filled: 0,
            due: 0,
            exchange: Exchange::default(),
            posture,
            trouble: None,
            told: false,
            scaled: 0,
        }
    }

    /// The device that it was said to be.
    #[must_use]
    pub const fn model(&self) -> &Model {
        &self.model
    }

    /// The last posture that was believed.
    #[must_use]
    pub const fn posture(&self) -> &Posture {
        &self.posture
    }

    /// The trouble that ended it, if any did.
    #[must_use]
    pub const fn trouble(&self) -> Option<Trouble> {
        self.trouble
    }

    /// True if a board in trouble was told to let go: the line took every byte of that. A port that is gone takes none.
    #[must_use]
    pub(crate) const fn was_told(&self) -> bool {
        self.told && !matches!(self.trouble, Some(Trouble::Gone))
    }

    /// Ticks whose torques were scaled down to what the board makes.
    #[must_use]
    pub const fn scaled(&self) -> u64 {
        self.scaled
    }

    /// From now on ticks come at this period.
    pub(super) fn ticks_every(&mut self, period_s: f64) {
        self.period_s = period_s;
        // The answer has most of a period on its own.
        let patience = Duration::from_secs_f64(period_s) / WAITING;
        if self.line.set_patience(patience).is_err() {
            self.fails(Trouble::Gone);
        }
    }

    /// What of the exchange of frames came through.
    pub(super) const fn exchange(&mut self) -> &mut Exchange {
        &mut self.exchange
    }

    /// Takes in what came, and judges it.
    pub(super) fn measure(&mut self) -> Result<&Posture, Trouble> {
        if let Some(trouble) = self.trouble {
            return Err(trouble);
        }
        match self.hear() {
            Ok(()) => Ok(&self.posture),
            Err(trouble) => Err(self.fails(trouble)),
        }
    }

    fn hear(&mut self) -> Result<(), Trouble> {
        self.receive()?;
        let expected = usize::from(self.due) * ANSWER_BYTES;
        if self.filled > expected {
            return Err(Trouble::TooMuch {
                bytes: self.filled as u8,
                expected: expected as u8,
            });
        }
        if self.due == 0 {
            return Ok(());
        }
        if self.filled < expected {
            let ticks = self.exchange.unanswered();
            if ticks > LATE_MOST {
                return Err(Trouble::Silent {
                    ticks,
                    bytes: self.filled as u8,
                });
            }
            return Ok(());
        }
        let mut answer = [0; ANSWER_BYTES];
        answer.copy_from_slice(&self.bytes[expected - ANSWER_BYTES..expected]);
        let passed_s = (1.0 + f64::from(self.exchange.unmeasured())) * self.period_s;
        let (_, posture) = judged(&self.model, answer, Some((&self.posture, passed_s)))?;
        self.posture = posture;
        self.exchange.answered();
        (self.filled, self.due) = (0, 0);
        Ok(())
    }

    /// Takes what is there; waits only while an answer is due and not whole.
    fn receive(&mut self) -> Result<(), Trouble> {
        loop {
            match self.line.read(&mut self.bytes[self.filled..]) {
                Ok(0) => return Err(Trouble::Gone),
                Ok(count) => self.filled += count,
                Err(error) if error.kind() == ErrorKind::TimedOut => return Ok(()),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(_) => return Err(Trouble::Gone),
            }
            if self.filled >= usize::from(self.due) * ANSWER_BYTES {
                return Ok(());
            }
        }
    }

    /// Sends the torques of a force in the plane, N, unless the board still owes an answer.
    pub(super) fn push(&mut self, force_n: Vector2<f64>) -> Result<(), Trouble> {
        if let Some(trouble) = self.trouble {
            return Err(trouble);
        }
        self.exchange.sent(self.due == 0);
        if self.due > 0 {
            return Ok(());
        }
        let mut wanted = self.posture.torques(force_n);
        let largest = wanted.amax();
        if !largest.is_finite() {
            return Err(self.fails(Trouble::NotFinite));
        }
        if largest > TORQUE_MAX_NM {
            wanted *= TORQUE_MAX_NM / largest;
            self.scaled += 1;
        }
        let frame = torques(&self.model, [wanted.x as f32, wanted.y as f32]);
        if self.line.write_all(&frame).is_err() {
            return Err(self.fails(Trouble::Gone));
        }
        self.due = 1;
        Ok(())
    }

    /// The first trouble counts: no torque from now on.
    fn fails(&mut self, trouble: Trouble) -> Trouble {
        let first = *self.trouble.get_or_insert(trouble);
        self.let_go();
        first
    }

    /// No torque from now on. A device in order keeps its configuration, and with it the place of its home; one in trouble is brought
    /// to the begin of a frame, told once more that there is no torque, and reset.
    pub(super) fn let_go(&mut self) {
        let nothing = torques(&self.model, [0.0; 2]);
        // A line that takes no bytes has nobody at its other end.
        let heard = self.line.write_all(&nothing).is_ok();
        if self.trouble.is_none() {
            // It answers this one too.
            self.due += u8::from(heard && self.due < DUE_MOST);
            return;
        }
        let told = (self.line.write_all(&resynchronise()))
            .and_then(|()| self.line.write_all(&configuration(&self.model)))
            .and_then(|()| self.line.write_all(&nothing))
            .and_then(|()| self.line.write_all(&reset()));
        self.told |= told.is_ok();
    }
}

impl<L: Line> Drop for Planar<L> {
    fn drop(&mut self) {
        self.let_go();
    }
}
