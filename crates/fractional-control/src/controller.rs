//! The contract of all controllers: two phases, limits, what was really applied, a change without a bump.

use crate::ControlError;
use core::fmt::Debug;
use fracdiff::{
    Real, Seconds,
    parameter::{RangeError, positive},
};

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

    /// Stage as it is run. With an integral a bias stays for ever: it is a sum that the integral has.
    pub(crate) fn stage<F: Real>(&self, sample_time: Seconds, integrates: bool) -> Stage<F> {
        let fade_s = if integrates {
            f64::INFINITY
        } else {
            self.fade_s
        };
        let keep = F::from_f64(libm::exp(-sample_time.0 / fade_s));
        Stage::between([self.low, self.high].map(F::from_f64), keep)
    }
}

/// Samples over which a command is averaged: noise alone does not stop the clock of an integral.
pub const AVERAGED: f64 = 20.0;
/// The dead zone of what an actuator does: shares of the command and of its range.
pub const DEAD_ZONE: [f64; 2] = [0.2, 0.05];
/// Limits farther apart than this count as no limits, and their range as 0.
pub const RANGE_MOST: f64 = 1e30;

/// [`Actuator`] as it is run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stage<F> {
    low: F,
    high: F,
    /// Range of the command, or 0 where that has no end.
    range: F,
    /// The share of a bias that is left after a sample.
    pub keep: F,
}

impl<F: Real> Stage<F> {
    /// Between two limits, with the share of a bias that is left after a sample.
    pub(crate) fn between([low, high]: [F; 2], keep: F) -> Self {
        let range = high - low;
        Self {
            low,
            high,
            range: if range < F::from_f64(RANGE_MOST) {
                range
            } else {
                F::ZERO
            },
            keep,
        }
    }

    /// The applied command if it is finite, otherwise the command within its limits.
    #[inline]
    pub(crate) fn applied(&self, wanted: F, applied: F) -> F {
        if applied.is_finite() {
            applied
        } else {
            self.limit(wanted)
        }
    }

    /// The applied command if it is beyond the dead zone, as with an unknown limit, otherwise the command within its limits.
    #[inline]
    pub(crate) fn given(&self, wanted: F, applied: F) -> F {
        let (command, applied) = (self.limit(wanted), self.applied(wanted, applied));
        let [threshold, range] = DEAD_ZONE.map(F::from_f64);
        if (applied - command).abs() > threshold * command.abs() + range * self.range {
            applied
        } else {
            command
        }
    }

    /// True if the clock of an integral stands while its error pushes down, and while it pushes up. `average` is that of what was wanted.
    #[inline]
    pub(crate) fn stops(&self, average: &mut F, wanted: F, applied: F) -> [bool; 2] {
        let (command, given) = (self.limit(wanted), self.given(wanted, applied));
        *average = settled(*average + (wanted - *average) * F::from_f64(1.0 / AVERAGED));
        [
            given > command || (wanted < self.low && *average < self.low),
            given < command || (wanted > self.high && *average > self.high),
        ]
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

    /// Decays a bias by one sample.
    #[inline]
    pub(crate) fn faded(&self, bias: F) -> F {
        settled(bias * self.keep)
    }
}

/// A state that fades, or 0 where little is left of it or where it is not finite.
#[inline]
fn settled<F: Real>(state: F) -> F {
    if state.is_finite() && state.abs() >= F::NEGLIGIBLE {
        state
    } else {
        F::ZERO
    }
}

/// A controller: immutable, apart from the history of its loop.
/// ```text
/// u[n] = limit(g_r·r[n] − g_y·y[n] + S[n])      output: before the command leaves
/// S[n+1] from r[n], y[n] and what was applied   advance: after it has left
/// ```
/// - *Anti-windup*: without a gain to choose. The clock of an integral stands while its error would push the command further beyond a
///   limit, if its average over 20 samples is beyond it too: the noise of a derivative, which saturates single samples, leaves the
///   integral alone.
/// - *What the actuator did*: pass it to [`advance`](Self::advance), if it says so. Up to a fifth of the command and a twentieth of its
///   range away it counts as the command: the integral corrects the counts of a PWM or a weak drive by the error, as any load.
///   Farther away it is an unknown limit, and the clock stands as at a known one. NaN and infinite count as the command.
/// - *A function of the error* takes in the error that would have given what was left of its command (R. Hanus, M. Kinnaert,
///   J.-L. Henrotte, *Conditioning technique, a general anti-windup and bumpless transfer method*, Automatica 23, 1987).
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
    /// proportional   its own          derivative   settled at c·r − y: 0          integral   the rest of the command
    /// ```
    /// - *The rest of the command* is a bias, which an integral of any order holds for ever: nothing moves.
    /// - *Without an integral* the bias fades with the time of the [`Actuator`]; ten times 1/crossover moves the loop by little.
    ///   A function of the error starts at its gain at rest times that error, and the bias.
    /// - *A command that is not finite* counts as the parts' own.
    ///
    /// `None` for a function that does not rest at such an error, as with a pole at s = 0.
    fn settled(&self, reference: F, measured: F, command: F) -> Option<Self::History>;

    /// The command before its limits, for reference r and measured y.
    fn wanted(&self, history: &Self::History, reference: F, measured: F) -> F;

    /// The command, within its limits.
    fn output(&self, history: &Self::History, reference: F, measured: F) -> F;

    /// A command within the limits.
    fn limited(&self, command: F) -> F;

    /// Takes the sample into the history, with the command that was applied; one that is not finite counts as the output.
    fn advance(&self, history: &mut Self::History, reference: F, measured: F, applied: F);

    /// Tracks a command applied by somebody else, so that the next output continues from it without a bump. The clock of an integral stands.
    fn follow(&self, history: &mut Self::History, reference: F, measured: F, applied: F);

    /// `g_y`: how much the command falls at once when the measurement rises by one.
    fn feedback_gain(&self) -> F;

    /// The history with which this controller continues from another one of its kind: its next output is that of the other.
    /// Histories are of signals, not of products with gains, so a part of equal order keeps its past; another integral starts
    /// at rest, another derivative as if its input always had been what it is now. A difference in the command is held; it fades with the
    /// time of the [`Actuator`], or stays where an integral takes it for its own.
    fn take_over(
        &self,
        other: &Self,
        history: &Self::History,
        reference: F,
        measured: F,
    ) -> Self::History;
}

/// Source of the command: the controller, or somebody in its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mode<F> {
    /// The controller commands, by reference and measurement.
    Automatic,
    /// Somebody, this command; the controller follows. If it is not finite, the controller commands.
    Manual(F),
}

/// A controller with the history of its one loop: automatic or manual, parameters changed without a bump, bad readings held off.
///
/// - *Start* beside a running plant: [`settle`](Self::settle) first.
/// - *A reference or measurement that is not a finite number*: the last command, within its limits, is held for this sample, the history does not see it,
///   and [`missed`](Self::missed) counts it. The tenth in a row, [`MISSED_MOST`], and all that follow give 0.
/// ```
/// use fracdiff::Seconds;
/// use fractional_control::{
///     Actuator, FractionalPid, PowerMemory, Mode, PidParameters, Rule, SetPoint, Station,
/// };
///
/// let memory = PowerMemory::new(Rule::Grunwald, 1e-4, 100.0)?;
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

/// Consecutive readings that are not numbers after which the command is 0.
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
        if !(reference - measured).is_finite() {
            return None;
        }
        self.history = (self.controller).settled(reference, measured, command)?;
        let output = self.controller.output(&self.history, reference, measured);
        self.applied = if command.is_finite() { command } else { output };
        self.missed = 0;
        Some(output - self.applied)
    }

    /// Number of readings in a row, up to now, that were not numbers.
    pub const fn missed(&self) -> u32 {
        self.missed
    }

    /// The command now; leaves the history alone.
    #[inline]
    pub fn output(&self, reference: F, measured: F) -> F {
        match self.mode {
            Mode::Manual(command) if command.is_finite() => command,
            Mode::Manual(_) | Mode::Automatic if (reference - measured).is_finite() => {
                self.controller.output(&self.history, reference, measured)
            }
            Mode::Manual(_) | Mode::Automatic if self.missed + 1 < MISSED_MOST => {
                self.controller.limited(self.applied)
            }
            Mode::Manual(_) | Mode::Automatic => F::ZERO,
        }
    }

    /// Adds the sample to the history, with the command that was applied; one that is not finite counts as [`output`](Self::output).
    #[inline]
    pub fn advance(&mut self, reference: F, measured: F, applied: F) {
        if !(reference - measured).is_finite() {
            self.missed = (self.missed + 1).min(MISSED_MOST);
            return;
        }
        let applied = if applied.is_finite() {
            applied
        } else {
            self.output(reference, measured)
        };
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
