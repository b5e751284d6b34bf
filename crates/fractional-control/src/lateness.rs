//! The delay margin of a plant behind a hold: a dead time of a part of a sample turns the loop otherwise than whole samples do.

use crate::{Crossing, SampledControlLoop};
use certified_count::{Late, Unknown, delay_margin};
use core::f64::consts::PI;
use std::vec::Vec;

/// Parts of a sample that are looked at.
const PARTS: u32 = 16;

impl Late for SampledControlLoop {
    fn crossovers(&self) -> Vec<(f64, f64)> {
        self.turns().collect()
    }

    fn is_turned(&self) -> bool {
        self.open(PI).norm() >= 1.0
    }

    fn lost(&self) -> Result<Option<f64>, Unknown> {
        let verdict = self.verdict();
        Ok((!verdict.stable).then_some(verdict.theta))
    }
}

impl SampledControlLoop {
    /// A delay within [`memory_s`](Self::memory_s): beyond it the loop is not the one that was asked about.
    #[must_use]
    pub fn remembered(&self, delay: Option<Crossing>) -> Option<Crossing> {
        let within = |delay: &Crossing| self.memory_s().is_none_or(|held| delay.value < held);
        delay.filter(within)
    }

    /// The delay margin of a stable loop around a plant behind a hold, s: with any smaller dead time more it is stable; `None` if no dead time loses
    /// it. That of [`margins`](Self::margins), `first`, turns the phase of L as a dead time of whole samples does; a part of a sample turns it
    /// otherwise, for the hold then switches inside a sample. `later` is the loop whose plant has so much more dead time.
    /// ```text
    /// each part h of a sample:  L(h) is lost with no fewer than (π + arg L(h))/θ whole samples more, θ its crossovers
    /// ```
    /// Sixteen parts are looked at, and the one that makes the dead time whole, where L changes most; and
    /// the delay is narrowed until the verdicts on both sides of it differ. A loop that is lost for less than a sixteenth of a sample may
    /// be missed. `first` itself of a loop that is not stable. Of a plant that follows a rule it is the margin of the plant behind its
    /// hold.
    ///
    /// # Errors
    /// As `later` gives them.
    pub fn delay_margin<E>(
        first: Option<Crossing>,
        later: &dyn Fn(f64) -> Result<Self, E>,
    ) -> Result<Option<Crossing>, E> {
        let later = |delay_s: f64| {
            let late = later(delay_s)?;
            Ok(late.of_plant().unwrap_or(late))
        };
        let prompt = later(0.0)?;
        if !prompt.verdict().stable {
            return Ok(first);
        }
        let rate = prompt.rate();
        let equal = (0..PARTS).map(|part| f64::from(part) / f64::from(PARTS));
        let mut mores: Vec<f64> = equal.chain([prompt.to_whole()]).collect();
        mores.sort_by(f64::total_cmp);
        mores.dedup();
        let zero = self::delay_margin(&|samples| later(samples / rate), &mores, 1)?;
        Ok(zero
            .map(|(samples, theta)| Crossing::new(theta * rate, samples / rate))
            .or(first))
    }
}
