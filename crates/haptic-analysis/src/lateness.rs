//! Delay margin of a stable loop: the further delay of the force, behind the hold, that it tolerates.
//! ```text
//! F(w; τ) = A(w) + w^(k+1)·N(w; h)·(α + βP(w)),   k + h = d + τ, the delay with τ samples more;   the least τ with F = 0, |w| = 1
//! ```
//! A part of a sample is no turn of the phase: the held force then changes inside a sample, and N is another. For one part h the
//! angles with |GH| = 1 are the same for every k, as |w^k| = 1, and each gives the k, in general not whole, at which its phase
//! meets −1. So a few parts of a sample give the first zero for every delay, however long; there it is narrowed.

use crate::characteristic::Characteristic;
use crate::margin::Open;
use crate::{AnalysisError, SampledLoop};
use certified_count::{AtAngle, Late, OpenLoop, Unknown, delay_margin};
use core::f64::consts::PI;

/// Least and largest number of parts of a sample that are tried.
const PARTS: [f64; 2] = [16.0, 64.0];
/// Parts of a sample for each radian that the plant turns within one.
const PARTS_A_RADIAN: f64 = 4.0;
/// Parts of such a part that are tried where the verdict does not turn from one to the next.
const FINER: u32 = 32;

/// A loop some delay later. Whole samples turn the phase alone, so its crossovers are known beyond the longest delay.
struct Later<'a> {
    prompt: SampledLoop<'a>,
    whole: f64,
    late: Option<SampledLoop<'a>>,
}

impl Late for Later<'_> {
    fn crossovers(&self) -> Vec<(f64, f64)> {
        let crossovers = self.prompt.crossovers().into_iter();
        let left = |(theta, turn): (f64, f64)| {
            let left = turn - self.whole * theta;
            (theta, left - 2.0 * PI * libm::rint(left / (2.0 * PI)))
        };
        crossovers.map(left).collect()
    }

    fn is_turned(&self) -> bool {
        self.prompt.loop_gain(PI).norm() >= 1.0
    }

    fn lost(&self) -> Result<Option<f64>, Unknown> {
        let verdict = self.late.as_ref().ok_or(Unknown)?.verdict();
        Ok((!verdict.stable).then_some(verdict.theta))
    }
}

impl SampledLoop<'_> {
    pub(crate) fn delay_margin(&self) -> Option<AtAngle> {
        let turn = PARTS_A_RADIAN * self.characteristic.plant.turn();
        let count = libm::ceil(turn).clamp(PARTS[0], PARTS[1]);
        let parts = 0..count as u32;
        let mores: Vec<f64> = parts.map(|part| f64::from(part) / count).collect();
        let delay = self.plant().path().delay_samples();
        let later = |samples: f64| {
            let total = delay + samples;
            let prompt = self.delayed_by(total - libm::floor(total))?;
            let whole = libm::rint(total - prompt.plant().path().delay_samples());
            // Of the prompt one, whose numerator behind this part of a sample is worked out.
            let late = prompt.delayed_by(total).ok();
            Ok::<_, AnalysisError>(Later {
                prompt,
                whole,
                late,
            })
        };
        let zero = delay_margin(&later, &mores, FINER).ok()?;
        zero.map(|(delay, theta)| AtAngle::new(delay, theta))
    }

    /// The angles at which |GH| = 1, and the turn, −π to π, that takes GH to −1 there.
    fn crossovers(&self) -> Vec<(f64, f64)> {
        // |GH| is the same without the whole samples, and found sooner.
        let path = self.plant().path();
        let prompt = self.delayed_by(path.fraction()).unwrap_or(*self);
        let angles = Open(&prompt).crossovers().into_iter();
        angles
            .map(|theta| (theta, (-self.loop_gain(theta)).arg()))
            .collect()
    }

    /// Replaces the total delay, samples.
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
