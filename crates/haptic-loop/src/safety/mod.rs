//! The safety chain: the only way for a force to become a [`SafeForce`].
//!
//! ```text
//! wanted ─▶ finite? ─▶ rate limit (N/s) ─▶ magnitude limit per axis (N) ─▶ SafeForce
//! ```
//! - *Finite check first*: a NaN passed through `max` and `min` would come out as the full force. A
//!   wanted force that is not finite latches a [`Fault`]; from then on the chain wants zero, so the
//!   force falls to zero at the rate limit, until [`SafetyState::clear`].
//! - *Rate limit*: |f\[n\] − f\[n−1\]| ≤ rate·T per axis.
//! - *Start-up*: zero force. *Cost*: a few comparisons per axis; no allocation, no panic.

use crate::error::{ParameterError, positive, rounded};
use crate::units::{Newtons, NewtonsPerSecond, Seconds};
use fracdiff::Real;
use nalgebra::SVector;

/// A force that has passed the safety chain, N. Nothing else can make one, except [`zero`](Self::zero).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SafeForce<F, const D: usize>(SVector<F, D>);

impl<F: Real, const D: usize> SafeForce<F, D> {
    /// No force: always safe.
    #[must_use]
    pub fn zero() -> Self {
        Self(SVector::from([F::ZERO; D]))
    }

    /// The force, N: finite, and within the limits of the chain that made it.
    pub fn newtons(&self) -> &SVector<F, D> {
        &self.0
    }
}

/// Which limiters acted in a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Limiters(u8);

impl Limiters {
    /// None acted.
    pub const NONE: Self = Self(0);
    /// The magnitude limit.
    pub const MAGNITUDE: Self = Self(1);
    /// The rate limit.
    pub const RATE: Self = Self(2);
    /// A latched fault holds the wanted force at zero.
    pub const FAULT: Self = Self(4);
    /// The loop was asked to stop and the force ramps to zero.
    pub const STOPPING: Self = Self(8);

    /// The bits, as logs keep them: 1 magnitude, 2 rate, 4 fault, 8 stopping.
    #[must_use]
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// Whether all of `other` acted.
    #[must_use]
    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    fn insert(&mut self, other: Self) {
        self.0 |= other.0;
    }
}

/// Why the chain holds the force at zero. The numbers are those of the wire and of the log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
#[repr(u8)]
pub enum Fault {
    /// The wanted force was NaN or infinite.
    NonFiniteForce = 1,
    /// A device whose force depends on the host heard nothing from it for the watchdog time.
    HostSilent = 2,
    /// A tick took longer than its period, or began a whole period late.
    TickOverrun = 3,
    /// The emergency stop is open.
    EmergencyStop = 4,
    /// The measured current does not follow the commanded one.
    CurrentMismatch = 5,
    /// The device left its workspace.
    Workspace = 6,
    /// The device moved too fast.
    Velocity = 7,
    /// The hardware watchdog reset the device while it was armed.
    Reset = 8,
}

impl Fault {
    /// Every fault, in the order of the codes.
    pub const ALL: [Self; 8] = [
        Self::NonFiniteForce,
        Self::HostSilent,
        Self::TickOverrun,
        Self::EmergencyStop,
        Self::CurrentMismatch,
        Self::Workspace,
        Self::Velocity,
        Self::Reset,
    ];

    /// The code on the wire and in the log, from 1.
    #[must_use]
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// The fault with this code.
    #[must_use]
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|fault| fault.code() == code)
    }
}

impl core::fmt::Display for Fault {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::NonFiniteForce => "the wanted force was not a finite number",
            Self::HostSilent => "the device heard nothing from the host for the watchdog time",
            Self::TickOverrun => "a tick of the loop was a whole period late",
            Self::EmergencyStop => "the emergency stop is open",
            Self::CurrentMismatch => "the measured current does not follow the commanded one",
            Self::Workspace => "the device left its workspace",
            Self::Velocity => "the device moved faster than its limit",
            Self::Reset => "the device was reset by its hardware watchdog",
        })
    }
}

/// The chain's immutable part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SafetyChain<F> {
    magnitude: F,
    step: F,
}

/// The chain's state: the last force, the latched fault, a wish to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SafetyState<F, const D: usize> {
    force: SVector<F, D>,
    fault: Option<Fault>,
    stopping: bool,
}

impl<F: Real, const D: usize> Default for SafetyState<F, D> {
    fn default() -> Self {
        Self {
            force: SVector::from([F::ZERO; D]),
            fault: None,
            stopping: false,
        }
    }
}

impl<F: Real, const D: usize> SafetyState<F, D> {
    /// The latched fault.
    #[must_use]
    pub fn fault(&self) -> Option<Fault> {
        self.fault
    }

    /// Latches a fault that something else has found. The first fault stays.
    pub fn trip(&mut self, fault: Fault) {
        self.fault.get_or_insert(fault);
    }

    /// From the next tick the wanted force is zero, until [`clear`](Self::clear).
    pub fn stop(&mut self) {
        self.stopping = true;
    }

    /// Whether the force has reached zero on every axis.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        self.force.iter().all(|&axis| axis == F::ZERO)
    }

    /// Clears the fault and the wish to stop. The force goes on from where it is.
    pub fn clear(&mut self) {
        self.fault = None;
        self.stopping = false;
    }
}

impl<F: Real> SafetyChain<F> {
    /// A chain for the largest force per axis, the largest rate, and the sample time.
    ///
    /// # Errors
    /// Each must be finite and above zero, in the precision of the loop too.
    pub fn new(
        force: Newtons,
        rate: NewtonsPerSecond,
        sample_time: Seconds,
    ) -> Result<Self, ParameterError> {
        let magnitude = positive("force limit", force.0, "N")?;
        let rate = positive("force rate limit", rate.0, "N/s")?;
        let sample_time = positive("sample time", sample_time.0, "s")?;
        Ok(Self {
            magnitude: rounded("force limit", magnitude, "N")?,
            step: rounded("force step of a sample", rate * sample_time, "N")?,
        })
    }

    /// Makes a wanted force safe, and says which limiters acted.
    pub fn apply<const D: usize>(
        &self,
        state: &mut SafetyState<F, D>,
        wanted: &SVector<F, D>,
    ) -> (SafeForce<F, D>, Limiters) {
        let mut limiters = Limiters::NONE;
        if !wanted.iter().all(|axis| axis.is_finite()) {
            state.trip(Fault::NonFiniteForce);
        }
        if state.fault.is_some() {
            limiters.insert(Limiters::FAULT);
        }
        if state.stopping {
            limiters.insert(Limiters::STOPPING);
        }
        let released = state.fault.is_some() || state.stopping;
        for (last, &wanted) in state.force.iter_mut().zip(wanted) {
            let wanted = if released { F::ZERO } else { wanted };
            let slewed = clamp(wanted, *last - self.step, *last + self.step);
            if slewed != wanted {
                limiters.insert(Limiters::RATE);
            }
            let limited = clamp(slewed, -self.magnitude, self.magnitude);
            if limited != slewed {
                limiters.insert(Limiters::MAGNITUDE);
            }
            *last = limited;
        }
        (SafeForce(state.force), limiters)
    }
}

/// The nearest value in [low, high], for finite numbers.
fn clamp<F: Real>(value: F, low: F, high: F) -> F {
    if value < low {
        low
    } else if value > high {
        high
    } else {
        value
    }
}
