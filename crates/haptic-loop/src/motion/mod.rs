//! Devices that move instead of pushing: a robot that takes a velocity and senses the force of the hand.
//!
//! ```text
//! hand ─▶ robot.sense ─▶ checks of the sensor ─▶ f_m ─┐
//!                                                     ├─▶ virtual body ─▶ motion chain ─SafeMotion─▶ robot.command
//! law(x) ─▶ safety chain ─SafeForce─▶ f_e ────────────┘                        │
//!      ▲                                                                       └─▶ x, the position of the command
//!      └──────────────────────────── Admittance::read ◀────────────────────────────┘
//! ```
//! - *Law*: a [`VirtualBody`] stands between the hand and the virtual world, M(D)·v = `f_m` + `f_e`. [`Admittance`] makes robot and body
//!   one [`Device`](crate::Device), whose position is that of the command, so every law of ours runs on it.
//! - *Safety is of motion*: zero force is not zero motion. Only a [`MotionChain`] makes a [`SafeMotion`], and a [`MovingDevice`]
//!   accepts nothing else.
//! - *Not a device that damps*: the virtual port sees no energy while the robot diverges in a hand. The guards of a safety chain
//!   are refused for it, see [`Admittance::accepts`]; its own books are of the hand's port, [`MotionLimits::hand_energy`].
//! - *Stable* is a question of hand and robot, not of the law alone: a wall that is stable on a device of forces may run away here.

mod admittance;
mod body;
mod chain;
mod limits;
mod state;

pub use admittance::{Admittance, AdmittanceError, GuardRefused};
pub use body::{LaggedRate, LaggedRateHistory, VirtualBody};
pub use chain::MotionChain;
pub use limits::{MotionLimits, StuckSensor};
pub use state::{AtRest, MotionFault, MotionStartRefused, MotionState};

use core::fmt::Debug;
use fracdiff::Real;
use nalgebra::SVector;

/// A velocity that has passed the motion chain, m/s. Nothing else can make one, except [`zero`](Self::zero).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SafeMotion<F, const D: usize>(SVector<F, D>);

impl<F: Real, const D: usize> SafeMotion<F, D> {
    /// No motion: the command of a robot that holds its place.
    #[must_use]
    pub fn zero() -> Self {
        Self(SVector::from([F::ZERO; D]))
    }

    /// The velocity, m/s: finite, and within the limits of the chain that made it.
    pub const fn metres_per_second(&self) -> &SVector<F, D> {
        &self.0
    }
}

/// The readings of a robot's sensors at the start of a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionReading<F, const D: usize> {
    /// Number of the tick, from 0. A gap is a number of ticks for which the last command was held.
    pub tick: u64,
    /// The robot's own time since its start, s. Virtual in simulation.
    pub time_s: f64,
    /// Measured position of the handle, m.
    pub position_m: SVector<F, D>,
    /// Force of the hand on the robot, N, positive along the position, as the sensor under the handle shows it.
    pub sensed_force_n: SVector<F, D>,
    /// Time since that force was sensed, s, at least 0.
    pub force_age_s: F,
}

/// A robot with D degrees of freedom, real or simulated, that takes a velocity: sense, then command, once a tick.
///
/// A command holds until the next one. A real robot comes to rest by itself when commands fail to appear.
pub trait MovingDevice<F: Real, const D: usize> {
    /// Why a reading or a command did not get through; `Infallible` for a simulated robot.
    type Error: Debug;

    /// Reads the sensors.
    ///
    /// # Errors
    /// As the robot says.
    fn sense(&mut self) -> Result<MotionReading<F, D>, Self::Error>;

    /// Moves at this velocity until the next tick. A simulated robot moves on by one sample time.
    ///
    /// # Errors
    /// As the robot says.
    fn command(&mut self, motion: SafeMotion<F, D>) -> Result<(), Self::Error>;

    /// Comes to rest by its own means and holds its place: nobody commands any more. *Default*: commands zero. A robot with more
    /// than that, such as a stop category of its drives, uses it here.
    fn let_go(&mut self) {
        // One that cannot even be commanded has to stop by its own watchdog.
        let _ = self.command(SafeMotion::zero());
    }
}

impl<F: Real, const D: usize, R: MovingDevice<F, D> + ?Sized> MovingDevice<F, D> for &mut R {
    type Error = R::Error;

    #[inline]
    fn sense(&mut self) -> Result<MotionReading<F, D>, R::Error> {
        (**self).sense()
    }

    #[inline]
    fn command(&mut self, motion: SafeMotion<F, D>) -> Result<(), R::Error> {
        (**self).command(motion)
    }

    fn let_go(&mut self) {
        (**self).let_go();
    }
}

#[inline]
fn finite<F: Real, const D: usize>(vector: &SVector<F, D>) -> bool {
    (0..D).all(|axis| vector[axis].is_finite())
}
