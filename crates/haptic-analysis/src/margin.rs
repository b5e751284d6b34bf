//! Distance of a stable loop from the edge: gain margins, delay margin, sensitivity.

use crate::characteristic::{Characteristic, Node};
use crate::curve::{Bounds, product};
use crate::{AnalysisError, SampledLoop};
use core::f64::consts::PI;
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
pub struct Margins {
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
        let (mut up, mut down): (Option<AtAngle>, Option<AtAngle>) = (None, None);
        for found in self.gain_crossings() {
            let value = found.value;
            if value > 1.0 && up.is_none_or(|up| value < up.value) {
                up = Some(found);
            } else if value < 1.0 && down.is_none_or(|down| value > down.value) {
                down = Some(found);
            }
        }
        (up, down)
    }

    /// Every g > 0 with 1 + g·GH = 0 on the circle.
    pub(crate) fn gain_crossings(&self) -> impl Iterator<Item = AtAngle> {
        // GH is real: Im(A·(SH)*) = 0.
        let imaginary = |at: &Terms| {
            let rate = at.plant_rate * at.feedback.conj() + at.plant * at.feedback_rate.conj();
            [(at.plant * at.feedback.conj()).im, rate.im]
        };
        let bend = |plant: Bounds, feedback: Bounds| plant.times(feedback).bend;
        let mut angles = self.zeros(imaginary, bend);
        angles.extend([0.0, PI]);
        angles.into_iter().filter_map(|theta| {
            let gain = self.loop_gain(theta);
            let value = -1.0 / gain.re;
            let is_real = gain.im.abs() <= 1e-6 * gain.norm();
            (value.is_finite() && value > 0.0 && is_real).then_some(AtAngle::new(value, theta))
        })
    }

    /// The peak of |A/F|: the best sample, improved, then proved, or replaced and proved again.
    fn peak(&self) -> AtAngle {
        let at = |theta| Terms::new(self, self.characteristic.node(theta));
        let angles: Vec<f64> = Characteristic::first_angles().collect();
        let samples: Vec<Terms> = angles.into_iter().map(at).collect();
        let mut best = AtAngle::new(0.0, 0.0);
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
            AtAngle::new(value, theta)
        } else {
            AtAngle::new(sample.sensitivity(), sample.theta())
        }
    }
}

/// A value and the angle, rad/sample, at which it occurs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AtAngle {
    /// The value, without a unit unless its field has one.
    pub value: f64,
    /// The angle θ = ωT of a frequency ω, from 0 to π.
    pub theta: f64,
}

impl AtAngle {
    pub(crate) const fn new(value: f64, theta: f64) -> Self {
        Self { value, theta }
    }
}

/// Crossings nearer to rest than this are not looked for, rad/sample.
const LEAST_ANGLE: f64 = 1e-6;
/// Intervals narrower than this are not halved.
pub(crate) const NARROW: f64 = 1e-12;

impl SampledLoop<'_> {
    /// GH(e^(−jθ)), the loop gain; infinite at a pole of the plant on the circle.
    #[must_use]
    pub fn loop_gain(&self, theta: f64) -> Complex<f64> {
        let terms = Terms::new(self, self.characteristic.node(theta));
        terms.feedback / terms.plant
    }

    /// All zeros in (0, π) of a real function of A and SH, from its value and derivative and a bound of its second derivative.
    pub(crate) fn zeros(
        &self,
        function: impl Fn(&Terms) -> [f64; 2],
        bend: impl Fn(Bounds, Bounds) -> f64,
    ) -> Vec<f64> {
        let at = |theta| Terms::new(self, self.characteristic.node(theta));
        let mut found = Vec::new();
        if self.alpha == 0.0 && self.beta == 0.0 {
            return found;
        }
        let mut todo = vec![(at(LEAST_ANGLE), at(PI))];
        while let Some((a, b)) = todo.pop() {
            let ([at_a, rate_a], [at_b, _]) = (function(&a), function(&b));
            let (low, high) = (a.theta(), b.theta());
            let width = high - low;
            let (plant, feedback) = Terms::bounds(self, &a, &b);
            let bend = bend(plant, feedback);
            let crosses = (at_a > 0.0) != (at_b > 0.0);
            if !crosses && at_a.abs().min(at_b.abs()) > 0.125 * width * width * bend {
                continue;
            }
            if rate_a.abs() > width * bend {
                // Monotone: one zero or none.
                if crosses {
                    found.push(bisect(low, high, |theta| {
                        (function(&at(theta))[0] > 0.0) == (at_a > 0.0)
                    }));
                }
                continue;
            }
            if width > NARROW {
                let middle = at(0.5 * (low + high));
                todo.extend([(a, middle), (middle, b)]);
            } else if crosses {
                found.push(0.5 * (low + high));
            }
        }
        found
    }
}

/// The point at which a condition that holds at the low end ceases to hold.
pub(crate) fn bisect(mut low: f64, mut high: f64, holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// A·D and S·(αD + βN) of one loop at one angle: GH is their ratio, F·D their sum.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Terms {
    pub(crate) node: Node,
    pub(crate) plant: Complex<f64>,
    pub(crate) feedback: Complex<f64>,
    pub(crate) plant_rate: Complex<f64>,
    pub(crate) feedback_rate: Complex<f64>,
}

impl Terms {
    pub(crate) fn new(subject: &SampledLoop, node: Node) -> Self {
        let [plant, stiff, fractional] = node.terms;
        let (alpha, beta) = (subject.alpha, subject.beta);
        let feedback_rate = if beta == 0.0 {
            stiff.rate * alpha
        } else {
            stiff.rate * alpha + fractional.rate * beta
        };
        Self {
            node,
            plant: plant.value,
            feedback: stiff.value * alpha + fractional.value * beta,
            plant_rate: plant.rate,
            feedback_rate,
        }
    }

    pub(crate) fn theta(&self) -> f64 {
        self.node.theta()
    }

    pub(crate) fn sensitivity(&self) -> f64 {
        self.plant.norm() / (self.plant + self.feedback).norm()
    }

    /// The derivative of the logarithm of the sensitivity.
    pub(crate) fn climb(&self) -> f64 {
        let sum = (self.plant_rate + self.feedback_rate) / (self.plant + self.feedback);
        (self.plant_rate / self.plant - sum).re
    }

    /// Of both terms over an interval.
    pub(crate) fn bounds(subject: &SampledLoop, a: &Self, b: &Self) -> (Bounds, Bounds) {
        let [plant, stiff, fractional] = subject.characteristic.bounds(&a.node, &b.node);
        let sum = |of: fn(&Bounds) -> f64| {
            product(subject.alpha, of(&stiff)) + product(subject.beta, of(&fractional))
        };
        let feedback = Bounds {
            size: sum(|bounds| bounds.size),
            rate: sum(|bounds| bounds.rate),
            bend: sum(|bounds| bounds.bend),
            travel: sum(|bounds| bounds.travel),
        };
        (plant, feedback)
    }

    /// True if |A/F| ≤ `most` is proved for a whole interval: from the paths of A and F, or because
    /// `most`²|F|² − |A|² cannot reach 0 with the second derivative it has.
    pub(crate) fn stays_below(subject: &SampledLoop, a: &Self, b: &Self, most: f64) -> bool {
        let (plant, feedback) = Self::bounds(subject, a, b);
        let sum = |terms: &Self| terms.plant + terms.feedback;
        let path = plant.travel + feedback.travel;
        let least = 0.5 * (sum(a).norm() + sum(b).norm() - path);
        if least > 0.0 && plant.size <= most * least {
            return true;
        }
        let whole = Bounds {
            size: plant.size + feedback.size,
            rate: plant.rate + feedback.rate,
            bend: plant.bend + feedback.bend,
            travel: path,
        };
        let bend = most * most * whole.times(whole).bend + plant.times(plant).bend;
        let room = |terms: &Self| most * most * sum(terms).norm_sqr() - terms.plant.norm_sqr();
        let width = b.theta() - a.theta();
        room(a).min(room(b)) > 0.125 * width * width * bend
    }
}
