//! How much later the force of a stable loop may come: the delay margin, behind the hold.
//! ```text
//! F(w; τ) = A(w) + w^(k+1)·N(w; h)·(α + βP(w)),   k + h = d + τ, the delay with τ samples more;   the least τ with F = 0, |w| = 1
//! ```
//! A part of a sample is no turn of the phase: the held force then changes inside a sample, and N is another. For one part h the
//! angles with |GH| = 1 are the same for every k, as |w^k| = 1, and each gives the k, in general not whole, at which its phase
//! meets −1. So a few parts of a sample tell of every delay, however long, where the first zero is; there it is narrowed.

use crate::characteristic::Characteristic;
use crate::curve::Bounds;
use crate::margin::{AtAngle, Terms};
use crate::{AnalysisError, SampledLoop};
use core::f64::consts::PI;

/// Parts of a sample that are looked at, at least and at most.
const PARTS: [f64; 2] = [16.0, 64.0];
/// Parts of a sample for each radian that the plant turns within one.
const PARTS_A_RADIAN: f64 = 4.0;
/// Parts of such a part that are looked at where the verdict does not turn from one to the next.
const FINER: u32 = 32;
/// Times the loop may come near a zero, and miss it, before its margin.
const NEAR_MISSES: usize = 64;
/// Steps towards a zero at most.
const STEPS: usize = 60;
/// A delay is known to this share of it.
const KNOWN: f64 = 1e-12;
/// What is left of a delay, as a share of it, where a zero is met: a delay so near a whole one is that.
const MET: f64 = 1e-9;
/// The verdicts so near a zero, as a share of it, must differ.
const BESIDE: f64 = 1e-7;

/// What is known of the delays with one part of a sample.
#[derive(Clone, Debug)]
struct Part {
    /// The part, more than the present delay.
    more: f64,
    /// True if the loop is stable with the part alone.
    stable: bool,
    /// The angles at which |GH| = 1, and the turn, −π to π, that takes GH to −1 there.
    crossovers: Vec<(f64, f64)>,
    /// |GH| ≥ 1 at w = −1, where each whole sample turns GH round.
    turned: bool,
}

#[derive(Clone, Copy, Debug)]
struct Beyond {
    /// One that is looked at, the first beyond a zero.
    delay: f64,
    /// About where the zero is.
    zero: AtAngle,
}

impl Part {
    /// The first whole delay more than this that is beyond a zero, for a loop that is stable with all looked at before.
    fn beyond(&self, after: f64) -> Option<Beyond> {
        if !self.stable {
            let value = self.more;
            let zero = AtAngle::new(value, PI);
            return Some(Beyond { delay: value, zero });
        }
        // The last delay of this part that was looked at.
        let last = libm::floor(after - self.more).max(0.0);
        // A stable loop has 1 + GH > 0 at w = −1, so |GH| ≥ 1 means GH ≥ 1, and one sample more gives 1 − GH ≤ 0.
        let turned = self.turned.then_some(AtAngle::new(last + 1.0, PI));
        let zeros = self.crossovers.iter().map(|&(theta, turn)| {
            let turns = libm::floor((last * theta - turn) / (2.0 * PI)) + 1.0;
            AtAngle::new((turn + 2.0 * PI * turns) / theta, theta)
        });
        let first = zeros
            .chain(turned)
            .min_by(|a, b| a.value.total_cmp(&b.value))?;
        Some(Beyond {
            delay: libm::ceil(first.value).max(last + 1.0) + self.more,
            zero: AtAngle {
                value: first.value + self.more,
                ..first
            },
        })
    }
}

impl SampledLoop<'_> {
    pub(crate) fn delay_margin(&self) -> Option<AtAngle> {
        let turn = PARTS_A_RADIAN * self.characteristic.plant.turn();
        let count = libm::ceil(turn).clamp(PARTS[0], PARTS[1]);
        let parts = self.parts(count);
        let mut after = 0.0;
        for _ in 0..NEAR_MISSES {
            let next = parts.iter().filter_map(|part| part.beyond(after));
            let next = next.min_by(|a, b| a.delay.total_cmp(&b.delay))?;
            let zero = self.narrowed(&next, 1.0 / count);
            if zero.is_some() {
                return zero;
            }
            // A swing that came near −1 between two whole delays.
            after = next.delay;
        }
        None
    }

    /// So many parts of a sample, up to the first with which the loop is not stable.
    fn parts(&self, count: f64) -> Vec<Part> {
        let mut parts = Vec::new();
        for part in 0..count as u32 {
            let more = f64::from(part) / count;
            // Of more than the longest delay nothing is known.
            let Ok(late) = self.later_by(more) else {
                break;
            };
            let stable = part == 0 || late.is_stable();
            parts.push(Part {
                more,
                stable,
                crossovers: late.crossovers(),
                turned: late.loop_gain(PI).norm() >= 1.0,
            });
            if !stable {
                break;
            }
        }
        parts
    }

    /// The zero before a delay that seems to be beyond one, by less than this step; `None` if there is none.
    fn narrowed(&self, beyond: &Beyond, step: f64) -> Option<AtAngle> {
        let (low, high) = ((beyond.delay - step).max(0.0), beyond.delay);
        // Poles outside the circle; of more than the longest delay there is no verdict.
        let outside = |delay: f64| self.later_by(delay).ok().map(|late| late.count().zeros);
        if let Some(found) = self.by_phase(beyond.zero, low, high + step) {
            let before = outside(found.value * (1.0 - BESIDE));
            let after = outside(found.value * (1.0 + BESIDE));
            let known = before.is_some() && after.is_some();
            let lost = |poles: Option<usize>| poles.is_some_and(|poles| poles > 0);
            if !known || (!before.is_some_and(lost) && after != Some(Some(0))) {
                return Some(found);
            }
        }
        // A loop that is lost for less than the step is back beyond it.
        let mut inside = low;
        for k in 1..=FINER {
            let tried = low + (high - low) * f64::from(k) / f64::from(FINER);
            if outside(tried)? != Some(0) {
                return Some(self.by_verdicts(inside, tried, beyond.zero.theta));
            }
            inside = tried;
        }
        None
    }

    /// The delay near one, within two, at which the phase of a crossover is that of −1, by steps of what is left of it.
    fn by_phase(&self, near: AtAngle, low: f64, high: f64) -> Option<AtAngle> {
        let (mut delay, mut theta) = (near.value.clamp(low, high), near.theta);
        for _ in 0..STEPS {
            let left = self.back_at(delay, theta)?;
            let next = (delay + left.value).clamp(low, high);
            let moved = next - delay;
            (delay, theta) = (next, left.theta);
            if moved.abs() <= KNOWN * delay {
                let met = left.value.abs() <= MET * delay.max(1.0);
                return met.then_some(AtAngle::new(delay, theta));
            }
        }
        None
    }

    /// What is left at a delay, in samples, of the crossover next to an angle: below 0 beyond −1.
    fn back_at(&self, delay: f64, theta: f64) -> Option<AtAngle> {
        let total = self.plant().path().delay_samples() + delay;
        // Whole samples turn the phase alone, and are not bounded so.
        let prompt = self.delayed_by(total - libm::floor(total)).ok()?;
        let more = libm::rint(total - prompt.plant().path().delay_samples());
        let away = |at: f64| libm::log(at / theta).abs();
        let crossovers = prompt.crossovers().into_iter();
        let (theta, turn) = crossovers.min_by(|a, b| away(a.0).total_cmp(&away(b.0)))?;
        let left = turn - more * theta;
        let turns = libm::rint(left / (2.0 * PI));
        Some(AtAngle::new((left - turns * 2.0 * PI) / theta, theta))
    }

    /// The delay at which the verdict turns, between one at which the loop is stable and one at which it is not.
    fn by_verdicts(&self, mut low: f64, mut high: f64, theta: f64) -> AtAngle {
        let mut theta = theta;
        while high - low > KNOWN * high {
            let middle = 0.5 * (low + high);
            let Ok(late) = self.later_by(middle) else {
                break;
            };
            let verdict = late.verdict();
            if middle <= low || middle >= high {
                break;
            }
            theta = verdict.theta;
            if verdict.stable {
                low = middle;
            } else {
                high = middle;
            }
        }
        AtAngle::new(high, theta)
    }

    /// The angles at which |GH| = 1, and the turn, −π to π, that takes GH to −1 there.
    fn crossovers(&self) -> Vec<(f64, f64)> {
        let excess = |at: &Terms| {
            let rate = at.feedback_rate * at.feedback.conj() - at.plant_rate * at.plant.conj();
            let excess = at.feedback.norm_sqr() - at.plant.norm_sqr();
            [excess, 2.0 * rate.re]
        };
        let bend = |plant: Bounds, feedback: Bounds| {
            plant.times(plant).bend + feedback.times(feedback).bend
        };
        // |GH| is the same without the whole samples, and found sooner.
        let path = self.plant().path();
        let prompt = self.delayed_by(path.fraction()).unwrap_or(*self);
        let angles = prompt.zeros(excess, bend).into_iter();
        angles
            .map(|theta| (theta, (-self.loop_gain(theta)).arg()))
            .collect()
    }

    fn later_by(&self, samples: f64) -> Result<Self, AnalysisError> {
        self.delayed_by(self.plant().path().delay_samples() + samples)
    }

    /// The same loop with another delay in all, samples.
    fn delayed_by(&self, samples: f64) -> Result<Self, AnalysisError> {
        let plant = self.characteristic.plant.delayed_by(samples)?;
        Ok(Self {
            characteristic: Characteristic {
                plant,
                ..self.characteristic
            },
            ..*self
        })
    }
}
