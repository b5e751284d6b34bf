//! Stability for every gain of an interval, as a proof.

use crate::{Margins, SampledLoop};
use certified_count::is_clear;

/// Gains looked at, over the nominal one.
const RANGE: [f64; 2] = [0.01, 100.0];
/// Share by which the interval stays away from the gains at which L meets −1.
const AWAY: f64 = 1e-3;
/// Times the interval is narrowed to half its logarithm, where a margin was missed by the grid.
const NARROWED: usize = 8;

impl SampledLoop {
    /// True if it is proved that the loop is stable for every gain of the plant from `low` to `high` times the present one, 0 < low ≤ high.
    ///
    /// ```text
    /// A_C·A_G + k·B_C·B_G is 0 nowhere on the circle for any of these k: the number of zeros within is the same for all
    /// ```
    /// *Cost*: that of two verdicts.
    ///
    /// ```
    /// use fracdiff::Seconds;
    /// use fractional_control::{Memory, PidParameters, Plant, Rule, SampledLoop, SampledPlant};
    ///
    /// // With a gain of 2 the loop of 1/(s − 1) is stable: above 1 it is, and below 2/T.
    /// let (t, memory) = (Seconds(0.01), Memory::new(Rule::Bdf2, 1e-6, 100.0)?);
    /// let plant = SampledPlant::new(&"1/(s-1)".parse::<Plant>()?, memory, t)?;
    /// let p = PidParameters { proportional: 2.0, ..PidParameters::NONE };
    /// let closed = SampledLoop::new(p.into(), memory, &plant)?;
    /// assert!(closed.is_stable_over(0.51, 90.0));
    /// assert!(!closed.is_stable_over(0.49, 1.0) && !closed.is_stable_over(1.0, 110.0));
    /// # Ok::<(), fractional_control::ControlError>(())
    /// ```
    #[must_use]
    pub fn is_stable_over(&self, low: f64, high: f64) -> bool {
        let gains = [self.gain() * low, self.gain() * high];
        let is_interval = gains[0] > 0.0 && low <= high && gains[1].is_finite();
        is_interval
            && self.with_gain(gains[0]).verdict().stable
            && is_clear(|arc| self.parts(arc), gains)
    }

    /// The gains of the plant, over the present one, between which the loop is proved stable: as far as the gain margins, within a hundredth
    /// to a hundred times. `None` for a loop that is not stable.
    #[must_use]
    pub fn gain_interval(&self, margins: &Margins) -> Option<[f64; 2]> {
        let low = margins.gain_down.map_or(0.0, |down| down.value);
        let high = margins.gain_up.map_or(f64::INFINITY, |up| up.value);
        if !self.is_stable_over(1.0, 1.0) {
            return None;
        }
        let low = (low * (1.0 + AWAY)).clamp(RANGE[0], 1.0);
        let high = (high * (1.0 - AWAY)).clamp(1.0, RANGE[1]);
        // Each side for itself, towards 1 where it is not proved.
        let nearer = |gain: &f64| Some(libm::sqrt(*gain));
        let tried = |gain: f64| core::iter::successors(Some(gain), nearer).take(NARROWED);
        let low = tried(low).find(|low| self.is_stable_over(*low, 1.0));
        let high = tried(high).find(|high| self.is_stable_over(1.0, *high));
        Some([low.unwrap_or(1.0), high.unwrap_or(1.0)])
    }
}
