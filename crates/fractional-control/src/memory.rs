//! The way powers of s are put into samples: the rule, and how far and how well it is remembered.

use crate::ControlError;
use fracdiff::{
    BDF2_TAPS, Differintegrator, FrequencyResponse, FullMemory, FullMemoryHistory, Order, Real,
    Seconds, bdf2_short_filter,
    full_memory::{Design, HORIZON_MIN, Kernel},
    parameter::positive,
};
use num_complex::Complex;

/// Recent samples that each memory keeps as they are.
pub(crate) const TAPS: usize = 16;

/// The function of w that replaces s.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// s → (1 − w)/T: backward differences, an error of O(T).
    Grunwald,
    /// s → (3/2 − 2w + w²/2)/T: an error of O(T²) for 28 taps a power more.
    Bdf2,
}

/// Rule, tolerance and horizon of every power of s in a function or controller.
///
/// - *Tolerance*: of each weight of a memory, relative, 1e-11 to 0.1.
/// - *Horizon*: time up to which it holds, s. Beyond, a memory fades.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PowerMemory {
    rule: Rule,
    tolerance: f64,
    horizon_s: f64,
    pruned: bool,
}

impl PowerMemory {
    /// A memory whose modes have a closed form, computed in microseconds without allocating.
    ///
    /// # Errors
    /// A horizon that is not above 0. The tolerance is checked where a memory is made.
    pub fn new(rule: Rule, tolerance: f64, horizon_s: f64) -> Result<Self, ControlError> {
        Ok(Self {
            rule,
            tolerance,
            horizon_s: positive("horizon", horizon_s, "s")?,
            pruned: false,
        })
    }

    /// Uses the fewest modes that reach the tolerance: half as many, computed in milliseconds.
    #[cfg(feature = "std")]
    #[must_use]
    pub fn fewest_modes(self) -> Self {
        Self {
            pruned: true,
            ..self
        }
    }

    /// The rule that replaces s in every power.
    #[must_use]
    pub fn rule(&self) -> Rule {
        self.rule
    }

    /// Rule and tolerance, as a [`ControllerSetup`](crate::ControllerSetup) has them.
    #[cfg(feature = "std")]
    #[must_use]
    pub fn scheme(&self) -> fracdiff::Scheme {
        let tolerance = self.tolerance;
        match self.rule {
            Rule::Bdf2 => fracdiff::Scheme::FullBdf2 { tolerance },
            Rule::Grunwald => fracdiff::Scheme::Full {
                kernel: Kernel::Grunwald,
                tolerance,
            },
        }
    }

    /// The horizon, s, up to which the tolerance holds.
    #[must_use]
    pub fn horizon_s(&self) -> f64 {
        self.horizon_s
    }

    pub(crate) fn design<const MODES: usize>(
        &self,
        order: Order,
        sample_time: Seconds,
    ) -> Result<Design<TAPS, MODES>, ControlError> {
        let horizon = libm::fmax(self.horizon_s / sample_time.0, HORIZON_MIN);
        #[cfg(feature = "std")]
        if self.pruned {
            return Ok(Design::pruned(
                Kernel::Grunwald,
                order,
                self.tolerance,
                horizon,
            )?);
        }
        Ok(Design::closed_form(
            Kernel::Grunwald,
            order,
            self.tolerance,
            horizon,
        )?)
    }

    /// I^ν, 0 ≤ ν < 1; also for ν = 0 the sample time is checked.
    ///
    /// # Errors
    /// A tolerance or horizon that no memory of MODES modes reaches; a sample time outside 1e-9 s to 1e6 s.
    pub fn integral<F: Real, const MODES: usize>(
        &self,
        fraction: f64,
        sample_time: Seconds,
    ) -> Result<Integral<F, MODES>, ControlError> {
        let design = self.design(Order::new(-fraction)?, sample_time)?;
        Ok(FullMemory::new(&design, sample_time)?)
    }

    /// The short filter that the rule puts behind (1 − w)^order, and how many of its taps are not 0; for 0 ≤ order ≤ 4.
    pub(crate) fn filter(&self, order: f64) -> ([f64; BDF2_TAPS], usize) {
        let mut taps = [0.0; BDF2_TAPS];
        taps[0] = 1.0;
        if self.rule == Rule::Grunwald || order == 0.0 {
            return (taps, 1);
        }
        // ((3 − w)/2)^μ = ((3 − w)/2)^(μ/2) twice: fracdiff's orders end at 2.
        let half = Order::new(0.5 * order).map(bdf2_short_filter);
        let half = half.unwrap_or(taps);
        taps = core::array::from_fn(|lag| (0..=lag).map(|j| half[j] * half[lag - j]).sum());
        let last = taps.iter().rposition(|tap| *tap != 0.0).unwrap_or(0);
        (taps, last + 1)
    }
}

/// Whole sums behind a memory at most: orders differ by 4 at most.
const SUMS_MAX: usize = 4;
/// Outputs of a chain: the memory's own, and those of the sums.
pub(crate) const LEVELS: usize = SUMS_MAX + 1;

/// I^ν of a rule, 0 ≤ ν < 1.
pub type Integral<F, const MODES: usize> = FullMemory<F, TAPS, MODES>;

/// I^ν, I^(ν+1), … of one signal, 0 ≤ ν < 1: one memory, and whole sums behind it.
/// ```text
/// q₀ = I^ν v,   q_m[n] = q_m[n−1] + T·q_{m−1}[n],   so q_m = I^(ν+m) v
/// ```
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Chain<F, const MODES: usize> {
    pub fraction: f64,
    core: Option<Integral<F, MODES>>,
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
    /// Chain with the [`Integral`] of its fraction.
    pub(crate) fn new(
        fraction: f64,
        sums: usize,
        integral: Integral<F, MODES>,
        sample_time: Seconds,
    ) -> Self {
        Self {
            fraction,
            core: (fraction > 0.0).then_some(integral),
            sums: sums.min(SUMS_MAX),
            sample_time: F::from_f64(sample_time.0),
        }
    }

    pub(crate) fn at_rest(&self) -> ChainHistory<F, MODES> {
        ChainHistory {
            core: self.core.as_ref().map(Differintegrator::at_rest),
            sums: [(F::ZERO, F::ZERO); SUMS_MAX],
        }
    }

    /// The history in which the output of this level stands and all others are 0; `None` of a memory's own output, which fades.
    pub(crate) fn standing(&self, level: usize, output: F) -> Option<ChainHistory<F, MODES>> {
        let mut history = self.at_rest();
        if level == 0 {
            // A gain remembers nothing.
            return self.core.is_none().then_some(history);
        }
        history.sums.get_mut(level - 1)?.0 = output;
        Some(history)
    }

    /// Takes v in; the outputs of all levels.
    #[inline]
    pub(crate) fn advance(&self, history: &mut ChainHistory<F, MODES>, v: F) -> [F; LEVELS] {
        let mut outputs = [v; LEVELS];
        if let (Some(core), Some(past)) = (&self.core, &mut history.core) {
            outputs[0] = core.output(past, v);
            core.advance(past, v);
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
        if let (Some(core), Some(state)) = (&self.core, &history.core) {
            past[0] = core.past(state);
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
