//! Distance of a stable loop from the edge: gain margins, delay margin, sensitivity.

use crate::affine::weighted;
use crate::characteristic::{Characteristic, Node};
use crate::{AnalysisError, SampledLoop};
use certified_count::{AtAngle, Bounds, Jet, LoopTerms, OpenLoop, Peak};
use num_complex::Complex;

/// The margins of a stable loop.
/// ```text
/// gain      the g nearest to 1 with 1 + g·GH = 0 somewhere on the circle, above and below 1
/// delay     the least τ > 0 with 1 + GH(τ) = 0, samples: G sampled with the hold and the delay d + τ, of any part of a sample
/// ```
/// None of the crossings in θ is missed: intervals of θ are dropped only where a bound of the
/// second derivative excludes any. The delay is scanned in steps of at most 1/16
/// sample, and the zero is narrowed until the verdicts on both sides of it differ.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct WallMargins {
    /// The least factor above 1 on both stiffness and dissipation that takes the loop to the boundary; `None` if none does.
    pub gain_up: Option<AtAngle>,
    /// The largest such factor below 1; `None` if the loop stays stable down to no gain.
    pub gain_down: Option<AtAngle>,
    /// The least additional delay that takes the loop to the boundary, samples, in general not
    /// whole: any smaller one leaves it stable. With more it may become stable again. `None` if no
    /// delay does.
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
        Open(self).terms(theta).share(Peak::Sensitivity)
    }

    /// All margins.
    ///
    /// # Errors
    /// [`AnalysisError::NotStable`].
    pub fn margins(&self) -> Result<WallMargins, AnalysisError> {
        if !self.is_stable() {
            return Err(AnalysisError::NotStable { what: "margins" });
        }
        let (gain_up, gain_down) = self.gain_margins();
        Ok(WallMargins {
            gain_up,
            gain_down,
            delay: self.delay_margin(),
            sensitivity: Open(self).peak(Peak::Sensitivity, PEAK_TOLERANCE),
        })
    }

    /// The peak of the sensitivity alone: a local maximum to rounding, and the function was proved not
    /// to exceed it anywhere by more than 1e-6, relative.
    ///
    /// # Errors
    /// [`AnalysisError::NotStable`]: then 1/(1 + GH) has poles, and its size on the circle says nothing.
    pub fn sensitivity_peak(&self) -> Result<AtAngle, AnalysisError> {
        if self.is_stable() {
            Ok(Open(self).peak(Peak::Sensitivity, PEAK_TOLERANCE))
        } else {
            Err(AnalysisError::NotStable {
                what: "sensitivity peak",
            })
        }
    }

    /// The factors between these two on both stiffness and dissipation with which the loop is stable, as intervals that rise.
    #[must_use]
    pub fn stable_factors(&self, [low, high]: [f64; 2]) -> Vec<[f64; 2]> {
        let crossings = Open(self).gain_crossings().into_iter();
        stable_between(crossings.map(|at| at.value), [low, high], |factor| {
            let scaled = Self {
                alpha: factor * self.alpha,
                beta: factor * self.beta,
                ..*self
            };
            scaled.is_stable()
        })
    }

    pub(crate) fn gain_margins(&self) -> (Option<AtAngle>, Option<AtAngle>) {
        let (mut up, mut down): (Option<AtAngle>, Option<AtAngle>) = (None, None);
        for found in Open(self).gain_crossings() {
            let value = found.value;
            if value > 1.0 && up.is_none_or(|up| value < up.value) {
                up = Some(found);
            } else if value < 1.0 && down.is_none_or(|down| value > down.value) {
                down = Some(found);
            }
        }
        (up, down)
    }

    /// GH(e^(−jθ)), the loop gain; infinite at a pole of the plant on the circle.
    #[must_use]
    pub fn loop_gain(&self, theta: f64) -> Complex<f64> {
        Open(self).terms(theta).gain()
    }
}

/// The values between these two, from 0 on, at which something is stable, as intervals that rise: it changes at crossings alone.
pub(crate) fn stable_between(
    crossings: impl Iterator<Item = f64>,
    [low, high]: [f64; 2],
    is_stable: impl Fn(f64) -> bool,
) -> Vec<[f64; 2]> {
    let inside = crossings.filter(|at| low < *at && *at < high);
    let mut ends: Vec<f64> = inside.chain([low, high]).collect();
    ends.sort_by(f64::total_cmp);
    let mut stable: Vec<[f64; 2]> = Vec::new();
    for pair in ends.windows(2) {
        let middle = if pair[0] > 0.0 {
            libm::sqrt(pair[0] * pair[1])
        } else {
            0.5 * pair[1]
        };
        match stable.last_mut() {
            _ if !is_stable(middle) => {}
            // A crossing that only touches bounds nothing.
            Some(last) if last[1] >= pair[0] => last[1] = pair[1],
            Some(_) | None => stable.push([pair[0], pair[1]]),
        }
    }
    stable
}

/// A·D and S·(αD + βN) of a loop: GH is their ratio, F·D their sum.
pub(crate) struct Open<'a, 'b>(pub(crate) &'a SampledLoop<'b>);

impl OpenLoop for Open<'_, '_> {
    type Node = Node;

    fn terms(&self, theta: f64) -> LoopTerms<Node> {
        let node = self.0.characteristic.node(theta);
        let [plant, stiff, fractional] = node.terms.jets;
        let (alpha, beta) = (self.0.alpha, self.0.beta);
        // A rate that is infinite counts for nothing without β.
        let rate = if beta == 0.0 {
            stiff.rate * alpha
        } else {
            stiff.rate * alpha + fractional.rate * beta
        };
        let feedback = Jet::new(stiff.value * alpha + fractional.value * beta, rate);
        LoopTerms {
            theta: node.theta(),
            parts: [plant, feedback],
            node,
        }
    }

    fn bounds(&self, a: &LoopTerms<Node>, b: &LoopTerms<Node>) -> [Bounds; 2] {
        let [plant, stiff, fractional] = self.0.characteristic.bounds(&a.node, &b.node);
        let feedback = weighted(&[stiff, fractional], &[self.0.alpha, self.0.beta]);
        [plant, feedback]
    }

    fn angles(&self) -> Vec<f64> {
        Characteristic::first_angles().collect()
    }
}
