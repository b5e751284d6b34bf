//! The indentation profile of a relaxation experiment.

use crate::ParameterError;
use crate::error::{positive, range};
use crate::units::{Metres, Seconds};

/// A ramp from zero to a depth, then a hold for ever.
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
    pub fn new(depth: Metres, ramp_time: Seconds) -> Result<Self, ParameterError> {
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
