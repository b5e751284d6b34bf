//! Distance of a stable loop from the edge: gain margins, delay margin, sensitivity.

use crate::characteristic::Characteristic;
use crate::crossing::{AtAngle, NARROW, Terms, bisect};
use crate::curve::Bounds;
use crate::{AnalysisError, SampledLoop};
use core::f64::consts::PI;

/// The margins of a stable loop.
///
/// ```text
/// gain      the g nearest to 1 with 1 + g·GH = 0 somewhere on the circle, above and below 1
/// delay     the least τ > 0 with 1 + GH(τ) = 0, samples: G sampled with the hold and the delay d + τ, of any part of a sample
/// ```
/// None of the crossings in θ is missed: intervals of θ are dropped only where a bound of the second
/// derivative proves that there is none. Of the delay 16 parts of a sample at least are looked at, and the
/// zero is narrowed until the verdicts on both sides of it differ.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Margins {
    /// The least factor above 1 on both stiffness and dissipation that takes the loop to the
    /// boundary; `None` if none does.
    pub gain_up: Option<AtAngle>,
    /// The largest factor below 1 that does; `None` if the loop stays stable down to no gain.
    pub gain_down: Option<AtAngle>,
    /// The least additional delay that does, samples, in general not whole: with any smaller one the loop is stable.
    /// With more it may become stable again. `None` if no delay does.
    pub delay: Option<AtAngle>,
    /// The largest sensitivity |1/(1 + GH)|; 1 over it is the distance of GH from −1.
    pub sensitivity: AtAngle,
}

/// Relative height by which another peak might exceed the one found.
const PEAK_TOLERANCE: f64 = 1e-6;

impl SampledLoop<'_> {
    /// |1/(1 + GH)| = |A/F|: how much a disturbance of the position is amplified. 1 is neutral.
    #[must_use]
    pub fn sensitivity(&self, theta: f64) -> f64 {
        Terms::new(self, self.characteristic.node(theta)).sensitivity()
    }

    /// All margins.
    ///
    /// # Errors
    /// [`AnalysisError::NotStable`].
    pub fn margins(&self) -> Result<Margins, AnalysisError> {
        if !self.is_stable() {
            return Err(AnalysisError::NotStable { what: "margins" });
        }
        let (gain_up, gain_down) = self.gain_margins();
        Ok(Margins {
            gain_up,
            gain_down,
            delay: self.delay_margin(),
            sensitivity: self.peak(),
        })
    }

    /// The peak of the sensitivity alone: a local maximum to rounding, and the function was proved not
    /// to exceed it anywhere by more than 1e-6, relative.
    ///
    /// # Errors
    /// [`AnalysisError::NotStable`]: then 1/(1 + GH) has poles, and its size on the circle says nothing.
    pub fn sensitivity_peak(&self) -> Result<AtAngle, AnalysisError> {
        if self.is_stable() {
            Ok(self.peak())
        } else {
            Err(AnalysisError::NotStable {
                what: "sensitivity peak",
            })
        }
    }

    pub(crate) fn gain_margins(&self) -> (Option<AtAngle>, Option<AtAngle>) {
        // GH is real: Im(A·(SH)*) = 0.
        let imaginary = |at: &Terms| {
            let rate = at.plant_rate * at.feedback.conj() + at.plant * at.feedback_rate.conj();
            [(at.plant * at.feedback.conj()).im, rate.im]
        };
        let bend = |plant: Bounds, feedback: Bounds| plant.times(feedback).bend;
        let mut angles = self.zeros(imaginary, bend);
        angles.extend([0.0, PI]);
        let (mut up, mut down): (Option<AtAngle>, Option<AtAngle>) = (None, None);
        for theta in angles {
            let gain = self.loop_gain(theta);
            let value = -1.0 / gain.re;
            if !value.is_finite() || value <= 0.0 || gain.im.abs() > 1e-6 * gain.norm() {
                continue;
            }
            let found = AtAngle { value, theta };
            if value > 1.0 && up.is_none_or(|up| value < up.value) {
                up = Some(found);
            } else if value < 1.0 && down.is_none_or(|down| value > down.value) {
                down = Some(found);
            }
        }
        (up, down)
    }

    /// The peak of |A/F|: the best sample, improved, then proved, or replaced and proved again.
    fn peak(&self) -> AtAngle {
        let at = |theta| Terms::new(self, self.characteristic.node(theta));
        let angles: Vec<f64> = Characteristic::first_angles().collect();
        let samples: Vec<Terms> = angles.into_iter().map(at).collect();
        let mut best = AtAngle {
            value: 0.0,
            theta: 0.0,
        };
        for (index, sample) in samples.iter().enumerate() {
            if sample.sensitivity() > best.value {
                let low = samples[index.saturating_sub(1)].theta();
                let high = samples[(index + 1).min(samples.len() - 1)].theta();
                best = self.improve(sample, low, high);
            }
        }
        let mut todo: Vec<(Terms, Terms)> =
            samples.windows(2).map(|pair| (pair[0], pair[1])).collect();
        while let Some((a, b)) = todo.pop() {
            if Terms::stays_below(self, &a, &b, best.value * (1.0 + PEAK_TOLERANCE)) {
                continue;
            }
            let (low, high) = (a.theta(), b.theta());
            if high - low <= NARROW {
                continue;
            }
            let middle = at(0.5 * (low + high));
            if middle.sensitivity() > best.value {
                best = self.improve(&middle, low, high);
            }
            todo.extend([(a, middle), (middle, b)]);
        }
        best
    }

    /// A local maximum between two angles, no lower than the sample.
    fn improve(&self, sample: &Terms, low: f64, high: f64) -> AtAngle {
        let at = |theta| Terms::new(self, self.characteristic.node(theta));
        let theta = bisect(low, high, |theta| at(theta).climb() > 0.0);
        let value = at(theta).sensitivity();
        if value > sample.sensitivity() {
            AtAngle { value, theta }
        } else {
            AtAngle {
                value: sample.sensitivity(),
                theta: sample.theta(),
            }
        }
    }
}
