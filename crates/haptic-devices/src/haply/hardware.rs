//! The 2DIY behind the device's side of the link: with one axis, a line of its plane, or with both.

use super::{
    kinematics::Posture,
    model::{HaplyModel, HaplyName, HaplyPlane, middle},
    protocol::{
        ANSWER_BYTES, HaplyTrouble, TORQUE_MAX_NM, configuration, judged, reset, resynchronise,
        torques,
    },
};
use haptic_link::{Capabilities, Conduct};
use haptic_loop::{Device, Fault, Reading, SafeForce};
use haptic_remote::{
    Exchange, Hardware, abilities,
    serial::{BoardTrouble, Line, ServedHardware, TroubleCause, USB_PERIOD_US},
};
use nalgebra::{SMatrix, SVector, Vector2};
use std::{io::ErrorKind, time::Duration};

/// Largest force along a line, N: both motors make it wherever 40 mm < y < 130 mm and the handle is within 50 mm of the middle.
pub const FORCE_MAX_N: f32 = 1.5;

/// Ticks without a whole answer that are borne while a force is asked for; the next is a fault.
pub const LATE_MOST: u32 = 3;
/// Part of a period that a tick waits for an answer.
const WAITING: u32 = 4;
/// Bytes that are read in a tick: more than are ever due.
const ROOM: usize = 64;
/// More answers than ever are due: the room for one more byte than theirs is there.
const DUE_MOST: u8 = 6;

/// A 2DIY that moves and pushes along D lines of its plane: one line by default, without force
/// across it, or both axes.
///
/// A force goes out in a write, and its place comes back with the next read: a tick of delay. A
/// frame is sent only when the last answer is whole, so a lost byte leaves the board waiting; after
/// a late answer, position and torque stay the same.
/// *Torques* beyond the board's are scaled down together: the force keeps its direction.
#[derive(Debug)]
pub struct Haply2Diy<L: Line, const D: usize = 1> {
    line: L,
    model: HaplyModel,
    period_s: f64,
    bytes: [u8; ROOM],
    filled: usize,
    /// Frames sent and not yet answered: one, and a second if the board was commanded to let go meanwhile.
    due: u8,
    exchange: Exchange,
    posture: Posture,
    trouble: Option<HaplyTrouble>,
    /// The line accepted every byte of the command to let go, for a board in trouble.
    is_let_go: bool,
    /// The command to let go was repeated to a board in trouble.
    told_again: bool,
    /// Torques beyond the board's, scaled down.
    scaled: u64,
    /// Unit vectors along the lines.
    along: SMatrix<f64, 2, D>,
    /// Place of the plane that is zero, m.
    zero: Vector2<f64>,
    /// The last place along the lines, m.
    position_m: SVector<f32, D>,
}

impl<L: Line, const D: usize> Haply2Diy<L, D> {
    /// A device that has answered: along a line, or in the plane, x to the right and y away from the base, from the middle of the workspace.
    pub(super) fn new(line: L, model: HaplyModel, posture: Posture, name: &HaplyName) -> Self {
        let (along, zero) = if D == 1 {
            let across = name.axis.across_and_along(name.zero_m);
            let along = name.axis.along();
            (
                SMatrix::from_fn(|row, _| along[row]),
                middle(&model) + across,
            )
        } else {
            (SMatrix::identity(), HaplyPlane::of(model).centre())
        };
        let mut this = Self {
            line,
            model,
            period_s: 1e-3,
            bytes: [0; ROOM],
            filled: 0,
            due: 0,
            exchange: Exchange::default(),
            posture,
            trouble: None,
            is_let_go: false,
            told_again: false,
            scaled: 0,
            along,
            zero,
            position_m: SVector::zeros(),
        };
        this.position_m = this.place();
        this
    }

    /// The device that it was said to be.
    #[must_use]
    pub const fn model(&self) -> &HaplyModel {
        &self.model
    }

    /// The last posture that was accepted.
    #[must_use]
    pub const fn posture(&self) -> &Posture {
        &self.posture
    }

    /// The trouble that ended it, if any did; its words are those of [`trouble`](ServedHardware::trouble).
    #[must_use]
    pub const fn ended_by(&self) -> Option<HaplyTrouble> {
        self.trouble
    }

    /// Number of ticks whose torques were scaled down to the board's limit.
    #[must_use]
    pub const fn scaled(&self) -> u64 {
        self.scaled
    }

    fn place(&self) -> SVector<f32, D> {
        let place = self.along.transpose() * (self.posture.hand_m - self.zero);
        place.map(|axis| axis as f32)
    }

    fn reading(&self) -> Reading<f32, D> {
        Reading {
            tick: 0,
            time_s: 0.0,
            position_m: self.position_m,
        }
    }

    fn ticks_every(&mut self, period_s: f64) {
        self.period_s = period_s;
        // The answer has most of a period on its own.
        let patience = Duration::from_secs_f64(period_s) / WAITING;
        if self.line.set_patience(patience).is_err() {
            self.fails(HaplyTrouble::Gone);
        }
    }

    /// Takes in what came, and judges it.
    fn measure(&mut self) -> Result<(), HaplyTrouble> {
        if let Some(trouble) = self.trouble {
            return Err(trouble);
        }
        self.hear().map_err(|trouble| self.fails(trouble))
    }

    fn hear(&mut self) -> Result<(), HaplyTrouble> {
        self.receive()?;
        let expected = usize::from(self.due) * ANSWER_BYTES;
        if self.filled > expected {
            return Err(HaplyTrouble::TooMuch {
                bytes: self.filled as u8,
                expected: expected as u8,
            });
        }
        if self.due == 0 {
            return Ok(());
        }
        if self.filled < expected {
            let ticks = self.exchange.unanswered();
            if self.exchange.is_silent(LATE_MOST + 1, self.period_s) {
                return Err(HaplyTrouble::Silent {
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
    fn receive(&mut self) -> Result<(), HaplyTrouble> {
        loop {
            match self.line.read(&mut self.bytes[self.filled..]) {
                Ok(0) => return Err(HaplyTrouble::Gone),
                Ok(count) => self.filled += count,
                Err(error) if error.kind() == ErrorKind::TimedOut => return Ok(()),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(_) => return Err(HaplyTrouble::Gone),
            }
            if self.filled >= usize::from(self.due) * ANSWER_BYTES {
                return Ok(());
            }
        }
    }

    /// Sends the torques of a force in the plane, N, unless the board still owes an answer.
    fn push(&mut self, force_n: Vector2<f64>) -> Result<(), HaplyTrouble> {
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
            return Err(self.fails(HaplyTrouble::NotFinite));
        }
        if largest > TORQUE_MAX_NM {
            wanted *= TORQUE_MAX_NM / largest;
            self.scaled += 1;
        }
        let frame = torques(&self.model, [wanted.x as f32, wanted.y as f32]);
        if self.line.write_all(&frame).is_err() {
            return Err(self.fails(HaplyTrouble::Gone));
        }
        self.due = 1;
        Ok(())
    }

    /// The first trouble counts: no torque from now on.
    fn fails(&mut self, trouble: HaplyTrouble) -> HaplyTrouble {
        let first = *self.trouble.get_or_insert(trouble);
        self.leave();
        first
    }

    /// No torque from now on. A device in order keeps its configuration and home; one in trouble is brought to the
    /// begin of a frame, commanded once more to let go, and reset.
    fn leave(&mut self) {
        let nothing = torques(&self.model, [0.0; 2]);
        // A line that takes no bytes has nobody at its other end.
        let heard = self.line.write_all(&nothing).is_ok();
        if self.trouble.is_none() {
            // It answers this one too.
            self.due += u8::from(heard && self.due < DUE_MOST);
            return;
        }
        let written = (self.line.write_all(&resynchronise()))
            .and_then(|()| self.line.write_all(&configuration(&self.model)))
            .and_then(|()| self.line.write_all(&nothing))
            .and_then(|()| self.line.write_all(&reset()));
        self.is_let_go |= written.is_ok();
    }
}

impl<L: Line, const D: usize> Drop for Haply2Diy<L, D> {
    fn drop(&mut self) {
        self.leave();
    }
}

impl<L: Line, const D: usize> Device<f32, D> for Haply2Diy<L, D> {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, D>, Fault> {
        // A board in trouble fails in each tick: no place is reported as measured.
        self.measure().map_err(HaplyTrouble::fault)?;
        self.position_m = self.place();
        Ok(self.reading())
    }

    fn write(&mut self, force: SafeForce<f32, D>) -> Result<(), Fault> {
        let force_n = self.along * force.newtons().map(f64::from);
        self.push(force_n).map_err(HaplyTrouble::fault)
    }

    fn let_go(&mut self) {
        // A board in trouble gets the command again at once, as a byte may be lost again, and at the end; not in each tick between.
        if !(self.trouble.is_some() && core::mem::replace(&mut self.told_again, true)) {
            self.leave();
        }
    }
}

impl<L: Line, const D: usize> Hardware<D> for Haply2Diy<L, D> {
    type Setup = ();

    fn capabilities(&self) -> Capabilities {
        let board = match self.model.version.number() {
            2 => "Haply 2DIY v2",
            _ => "Haply 2DIY v3",
        };
        Capabilities {
            tick_period_min_us: USB_PERIOD_US,
            force_max_n: FORCE_MAX_N,
            // From one end to the other in a tick.
            force_rate_max_n_per_s: 2000.0 * FORCE_MAX_N,
            position_resolution_m: self.model.resolution_m(),
            // It keeps the last torque until it receives another one.
            lets_go_alone: Conduct::default(),
            ..abilities(board, D as u8)
        }
    }

    fn install(&mut self, (): (), tick_period_us: u32) {
        self.ticks_every(1e-6 * f64::from(tick_period_us));
    }

    fn exchange(&mut self) -> Option<&mut Exchange> {
        Some(&mut self.exchange)
    }

    fn restart(&mut self) {}

    fn idle(&mut self) -> Result<Reading<f32, D>, Fault> {
        let reading = self.read()?;
        self.push(Vector2::zeros()).map_err(HaplyTrouble::fault)?;
        Ok(reading)
    }

    fn persisting_fault(&self) -> Option<Fault> {
        let silent = self.exchange.silent_ticks() > LATE_MOST;
        (silent || self.trouble.is_some()).then_some(Fault::BoardFailed)
    }
}

impl<L: Line + 'static, const D: usize> ServedHardware<D> for Haply2Diy<L, D> {
    fn trouble(&self) -> Option<BoardTrouble> {
        let trouble = self.trouble?;
        // A port that is gone takes no byte.
        let was_told = self.is_let_go && trouble != HaplyTrouble::Gone;
        let state = match (was_told, trouble.cause()) {
            (false, _) => "the 2DIY cannot be told to let go",
            (true, TroubleCause::Gone) => {
                "the 2DIY does not answer; it was told to let go and to reset itself"
            }
            (true, _) => "the 2DIY was told to let go and to reset itself",
        };
        Some(BoardTrouble {
            words: format!(
                "{state}: {trouble}; its home is uncertain: reopen it there, without home=before"
            ),
            cause: trouble.cause(),
        })
    }
}
