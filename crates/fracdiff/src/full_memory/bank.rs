//! The operator that runs a [`Design`].

use super::design::Design;
use super::kernel::DecayingMode;
use crate::differintegrator::past_is_kept;
use crate::fir::sum_of_8;
use crate::integer_part::{IntegerHistory, WithIntegerPart, operator_from_its_core};
use crate::list::{ListError, check_decay, check_finite, check_integer};
use crate::response::{delay, geometric};
use crate::{Differintegrator, FrequencyResponse, ParameterError, Real, Seconds};
use num_complex::Complex;

/// Modes that decay faster than this per sample need no compensation word even in `f32`: a state stands still where
/// its change rounds to nothing, 2^(−25)/decay of it at most, here 2e-6. In an integral of a constant that error lasts for ever.
const FAST: f64 = 1.0 / 64.0;
/// Limit as in [`FAST`], for increments, where the error lasts only while a motion keeps one speed: 3e-5 of a mode that gives a tenth of the output.
const FAST_INCREMENTS: f64 = 1.0 / 1024.0;

/// D^μ with the whole history: TAPS recent increments and up to MODES decaying modes.
/// ```text
/// u[n] = Δ^⌈μ⌉ x[n]                        the difference, second difference, or x itself for μ ≤ 0
/// y[n] = g·u[n] + Σ_{j=1}^{TAPS−1} k_j·u[n−j] + Σ_q W_q·z_q[n]
/// z_q[n+1] = z_q[n] + (u[n] − d_q·z_q[n]),    d_q = 1 − e^(−s_q),   W_q = T^(−μ)·w_q·e^(−s_q)
/// ```
/// The modes take part from lag 1 on; `k_j` is the rest of the true weight. For μ ≤ −1 running sums of y follow.
///
/// - *Units*: x any unit \[x\], y \[x\]·s^(−μ), T s. *Start-up*: zero for ever before.
/// - *Accuracy*: up to the horizon |error| ≤ `ε·T^(−μ)·Σ_j c_j·|u[n−j]|`, ε = [`Design::error_bound`], and the
///   rounding of the sample type. Beyond the horizon the memory fades out.
/// - *At rest*: for μ > 0 a constant gives exactly 0 in the end, P(1) = 0 to the last bit: the increments are 0, and a
///   state that has decayed below a negligible size (8e-28 in `f32`) becomes 0, so an idle loop is as fast as a busy one.
/// - *Passive*: for 0 < μ ≤ 1 every mode (1 − w)/(1 − (1 − d)w) has a positive real part on the circle, and with them the operator.
/// - *Single precision*: all that is added up is of one sign for a motion in one direction; 200 s at 1 kHz agree with `f64` to 2e-6 of the
///   bound above. Above order 1 comes what the rounding of first differences takes, `2^(−24)·T^(−μ)·Σ_j c_j·(|Δx[n−j]| + |Δx[n−j−1]|)`:
///   near order 2 up to 1.2e-4 of that bound, where an oscillation of 0.4 Hz passes zero. Blocks of slow modes keep a compensation word.
/// - *Not finite*: no output is finite until reset. Whole orders have no modes: only the next TAPS outputs are not finite.
/// - *Cost*: `output` two subtractions and a multiply-add; `advance` TAPS multiply-adds and 5 operations a mode, 8 with
///   compensation. TAPS ≥ 4 and MODES a multiple of 8, else it does not compile.
/// ```
/// use fracdiff::full_memory::{Design, FullMemory, Kernel};
/// use fracdiff::{Differintegrator, Order, Seconds};
///
/// // One hour at 1 kHz, every weight within 1e-6.
/// let design = Design::<16, 48>::closed_form(Kernel::Grunwald, Order::new(0.2247)?, 1e-6, 3.6e6)?;
/// assert!(design.error_bound() <= 1e-6);
/// let tissue = FullMemory::<f32, 16, 48>::new(&design, Seconds(1e-3))?;
/// let mut history = tissue.at_rest();
/// assert!(tissue.step(&mut history, 1.0) > tissue.step(&mut history, 1.0)); // it relaxes
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct FullMemory<F, const TAPS: usize, const MODES: usize>(
    WithIntegerPart<Bank<F, TAPS, MODES>>,
);

/// History of [`FullMemory`].
pub type FullMemoryHistory<F, const TAPS: usize, const MODES: usize> =
    IntegerHistory<F, BankHistory<F, TAPS, MODES>>;

impl<F: Real, const TAPS: usize, const MODES: usize> FullMemory<F, TAPS, MODES> {
    /// Computes the coefficients in `f64` and rounds each once.
    ///
    /// # Errors
    /// [`ParameterError::SampleTime`] unless 1e-9 s ≤ T ≤ 1e6 s.
    pub fn new(design: &Design<TAPS, MODES>, sample_time: Seconds) -> Result<Self, ParameterError> {
        let rate = sample_time.rate_to_the(design.order())?;
        let mode = |mode: &DecayingMode| {
            let weight = rate * mode.weight * libm::exp(-mode.rate);
            (mode.decay(), weight)
        };
        let integer = design.integer();
        let direct = rate * design.head()[0];
        let mut core = Bank::of_modes(rate, direct, design.modes().iter().map(mode), integer);
        let later = design.corrections();
        for (correction, left) in core.corrections.iter_mut().zip(&later[1..]) {
            *correction = F::from_f64(rate * left);
        }
        core.look_at_corrections();
        Ok(Self(WithIntegerPart { integer, core }))
    }
}

operator_from_its_core!(FullMemory<TAPS, MODES>, FullMemoryHistory);

/// The core: a fractional integral of order ν, 0 ≤ ν < 1.
#[derive(Clone, Debug, PartialEq)]
// Aligned for vectors of any width: one that lies in two cache lines is loaded at half the speed.
#[cfg_attr(any(target_arch = "aarch64", target_arch = "x86_64"), repr(align(64)))]
pub(crate) struct Bank<F, const TAPS: usize, const MODES: usize> {
    rate: f64,
    direct: F,
    /// Corrections of lags 1 to TAPS − 1; the last is zero.
    corrections: [F; TAPS],
    decays: [F; MODES],
    weights: [F; MODES],
    /// Blocks of modes without compensation: the fast ones, which come first; in `f64` all.
    fast_blocks: usize,
    /// Those and the slow ones, which follow.
    whole_blocks: usize,
    #[cfg(not(target_arch = "arm"))]
    shape: Shape,
}

/// Parts of a step that may be skipped; on a small core without vectors the test costs more than the step.
#[cfg(not(target_arch = "arm"))]
#[derive(Clone, Copy, Debug, PartialEq)]
struct Shape {
    /// True if a correction is not zero.
    tapped: bool,
    tail: Tail,
}

/// Half a block behind the others, if as much is enough for the last modes.
#[cfg_attr(target_arch = "arm", expect(dead_code))]
#[derive(Clone, Copy, Debug, PartialEq)]
enum Tail {
    None,
    Fast,
    Slow,
}

/// Blocks without a slow mode. Fast modes come first, so compensation is a property of blocks.
fn fast_blocks<F: Real>(decays: &[F], integer: i32) -> usize {
    let fast = if integer > 0 { FAST_INCREMENTS } else { FAST };
    // Double precision needs no compensation anywhere.
    let slow = decays
        .iter()
        .position(|decay| F::COMPENSATED && decay.to_f64() < fast);
    slow.map_or(decays.len().div_ceil(LANES), |first| first / LANES)
}

impl<F: Real, const TAPS: usize, const MODES: usize> Bank<F, TAPS, MODES> {
    /// Bank without taps and modes: all zero, to the last bit, so that it is made in its place without a copy.
    pub(crate) const SILENT: Self = Self {
        rate: 0.0,
        direct: F::ZERO,
        corrections: [F::ZERO; TAPS],
        decays: [F::ZERO; MODES],
        weights: [F::ZERO; MODES],
        fast_blocks: 0,
        whole_blocks: 0,
        #[cfg(not(target_arch = "arm"))]
        shape: Shape {
            tapped: false,
            tail: Tail::None,
        },
    };

    /// Bank from g, d and W of at most MODES modes, behind `integer` differences (> 0) or before −`integer` sums (< 0); without corrections.
    pub(crate) fn of_modes(
        rate: f64,
        direct: f64,
        modes: impl Iterator<Item = (f64, f64)>,
        integer: i32,
    ) -> Self {
        const {
            assert!(
                MODES.is_multiple_of(LANES),
                "the number of modes is a multiple of 8"
            );
        };
        let mut bank = Self {
            rate,
            direct: F::from_f64(direct),
            ..Self::SILENT
        };
        let mut count = 0;
        let places = bank.decays.iter_mut().zip(&mut bank.weights);
        for ((decay, weight), mode) in places.zip(modes) {
            (*decay, *weight) = (F::from_f64(mode.0), F::from_f64(mode.1));
            count += 1;
        }
        bank.use_modes(count, integer);
        bank
    }

    /// Sees whether a correction is not zero.
    fn look_at_corrections(&mut self) {
        #[cfg(not(target_arch = "arm"))]
        {
            self.shape.tapped = self
                .corrections
                .iter()
                .any(|&correction| correction != F::ZERO);
        }
    }

    /// Takes the first `count` modes into use.
    fn use_modes(&mut self, count: usize, integer: i32) {
        let fast = fast_blocks(&self.decays[..count], integer);
        let all = count.div_ceil(LANES);
        let has_tail = !cfg!(target_arch = "arm") && (1..=HALF).contains(&(count % LANES));
        let whole = all - usize::from(has_tail);
        self.fast_blocks = fast.min(whole);
        self.whole_blocks = whole;
        #[cfg(not(target_arch = "arm"))]
        {
            self.shape.tail = match (has_tail, fast > whole) {
                (false, _) => Tail::None,
                (true, true) => Tail::Fast,
                (true, false) => Tail::Slow,
            };
        }
    }

    /// True if a correction is not zero, and the half block behind the others.
    #[inline]
    fn shape(&self) -> (bool, Tail) {
        #[cfg(target_arch = "arm")]
        return (true, Tail::None);
        #[cfg(not(target_arch = "arm"))]
        (self.shape.tapped, self.shape.tail)
    }

    /// Modes in use, those that fill up the last block included: the same on every machine.
    fn used(&self) -> usize {
        let tail = usize::from(self.shape().1 != Tail::None);
        (self.whole_blocks + tail) * LANES
    }
}

/// The history of one signal: due contributions of recent inputs, and the modes.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = "F: Real"))]
// Aligned for vectors of any width: one that lies in two cache lines is loaded at half the speed.
#[cfg_attr(
    any(target_arch = "aarch64", target_arch = "x86_64"),
    repr(C, align(64))
)]
pub struct BankHistory<F, const TAPS: usize, const MODES: usize> {
    /// due\[i\] is what inputs so far contribute, by taps, to the output i + 1 ticks ahead.
    #[cfg_attr(feature = "serde", serde(with = "crate::saved"))]
    due: [F; TAPS],
    #[cfg_attr(feature = "serde", serde(with = "crate::saved"))]
    states: [F; MODES],
    #[cfg_attr(feature = "serde", serde(with = "crate::saved"))]
    carries: [F; MODES],
    /// The state that is looked at next, whether it has decayed.
    #[cfg_attr(
        feature = "serde",
        serde(deserialize_with = "crate::saved::below::<_, MODES>")
    )]
    turn: usize,
    past: F,
}

impl<F: Real, const TAPS: usize, const MODES: usize> BankHistory<F, TAPS, MODES> {
    /// A signal that was zero for ever: all zero, to the last bit, so that it is made in its place without a copy.
    pub(crate) const AT_REST: Self = Self {
        due: [F::ZERO; TAPS],
        states: [F::ZERO; MODES],
        carries: [F::ZERO; MODES],
        turn: 0,
        past: F::ZERO,
    };

    /// One state a sample without input, in turn: if it has decayed to next to nothing it becomes zero, before it could
    /// become a subnormal number, which many processors are slow with. The very fastest modes can get there before
    /// their turn, and no longer than one round. With input no state gets that small.
    #[inline]
    fn flush_one(&mut self, used: usize) {
        let turn = self.turn;
        self.turn = if turn + 1 < used { turn + 1 } else { 0 };
        if let (Some(state), Some(carry)) = (self.states.get_mut(turn), self.carries.get_mut(turn))
            && state.abs() < F::NEGLIGIBLE
            && *state != F::ZERO
        {
            (*state, *carry) = (F::ZERO, F::ZERO);
        }
    }
}

impl<F: Real, const TAPS: usize, const MODES: usize> Differintegrator<F> for Bank<F, TAPS, MODES> {
    type History = BankHistory<F, TAPS, MODES>;

    fn at_rest(&self) -> Self::History {
        BankHistory::AT_REST
    }

    fn settled(&self, x: F) -> Option<Self::History> {
        let mut history = self.at_rest();
        for i in (0..TAPS - 1).rev() {
            history.due[i] = history.due[i + 1] + self.corrections[i] * x;
        }
        // z = x/d; a decay of zero is no mode.
        for (state, &decay) in history.states.iter_mut().zip(&self.decays) {
            *state = if decay > F::ZERO { x / decay } else { F::ZERO };
        }
        self.advance(&mut history, x);
        Some(history)
    }

    past_is_kept!(direct);

    // Inlined, so that S stays in a register up to the integer part.
    #[cfg_attr(target_arch = "arm", inline)]
    #[cfg_attr(not(target_arch = "arm"), inline(always))]
    fn advance(&self, history: &mut Self::History, x: F) {
        if self.shape().0 {
            let before = history.due;
            // A core with an FPU and no vectors moves faster than it multiplies. The same bits: no number here is −0, as the last
            // is never written.
            if cfg!(all(target_arch = "arm", target_abi = "eabihf")) && x == F::ZERO {
                history.due[..TAPS - 1].copy_from_slice(&before[1..]);
            } else {
                // due[i] ← due[i+1] + k_{i+1}·x
                for i in 0..TAPS - 1 {
                    history.due[i] = before[i + 1] + self.corrections[i] * x;
                }
            }
        }
        let (states, _) = history.states.as_chunks_mut::<LANES>();
        let (carries, _) = history.carries.as_chunks_mut::<LANES>();
        let (decays, _) = self.decays.as_chunks::<LANES>();
        let (weights, _) = self.weights.as_chunks::<LANES>();
        // To −0 anything is added without a change: the first block costs no addition, and LLVM leaves the lanes in order. Where all
        // of them stay −0 the bits are those of 0, as due[0] is never −0.
        let mut sums = [-F::ZERO; LANES];
        if let Some(states) = states.get_mut(..self.fast_blocks) {
            let coefficients = decays.iter().zip(weights);
            for (states, (decays, weights)) in states.iter_mut().zip(coefficients) {
                advance_plain(states, decays, weights, x, &mut sums);
            }
        }
        if F::COMPENSATED {
            for block in self.fast_blocks..self.whole_blocks.min(MODES / LANES) {
                let (states, carries) = (&mut states[block], &mut carries[block]);
                advance_compensated(
                    states,
                    carries,
                    &decays[block],
                    &weights[block],
                    x,
                    &mut sums,
                );
            }
        }
        let tail = self.shape().1;
        if tail != Tail::None {
            let block = self.whole_blocks;
            if let (Some(states), Some(carries)) = (states.get_mut(block), carries.get_mut(block))
                && let (Some(decays), Some(weights)) = (decays.get(block), weights.get(block))
                && let (Some(states), Some(carries)) =
                    (states.first_chunk_mut(), carries.first_chunk_mut())
                && let (Some(decays), Some(weights)) = (decays.first_chunk(), weights.first_chunk())
                && let Some(sums) = sums.first_chunk_mut()
            {
                if F::COMPENSATED && tail == Tail::Slow {
                    advance_half(states, carries, decays, weights, x, sums);
                } else {
                    advance_plain(states, decays, weights, x, sums);
                }
            }
        }
        let past = history.due[0] + sum_of_8(sums);
        if x == F::ZERO {
            history.flush_one(self.used());
        }
        // Behind other stores, or it would be loaded again.
        history.past = past;
    }

    fn memory_length(&self) -> Option<usize> {
        (self.used() == 0).then_some(TAPS)
    }
}

impl<F: Real, const TAPS: usize, const MODES: usize> FrequencyResponse for Bank<F, TAPS, MODES> {
    fn response(&self, theta: f64) -> Complex<f64> {
        let w = delay(theta);
        let taps = self.corrections.iter().rev();
        let recent = taps.fold(Complex::new(0.0, 0.0), |sum, k| (sum + k.to_f64()) * w);
        let modes = self.decays.iter().zip(&self.weights);
        let tail: Complex<f64> = modes
            .filter(|(decay, _)| decay.to_f64() > 0.0)
            .map(|(decay, weight)| geometric(theta, decay.to_f64()) * w * weight.to_f64())
            .sum();
        (recent + tail + self.direct.to_f64()) / self.rate
    }
}

// The arithmetic of one step, block by block. The order of summation is part of the numerical contract: lane l adds the modes l, l + 8, …

/// Modes side by side in one block.
const LANES: usize = 8;

const HALF: usize = LANES / 2;

/// A number of each mode of a block, or of half of it.
type Block<F> = [F; LANES];
type Half<F> = [F; HALF];

/// One step of the modes, z ← z + (x − d·z), without compensation, and Σ W·z of each lane.
#[inline(always)]
fn advance_plain<F: Real, const SIZE: usize>(
    states: &mut [F; SIZE],
    decays: &[F; SIZE],
    weights: &[F; SIZE],
    x: F,
    sums: &mut [F; SIZE],
) {
    // A block is loaded, changed and stored as a whole, or it would not become vectors.
    let mut next = *states;
    for lane in 0..SIZE {
        next[lane] += x - decays[lane] * next[lane];
    }
    *states = next;
    for lane in 0..SIZE {
        sums[lane] += weights[lane] * next[lane];
    }
}

/// One step as in [`advance_plain`], with compensation words.
#[inline(always)]
fn advance_compensated<F: Real>(
    states: &mut Block<F>,
    carries: &mut Block<F>,
    decays: &Block<F>,
    weights: &Block<F>,
    x: F,
    sums: &mut Block<F>,
) {
    let ((states, _), (carries, _)) = (states.as_chunks_mut(), carries.as_chunks_mut());
    let ((decays, _), (weights, _)) = (decays.as_chunks(), weights.as_chunks());
    // Half a block at a time: more is more than the registers of a Cortex-M4F hold.
    for (half, sums) in sums.as_chunks_mut().0.iter_mut().enumerate() {
        let (states, carries) = (&mut states[half], &mut carries[half]);
        advance_half(states, carries, &decays[half], &weights[half], x, sums);
    }
}

/// The sums do not wait for the new compensation words.
#[inline(always)]
fn advance_half<F: Real>(
    states: &mut Half<F>,
    carries: &mut Half<F>,
    decays: &Half<F>,
    weights: &Half<F>,
    x: F,
    sums: &mut Half<F>,
) {
    let (mut next, mut rest) = (*states, *carries);
    for lane in 0..HALF {
        let state = next[lane];
        let addend = (x - decays[lane] * state) + rest[lane];
        next[lane] = state + addend;
        // Dekker's sum, three operations instead of Knuth's six: exact while |addend| ≤ |state|. Where the
        // input is larger than a slow state it is the state that is next to nothing.
        rest[lane] = addend - (next[lane] - state);
    }
    (*states, *carries) = (next, rest);
    for lane in 0..HALF {
        sums[lane] += weights[lane] * next[lane];
    }
}

/// Taps of a bank that is given as a list of values.
pub(crate) const PORTABLE_TAPS: usize = 16;

/// The modes of a portable list in blocks that need no compensation.
#[cfg(feature = "std")]
pub(crate) fn plain_modes<F: Real>(values: &[F], integer: i32) -> usize {
    let modes = values.get(PORTABLE_TAPS..).unwrap_or_default();
    let decays: std::vec::Vec<F> = modes.iter().step_by(2).copied().collect();
    LANES * fast_blocks(&decays, integer)
}

impl<F: Real, const TAPS: usize, const MODES: usize> Bank<F, TAPS, MODES> {
    /// Bank from g, `k_1`, …, `k_{TAPS−1}`, then d and W of each mode, all finite. Do not ask for its
    /// frequency response: the rate is not in the list.
    pub(crate) fn from_list(values: &[F], integer: i32) -> Result<Self, ListError> {
        let mut bank = Self::SILENT;
        bank.replace(values, integer)?;
        Ok(bank)
    }

    /// Taps, and d and W of each mode, of a list that is one.
    pub(crate) fn parts(values: &[F]) -> Result<(&[F], &[[F; 2]]), ListError> {
        let (count, most) = (values.len(), TAPS + 2 * MODES);
        let wrong = ListError::Count { count, most };
        let (taps, modes) = values.split_at_checked(TAPS).ok_or(wrong)?;
        let (pairs, rest) = modes.as_chunks::<2>();
        if !rest.is_empty() || pairs.len() > MODES {
            return Err(wrong);
        }
        for (q, &[decay, _]) in pairs.iter().enumerate() {
            check_decay(decay, TAPS + 2 * q)?;
        }
        Ok((taps, pairs))
    }

    /// Replaces the bank by that of a list, in its place; an invalid list leaves it unchanged.
    pub(crate) fn replace(&mut self, values: &[F], integer: i32) -> Result<(), ListError> {
        let (taps, pairs) = Self::parts(values)?;
        self.rate = 1.0;
        self.direct = taps[0];
        self.corrections[..TAPS - 1].copy_from_slice(&taps[1..]);
        self.corrections[TAPS - 1] = F::ZERO;
        self.look_at_corrections();
        // A decay of zero stands for no mode.
        self.decays.fill(F::ZERO);
        self.weights.fill(F::ZERO);
        for (q, &[decay, weight]) in pairs.iter().enumerate() {
            self.decays[q] = decay;
            self.weights[q] = weight;
        }
        self.use_modes(pairs.len(), integer);
        Ok(())
    }

    /// Value `index` of the list that [`from_list`](Self::from_list) takes.
    pub(crate) fn value(&self, index: usize) -> Option<F> {
        if index < TAPS {
            return Some(if index == 0 {
                self.direct
            } else {
                self.corrections[index - 1]
            });
        }
        let (mode, second) = ((index - TAPS) / 2, (index - TAPS) % 2 == 1);
        // A decay of zero is no mode.
        let decay = *self.decays.get(mode).filter(|decay| **decay > F::ZERO)?;
        Some(if second { self.weights[mode] } else { decay })
    }
}

impl<F: Real, const MODES: usize> FullMemory<F, PORTABLE_TAPS, MODES> {
    /// Operator from the integer part and the values of [`Form::Modes`](crate::portable::Form::Modes), as
    /// [`Operator::list`](crate::Operator::list) gives them: the same bits as the operator that the list is of, without
    /// its design, so that a microcontroller needs no elementary functions.
    ///
    /// # Errors
    /// An invalid list, see [`ListError`]. The response is not to be asked for: the rate
    /// is not in the list.
    pub fn from_list(integer: i8, values: &[F]) -> Result<Self, ListError> {
        let integer = check_integer(integer)?;
        check_finite(values)?;
        let core = Bank::from_list(values, integer)?;
        Ok(Self(WithIntegerPart { integer, core }))
    }

    /// Integer part, and the values of [`Form::Modes`](crate::portable::Form::Modes).
    #[cfg(feature = "std")]
    pub(crate) fn list(&self) -> (i32, std::vec::Vec<F>) {
        self.0.list(Bank::value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Order;
    use crate::full_memory::Kernel;

    #[test]
    fn blocks_are_compensated_from_the_first_that_has_a_slow_mode() {
        for (integer, edge) in [(0, 1.0 / 64.0), (-1, 1.0 / 64.0), (1, 1.0 / 1024.0)] {
            let mut decays = [edge as f32; 3 * LANES];
            assert_eq!(fast_blocks(&decays, integer), 3);
            decays[2 * LANES - 1] *= 0.999;
            assert_eq!(fast_blocks(&decays, integer), 1);
            assert_eq!(fast_blocks(&decays.map(f64::from), integer), 3);
        }
    }

    #[test]
    fn only_a_whole_order_forgets() {
        for (order, length) in [(0.5, None), (1.0, Some(17)), (2.0, Some(18)), (-0.5, None)] {
            let order = Order::new(order).expect("an order");
            let design = Design::<16, 48>::closed_form(Kernel::Grunwald, order, 1e-6, 2e5);
            let memory = FullMemory::<f32, 16, 48>::new(&design.expect("modes"), Seconds(1e-3));
            assert_eq!(memory.expect("a time").memory_length(), length);
        }
    }

    /// Idle loops are fast because no number in them stays subnormal, however long they idle.
    #[test]
    fn a_number_is_subnormal_for_one_round_at_most_while_the_input_stands_still() {
        fn check<F: Real>(order: f64, size: f64, is_slow: fn(F) -> bool) {
            let order = Order::new(order).expect("an order");
            let design = Design::<16, 48>::closed_form(Kernel::Grunwald, order, 1e-6, 2e5);
            let bank = FullMemory::<F, 16, 48>::new(&design.expect("modes"), Seconds(1e-3));
            let bank = bank.expect("a time").0.core;
            let mut history = bank.at_rest();
            let mut slow_for = [0; 2 * 48 + 16];
            for n in 0..40_000 {
                // So small a motion that what it leaves soon counts as nothing, then none.
                bank.advance(&mut history, F::from_f64(if n < 50 { size } else { 0.0 }));
                let words = history.states.iter().chain(&history.carries);
                for (slow_for, &word) in slow_for.iter_mut().zip(words.chain(&history.due)) {
                    *slow_for = if is_slow(word) { *slow_for + 1 } else { 0 };
                    assert!(*slow_for <= bank.used(), "{order:?} {n}: {history:?}");
                }
            }
            assert!(history.states.contains(&F::ZERO) && history.states[..8] == [F::ZERO; 8]);
        }
        for order in [0.05, 0.2247, 0.5, 0.9, 1.5] {
            for factor in [1.0, 1e-3, 1e-6] {
                check::<f32>(order, 1e-20 * factor, f32::is_subnormal);
                check::<f64>(order, 1e-263 * factor, f64::is_subnormal);
            }
        }
    }
}
