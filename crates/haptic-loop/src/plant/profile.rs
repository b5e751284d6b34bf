//! An indentation profile, and a motion that follows it whatever the force.

use crate::units::{Metres, Seconds};
use crate::{Device, LoopParameterError, Reading, SafeForce};
use core::convert::Infallible;
use fracdiff::Real;
use fracdiff::parameter::{positive, range};
use nalgebra::SVector;

/// A ramp from zero to a depth, which is then held for ever.
///
/// ```text
/// x(t) = depth·min(t/T₀, 1) for t ≥ 0,    0 for t < 0
/// ```
/// - *Symbols*: depth m, any finite number, positive into the tissue; T₀ ramp time s, > 0.
/// - *Exact*: from T₀ on the position is the depth, bit for bit.
///
/// Source: dissertation ch. VII (ramp to 1 mm in 1 s, hold to 200 s).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RampHold {
    depth: f64,
    ramp_time: f64,
}

impl RampHold {
    /// A ramp to `depth` in `ramp_time`.
    ///
    /// # Errors
    /// Unless the depth is finite and the ramp time finite and above zero.
    pub fn new(depth: Metres, ramp_time: Seconds) -> Result<Self, LoopParameterError> {
        Ok(Self {
            depth: range("indentation depth", depth.0, true, "finite", "m")?,
            ramp_time: positive("ramp time", ramp_time.0, "s")?,
        })
    }

    /// x(t), m, at `time` in s.
    #[must_use]
    pub fn position(&self, time: f64) -> f64 {
        // x(t) = depth·min(t/T₀, 1)
        self.depth * (time / self.ramp_time).clamp(0.0, 1.0)
    }

    /// The depth of the hold, m.
    #[must_use]
    pub const fn depth(&self) -> Metres {
        Metres(self.depth)
    }

    /// T₀, s: when the hold begins.
    #[must_use]
    pub const fn ramp_time(&self) -> Seconds {
        Seconds(self.ramp_time)
    }
}

/// A device that is forced along a profile, whatever force it makes.
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
    pub fn new(profile: RampHold, sample_time: Seconds) -> Result<Self, LoopParameterError> {
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
