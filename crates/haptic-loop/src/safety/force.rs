//! The output of the safety chain: a force, the limiters that acted, or the reason for no force.

use fracdiff::Real;
use nalgebra::SVector;
use thiserror::Error;

/// A force that has passed the safety chain, N. Nothing else can make one, except [`zero`](Self::zero).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SafeForce<F, const D: usize>(pub(super) SVector<F, D>);

impl<F: Real, const D: usize> SafeForce<F, D> {
    /// No force, which is safe anywhere.
    #[must_use]
    pub fn zero() -> Self {
        Self(SVector::from([F::ZERO; D]))
    }

    /// The force, N: finite, and within the limits of the chain that made it.
    pub fn newtons(&self) -> &SVector<F, D> {
        &self.0
    }
}

impl<F: Real> SafeForce<F, 1> {
    /// This force on one of D axes, and none on the others: its magnitude stays. None at all on an axis that is not there.
    #[must_use]
    pub fn on_axis<const D: usize>(self, axis: usize) -> SafeForce<F, D> {
        SafeForce(SVector::from_fn(|row, _| {
            if row == axis { self.0[0] } else { F::ZERO }
        }))
    }
}

/// The limiters that acted in a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Limiters(u8);

impl Limiters {
    /// No limiter acted: the force is the environment's.
    pub const NONE: Self = Self(0);
    /// The force was cut to its largest magnitude.
    pub const MAGNITUDE: Self = Self(1);
    /// The force was held back by its largest rate.
    pub const RATE: Self = Self(2);
    /// A latched fault holds the wanted force at zero.
    pub const FAULT: Self = Self(4);
    /// The loop was asked to stop and the force ramps to zero.
    pub const STOPPING: Self = Self(8);
    /// The force still rises after the start.
    pub const STARTUP: Self = Self(16);
    /// Braking near the end of the workspace.
    pub const WORKSPACE: Self = Self(32);
    /// Braking near the largest speed.
    pub const VELOCITY: Self = Self(64);
    /// The passivity guard changed the force.
    pub const GUARD: Self = Self(128);

    /// Names of the limiters, bit by bit from the lowest.
    pub const NAMES: [&str; 8] = [
        "magnitude",
        "rate",
        "fault",
        "stopping",
        "start-up",
        "workspace",
        "velocity",
        "guard",
    ];

    /// The bits, as logs keep them: 1 magnitude, 2 rate, 4 fault, 8 stopping, 16 start-up, 32 workspace,
    /// 64 velocity, 128 guard.
    #[must_use]
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// True if all of `other` acted.
    #[must_use]
    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    pub(crate) fn insert(&mut self, other: Self) {
        self.0 |= other.0;
    }
}

fracdiff::enumerated! {
    /// Why the chain holds the force at zero. The numbers are the same on the wire and in the log.
    ///
    /// The chain itself latches [`NonFiniteForce`](Self::NonFiniteForce), [`Workspace`](Self::Workspace),
    /// [`Velocity`](Self::Velocity), [`PositionStuck`](Self::PositionStuck) and [`PositionJump`](Self::PositionJump);
    /// the others are found elsewhere and handed to it.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
    #[non_exhaustive]
    #[repr(u8)]
    pub enum Fault {
        /// The wanted force was NaN or infinite, or so was a position that a limit or guard needs.
        #[error("the wanted force was not a finite number")]
        NonFiniteForce = 1,
        /// A device whose force depends on the host heard nothing from it for the watchdog time.
        #[error("the device heard nothing from the host for the watchdog time")]
        HostSilent = 2,
        /// A tick took longer than its period, or began a whole period late.
        #[error("a tick of the loop was a whole period late")]
        TickOverrun = 3,
        /// The emergency stop is open.
        #[error("the emergency stop is open")]
        EmergencyStop = 4,
        /// The measured current does not follow the commanded one.
        #[error("the measured current does not follow the commanded one")]
        CurrentMismatch = 5,
        /// The device left its workspace: a position beyond [`Workspace::low`](crate::Workspace::low) or
        /// [`high`](crate::Workspace::high) on some axis.
        #[error("the device left its workspace")]
        Workspace = 6,
        /// The device moved too fast: an estimated speed above [`SafetyLimits::speed`](crate::SafetyLimits::speed) on some
        /// axis. A position that jumps is a speed too.
        #[error("the device moved faster than its limit")]
        Velocity = 7,
        /// The hardware watchdog reset the device while it was armed.
        #[error("the device was reset by its hardware watchdog")]
        Reset = 8,
        /// The position stands still while the force on the device grows: see [`Stuck`](crate::Stuck).
        #[error("the position stands still while the force on the device grows")]
        PositionStuck = 9,
        /// The position moved in a tick by more than [`SafetyLimits::jump`](crate::SafetyLimits::jump) beyond what the speed limit
        /// allows.
        #[error("the position jumped by more than the speed limit allows")]
        PositionJump = 10,
        /// The host of a host loop sent a force that answers a sample too many ticks ago.
        #[error("the host sent a force for a sample too many ticks ago")]
        StaleForce = 11,
        /// The device failed to measure or to apply: a board of another maker did not answer in time, answered what cannot be, or reports a
        /// fault of its own; a [`Device`](crate::Device) gave an error.
        #[error("the board was silent, implausible or in a fault of its own")]
        BoardFailed = 12,
        /// One channel of an encoder changes again and again, the other never: its wire is off, and the position stands still
        /// whatever the device does.
        #[error("one channel of the encoder changes without the other")]
        EncoderWire = 13,
        /// The force sensor of a device that moves was silent, saturated or stuck, or not at rest at a start.
        #[error("the force sensor was silent, saturated, stuck, or not at rest at the start")]
        ForceSensor = 14,
        /// The sensed force on a device that moves is above its limit.
        #[error("the force of the hand was above its limit: it may have been caught")]
        HandForce = 15,
        /// A device that moves is too far from its command.
        #[error("the robot did not follow its command")]
        Following = 16,
        /// A device that moves gave the hand more energy than its limit.
        #[error("the robot gave energy to the hand: the loop is not stable in it")]
        HandEnergy = 17,
    }
}

impl Fault {
    /// True if a damper can still oppose the motion: it needs its sensor and its actuator.
    pub(crate) const fn leaves_braking(self) -> bool {
        match self {
            Self::CurrentMismatch
            | Self::PositionStuck
            | Self::PositionJump
            | Self::BoardFailed
            | Self::EncoderWire
            | Self::ForceSensor
            | Self::HandForce
            | Self::Following
            | Self::HandEnergy => false,
            Self::NonFiniteForce
            | Self::HostSilent
            | Self::TickOverrun
            | Self::EmergencyStop
            | Self::Workspace
            | Self::Velocity
            | Self::Reset
            | Self::StaleForce => true,
        }
    }

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
