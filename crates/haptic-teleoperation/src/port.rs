//! One side: its settings in SI units, readings and messages in, safe forces and messages out.

use crate::law::{Coupled, CouplerGains, Law, Observed, WavePort};
use fracdiff::{
    Differintegrator, Seconds,
    parameter::{RangeError, not_negative, positive, range},
};
use haptic_link::{HandSample, HandSide, RequestTracker};
use haptic_loop::{LoopParameterError, LoopSample, Reading, SafeForce, SafetyChain, SafetyState};
use nalgebra::Vector1;

/// One side of a line between two hands, with one axis.
///
/// - *Start*: the first reading is the place from which displacements count, on each side its own. No force until the other side
///   is heard.
/// - *Messages*: [`receive`](Self::receive) any number between two ticks. Of another architecture, not newer than the newest, or
///   not a number: not acted on.
/// - *Silence*: [`Settings::silence`] without a new message, and the force falls to zero within the stop time of the safety chain
///   and stays there. Without braking it never grows on its way.
/// - *Energy*: [`given_j`](Self::given_j) is what the line has given to the device, Σ f·Δx with the Δx before each force, as for a
///   coupler. Of a passive architecture the sum of both sides never is above 0, but for rounding and for what the safety
///   chain adds to a force. A device under a held force needs damping of its own beside this: see the guard of the chain.
/// - *Cost*: a tick of the law beside the safety chain; no allocation, no panic.
///
/// ```
/// use fracdiff::{Order, Seconds, ShortMemory};
/// use haptic_link::HandSide;
/// use haptic_loop::units::{Newtons, NewtonsPerSecond};
/// use haptic_loop::{Reading, SafetyChain};
/// use haptic_teleoperation::{Port, PortLaw, Settings};
///
/// let t = Seconds(1e-3);
/// let side = |side| {
///     let law = PortLaw::<ShortMemory<f64, 8>>::Wave { impedance_n_s_per_m: 4.0, playout_samples: 1 };
///     let settings = Settings { side, sample_time: t, silence: Seconds(0.1) };
///     Port::new(law, settings, SafetyChain::new(Newtons(10.0), NewtonsPerSecond(1e6), t)?)
/// };
/// let (mut master, mut slave) = (side(HandSide::Master)?, side(HandSide::Slave)?);
/// for tick in 0..100 {
///     let reading = |x: f64| Reading { tick, time_s: 1e-3 * tick as f64, position_m: [x].into() };
///     // The hand pulls the master at 0.1 m/s; the slave is held.
///     let said = master.begin(reading(1e-4 * tick as f64)).finish().message;
///     let answer = slave.begin(reading(0.0)).finish().message;
///     slave.receive(&said);
///     master.receive(&answer);
/// }
/// assert!(slave.force_n() > 1.0); // pulled along
/// assert!(master.given_j() + slave.given_j() <= 0.0);
/// # Ok::<(), haptic_loop::LoopParameterError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Port<O: Differintegrator<f64>> {
    law: Law<O>,
    chain: SafetyChain<f64>,
    safety: SafetyState<f64, 1>,
    tracker: RequestTracker,
    foreign: u32,
    silence_ticks: u64,
    /// Ticks since the newest message; `None` before the first.
    quiet: Option<u64>,
    silent: bool,
    start_m: Option<f64>,
    last_m: f64,
    next_tick: u64,
    sequence: u32,
    force_n: f64,
    given_j: f64,
}

/// Messages that a port has received.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PortCounts {
    /// Numbers that were skipped: the messages are lost or late.
    pub missing: u32,
    /// Messages that came twice in a row.
    pub duplicate: u32,
    /// Messages that came after a later one.
    pub stale: u32,
    /// Messages for another architecture, for example from a side that was restarted with it.
    pub foreign: u32,
}

/// A tick whose force is known but which is not finished. Dropping it leaves a gap in the law's
/// history, but the safety chain still knows its force.
#[must_use = "send its force, then finish it"]
#[derive(Debug)]
pub struct Begun<'a, O: Differintegrator<f64>> {
    port: &'a mut Port<O>,
    sample: LoopSample<f64, 1>,
    position_m: f64,
    moved_m: f64,
    heard: bool,
}

/// A finished tick, to be recorded and sent to the other side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FinishedTick {
    /// Reading, wanted and sent force, limiters.
    pub sample: LoopSample<f64, 1>,
    /// The state to send to the other side.
    pub message: HandSample,
}

impl<O: Differintegrator<f64>> Port<O> {
    /// A port at rest.
    ///
    /// # Errors
    /// A gain, impedance, playout or time outside its range.
    pub fn new(
        law_of_port: PortLaw<O>,
        settings: Settings,
        chain: SafetyChain<f64>,
    ) -> Result<Self, LoopParameterError> {
        Ok(Self {
            silence_ticks: settings.silence_ticks()?,
            law: law(law_of_port, &settings)?,
            chain,
            safety: SafetyState::default(),
            tracker: RequestTracker::NEW,
            foreign: 0,
            quiet: None,
            silent: false,
            start_m: None,
            last_m: 0.0,
            next_tick: 0,
            sequence: 0,
            force_n: 0.0,
            given_j: 0.0,
        })
    }

    /// Takes in a message of the other side; true if it is the newest so far and was acted on.
    pub fn receive(&mut self, message: &HandSample) -> bool {
        if !self.tracker.is_new(message.sequence) {
            return false;
        }
        if !self.law.hear(message.state) {
            self.foreign = self.foreign.wrapping_add(1);
            return false;
        }
        self.quiet = Some(0);
        true
    }

    /// The first half of a tick: the force for this reading.
    pub fn begin(&mut self, reading: Reading<f64, 1>) -> Begun<'_, O> {
        let start = *self.start_m.get_or_insert(reading.position_m[0]);
        let displacement = reading.position_m[0] - start;
        let known = displacement.is_finite();
        let position_m = if known { displacement } else { self.last_m };
        let moved_m = position_m - self.last_m;
        // The first tick of a run has any number.
        let next = Some(self.next_tick).filter(|next| *next > 0);
        let missed = next.map_or(0, |next| reading.tick.saturating_sub(next));
        if missed > 0 {
            self.safety.skip(missed);
        }
        self.next_tick = reading.tick.wrapping_add(1);
        let heard = self.quiet.is_some();
        if let Some(quiet) = &mut self.quiet {
            // A message that has just come is of now, whatever ticks were passed over before; but not if they were as many
            // as a silence has: it may have waited as long.
            *quiet = match *quiet {
                0 if missed < self.silence_ticks => 1,
                ticks => ticks.saturating_add(1 + missed),
            };
            if *quiet > self.silence_ticks && !self.silent {
                self.silent = true;
                self.safety.stop();
            }
        }
        let wanted = match (known, heard) {
            // A fault of the safety chain.
            (false, _) => f64::NAN,
            (true, true) => self.law.wanted_n(position_m, moved_m),
            (true, false) => 0.0,
        };
        let wanted = Vector1::new(wanted);
        let sample = LoopSample::of(&self.chain, &mut self.safety, reading, &wanted);
        Begun {
            port: self,
            sample,
            position_m,
            moved_m,
            heard,
        }
    }

    /// Lets the force fall to zero from the next tick on.
    pub fn stop(&mut self) {
        self.safety.stop();
    }

    /// The state of the safety chain.
    pub const fn safety(&self) -> &SafetyState<f64, 1> {
        &self.safety
    }

    /// True once the other side has been silent for too long. It stays so.
    pub const fn is_silent(&self) -> bool {
        self.silent
    }

    /// True once the other side has been heard.
    pub const fn has_heard(&self) -> bool {
        self.quiet.is_some()
    }

    /// The force on the device of the last tick, N.
    pub const fn force_n(&self) -> f64 {
        self.force_n
    }

    /// Energy that the line has given to the device, J: `Σ f[n]·(x[n] − x[n−1])`.
    pub const fn given_j(&self) -> f64 {
        self.given_j
    }

    /// Energy in the account of a passive architecture, J; below 0 a debt.
    pub fn balance_j(&self) -> Option<f64> {
        self.law.account().map(|account| account.balance_j)
    }

    /// Counts of the messages that have come up to now.
    pub const fn counts(&self) -> PortCounts {
        let messages = self.tracker.out_of_order();
        PortCounts {
            missing: messages.lost,
            duplicate: messages.duplicate,
            stale: messages.late,
            foreign: self.foreign,
        }
    }
}

impl<O: Differintegrator<f64>> Begun<'_, O> {
    /// The force to send to the device.
    pub const fn force(&self) -> SafeForce<f64, 1> {
        self.sample.force
    }

    /// The rest of the tick, and the message for the other side.
    pub fn finish(self) -> FinishedTick {
        let Self {
            port,
            sample,
            position_m,
            moved_m,
            heard,
        } = self;
        let applied_n = sample.force.newtons()[0];
        if heard {
            port.law.advance(position_m, moved_m, applied_n);
        }
        port.given_j += applied_n * moved_m;
        port.force_n = applied_n;
        port.last_m = position_m;
        port.sequence = port.sequence.wrapping_add(1);
        let message = HandSample {
            sequence: port.sequence,
            time_s: sample.reading.time_s,
            state: port.law.state(position_m, applied_n),
        };
        FinishedTick { sample, message }
    }
}

/// The law of a port, with its operator where it has one.
#[derive(Clone, Debug)]
pub enum PortLaw<O> {
    /// Each side is coupled to the place of the other.
    PositionPosition(CouplerGains, O),
    /// Position–force: the coupler is the slave's; the master feels its force.
    PositionForce(CouplerGains, O),
    /// Each side sends waves, which no delay makes active.
    Wave {
        /// b, N·s/m, above 0: the damping that each hand feels of the line itself. A sampled device bears it if its own damping
        /// is as large.
        impedance_n_s_per_m: f64,
        /// N, 1 to 10 000: samples over which waves that came in a bunch are played out.
        playout_samples: u32,
    },
    /// Position–position that gives no more energy than has come in.
    TimeDomain {
        /// Gains of the coupler, of which at least one is above 0.
        gains: CouplerGains,
        /// Operator of the coupler's dissipation.
        operator: O,
        /// N, 1 to 10 000: a tick spends at most 1/N of the account, so that energy that came in a bunch lasts to the next.
        playout_samples: u32,
    },
}

/// Everything in a port except its law and its safety chain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The hand of this port; the laws differ by it.
    pub side: HandSide,
    /// T, s, above 0.
    pub sample_time: Seconds,
    /// Silence of the other side after which the force falls to zero, s: at least one sample. Counted from the first message on.
    pub silence: Seconds,
}

impl Settings {
    /// Default silence after which the force falls to zero, s: longer than the gaps that jitter and
    /// loss cause on a line around the world, shorter than a person takes to be startled.
    pub const SILENCE_S: f64 = 0.2;
    /// Most samples over which waves or energy that arrive together are spread.
    pub const PLAYOUT_MOST: u32 = 10_000;

    fn silence_ticks(&self) -> Result<u64, LoopParameterError> {
        let t = positive("sample time", self.sample_time.0, "s")?;
        let ticks = libm::ceil(self.silence.0 / t - 1e-9);
        range(
            "silence",
            self.silence.0,
            (1.0..=1e9).contains(&ticks),
            "at least one sample time and at most 1e9 of them",
            "s",
        )?;
        Ok(ticks as u64)
    }
}

fn checked(gains: CouplerGains) -> Result<CouplerGains, RangeError> {
    not_negative("coupler stiffness", gains.stiffness_n_per_m, "N/m")?;
    not_negative(
        "coupler dissipation",
        gains.dissipation_n_s_mu_per_m,
        "N·s^μ/m",
    )?;
    positive(
        "coupler stiffness and dissipation together",
        gains.stiffness_n_per_m + gains.dissipation_n_s_mu_per_m,
        "",
    )?;
    Ok(gains)
}

fn playout(samples: u32) -> Result<u32, LoopParameterError> {
    range(
        "playout",
        f64::from(samples),
        (1..=Settings::PLAYOUT_MOST).contains(&samples),
        "in [1, 10000] {}",
        "samples",
    )?;
    Ok(samples)
}

pub(crate) fn law<O: Differintegrator<f64>>(
    law: PortLaw<O>,
    settings: &Settings,
) -> Result<Law<O>, LoopParameterError> {
    let coupled = |gains, operator| Ok::<_, RangeError>(Coupled::new(checked(gains)?, operator));
    Ok(match law {
        PortLaw::PositionPosition(gains, operator) => Law::Position(coupled(gains, operator)?),
        PortLaw::PositionForce(gains, operator) => {
            let coupled = coupled(gains, operator)?;
            match settings.side {
                HandSide::Master => Law::Reflected { force_n: 0.0 },
                HandSide::Slave => Law::Reflecting(coupled),
            }
        }
        PortLaw::Wave {
            impedance_n_s_per_m,
            playout_samples,
        } => Law::Wave(WavePort::new(
            positive("wave impedance", impedance_n_s_per_m, "N·s/m")?,
            playout(playout_samples)?,
            settings.sample_time.0,
        )),
        PortLaw::TimeDomain {
            gains,
            operator,
            playout_samples,
        } => Law::Observed(Observed::new(
            coupled(gains, operator)?,
            playout(playout_samples)?,
            settings.side == HandSide::Master,
        )),
    })
}
