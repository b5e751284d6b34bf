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
///
/// ```
/// use fracdiff::Seconds;
/// use haptic_loop::Device;
/// use haptic_loop::plant::{ImposedMotion, RampHold};
/// use haptic_loop::units::Metres;
///
/// let ramp = RampHold::new(Metres(2e-3), Seconds(0.5))?;
/// let mut motion = ImposedMotion::new(ramp, Seconds(1e-3))?;
/// let reading = Device::<f64, 1>::read(&mut motion).unwrap_or_else(|never| match never {});
/// assert_eq!((reading.tick, reading.position_m[0]), (0, 0.0));
/// # Ok::<(), haptic_loop::ParameterError>(())
/// ```
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
