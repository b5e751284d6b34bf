//! A transfer function, sample by sample.

use crate::{
    ControlError, FractionalTransferFunction, PowerMemory,
    memory::{Chain, ChainHistory, Integral, LEVELS},
};
use fracdiff::{
    BDF2_TAPS, Differintegrator, Fir, FirHistory, FrequencyResponse, Real, Seconds,
    parameter::RangeError,
};
use num_complex::Complex;

/// Different orders in one function at most: counting numerator and denominator together.
pub const ORDERS_MAX: usize = 16;
/// Largest number of different fractional parts among the orders.
pub const PARTS_MAX: usize = 8;

/// A [`FractionalTransferFunction`] that runs: two phases, the whole past, `f32` or `f64`.
/// ```text
/// Σ a_i D^(α_i) ξ = u,   y = Σ b_i D^(β_i) ξ,   v = D^α ξ with the largest α
/// D^(α_i) ξ = f_i ∗ I^(α − α_i) v,   f_i the short filter of the rule, I by Grünwald weights
/// v[n] = (u[n] − Σ a_i·past_i)/Σ a_i·g_i,   y[n] = Σ b_i·(g_i·v[n] + past_i) = G·u[n] + S[n]
/// ```
/// Only integrals of one signal are remembered. Orders with the same fractional part share one
/// memory, so those of a commensurate function of order 1/2 have one for all. Rounding acts as
/// noise of the input does: it accumulates no error and loses no digits.
///
/// - *Units*: u any, y that times G's, T s. *Start-up*: zero for ever before.
/// - *Convergence*: O(T) with [`Rule::Grunwald`](crate::Rule::Grunwald), O(T²) with [`Rule::Bdf2`](crate::Rule::Bdf2) for an input that starts
///   smoothly. A step lies between two samples: halve its first sample.
/// - *Held input*: where u comes out of a hold, feed the mean of newest and last command.
/// - *Not finite*: no output is finite until reset. *Cost*: `output` a multiply-add; `advance` as one full memory for each
///   fractional part, and for [`Rule::Bdf2`](crate::Rule::Bdf2) 27 multiply-adds for each order.
/// - MODES: a multiple of 8; 64 are enough for 1e-6 over a day at 1 kHz.
/// ```
/// use fracdiff::{Channel, Seconds};
/// use fractional_control::{FractionalTransferFunction, PowerMemory, Rule, SampledTransferFunction};
///
/// let plant: FractionalTransferFunction = "1/(0.8s^2.2+0.5s^0.9+1)".parse()?;
/// let memory = PowerMemory::new(Rule::Bdf2, 1e-6, 100.0)?;
/// let mut plant = Channel::new(SampledTransferFunction::<f64>::new(&plant, memory, Seconds(0.01))?);
/// let mut y = plant.step(0.5); // the first sample of a step, halved
/// for _ in 0..10_000 {
///     y = plant.step(1.0);
/// }
/// assert!((y - 1.0).abs() < 0.02); // it creeps to its end as t^(−0.9)
/// # Ok::<(), fractional_control::ControlError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SampledTransferFunction<F, const MODES: usize = 64> {
    chains: [Option<Chain<F, MODES>>; PARTS_MAX],
    parts: [Option<Part<F>>; ORDERS_MAX],
    /// Whole sums that the deepest level has.
    sums: usize,
    /// The part of order 0, if it has an a₀.
    constant: Option<usize>,
    /// 1/Σ `a_i·g_i`.
    inverse: F,
    direct: F,
}

/// One order: its place in a chain, its coefficients, its filter.
#[derive(Clone, Debug, PartialEq)]
struct Part<F> {
    chain: usize,
    level: usize,
    below: F,
    above: F,
    filter: Fir<F, BDF2_TAPS>,
}

/// History of [`SampledTransferFunction`].
#[derive(Clone, Debug, PartialEq)]
pub struct SampledHistory<F, const MODES: usize> {
    chains: [Option<ChainHistory<F, MODES>>; PARTS_MAX],
    filters: [Option<FirHistory<F, BDF2_TAPS>>; ORDERS_MAX],
    /// Σ `a_i·past_i`.
    fed_back: F,
    past: F,
}

/// An order of a function with both its coefficients, and its distance from the highest: fraction and whole part.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Entry {
    pub order: f64,
    pub below: f64,
    pub above: f64,
    pub fraction: f64,
    pub level: usize,
}

/// All orders of a function, highest first.
pub(crate) fn entries(
    function: &FractionalTransferFunction,
) -> Result<([Entry; ORDERS_MAX], usize), ControlError> {
    let mut all = [Entry::default(); ORDERS_MAX];
    let mut count = 0;
    let parts = [
        (function.denominator(), true),
        (function.numerator(), false),
    ];
    let highest = function.denominator().degree();
    for (polynomial, below) in parts {
        for term in polynomial.terms() {
            let known = all[..count].iter();
            let same = known
                .clone()
                .position(|e| (e.order - term.order).abs() < 1e-9);
            let index = same.unwrap_or(count);
            if index == ORDERS_MAX {
                let (count, most) = (ORDERS_MAX + 1, ORDERS_MAX);
                return Err(ControlError::TooManyTerms { count, most });
            }
            count = count.max(index + 1);
            let (level, fraction) = split(highest - term.order);
            let entry = &mut all[index];
            (entry.order, entry.level, entry.fraction) = (term.order, level, fraction);
            if below {
                entry.below = term.coefficient;
            } else {
                entry.above = term.coefficient;
            }
        }
    }
    Ok((all, count))
}

/// The fractions ν of the memories I^ν that a function runs with, one for each order; none of a function with too many of them.
pub fn fractions(function: &FractionalTransferFunction) -> impl Iterator<Item = f64> + use<> {
    let (entries, count) = entries(function).unwrap_or_default();
    entries.into_iter().take(count).map(|entry| entry.fraction)
}

/// Whole part and fraction of a distance of orders; next to a whole number it is that.
fn split(distance: f64) -> (usize, f64) {
    let nearest = libm::round(distance);
    if (distance - nearest).abs() < 1e-9 {
        return (nearest as usize, 0.0);
    }
    let whole = libm::floor(distance);
    (whole as usize, distance - whole)
}

impl<F: Real, const MODES: usize> SampledTransferFunction<F, MODES> {
    /// Coefficients in `f64`, rounded once.
    ///
    /// # Errors
    /// More than [`ORDERS_MAX`] orders or [`PARTS_MAX`] fractional parts; a tolerance or horizon that no memory of MODES modes
    /// reaches; a sample time outside 1e-9 s to 1e6 s, or so long that the newest output does not follow from the newest input.
    pub fn new(
        function: &FractionalTransferFunction,
        memory: PowerMemory,
        sample_time: Seconds,
    ) -> Result<Self, ControlError> {
        let integral = |fraction| memory.integral(fraction, sample_time);
        Self::of_integrals(function, memory, sample_time, integral)
    }

    /// Function from memories that the caller makes, or has: of each of [`fractions`], by [`PowerMemory::integral`].
    ///
    /// # Errors
    /// As [`new`](Self::new), and those of `integral`.
    pub fn of_integrals(
        function: &FractionalTransferFunction,
        memory: PowerMemory,
        sample_time: Seconds,
        integral: impl Fn(f64) -> Result<Integral<F, MODES>, ControlError>,
    ) -> Result<Self, ControlError> {
        let (entries, count) = entries(function)?;
        let entries = &entries[..count];
        let mut chains: [Option<Chain<F, MODES>>; PARTS_MAX] = [const { None }; PARTS_MAX];
        let mut parts: [Option<Part<F>>; ORDERS_MAX] = [const { None }; ORDERS_MAX];
        let (mut below, mut above) = (0.0, 0.0);
        for (part, entry) in parts.iter_mut().zip(entries) {
            let same = |e: &Entry| (e.fraction - entry.fraction).abs() < 1e-9;
            let known = chains.iter().flatten();
            let place = known
                .clone()
                .position(|c| (c.fraction - entry.fraction).abs() < 1e-9);
            let place = place.unwrap_or_else(|| known.count());
            let Some(slot) = chains.get_mut(place) else {
                let (count, most) = (PARTS_MAX + 1, PARTS_MAX);
                return Err(ControlError::TooManyTerms { count, most });
            };
            if slot.is_none() {
                let sums = entries.iter().filter(|e| same(e)).map(|e| e.level).max();
                let sums = sums.unwrap_or(0);
                let integral = integral(entry.fraction)?;
                *slot = Some(Chain::new(entry.fraction, sums, integral, sample_time));
            }
            let (taps, used) = memory.filter(entry.order);
            // f₀·T^(ν+m)
            let gain = taps[0] * libm::pow(sample_time.0, entry.fraction + entry.level as f64);
            below += entry.below * gain;
            above += entry.above * gain;
            let taps = taps.map(F::from_f64);
            *part = Some(Part {
                chain: place,
                level: entry.level,
                below: F::from_f64(entry.below),
                above: F::from_f64(entry.above),
                filter: Fir::from_slice(&taps[..used]).map_err(|_| ControlError::Empty {
                    what: "short filter",
                })?,
            });
        }
        let well = below.is_finite() && below.abs() > 1e-12 * entries[0].below.abs();
        if !well {
            let allowed = "short enough for this function: its newest output does not follow from its newest input";
            return Err(RangeError::new("sample time", sample_time.0, allowed, "s").into());
        }
        let sums = entries.iter().map(|e| e.level).max().unwrap_or(0);
        Ok(Self {
            chains,
            parts,
            sums,
            constant: (entries.iter()).position(|e| e.order.abs() < 1e-9 && e.below != 0.0),
            inverse: F::from_f64(1.0 / below),
            direct: F::from_f64(above / below),
        })
    }

    /// S\[n\] and what is fed back, from what the chains and filters hold.
    #[inline]
    fn refresh(&self, history: &mut SampledHistory<F, MODES>) {
        let mut past = [[F::ZERO; LEVELS]; PARTS_MAX];
        for ((past, chain), state) in past.iter_mut().zip(&self.chains).zip(&history.chains) {
            if let (Some(chain), Some(state)) = (chain, state) {
                *past = chain.past(state);
            }
        }
        let (mut fed_back, mut forward) = (F::ZERO, F::ZERO);
        for (part, filter) in self.parts.iter().zip(&history.filters) {
            let (Some(part), Some(filter)) = (part, filter) else {
                break;
            };
            let level = past.get(part.chain).and_then(|p| p.get(part.level));
            let value = part
                .filter
                .output(filter, level.copied().unwrap_or_default());
            fed_back += part.below * value;
            forward += part.above * value;
        }
        history.fed_back = fed_back;
        history.past = forward - self.direct * fed_back;
    }
}

impl<F: Real, const MODES: usize> Differintegrator<F> for SampledTransferFunction<F, MODES> {
    type History = SampledHistory<F, MODES>;

    fn at_rest(&self) -> Self::History {
        let chain = |chain: &Option<Chain<F, MODES>>| chain.as_ref().map(Chain::at_rest);
        let filter = |part: &Option<Part<F>>| part.as_ref().map(|part| part.filter.at_rest());
        SampledHistory {
            chains: self.chains.each_ref().map(chain),
            filters: self.parts.each_ref().map(filter),
            fed_back: F::ZERO,
            past: F::ZERO,
        }
    }

    /// ξ = u/a₀ stands, and all its powers are 0. Without a₀ there is a pole at rest.
    fn settled(&self, u: F) -> Option<Self::History> {
        let mut history = self.at_rest();
        if u != F::ZERO {
            let part = self.parts.get(self.constant?)?.as_ref()?;
            let chain = self.chains.get(part.chain)?.as_ref()?;
            let standing = chain.standing(part.level, u / part.below)?;
            *history.chains.get_mut(part.chain)? = Some(standing);
            self.refresh(&mut history);
        }
        Some(history)
    }

    #[inline]
    fn direct_gain(&self) -> F {
        self.direct
    }

    #[inline]
    fn past(&self, history: &Self::History) -> F {
        history.past
    }

    #[inline]
    fn advance(&self, history: &mut Self::History, u: F) {
        let v = (u - history.fed_back) * self.inverse;
        let mut outputs = [[F::ZERO; LEVELS]; PARTS_MAX];
        let chains = self.chains.iter().zip(&mut history.chains);
        for (outputs, (chain, state)) in outputs.iter_mut().zip(chains) {
            if let (Some(chain), Some(state)) = (chain, state) {
                *outputs = chain.advance(state, v);
            }
        }
        for (part, filter) in self.parts.iter().zip(&mut history.filters) {
            let (Some(part), Some(filter)) = (part, filter) else {
                break;
            };
            let level = outputs.get(part.chain).and_then(|o| o.get(part.level));
            part.filter
                .advance(filter, level.copied().unwrap_or_default());
        }
        self.refresh(history);
    }

    fn memory_length(&self) -> Option<usize> {
        None
    }
}

impl<F: Real, const MODES: usize> FrequencyResponse for SampledTransferFunction<F, MODES> {
    /// y/u at the angle θ, of the weights held. At rest that of a pole there is infinite.
    fn response(&self, theta: f64) -> Complex<f64> {
        let zero = Complex::new(0.0, 0.0);
        let (mut above, mut below) = (zero, zero);
        for part in self.parts.iter().flatten() {
            let Some(Some(chain)) = self.chains.get(part.chain) else {
                continue;
            };
            let branch = chain.response(theta, part.level, self.sums) * part.filter.response(theta);
            above += branch * part.above.to_f64();
            below += branch * part.below.to_f64();
        }
        above / below
    }
}
