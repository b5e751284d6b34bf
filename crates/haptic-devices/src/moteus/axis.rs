//! A servo as the board of one axis.
//!
//! ```text
//! tick n:  read: answers to the frame of tick n − 1 ─▶ x        write: f ─▶ τ = r·f ─▶ frame with a query
//! ```
//! Nothing waits: an answer that has not come by the next tick counts as lost, and the axis stays where it was. So a position is
//! one tick old, less the time of the way to the servo. *Cost* of a tick: one line each way, some 10⁴ operations, two calls
//! of the system; no allocation.

use super::{
    adapter::{Adapter, Gone, Heard},
    frames::{Frames, HOST, Reply, Route},
    settings::{MoteusName, MoteusSettings},
    trouble::{Instead, MoteusOpenError, MoteusTrouble},
};
use haptic_link::{Capabilities, ControllerCost};
use haptic_loop::{Device, Fault, Reading, SafeForce};
use haptic_remote::{
    CONTROLLER_COST, Exchange, Hardware, abilities,
    serial::{BoardTrouble, Line, ServedHardware, USB_PERIOD_US, open, port_of, ports},
};
use moteus_protocol::{CanFdFrame, Mode};
use nalgebra::SVector;
use std::{
    io::{Read, Write},
    string::ToString as _,
    time::Duration,
};

/// Bits per second of a servo on a UART; an adapter on USB has no speed.
const BAUD: u32 = 921_600;
/// USB numbers of the maker's adapters, the old one and the new one. They check what they carry themselves.
const FDCANUSBS: [(u16, u16); 2] = [(0x0483, 0x5740), (0x1209, 0x2323)];
/// Largest number of lines read in a tick, so that a flood does not hold up the loop.
const LINES_MOST: usize = 64;
/// Frames after which a servo with a drive command may still report that it is stopped: it prepares.
const PREPARING_MOST: u32 = 20;
/// Largest step of a position that the speed does not explain, revolutions.
const STEP_MOST_REV: f64 = 0.05;
/// Largest speed that is believed, revolutions per second: beyond what such a servo turns.
const SPEED_MOST_REV_PER_S: f32 = 200.0;
/// Answers in a row, of a servo at rest, with which it is opened.
const ANSWERS: u32 = 3;
/// Lines for which an attempt to open it waits: twice those of an answer.
const LINES_GREETING: usize = 4;
/// Frames in which it may begin to answer.
const ATTEMPTS: u32 = 25;

/// A moteus servo as the hardware of one axis.
///
/// - *Start-up*: stopped; its place is x = 0.
/// - *Torque*: the force times the radius, never beyond the limit of the settings, with the servo's own control off.
/// - *Faults*, all of them [`Fault::BoardFailed`] with words in [`trouble`](ServedHardware::trouble): a servo in fault, in a
///   mode that is not asked for, without a position; several answers in a row that did not come or cannot be; a frame of
///   another servo; a port that is gone.
/// - *Let go*: mode 0, repeated at every tick; where no frame arrives any more, the servo's own watchdog.
#[derive(Debug)]
pub struct MoteusAxis<S: Read + Write> {
    adapter: Adapter<S>,
    frames: Frames,
    settings: MoteusSettings,
    /// Place of x = 0, revolutions.
    zero_rev: f64,
    newest: Reply,
    exchange: Exchange,
    instead: Instead,
    /// Frames in a row that asked for a torque; 0 while stopped.
    driven: u32,
    tick: u64,
    period_s: f64,
    trouble: Option<MoteusTrouble>,
}

impl<S: Read + Write> MoteusAxis<S> {
    /// Stops the servo, which clears its faults, and waits until it answers as one that stands.
    /// Each read of the stream may wait for some 20 ms here, and must not from then on: see
    /// [`stream`](Self::stream). With `checksum` each line must have one from the first on; without
    /// it they are used once the other end has shown that it knows them.
    ///
    /// # Errors
    /// A setting outside its range; no answer, a fault that stays, another servo.
    pub fn open(
        stream: S,
        settings: MoteusSettings,
        checksum: bool,
    ) -> Result<Self, MoteusOpenError> {
        settings.check()?;
        let mut axis = Self {
            adapter: Adapter::new(stream, checksum),
            frames: Frames::new(settings.id, settings.watchdog_s),
            settings,
            zero_rev: 0.0,
            newest: Reply {
                mode: Mode::Stopped.into(),
                position_rev: 0.0,
                velocity_rev_per_s: 0.0,
                torque_nm: 0.0,
                fault: 0,
            },
            exchange: Exchange::default(),
            instead: Instead::default(),
            driven: 0,
            tick: 0,
            period_s: 1e-3,
            trouble: None,
        };
        axis.greet()?;
        axis.zero_rev = f64::from(axis.newest.position_rev);
        Ok(axis)
    }

    fn greet(&mut self) -> Result<(), MoteusTrouble> {
        let mut answers = 0;
        for _ in 0..ATTEMPTS {
            self.let_go();
            let mut lines = LINES_GREETING;
            if let Some(reply) = self.heard(&mut lines)? {
                answers = if reply.is_in(Mode::Stopped) {
                    answers + 1
                } else {
                    0
                };
                self.newest = reply;
            }
            if answers == ANSWERS {
                self.instead = Instead::default();
                return Ok(());
            }
        }
        // A servo that stands and answers was accepted above.
        if self.newest.is_in(Mode::Stopped) {
            return Err(self.silent(ATTEMPTS));
        }
        Err(self.unwanted_mode())
    }

    const fn silent(&self, ticks: u32) -> MoteusTrouble {
        MoteusTrouble::Silent {
            id: self.settings.id,
            ticks,
            instead: self.instead,
        }
    }

    /// The next answer that comes within this many lines, however long the stream waits for it.
    fn heard(&mut self, lines: &mut usize) -> Result<Option<Reply>, MoteusTrouble> {
        while *lines > 0 {
            *lines -= 1;
            match self.adapter.receive() {
                Err(Gone) => return Err(MoteusTrouble::Gone),
                Ok(None) => return Ok(None),
                Ok(Some(heard)) => {
                    if let Some(reply) = self.sorted(heard)? {
                        return Ok(Some(reply));
                    }
                }
            }
        }
        Ok(None)
    }

    /// The stream, so that its reads can be set not to wait.
    pub const fn stream(&mut self) -> &mut S {
        &mut self.adapter.stream
    }

    fn listen(&mut self) -> Result<(), MoteusTrouble> {
        let mut answered = false;
        let mut lines = LINES_MOST;
        while let Some(reply) = self.heard(&mut lines)? {
            if self.believed(&reply) {
                self.newest = reply;
                answered = true;
            }
        }
        if answered {
            self.exchange.answered();
            self.instead = Instead::default();
            return if self.driven > 0 {
                self.judge_mode(self.driven > PREPARING_MOST)
            } else {
                Ok(())
            };
        }
        // The board takes every force that goes out, or answers none: nothing says that it took the last.
        self.exchange.sent(false);
        let lost = self.exchange.unanswered();
        if self
            .exchange
            .is_silent(self.settings.lost_most, self.period_s)
        {
            return Err(self.silent(lost));
        }
        Ok(())
    }

    /// The answer in a line; everything else is counted.
    fn sorted(&mut self, heard: Heard) -> Result<Option<Reply>, MoteusTrouble> {
        let instead = &mut self.instead;
        let counter = match heard {
            Heard::Frame(frame) => return self.answer(&frame),
            Heard::Taken => &mut instead.taken,
            Heard::Refused => &mut instead.refused,
            Heard::Garbage => &mut instead.garbage,
        };
        *counter = counter.saturating_add(1);
        Ok(None)
    }

    fn answer(&mut self, frame: &CanFdFrame) -> Result<Option<Reply>, MoteusTrouble> {
        let id = self.settings.id;
        let Route { from, to } = Route::of(frame);
        if from != id || to != HOST {
            return Err(MoteusTrouble::OtherSpeaker { id, from, to });
        }
        match self.frames.reply(frame) {
            Some(reply) if !reply.is_finite() => Err(MoteusTrouble::NotFinite { id }),
            Some(reply) => Ok(Some(reply)),
            None => self.sorted(Heard::Garbage),
        }
    }

    /// True if a position can have been reached since the last one.
    fn believed(&mut self, reply: &Reply) -> bool {
        let speed = reply.velocity_rev_per_s.abs();
        let fastest = f64::from(speed.max(self.newest.velocity_rev_per_s.abs()));
        let passed_s = self.period_s * (1.0 + f64::from(self.exchange.unmeasured()));
        let step = f64::from(reply.position_rev) - f64::from(self.newest.position_rev);
        let believed =
            speed <= SPEED_MOST_REV_PER_S && step.abs() <= STEP_MOST_REV + 2.0 * fastest * passed_s;
        if !believed {
            self.instead.garbage = self.instead.garbage.saturating_add(1);
        }
        believed
    }

    /// Refuses the modes in which a servo that drives must not be. While it prepares it may still be stopped.
    fn judge_mode(&self, prepared: bool) -> Result<(), MoteusTrouble> {
        match Mode::try_from(self.newest.mode) {
            Ok(Mode::Position | Mode::Enabling | Mode::Calibrating | Mode::CalibrationComplete) => {
                Ok(())
            }
            Ok(Mode::Stopped) if !prepared => Ok(()),
            _ => Err(self.unwanted_mode()),
        }
    }

    fn unwanted_mode(&self) -> MoteusTrouble {
        let (id, mode) = (self.settings.id, self.newest.mode);
        match Mode::try_from(mode) {
            Ok(Mode::Fault) => MoteusTrouble::Fault {
                id,
                code: self.newest.fault,
            },
            Ok(Mode::Timeout) => MoteusTrouble::WatchdogLetGo { id },
            _ => MoteusTrouble::OtherMode { id, mode },
        }
    }

    fn failed(&mut self, trouble: MoteusTrouble) -> Fault {
        self.trouble = Some(trouble);
        Fault::BoardFailed
    }

    fn reading(&self) -> Reading<f32, 1> {
        let turned_rev = f64::from(self.newest.position_rev) - self.zero_rev;
        let position_m = self.settings.metres_per_revolution() * turned_rev;
        Reading {
            tick: self.tick,
            time_s: self.tick as f64 * self.period_s,
            position_m: SVector::from([position_m as f32]),
        }
    }

    fn let_go(&mut self) {
        self.driven = 0;
        // Repeated at the next tick; a port that is gone is noticed when it is read.
        let went_out = self.adapter.send(&self.frames.stop());
        self.exchange.sent(went_out.is_ok_and(|went_out| went_out));
    }
}

impl<S: Read + Write> Device<f32, 1> for MoteusAxis<S> {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, 1>, Fault> {
        match self.listen() {
            Ok(()) => Ok(self.reading()),
            Err(trouble) => Err(self.failed(trouble)),
        }
    }

    fn write(&mut self, force: SafeForce<f32, 1>) -> Result<(), Fault> {
        let most = self.settings.torque_limit_nm as f32;
        // τ = r·f
        let torque_nm = (self.settings.radius_m * f64::from(force.newtons()[0])) as f32;
        self.tick += 1;
        self.driven = self.driven.saturating_add(1);
        let frame = self.frames.drive(torque_nm.clamp(-most, most));
        match self.adapter.send(&frame) {
            Ok(went_out) => {
                self.exchange.sent(went_out);
                Ok(())
            }
            Err(Gone) => Err(self.failed(MoteusTrouble::Gone)),
        }
    }

    fn let_go(&mut self) {
        self.let_go();
    }
}

impl<S: Read + Write> Hardware for MoteusAxis<S> {
    type Setup = ();

    fn capabilities(&self) -> Capabilities {
        Capabilities {
            tick_period_min_us: USB_PERIOD_US,
            tick_period_max_us: 5000,
            force_max_n: (self.settings.torque_limit_nm / self.settings.radius_m.abs()) as f32,
            force_rate_max_n_per_s: 1e5,
            // The servo does not report the step of its filtered position.
            ..abilities("moteus", 1)
        }
    }

    fn controller_cost(&self) -> Option<ControllerCost> {
        Some(CONTROLLER_COST)
    }

    fn install(&mut self, (): (), tick_period_us: u32) {
        self.period_s = f64::from(tick_period_us) * 1e-6;
    }

    fn exchange(&mut self) -> Option<&mut Exchange> {
        Some(&mut self.exchange)
    }

    fn restart(&mut self) {
        self.tick = 0;
    }

    fn idle(&mut self) -> Result<Reading<f32, 1>, Fault> {
        let read = self.read();
        self.let_go();
        read
    }

    fn persisting_fault(&self) -> Option<Fault> {
        let silent = self.exchange.silent_ticks() >= self.settings.lost_most;
        (silent || self.newest.is_in(Mode::Fault)).then_some(Fault::BoardFailed)
    }
}

impl<S: Read + Write + Send + 'static> ServedHardware for MoteusAxis<S> {
    fn trouble(&self) -> Option<BoardTrouble> {
        self.trouble.map(|trouble| BoardTrouble {
            words: trouble.to_string(),
            cause: trouble.cause(),
        })
    }
}

impl<S: Read + Write> Drop for MoteusAxis<S> {
    fn drop(&mut self) {
        self.let_go();
    }
}

impl MoteusName {
    /// Opens the port, and the servo behind it.
    pub(crate) fn open(&self) -> Result<MoteusAxis<Box<dyn Line>>, MoteusOpenError> {
        let line = open(&self.path, BAUD)?;
        // As the maker's clients: a servo on a UART takes checksums; an adapter may not know them, and is asked.
        let mut axis = MoteusAxis::open(line, self.settings, !is_fdcanusb(&self.path))?;
        let no_wait = axis.stream().set_patience(Duration::ZERO);
        no_wait.map_err(|error| MoteusOpenError::Patience {
            path: self.path.clone(),
            error,
        })?;
        Ok(axis)
    }
}

fn is_fdcanusb(path: &str) -> bool {
    let real = port_of(path).ok();
    let is_it = |name: &String| Some(name) == real.as_ref();
    let mut known = ports().into_iter().filter(|port| is_it(&port.path));
    known.any(|port| port.usb.is_some_and(|usb| FDCANUSBS.contains(&usb)))
}
