//! The contract of all controllers: two phases, limits, what was really applied, a change without a bump.

use crate::ControlError;
use core::fmt::Debug;
use fracdiff::parameter::{RangeError, positive};
use fracdiff::{Real, Seconds};

/// Limits of a command, and the time in which a bridged bump fades.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Actuator {
    low: f64,
    high: f64,
    fade_s: f64,
}

impl Actuator {
    /// No limits, for a controller whose command is never cut.
    pub const UNLIMITED: Self = Self {
        low: f64::NEG_INFINITY,
        high: f64::INFINITY,
        fade_s: 1.0,
    };

    /// Limits from low to high, in the unit of the command; infinite means no limit. A bump fades
    /// with a time constant of 1 s.
    ///
    /// # Errors
    /// A NaN, or low not below high.
    pub fn new(low: f64, high: f64) -> Result<Self, ControlError> {
        if low.is_nan() || high.is_nan() || low >= high {
            let allowed = "below the upper limit of the command";
            return Err(RangeError::new("lower limit of the command", low, allowed, "").into());
        }
        Ok(Self {
            low,
            high,
            fade_s: 1.0,
        })
    }

    /// The time constant with which a command that was held over a change fades into the controller's own, s.
    ///
    /// # Errors
    /// Unless above 0 and finite.
    pub fn fading(self, fade_s: f64) -> Result<Self, ControlError> {
        Ok(Self {
            fade_s: positive("fade time", fade_s, "s")?,
            ..self
        })
    }

    #[cfg(feature = "std")]
    pub(crate) const fn limits(&self) -> [f64; 2] {
        [self.low, self.high]
    }

    /// An integral of order 1 and more holds a bias for ever: to it that is a sum that it has. `lowest` is the order of the lowest part.
    pub(crate) fn stage<F: Real>(&self, sample_time: Seconds, lowest: f64) -> Stage<F> {
        let fade_s = if lowest <= -1.0 {
            f64::INFINITY
        } else {
            self.fade_s
        };
        Stage {
            low: F::from_f64(self.low),
            high: F::from_f64(self.high),
            keep: F::from_f64(libm::exp(-sample_time.0 / fade_s)),
        }
    }
}

/// [`Actuator`] as it is run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stage<F> {
    low: F,
    high: F,
    /// The share of a bias that is left after a sample.
    pub(crate) keep: F,
}

impl<F: Real> Stage<F> {
    /// Between two limits, with the share of a bias that is left after a sample.
    pub(crate) const fn between([low, high]: [F; 2], keep: F) -> Self {
        Self { low, high, keep }
    }

    #[inline]
    pub(crate) fn limit(&self, u: F) -> F {
        if u < self.low {
            self.low
        } else if u > self.high {
            self.high
        } else {
            u
        }
    }

    /// What is left of a bias after a sample.
    #[inline]
    pub(crate) fn faded(&self, bias: F) -> F {
        let bias = bias * self.keep;
        if bias.abs() < F::NEGLIGIBLE {
            F::ZERO
        } else {
            bias
        }
    }
}

/// A controller: immutable, apart from the history of its loop.
/// ```text
/// u[n] = limit(g_r·r[n] − g_y·y[n] + S[n])      output: before the command leaves
/// S[n+1] from r[n], y[n] and what was applied   advance: after it has left
/// ```
/// - *Anti-windup*: without a gain to choose. Where what was applied differs from what was wanted, [`advance`](Self::advance) takes
///   that reference into the history which would have given it (R. Hanus, M. Kinnaert, J.-L. Henrotte, *Conditioning technique, a
///   general anti-windup and bumpless transfer method*, Automatica 23, 1987). Pass what the actuator really did, if it says so.
/// - *Where that would not hold*, the clock of an integral stands while its error would push the command further beyond its limit:
///   the path from the reference to the command has to be one that runs backwards without growing, so its parts have one sign and
///   orders at most 2 apart; and a tenth of the gain over a sample has to be on it, as else the noise of a derivative that
///   saturates single samples goes into the integral.
/// - *Start*: [`at_rest`](Self::at_rest) if reference and measurement begin at zero, otherwise [`settled`](Self::settled).
/// - *Not finite*: in r or y, no command is finite until reset: the safety chain behind has to look, or a [`Station`] in front.
pub trait Controller<F: Real> {
    /// The past of one loop.
    type History: Clone + Debug;

    /// The history of a loop that always was at zero.
    fn at_rest(&self) -> Self::History;

    /// The history of a loop in which reference, measurement and command have stood for ever: a start beside a running plant. Take
    /// the reference for the measurement and 0 for the command if you do not know better.
    /// ```text
    /// proportional   its own          derivative   settled at c·r − y: 0          integral   what is left of the command
    /// ```
    /// - *The integral's share* is a bias: one of order 1 and more holds it for ever. One below 1 fades, so its bias fades too, with
    ///   the time of the [`Actuator`], while the integral takes over.
    /// - *Without an integral* nothing holds a command: it is ignored, and the first output is the parts' own. Compare, if you want to
    ///   know the bump. A function of the error starts at its gain at rest times that error.
    ///
    /// `None` for a function that does not rest at such an error, as with a pole at s = 0.
    fn settled(&self, reference: F, measured: F, command: F) -> Option<Self::History>;

    /// The command before its limits, for reference r and measured y.
    fn wanted(&self, history: &Self::History, reference: F, measured: F) -> F;

    /// The command, within its limits.
    fn output(&self, history: &Self::History, reference: F, measured: F) -> F;

    /// Takes the sample into the history, with the command that was applied.
    fn advance(&self, history: &mut Self::History, reference: F, measured: F, applied: F);

    /// The same where somebody else commands: so that the next output continues what was applied.
    fn follow(&self, history: &mut Self::History, reference: F, measured: F, applied: F);

    /// `g_y`: how much the command falls at once when the measurement rises by one.
    fn feedback_gain(&self) -> F;

    /// The history with which this controller goes on where another one of its kind stood: its next output is that of the other.
    /// Histories are of signals, not of products with gains, so what has the same order keeps its past; another integral starts
    /// at rest, another derivative as if its input always had been what it is now. A difference in the command is held; it fades with the
    /// time of the [`Actuator`], or stays where an integral of order 1 and more takes it for its own.
    fn take_over(
        &self,
        other: &Self,
        history: &Self::History,
        reference: F,
        measured: F,
    ) -> Self::History;
}

/// Who gives the command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mode<F> {
    /// The controller commands.
    Automatic,
    /// Somebody, this command; the controller follows.
    Manual(F),
}

/// A controller with the history of its one loop: automatic or manual, parameters changed without a bump, bad readings held off.
///
/// - *Start* beside a running plant: [`settle`](Self::settle) first.
/// - *A reference or measurement that is not a finite number*: the last command is held for this sample, the history does not see it,
///   and [`missed`](Self::missed) counts it. The tenth in a row, [`MISSED_MOST`], and all that follow give 0.
/// ```
/// use fracdiff::Seconds;
/// use fractional_control::{
///     Actuator, FractionalPid, Memory, Mode, PidParameters, Rule, SetPoint, Station,
/// };
///
/// let memory = Memory::new(Rule::Grunwald, 1e-4, 100.0)?;
/// let make = |proportional| {
///     let gains = PidParameters { proportional, integral: 3.0, integral_order: 0.9, ..PidParameters::NONE };
///     FractionalPid::<f64>::new(gains, SetPoint::DEFAULT, Actuator::new(-5.0, 5.0)?, memory, Seconds(0.01))
/// };
/// let mut station = Station::new(make(2.0)?);
/// station.set_mode(Mode::Manual(1.5));
/// assert_eq!(station.step(1.0, 0.2), 1.5);
/// station.set_mode(Mode::Automatic); // no bump
/// station.set_controller(make(4.0)?, 1.0, 0.2); // none here either
/// # Ok::<(), fractional_control::ControlError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Station<F: Real, C: Controller<F>> {
    controller: C,
    history: C::History,
    mode: Mode<F>,
    /// The last command that was applied, and readings since then that were no numbers.
    applied: F,
    missed: u32,
}

/// After so many readings in a row that are not numbers the command is 0.
pub const MISSED_MOST: u32 = 10;

impl<F: Real, C: Controller<F>> Station<F, C> {
    /// A station at rest, whose controller commands.
    pub fn new(controller: C) -> Self {
        let history = controller.at_rest();
        Self {
            controller,
            history,
            mode: Mode::Automatic,
            applied: F::ZERO,
            missed: 0,
        }
    }

    /// Starts as if reference, measurement and command had been constant for ever; see
    /// [`Controller::settled`]. Returns the remaining bump, by which the next command differs from
    /// this one. Returns `None` and does nothing if the controller cannot rest there.
    pub fn settle(&mut self, reference: F, measured: F, command: F) -> Option<F> {
        if !(reference - measured + command).is_finite() {
            return None;
        }
        self.history = (self.controller).settled(reference, measured, command)?;
        (self.applied, self.missed) = (command, 0);
        Some(self.controller.output(&self.history, reference, measured) - command)
    }

    /// Number of readings in a row, up to now, that were not numbers.
    pub const fn missed(&self) -> u32 {
        self.missed
    }

    /// The command now; leaves the history alone.
    #[inline]
    pub fn output(&self, reference: F, measured: F) -> F {
        match self.mode {
            Mode::Manual(command) => command,
            Mode::Automatic if (reference - measured).is_finite() => {
                self.controller.output(&self.history, reference, measured)
            }
            Mode::Automatic if self.missed + 1 < MISSED_MOST => self.applied,
            Mode::Automatic => F::ZERO,
        }
    }

    /// Adds the sample to the history, with the command that was applied.
    #[inline]
    pub fn advance(&mut self, reference: F, measured: F, applied: F) {
        if !(reference - measured).is_finite() {
            self.missed = (self.missed + 1).min(MISSED_MOST);
            return;
        }
        (self.applied, self.missed) = (applied, 0);
        let history = &mut self.history;
        match self.mode {
            Mode::Automatic => (self.controller).advance(history, reference, measured, applied),
            Mode::Manual(_) => (self.controller).follow(history, reference, measured, applied),
        }
    }

    /// Use both if the command is applied unchanged.
    #[inline]
    pub fn step(&mut self, reference: F, measured: F) -> F {
        let command = self.output(reference, measured);
        self.advance(reference, measured, command);
        command
    }

    /// Sets who commands from now on.
    pub fn set_mode(&mut self, mode: Mode<F>) {
        self.mode = mode;
    }

    /// Switches to another controller, whose command at this reference and measurement equals the
    /// present one's. While the reading is NaN, the present controller stays.
    pub fn set_controller(&mut self, controller: C, reference: F, measured: F) {
        if !(reference - measured).is_finite() {
            return;
        }
        self.history = controller.take_over(&self.controller, &self.history, reference, measured);
        self.controller = controller;
    }

    /// Puts the history to rest and forgets readings that were missed.
    pub fn reset(&mut self) {
        self.history = self.controller.at_rest();
        (self.applied, self.missed) = (F::ZERO, 0);
    }

    /// The controller that commands, or follows.
    pub const fn controller(&self) -> &C {
        &self.controller
    }
}
