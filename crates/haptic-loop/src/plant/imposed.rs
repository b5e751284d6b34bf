//! A motion that is imposed, whatever the force.

use super::RampHold;
use crate::error::positive;
use crate::units::Seconds;
use crate::{Device, ParameterError, Reading, SafeForce};
use core::convert::Infallible;
use fracdiff::Real;
use nalgebra::SVector;

/// A device that is moved along a profile by something infinitely stiff.
///
/// ```text
/// x[n] = profile(n·T)
/// ```
/// The same positions as an [`IndentationRig`](super::IndentationRig) with a rigid contact, bit for bit, without
/// its matrices. *Start-up*: tick 0. *Cost*: a division a tick; no allocation, no panic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImposedMotion {
    profile: RampHold,
    sample_time: f64,
    tick: u64,
}

impl ImposedMotion {
    /// T > 0.
    ///
    /// # Errors
    /// Unless the sample time is finite and above zero.
    pub fn new(profile: RampHold, sample_time: Seconds) -> Result<Self, ParameterError> {
        Ok(Self {
            profile,
            sample_time: positive("sample time", sample_time.0, "s")?,
            tick: 0,
        })
    }

    /// Back to tick 0.
    pub const fn restart(&mut self) {
        self.tick = 0;
    }
}

impl<F: Real> Device<F, 1> for ImposedMotion {
    type Error = Infallible;

    fn read(&mut self) -> Result<Reading<F, 1>, Infallible> {
        let time_s = self.tick as f64 * self.sample_time;
        Ok(Reading {
            tick: self.tick,
            time_s,
            position_m: SVector::from([F::from_f64(self.profile.position(time_s))]),
        })
    }

    fn write(&mut self, _: SafeForce<F, 1>) -> Result<(), Infallible> {
        self.tick += 1;
        Ok(())
    }
}
