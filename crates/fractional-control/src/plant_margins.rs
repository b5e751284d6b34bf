//! Margins of a plant behind its hold, whether it is sampled exactly or a rule stands for it.

use crate::margins::{Crossing, Margins};
use crate::verdict::SampledLoop;

/// Largest gain up to which a rule is asked to stand for its plant.
const ASKED: f64 = 100.0;
/// A rule is asked up to this share below the gain at which it loses the loop.
const SHORT: f64 = 0.01;

impl SampledLoop {
    /// Margins and peaks of the loop around the plant behind its hold. `own` are the [`margins`](Self::margins) of this loop, `later` is the loop
    /// whose plant has so much more dead time, s; where it is refused, the delay margin is that of whole samples.
    ///
    /// The gain at which the loop is lost is that of the rule where the rule stands for its plant, else that of the response of the plant. A delay
    /// is one that the memory [holds](Self::remembered). Cost: that of [`delay_margin`](Self::delay_margin), some dozen verdicts.
    ///
    /// ```
    /// use fracdiff::Seconds;
    /// use fractional_control::{ControlError, Memory, PidParameters, Plant, Rule, SampledLoop, SampledPlant};
    ///
    /// let (t, memory) = (Seconds(0.01), Memory::new(Rule::Bdf2, 1e-8, 100.0)?);
    /// let plant: Plant = "1/s^1.5".parse()?;
    /// let p = PidParameters { proportional: 1.0, ..PidParameters::NONE };
    /// let later = |delay_s: f64| {
    ///     let later = SampledPlant::new(&plant.clone().delayed(delay_s)?, memory, t)?;
    ///     SampledLoop::new(p.into(), memory, &later)
    /// };
    /// let prompt = later(0.0)?;
    /// // A margin of 45° at 1 rad/s, less half a sample of the hold.
    /// let delay = prompt.margins_of_plant(prompt.margins(), later).delay_s.expect("a crossover");
    /// assert!((delay.value - (core::f64::consts::FRAC_PI_4 - 0.005)).abs() < 1e-3);
    /// # Ok::<(), ControlError>(())
    /// ```
    pub fn margins_of_plant<E>(
        &self,
        own: Margins,
        later: impl Fn(f64) -> Result<Self, E>,
    ) -> Margins {
        let mut margins = own;
        if let Some(held) = self.of_plant() {
            margins = held.margins();
            margins.gain_up = self.lost_above(own.gain_up, margins.gain_up);
        }
        let first = self.remembered(margins.delay_s);
        margins.delay_s = self.remembered(Self::delay_margin(first, later).unwrap_or(first));
        margins
    }

    /// The least gain above 1 at which the loop is lost.
    fn lost_above(
        &self,
        of_rule: Option<Crossing>,
        of_plant: Option<Crossing>,
    ) -> Option<Crossing> {
        let most = of_rule.map_or(ASKED, |gain| gain.value * (1.0 - SHORT));
        let rule = self.rule_error();
        let holds = rule.is_none_or(|rule| rule.within([1.0, most])[1] >= most);
        if holds {
            of_rule.or(of_plant)
        } else {
            of_plant
        }
    }
}
