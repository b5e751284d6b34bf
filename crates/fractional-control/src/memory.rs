//! The way powers of s are put into samples: the rule, and how far and how well it is remembered.

use crate::ControlError;
use fracdiff::full_memory::{Design, HORIZON_MIN, Kernel};
use fracdiff::parameter::positive;
use fracdiff::{
    BDF2_TAPS, Bdf2History, Bdf2Memory, Differintegrator, FrequencyResponse, FullMemory,
    FullMemoryHistory, Order, Real, Seconds, bdf2_short_filter,
};
use num_complex::Complex;

/// Recent samples that each memory keeps as they are.
pub(crate) const TAPS: usize = 16;

/// The function of w that stands for s.
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
///
/// ```
/// use fractional_control::{Memory, Rule};
///
/// // 200 s within 1e-6; the fewest modes are for where there is time to search.
/// let memory = Memory::new(Rule::Bdf2, 1e-6, 200.0)?;
/// assert!(Memory::new(Rule::Bdf2, 1e-6, -1.0).is_err());
/// # Ok::<(), fractional_control::ControlError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Memory {
    rule: Rule,
    tolerance: f64,
    horizon_s: f64,
    pruned: bool,
}

impl Memory {
    /// With modes in closed form, made in microseconds without an allocation.
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

    /// The same with the fewest modes that reach the tolerance: half as many, made in milliseconds.
    #[cfg(feature = "std")]
    #[must_use]
    pub fn fewest_modes(self) -> Self {
        Self {
            pruned: true,
            ..self
        }
    }

    /// The rule.
    #[must_use]
    pub fn rule(&self) -> Rule {
        self.rule
    }

    /// The horizon, s.
    #[must_use]
    pub fn horizon_s(&self) -> f64 {
        self.horizon_s
    }

    /// The design of D^order.
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

    /// D^order, −2 ≤ order ≤ 2.
    pub(crate) fn power<F: Real, const MODES: usize>(
        &self,
        order: Order,
        sample_time: Seconds,
    ) -> Result<Power<F, MODES>, ControlError> {
        let design = self.design(order, sample_time)?;
        Ok(match self.rule {
            Rule::Grunwald => Power::First(FullMemory::new(&design, sample_time)?),
            Rule::Bdf2 => Power::Second(Bdf2Memory::new(&design, sample_time)?),
        })
    }
}

/// D^μ by either rule.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Power<F, const MODES: usize> {
    First(FullMemory<F, TAPS, MODES>),
    Second(Bdf2Memory<F, TAPS, MODES>),
}

/// History of [`Power`].
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum PowerHistory<F, const MODES: usize> {
    First(FullMemoryHistory<F, TAPS, MODES>),
    Second(Bdf2History<F, TAPS, MODES>),
}

impl<F: Real, const MODES: usize> Power<F, MODES> {
    pub(crate) fn at_rest(&self) -> PowerHistory<F, MODES> {
        match self {
            Self::First(o) => PowerHistory::First(o.at_rest()),
            Self::Second(o) => PowerHistory::Second(o.at_rest()),
        }
    }

    /// The history of a constant that always was, where that has an end; else at rest.
    pub(crate) fn settled(&self, x: F) -> PowerHistory<F, MODES> {
        let settled = match self {
            Self::First(o) => o.settled(x).map(PowerHistory::First),
            Self::Second(o) => o.settled(x).map(PowerHistory::Second),
        };
        settled.unwrap_or_else(|| self.at_rest())
    }

    pub(crate) fn direct_gain(&self) -> F {
        match self {
            Self::First(o) => o.direct_gain(),
            Self::Second(o) => o.direct_gain(),
        }
    }

    #[inline]
    pub(crate) fn output(&self, history: &PowerHistory<F, MODES>, x: F) -> F {
        match (self, history) {
            (Self::First(o), PowerHistory::First(h)) => o.output(h, x),
            (Self::Second(o), PowerHistory::Second(h)) => o.output(h, x),
            _ => F::from_f64(f64::NAN),
        }
    }

    #[inline]
    pub(crate) fn advance(&self, history: &mut PowerHistory<F, MODES>, x: F) {
        match (self, history) {
            (Self::First(o), PowerHistory::First(h)) => o.advance(h, x),
            (Self::Second(o), PowerHistory::Second(h)) => o.advance(h, x),
            _ => {}
        }
    }

    /// P, without T^(−μ).
    pub(crate) fn response(&self, theta: f64) -> Complex<f64> {
        match self {
            Self::First(o) => o.response(theta),
            Self::Second(o) => o.response(theta),
        }
    }
}
