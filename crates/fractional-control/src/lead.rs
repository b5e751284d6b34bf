//! Powers of a lead or lag, sample by sample.

use crate::{ControlError, PowerMemory, memory::TAPS};
use fracdiff::{
    Differintegrator, FrequencyResponse, FullMemory, FullMemoryHistory, Order, Real, Seconds,
    full_memory::{DecayingMode, Design},
    grunwald_weight,
    parameter::{positive, range},
};
use num_complex::Complex;

/// `((1 + s/ω_b)/(1 + s/ω_h))^ν` under the Tustin rule, ν from −2 to 2.
/// ```text
/// 1 + s/ω → (1 + A)(1 − p·w)/(1 + w),   A = 2/(ωT),   p = (A − 1)/(A + 1):   the 1 + w of both cancel
/// (1 − pw)^φ = (1 − pw)·Σ c_j(φ − 1)·p^j w^j,   (1 − qw)^(−φ) = Σ c_j(−φ)·q^j w^j,   0 < φ < 1
/// ```
/// Both sums are full memories whose modes decay faster by ln p and ln q: positive weights, stable.
#[derive(Clone, Debug, PartialEq)]
pub struct LeadPower<F, const MODES: usize> {
    /// Whole sections (1 − pw)/(1 − qw).
    pub(crate) sections: usize,
    /// p and q, of zero and pole.
    pub(crate) zero: F,
    pub(crate) pole: F,
    /// Memories of order φ − 1 with p, and of −φ with q; `None` where φ is 0.
    pub(crate) memories: Option<[Option<FullMemory<F, TAPS, MODES>>; 2]>,
}

/// History of [`LeadPower`].
#[derive(Clone, Debug, PartialEq)]
pub struct LeadPowerHistory<F, const MODES: usize> {
    /// x\[n−1\] and y\[n−1\] of each section.
    sections: [(F, F); 2],
    /// x\[n−1\] of the factor 1 − pw.
    last: F,
    memories: [Option<FullMemoryHistory<F, TAPS, MODES>>; 2],
}

/// p of a corner; refuses one beyond 2/T, where it would be negative.
fn corner(what: &'static str, omega: f64, sample_time: Seconds) -> Result<f64, ControlError> {
    positive(what, omega, "rad/s")?;
    let a = 2.0 / (omega * sample_time.0);
    let allowed = "at most 2/T, twice the sample rate";
    range(what, omega, a >= 1.0, allowed, "rad/s")?;
    Ok((a - 1.0) / (a + 1.0))
}

/// `k·f·((1 + s/ω_z)/(1 + s/ω_p))^ν`: both CRONE and lead–lag have this shape.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LeadShape {
    pub gain: f64,
    pub factor: f64,
    pub order: f64,
    pub zero_rad_s: f64,
    pub pole_rad_s: f64,
}

/// The parts of a power of a lead, in `f64`.
#[derive(Clone, Debug)]
pub(crate) struct LeadParts<const MODES: usize> {
    /// ((1 + A)/(1 + B))^ν.
    pub gain: f64,
    /// Whole sections (1 − pw)/(1 − qw).
    pub sections: usize,
    pub zero: f64,
    pub pole: f64,
    /// Memories of order φ − 1 with p, and of −φ with q.
    pub memories: Option<[Option<Design<TAPS, MODES>>; 2]>,
}

pub(crate) fn parts<const MODES: usize>(
    shape: &LeadShape,
    memory: &PowerMemory,
    sample_time: Seconds,
) -> Result<LeadParts<MODES>, ControlError> {
    let order = Order::new(shape.order)?.get();
    // Also for whole orders: the sample time is checked.
    sample_time.rate_to_the(Order::new(0.0)?)?;
    let (p, q) = (
        corner("corner of the zero", shape.zero_rad_s, sample_time)?,
        corner("corner of the pole", shape.pole_rad_s, sample_time)?,
    );
    // A negative power is a positive one of the inverse.
    let (power, zero, pole) = if order < 0.0 {
        (-order, q, p)
    } else {
        (order, p, q)
    };
    let sections = libm::trunc(power);
    let fraction = power - sections;
    let memories = if fraction < 1e-12 {
        None
    } else {
        Some([
            tempered(1.0 - fraction, zero, memory, sample_time)?,
            tempered(fraction, pole, memory, sample_time)?,
        ])
    };
    Ok(LeadParts {
        // 1 + A = 2/(1 − p)
        gain: libm::pow((1.0 - q) / (1.0 - p), order),
        sections: sections as usize,
        zero,
        pole,
        memories,
    })
}

/// Σ `c_j(−order)·p^j·w^j`; `None` for p = 0, where it is 1.
fn tempered<const MODES: usize>(
    order: f64,
    p: f64,
    memory: &PowerMemory,
    sample_time: Seconds,
) -> Result<Option<Design<TAPS, MODES>>, ControlError> {
    if p <= 0.0 {
        return Ok(None);
    }
    let (order, faster) = (Order::new(-order)?, -libm::log(p));
    let plain = memory.design::<MODES>(order, sample_time)?;
    let mut modes = [DecayingMode::default(); MODES];
    for (slot, mode) in modes.iter_mut().zip(plain.modes()) {
        *slot = DecayingMode {
            rate: mode.rate + faster,
            ..*mode
        };
    }
    let weight = |lag: u64| grunwald_weight(order, lag) * libm::exp(-faster * lag as f64);
    let modes = &modes[..plain.modes().len()];
    let design = Design::<TAPS, MODES>::from_modes(order, weight, modes, plain.horizon())?;
    Ok(Some(design))
}

impl<F: Real, const MODES: usize> LeadPower<F, MODES> {
    /// The operator, and the gain that it leaves out.
    pub(crate) fn new(
        shape: &LeadShape,
        memory: &PowerMemory,
        sample_time: Seconds,
    ) -> Result<(Self, f64), ControlError> {
        let parts = parts(shape, memory, sample_time)?;
        // T = 1: the powers of T are in the corners already.
        let run = |design: &Option<Design<TAPS, MODES>>| match design {
            Some(design) => FullMemory::new(design, Seconds(1.0)).map(Some),
            None => Ok(None),
        };
        let memories = match &parts.memories {
            Some([zero, pole]) => Some([run(zero)?, run(pole)?]),
            None => None,
        };
        let operator = Self {
            sections: parts.sections,
            zero: F::from_f64(parts.zero),
            pole: F::from_f64(parts.pole),
            memories,
        };
        Ok((operator, parts.gain))
    }
}

impl<F: Real, const MODES: usize> Differintegrator<F> for LeadPower<F, MODES> {
    type History = LeadPowerHistory<F, MODES>;

    fn at_rest(&self) -> Self::History {
        let memory = |index: usize| {
            let memories = self.memories.as_ref()?;
            let memory = memories.get(index)?.as_ref();
            memory.map(Differintegrator::at_rest)
        };
        LeadPowerHistory {
            sections: [(F::ZERO, F::ZERO); 2],
            last: F::ZERO,
            memories: core::array::from_fn(memory),
        }
    }

    fn settled(&self, x: F) -> Option<Self::History> {
        let mut history = self.at_rest();
        let mut y = x;
        for section in history.sections.iter_mut().take(self.sections) {
            let next = y * (F::ONE - self.zero) / (F::ONE - self.pole);
            *section = (y, next);
            y = next;
        }
        if let Some(memories) = &self.memories {
            history.last = y;
            y = y * (F::ONE - self.zero);
            for (memory, past) in memories.iter().zip(&mut history.memories) {
                if let Some(memory) = memory {
                    *past = memory.settled(y);
                    y = past.as_ref().map_or(y, |past| memory.output(past, y));
                }
            }
        }
        Some(history)
    }

    fn direct_gain(&self) -> F {
        F::ONE
    }

    fn past(&self, history: &Self::History) -> F {
        self.output(history, F::ZERO)
    }

    fn memory_length(&self) -> Option<usize> {
        None
    }

    #[inline]
    fn output(&self, history: &Self::History, x: F) -> F {
        let mut y = x;
        for (before, past) in history.sections.iter().take(self.sections) {
            y = (y - self.zero * *before) + self.pole * *past;
        }
        if let Some(memories) = &self.memories {
            y -= self.zero * history.last;
            for (memory, past) in memories.iter().zip(&history.memories) {
                if let (Some(memory), Some(past)) = (memory, past) {
                    y = memory.output(past, y);
                }
            }
        }
        y
    }

    #[inline]
    fn advance(&self, history: &mut Self::History, x: F) {
        let mut y = x;
        for (before, past) in history.sections.iter_mut().take(self.sections) {
            let next = (y - self.zero * *before) + self.pole * *past;
            (*before, *past) = (y, next);
            y = next;
        }
        if let Some(memories) = &self.memories {
            let difference = y - self.zero * history.last;
            history.last = y;
            y = difference;
            for (memory, past) in memories.iter().zip(&mut history.memories) {
                if let (Some(memory), Some(past)) = (memory, past) {
                    let next = memory.output(past, y);
                    memory.advance(past, y);
                    y = next;
                }
            }
        }
    }
}

impl<F: Real, const MODES: usize> FrequencyResponse for LeadPower<F, MODES> {
    fn response(&self, theta: f64) -> Complex<f64> {
        let (s, c) = libm::sincos(theta);
        let factor = |p: F| Complex::new(1.0, 0.0) - Complex::new(c, -s) * p.to_f64();
        let (zero, pole) = (factor(self.zero), factor(self.pole));
        let mut all = (0..self.sections).fold(Complex::new(1.0, 0.0), |all, _| all * zero / pole);
        if let Some(memories) = &self.memories {
            all *= zero;
            for memory in memories.iter().flatten() {
                all *= memory.response(theta);
            }
        }
        all
    }
}
