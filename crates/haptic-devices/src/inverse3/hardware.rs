//! The Inverse3 behind the device's side of the link: with one axis, a line of its workspace, or all three.
//!
//! ```text
//! tick n:  read: the answer to the message of tick n − 1 ─▶ x        write: f ─▶ message
//! ```
//! Nothing waits: an answer that has not come by the next tick counts as missing, the device stays where it was, and no further
//! message goes out before it, so that no force waits in a queue and acts later. A position is one tick old at least. *Cost* of a
//! tick: a message each way, two calls of the system; `tungstenite` and the text of the force allocate, nothing else does.

use super::{
    in_time::InTime,
    name::Inverse3Name,
    trouble::Inverse3Trouble,
    wire::{before_force, force, position},
};
use crate::moteus::is_not_now;
use haptic_link::{Capabilities, SerialNumber};
use haptic_loop::{Device, Fault, Reading, SafeForce};
use haptic_remote::{
    Exchange, Hardware, abilities,
    serial::{BoardTrouble, ServedHardware, TroubleCause},
};
use nalgebra::{SMatrix, SVector, Vector3};
use std::io::{Read, Write};
use tungstenite::{Message, WebSocket};

pub(super) type Socket<S> = WebSocket<InTime<S>>;

/// Largest force, N. The maker's is in no message; this one a hand bears.
pub const FORCE_MAX_N: f32 = 3.0;
/// 4 kHz, as fast as this was tried.
const PERIOD_MIN_US: u32 = 250;
/// Messages that are read in a tick: more than are ever due.
const MESSAGES_MOST: u32 = 16;
/// Answers that may be due: one, and those to commands to let go.
const DUE_MOST: u32 = 6;
/// A hand is slower, m/s, and an encoder coarser, m.
const SPEED_MOST_M_PER_S: f64 = 5.0;
const SPARE_M: f64 = 2e-3;

/// An Inverse3 that moves and pushes along D lines of its workspace: one, without force across it, or all three axes.
///
/// - *Faults*, all of them [`Fault::BoardFailed`] with words in [`trouble`](ServedHardware::trouble): see [`Inverse3Trouble`]. They stay
///   until it is opened anew.
/// - *Let go*: a force of zero. Where no message arrives any more, the service lets go when commands stop; after what time is
///   not documented.
#[derive(Debug)]
pub struct Inverse3<S: Read + Write, const D: usize = 1> {
    socket: Socket<S>,
    id: String,
    before_force: String,
    along: SMatrix<f64, 3, D>,
    lost_most: u32,
    /// The last place that was believed, m.
    place_m: Vector3<f64>,
    /// Messages without an answer so far.
    due: u32,
    exchange: Exchange,
    period_s: f64,
    trouble: Option<Inverse3Trouble>,
}

impl<S: Read + Write, const D: usize> Inverse3<S, D> {
    pub(super) fn new(
        socket: Socket<S>,
        id: &str,
        name: &Inverse3Name,
        place_m: Vector3<f64>,
    ) -> Self {
        Self {
            socket,
            id: id.to_owned(),
            before_force: before_force(id),
            along: name.lines(),
            lost_most: name.lost_most,
            place_m,
            due: 0,
            exchange: Exchange::default(),
            period_s: 1e-3,
            trouble: None,
        }
    }

    /// The stream, so that its reads can be set not to wait.
    pub(super) fn stream(&self) -> &S {
        self.socket.get_ref().stream()
    }

    fn hear(&mut self) -> Result<(), Inverse3Trouble> {
        let mut answered = false;
        self.socket.get_mut().tick();
        for _ in 0..MESSAGES_MOST {
            match self.socket.read() {
                Ok(Message::Text(text)) => {
                    let place_m = position(&text, &self.id)?;
                    self.believe(place_m)?;
                    self.due = self.due.saturating_sub(1);
                    answered = true;
                }
                Ok(Message::Close(_)) => return Err(Inverse3Trouble::Gone),
                Ok(_) => {}
                Err(tungstenite::Error::Io(error)) if is_not_now(error.kind()) => break,
                Err(_) => return Err(Inverse3Trouble::Gone),
            }
        }
        if answered {
            self.exchange.answered();
        } else if self.due > 0 {
            let ticks = self.exchange.unanswered();
            if self.exchange.is_silent(self.lost_most, self.period_s) {
                return Err(Inverse3Trouble::Silent { ticks });
            }
        }
        Ok(())
    }

    fn believe(&mut self, place_m: Vector3<f64>) -> Result<(), Inverse3Trouble> {
        let step = place_m - self.place_m;
        let step_m = libm::sqrt(step.dot(&step));
        let time_s = (1.0 + f64::from(self.exchange.unmeasured())) * self.period_s;
        if step_m > SPEED_MOST_M_PER_S * time_s + SPARE_M {
            return Err(Inverse3Trouble::Jump {
                step_mm: 1e3 * step_m,
                time_ms: 1e3 * time_s,
            });
        }
        self.place_m = place_m;
        Ok(())
    }

    /// Sends a force, N, unless the service still owes an answer.
    fn push(&mut self, force_n: Vector3<f32>) -> Result<(), Inverse3Trouble> {
        if let Some(trouble) = self.trouble {
            return Err(trouble);
        }
        self.exchange.sent(self.due == 0);
        if self.due > 0 {
            return Ok(());
        }
        let sent = self.send(force_n);
        sent.map_err(|trouble| self.fails(trouble))
    }

    fn send(&mut self, force_n: Vector3<f32>) -> Result<(), Inverse3Trouble> {
        let text = force(&self.before_force, force_n);
        // A socket without room for so little has nobody at its other end.
        (self.socket.send(Message::text(text))).map_err(|_| Inverse3Trouble::Gone)?;
        self.due += 1;
        Ok(())
    }

    /// The first trouble counts: no force from now on.
    fn fails(&mut self, trouble: Inverse3Trouble) -> Inverse3Trouble {
        let first = *self.trouble.get_or_insert(trouble);
        self.leave();
        first
    }

    fn leave(&mut self) {
        if self.due < DUE_MOST {
            // Repeated at the next tick; a connection that has ended is noticed when it is read.
            let _ = self.send(Vector3::zeros());
        }
    }
}

impl<S: Read + Write, const D: usize> Device<f32, D> for Inverse3<S, D> {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, D>, Fault> {
        // In trouble it fails in each tick: no place is reported as measured.
        if self.trouble.is_none()
            && let Err(trouble) = self.hear()
        {
            self.fails(trouble);
        }
        if self.trouble.is_some() {
            return Err(Fault::BoardFailed);
        }
        let along: SVector<f64, D> = self.along.transpose() * self.place_m;
        Ok(Reading {
            tick: 0,
            time_s: 0.0,
            position_m: along.map(|axis| axis as f32),
        })
    }

    fn write(&mut self, force: SafeForce<f32, D>) -> Result<(), Fault> {
        let force_n = self.along * force.newtons().map(f64::from);
        let pushed = self.push(force_n.map(|axis| axis as f32));
        pushed.map_err(|_| Fault::BoardFailed)
    }

    fn let_go(&mut self) {
        self.leave();
    }
}

impl<S: Read + Write, const D: usize> Hardware<D> for Inverse3<S, D> {
    type Setup = ();

    fn capabilities(&self) -> Capabilities {
        Capabilities {
            tick_period_min_us: PERIOD_MIN_US,
            force_max_n: FORCE_MAX_N,
            // From one end to the other in a tick of 1 ms.
            force_rate_max_n_per_s: 2000.0 * FORCE_MAX_N,
            // The device does not report the step of its position.
            ..abilities(&format!("Inverse3 {}", self.id), D as u8)
        }
    }

    fn serial_number(&self) -> SerialNumber {
        SerialNumber::named(&format!("Inverse3-{}", self.id)).unwrap_or(SerialNumber::NONE)
    }

    fn install(&mut self, (): (), tick_period_us: u32) {
        self.period_s = 1e-6 * f64::from(tick_period_us);
    }

    fn exchange(&mut self) -> Option<&mut Exchange> {
        Some(&mut self.exchange)
    }

    fn restart(&mut self) {}

    fn idle(&mut self) -> Result<Reading<f32, D>, Fault> {
        let reading = self.read()?;
        let pushed = self.push(Vector3::zeros());
        pushed.map_err(|_| Fault::BoardFailed)?;
        Ok(reading)
    }

    fn persisting_fault(&self) -> Option<Fault> {
        let silent = self.exchange.silent_ticks() >= self.lost_most;
        (silent || self.trouble.is_some()).then_some(Fault::BoardFailed)
    }
}

impl<S: Read + Write + Send + 'static, const D: usize> ServedHardware<D> for Inverse3<S, D> {
    fn trouble(&self) -> Option<BoardTrouble> {
        let trouble = self.trouble?;
        let outcome = match trouble.cause() {
            TroubleCause::Board => "it was told to let go",
            TroubleCause::Gone | TroubleCause::HostLate => "it cannot be told to let go",
        };
        Some(BoardTrouble {
            words: format!("Inverse3 {}: {trouble}; {outcome}", self.id),
            cause: trouble.cause(),
        })
    }
}

impl<S: Read + Write, const D: usize> Drop for Inverse3<S, D> {
    fn drop(&mut self) {
        self.leave();
        // The service ends its session.
        let _ = self.socket.close(None);
        let _ = self.socket.flush();
    }
}
