//! Integrals of one signal: one memory for each fractional part of an order, and whole sums behind it.
//!
//! ```text
//! q₀ = I^ν v,   q_m[n] = q_m[n−1] + T·q_{m−1}[n],   so q_m = I^(ν+m) v
//! ```

use crate::memory::TAPS;
use crate::{ControlError, Memory};
use fracdiff::{
    Differintegrator, FrequencyResponse, FullMemory, FullMemoryHistory, Order, Real, Seconds,
};
use num_complex::Complex;

/// Whole sums behind a memory at most: orders differ by 4 at most.
pub(crate) const SUMS_MAX: usize = 4;
/// Outputs of a chain: the memory's own, and those of the sums.
pub(crate) const LEVELS: usize = SUMS_MAX + 1;

/// I^ν, I^(ν+1), … of one signal, 0 ≤ ν < 1.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Chain<F, const MODES: usize> {
    /// ν.
    pub(crate) fraction: f64,
    core: Option<FullMemory<F, TAPS, MODES>>,
    sums: usize,
    sample_time: F,
}

/// History of [`Chain`]: of the memory, and each sum with its compensation word.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ChainHistory<F, const MODES: usize> {
    core: Option<FullMemoryHistory<F, TAPS, MODES>>,
    sums: [(F, F); SUMS_MAX],
}

impl<F: Real, const MODES: usize> Chain<F, MODES> {
    pub(crate) fn new(
        fraction: f64,
        sums: usize,
        memory: &Memory,
        sample_time: Seconds,
    ) -> Result<Self, ControlError> {
        let order = Order::new(-fraction)?;
        // Also where there is no fraction: the sample time is checked.
        let core = FullMemory::new(&memory.design(order, sample_time)?, sample_time)?;
        Ok(Self {
            fraction,
            core: (fraction > 0.0).then_some(core),
            sums: sums.min(SUMS_MAX),
            sample_time: F::from_f64(sample_time.0),
        })
    }

    pub(crate) fn at_rest(&self) -> ChainHistory<F, MODES> {
        ChainHistory {
            core: self.core.as_ref().map(Differintegrator::at_rest),
            sums: [(F::ZERO, F::ZERO); SUMS_MAX],
        }
    }

    /// Takes v in; the outputs of all levels.
    #[inline]
    pub(crate) fn advance(&self, history: &mut ChainHistory<F, MODES>, v: F) -> [F; LEVELS] {
        let mut outputs = [v; LEVELS];
        if let (Some(core), Some(own)) = (&self.core, &mut history.core) {
            outputs[0] = core.output(own, v);
            core.advance(own, v);
        }
        for (level, (sum, carry)) in history.sums.iter_mut().enumerate().take(self.sums) {
            // Kahan's sum: in single precision small increments are not lost.
            let addend = self.sample_time * outputs[level] + *carry;
            let total = *sum + addend;
            let rounded = total - *sum;
            *carry = (*sum - (total - rounded)) + (addend - rounded);
            *sum = total;
            outputs[level + 1] = total;
        }
        outputs
    }

    /// The share of the past in the next output of each level.
    #[inline]
    pub(crate) fn past(&self, history: &ChainHistory<F, MODES>) -> [F; LEVELS] {
        let mut past = [F::ZERO; LEVELS];
        if let (Some(core), Some(own)) = (&self.core, &history.core) {
            past[0] = core.past(own);
        }
        for (level, (sum, carry)) in history.sums.iter().enumerate().take(self.sums) {
            past[level + 1] = *sum + (self.sample_time * past[level] + *carry);
        }
        past
    }

    /// (1 − w)^sums·I^(ν+level) at an angle: finite at rest for level ≤ sums.
    pub(crate) fn response(&self, theta: f64, level: usize, sums: usize) -> Complex<f64> {
        let t = self.sample_time.to_f64();
        let scale = libm::pow(t, self.fraction + level as f64);
        let core = match &self.core {
            Some(core) => core.response(theta),
            None => Complex::new(1.0, 0.0),
        };
        let (s, c) = libm::sincos(0.5 * theta);
        let v = Complex::new(2.0 * s * s, 2.0 * s * c);
        (level..sums).fold(core * scale, |value, _| value * v)
    }
}
