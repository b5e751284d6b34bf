//! The output of the safety chain.

use fracdiff::Real;
use nalgebra::SVector;

/// A force that has passed the safety chain, N. Nothing else can make one, except [`zero`](Self::zero).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SafeForce<F, const D: usize>(pub(super) SVector<F, D>);

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

/// The limiters that acted in a tick.
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

    pub(super) fn insert(&mut self, other: Self) {
        self.0 |= other.0;
    }
}
