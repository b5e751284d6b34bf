//! Finite impulse responses: a window of the newest samples and one dot product, which every finite memory shares.

use crate::differintegrator::past_is_kept;
use crate::list::{ListError, check_finite};
use crate::response::polynomial;
use crate::{Differintegrator, FrequencyResponse, Real};
#[cfg(feature = "alloc")]
use alloc::{vec, vec::Vec};
use num_complex::Complex;

/// Number of partial sums in a dot product. Part of the numerical contract: the order of summation
/// depends on it, and on nothing else, on every target.
const LANES: usize = 16;

/// Σ taps\[i\]·samples\[i\], summed in lanes: lane l adds i = l, l + 16, … in order; then the lanes
/// are added in pairs. Same bits on every target.
#[inline]
fn dot<F: Real>(taps: &[F], samples: &[F]) -> F {
    let (tap_blocks, tap_rest) = taps.as_chunks::<LANES>();
    let (sample_blocks, sample_rest) = samples.as_chunks::<LANES>();
    // Without this the shortest memories would pay for a call that does nothing.
    let lanes = if tap_blocks.is_empty() {
        [F::ZERO; LANES]
    } else {
        lane_sums(tap_blocks, sample_blocks)
    };
    finish(lanes, tap_rest, sample_rest)
}

/// Adds the rest, fifteen products at most, and all lanes.
#[inline]
fn finish<F: Real>(mut lanes: [F; LANES], taps: &[F], samples: &[F]) -> F {
    // The rest continues in the lanes where the blocks ended: fifteen additions side by side, not in a row.
    if cfg!(target_arch = "arm") {
        for (lane, (&tap, &sample)) in lanes.iter_mut().zip(taps.iter().zip(samples)) {
            *lane += tap * sample;
        }
        return sum_of_16(lanes);
    }
    // In fours: a vector that is read as a whole must not wait for numbers that were stored one by one.
    let ((taps, last_taps), (samples, last_samples)) =
        (taps.as_chunks::<4>(), samples.as_chunks::<4>());
    let last: [F; 4] = core::array::from_fn(|l| match (last_taps.get(l), last_samples.get(l)) {
        (Some(&tap), Some(&sample)) => tap * sample,
        // Changes no sum, not even one of −0.
        _ => -F::ZERO,
    });
    for (i, lanes) in lanes.as_chunks_mut::<4>().0.iter_mut().enumerate() {
        let products = match (taps.get(i), samples.get(i)) {
            (Some(taps), Some(samples)) => core::array::from_fn(|l| taps[l] * samples[l]),
            _ if i == taps.len() => last,
            _ => break,
        };
        for l in 0..4 {
            lanes[l] += products[l];
        }
    }
    sum_of_16(lanes)
}

/// [`dot`] of the same taps with the samples of D axes, to the bit.
#[inline]
fn dot_many<F: Real, const D: usize>(taps: &[F], samples: [&[F]; D]) -> [F; D] {
    let (tap_blocks, tap_rest) = taps.as_chunks::<LANES>();
    let samples = samples.map(<[F]>::as_chunks::<LANES>);
    let lanes = lane_sums_many(tap_blocks, samples.map(|(blocks, _)| blocks));
    core::array::from_fn(|axis| finish(lanes[axis], tap_rest, samples[axis].1))
}

/// [`lane_sums`] for D axes, three at a time; each tap is read once for all three.
#[inline]
fn lane_sums_many<F: Real, const D: usize>(
    taps: &[[F; LANES]],
    samples: [&[[F; LANES]]; D],
) -> [[F; LANES]; D] {
    let mut lanes = [[F::ZERO; LANES]; D];
    let (threes, rest) = samples.as_chunks::<3>();
    let (lane_threes, lane_rest) = lanes.as_chunks_mut::<3>();
    for (lanes, &samples) in lane_threes.iter_mut().zip(threes) {
        *lanes = lane_sums_of_3(taps, samples);
    }
    match (lane_rest, rest) {
        ([a, b], &[first, second]) => [*a, *b] = lane_sums_of_2(taps, [first, second]),
        ([a], &[only]) => *a = lane_sums(taps, only),
        _ => (),
    }
    lanes
}

/// Half of the lanes at a time, so that the sums of three axes stay in sixteen registers; and zipped slices only,
/// so that nothing is checked inside.
macro_rules! lane_sums_together {
    ($name:ident, $axes:literal, $samples:ident => $zipped:expr, $($axis:ident $at:tt),+ in $pattern:pat) => {
        #[inline(never)]
        fn $name<F: Real>(
            taps: &[[F; LANES]],
            $samples: [&[[F; LANES]]; $axes],
        ) -> [[F; LANES]; $axes] {
            const HALF: usize = LANES / 2;
            let mut lanes = [[F::ZERO; LANES]; $axes];
            for half in 0..2 {
                let mut sums = [[F::ZERO; HALF]; $axes];
                for (taps, $pattern) in taps.iter().zip($zipped) {
                    let taps = taps.as_chunks::<HALF>().0[half];
                    $(let $axis = $axis.as_chunks::<HALF>().0[half];)+
                    for lane in 0..HALF {
                        $(sums[$at][lane] += taps[lane] * $axis[lane];)+
                    }
                }
                for (lanes, sums) in lanes.iter_mut().zip(sums) {
                    lanes.as_chunks_mut::<HALF>().0[half] = sums;
                }
            }
            lanes
        }
    };
}

lane_sums_together!(lane_sums_of_2, 2, s => s[0].iter().zip(s[1]), a 0, b 1 in (a, b));
lane_sums_together!(
    lane_sums_of_3, 3, s => s[0].iter().zip(s[1].iter().zip(s[2])), a 0, b 1, c 2 in (a, (b, c))
);

/// Lane l of the result is the sum of lane l of all blocks, in order. Not inlined, because LLVM
/// otherwise shapes its vectors after the pairwise sum at the end and gathers lanes one by one.
#[inline(never)]
fn lane_sums<F: Real>(taps: &[[F; LANES]], samples: &[[F; LANES]]) -> [F; LANES] {
    let mut lanes = [F::ZERO; LANES];
    for (taps, samples) in taps.iter().zip(samples) {
        for lane in 0..LANES {
            lanes[lane] += taps[lane] * samples[lane];
        }
    }
    lanes
}

/// Adds sixteen lanes: l and l + 8, then as [`sum_of_8`].
#[inline]
fn sum_of_16<F: Real>(lanes: [F; 16]) -> F {
    sum_of_8(core::array::from_fn(|l| lanes[l] + lanes[l + 8]))
}

/// Adds eight lanes: l and l + 4, then l and l + 2, then the last two.
#[inline]
pub(crate) fn sum_of_8<F: Real>(lanes: [F; 8]) -> F {
    let [a, b, c, d]: [F; 4] = core::array::from_fn(|l| lanes[l] + lanes[l + 4]);
    (a + c) + (b + d)
}

/// The newest N samples of one signal, and what they contribute to the next output.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(from = "Newest<F, N>", into = "Newest<F, N>", bound = "F: Real")
)]
pub struct FirHistory<F, const N: usize> {
    samples: [[F; N]; 2],
    newest: usize,
    pub(crate) past: F,
}

/// Serialized form: each sample once, newest first, wherever in the ring it lay.
#[cfg(feature = "serde")]
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "FirHistory")]
#[serde(bound = "F: Real")]
struct Newest<F, const N: usize> {
    #[serde(with = "crate::saved")]
    samples: [F; N],
    past: F,
}

#[cfg(feature = "serde")]
impl<F: Real, const N: usize> From<FirHistory<F, N>> for Newest<F, N> {
    fn from(history: FirHistory<F, N>) -> Self {
        let newest = newest_samples(history.samples.as_flattened(), history.newest, N).iter();
        let mut samples = [F::ZERO; N];
        for (sample, newest) in samples.iter_mut().zip(newest) {
            *sample = *newest;
        }
        Self {
            samples,
            past: history.past,
        }
    }
}

#[cfg(feature = "serde")]
impl<F: Real, const N: usize> From<Newest<F, N>> for FirHistory<F, N> {
    fn from(saved: Newest<F, N>) -> Self {
        Self {
            samples: [saved.samples; 2],
            newest: 0,
            past: saved.past,
        }
    }
}

impl<F: Real, const N: usize> FirHistory<F, N> {
    /// A signal that was zero for ever: all zero, to the last bit, so that it is made in its place without a copy.
    pub(crate) const AT_REST: Self = Self {
        samples: [[F::ZERO; N]; 2],
        newest: 0,
        past: F::ZERO,
    };

    /// Becomes a signal that was zero for ever.
    pub(crate) fn rest(&mut self) {
        self.samples.as_flattened_mut().fill(F::ZERO);
        (self.newest, self.past) = (0, F::ZERO);
    }

    /// A signal that has stood at x for ever.
    pub(crate) fn settled(taps: &[F], x: F) -> Self {
        let mut history = Self {
            samples: [[x; N]; 2],
            ..Self::AT_REST
        };
        history.advance(taps, x);
        history
    }

    /// Takes a sample in and sets S\[n\] from the taps of w¹, w², …; N of them at most.
    #[inline]
    pub(crate) fn advance(&mut self, taps: &[F], x: F) {
        self.past = advance(self.samples.as_flattened_mut(), &mut self.newest, taps, x);
    }

    /// [`advance`](Self::advance) of D axes.
    #[inline]
    pub(crate) fn advance_many<const D: usize>(histories: [&mut Self; D], taps: &[F], x: [F; D]) {
        /// Memories of fewer taps than this are not worth bringing together.
        const FEW: usize = 300;
        if N < FEW {
            for (history, x) in histories.into_iter().zip(x) {
                history.advance(taps, x);
            }
            return;
        }
        let axes = histories.map(|history| {
            (
                history.samples.as_flattened_mut(),
                &mut history.newest,
                &mut history.past,
            )
        });
        advance_many(axes, taps, x);
    }
}

/// [`advance`] of D axes, each its buffer, its newest sample and what becomes of it.
#[inline]
pub(crate) fn advance_many<F: Real, const D: usize>(
    axes: [(&mut [F], &mut usize, &mut F); D],
    taps: &[F],
    x: [F; D],
) {
    let mut x = x.into_iter();
    let axes = axes.map(|(twice, newest, past)| {
        push(twice, newest, x.next().unwrap_or_default());
        (newest_samples(twice, *newest, taps.len()), past)
    });
    let samples: [&[F]; D] = core::array::from_fn(|axis| axes[axis].0);
    for ((_, past), sum) in axes.into_iter().zip(dot_many(taps, samples)) {
        *past = sum;
    }
}

/// Takes a sample into a buffer that holds each twice, see [`push`], and convolves the newest with
/// `taps`, which are at most half as long as the buffer.
#[inline]
pub(crate) fn advance<F: Real>(twice: &mut [F], newest: &mut usize, taps: &[F], x: F) -> F {
    push(twice, newest, x);
    dot(taps, newest_samples(twice, *newest, taps.len()))
}

/// The newest `count` samples, at most half of the buffer.
#[inline]
fn newest_samples<F>(twice: &[F], newest: usize, count: usize) -> &[F] {
    let samples = twice.get(newest..).unwrap_or_default();
    samples.get(..count).unwrap_or_default()
}

/// Place of the newest of N samples in a buffer of 2N that holds each sample twice, N apart, so that the newest N always lie in one piece,
/// newest first. No modulo, no wrap in the dot product, and a summation order that does not depend on the position in the ring.
#[inline]
fn push<F: Real>(twice: &mut [F], newest: &mut usize, x: F) {
    let length = twice.len() / 2;
    // newest ← newest − 1, after 0 the last; `min`, so that no index can be out of bounds.
    *newest = newest.wrapping_sub(1).min(length - 1);
    let (first, second) = twice.split_at_mut(length);
    for half in [first, second] {
        if let Some(slot) = half.get_mut(*newest) {
            *slot = x;
        }
    }
}

/// A finite impulse response of N coefficients at most, whatever they are.
/// ```text
/// y[n] = Σ_{j=0}^{n−1} c_j·x[n−j]
/// ```
/// - *Units*: c has \[y\]/\[x\]; nothing is scaled by a sample time.
/// - *Start-up*: zero for ever before. *Not finite*: spoils as many outputs as there are coefficients.
/// - *Cost*: `output` one multiply-add, `advance` one for each other coefficient. No allocation or panic.
/// ```
/// use fracdiff::{Channel, Fir};
///
/// let mut slope = Channel::new(Fir::<f32, 2>::from_slice(&[1e3, -1e3])?);
/// slope.step(1.0);
/// assert_eq!(slope.step(1.5), 500.0);
/// # Ok::<(), fracdiff::portable::ListError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Fir<F, const N: usize> {
    used: usize,
    coefficients: [F; N],
}

impl<F: Real, const N: usize> Fir<F, N> {
    /// That of the newest sample first. `N = 0` does not compile.
    ///
    /// # Errors
    /// [`ListError::Count`] unless there are 1 to N; [`ListError::Value`] for one that is not finite.
    pub fn from_slice(coefficients: &[F]) -> Result<Self, ListError> {
        const { assert!(N > 0, "there is at least one coefficient") };
        let mut fir = Self::SILENT;
        fir.replace(coefficients)?;
        Ok(fir)
    }

    /// No coefficient: all zero, to the last bit, so that it is made in its place without a copy.
    pub(crate) const SILENT: Self = Self {
        used: 0,
        coefficients: [F::ZERO; N],
    };

    /// Accepts what [`from_slice`](Self::from_slice) accepts.
    pub(crate) fn check(coefficients: &[F]) -> Result<(), ListError> {
        let (count, most) = (coefficients.len(), N);
        if !(1..=most).contains(&count) {
            return Err(ListError::Count { count, most });
        }
        check_finite(coefficients)
    }

    /// Takes other coefficients, in its place; refused ones leave it as it is.
    pub(crate) fn replace(&mut self, coefficients: &[F]) -> Result<(), ListError> {
        Self::check(coefficients)?;
        self.used = coefficients.len();
        let (used, rest) = self.coefficients.split_at_mut(self.used);
        used.copy_from_slice(coefficients);
        rest.fill(F::ZERO);
        Ok(())
    }

    /// Coefficients that are known to be finite; zeros at the end take no part.
    pub(crate) fn of(coefficients: [F; N]) -> Self {
        let last = coefficients.iter().rposition(|c| *c != F::ZERO);
        let used = last.map_or(1, |last| last + 1);
        Self { used, coefficients }
    }

    /// The coefficients, that of the newest sample first.
    #[must_use]
    pub fn coefficients(&self) -> &[F] {
        self.coefficients.get(..self.used).unwrap_or_default()
    }

    /// Those of w¹, w², …
    #[inline]
    fn taps(&self) -> &[F] {
        self.coefficients.get(1..self.used).unwrap_or_default()
    }
}

impl<F: Real, const N: usize> Differintegrator<F> for Fir<F, N> {
    type History = FirHistory<F, N>;

    fn at_rest(&self) -> Self::History {
        FirHistory::AT_REST
    }

    fn settled(&self, x: F) -> Option<Self::History> {
        Some(FirHistory::settled(self.taps(), x))
    }

    past_is_kept!(coefficients[0]);

    #[inline]
    fn advance(&self, history: &mut Self::History, x: F) {
        history.advance(self.taps(), x);
    }

    #[inline]
    fn advance_many<const D: usize>(&self, histories: [&mut Self::History; D], x: [F; D]) {
        FirHistory::advance_many(histories, self.taps(), x);
    }

    fn memory_length(&self) -> Option<usize> {
        Some(self.used)
    }
}

impl<F: Real, const N: usize> FrequencyResponse for Fir<F, N> {
    /// Response of the coefficients as they are: in \[y\]/\[x\], not freed of any T^(−μ).
    fn response(&self, theta: f64) -> Complex<f64> {
        polynomial(self.coefficients().iter().map(|c| c.to_f64()), theta)
    }
}

/// Each sample twice, so that the newest lie in one piece, see [`push`].
#[cfg(feature = "alloc")]
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(from = "Vec<F>", into = "Vec<F>", bound = "F: Real")
)]
pub(crate) struct Ring<F> {
    twice: Vec<F>,
    newest: usize,
}

#[cfg(feature = "alloc")]
impl<F: Real> Ring<F> {
    /// Ring of `length` samples of one value.
    pub(crate) fn of(x: F, length: usize) -> Self {
        Self {
            twice: vec![x; 2 * length],
            newest: 0,
        }
    }

    #[inline]
    pub(crate) fn length(&self) -> usize {
        self.twice.len() / 2
    }

    /// Takes in a sample as [`advance`] does.
    #[inline]
    pub(crate) fn advance(&mut self, taps: &[F], x: F) -> F {
        advance(&mut self.twice, &mut self.newest, taps, x)
    }

    /// The samples twice, and where the newest is.
    #[inline]
    pub(crate) fn parts(&mut self) -> (&mut [F], &mut usize) {
        (&mut self.twice, &mut self.newest)
    }
}

/// Data in which each sample stands once, newest first.
#[cfg(all(feature = "alloc", feature = "serde"))]
impl<F: Real> From<Ring<F>> for Vec<F> {
    fn from(ring: Ring<F>) -> Self {
        let length = ring.length();
        ring.twice
            .into_iter()
            .skip(ring.newest)
            .take(length)
            .collect()
    }
}

#[cfg(all(feature = "alloc", feature = "serde"))]
impl<F: Real> From<Vec<F>> for Ring<F> {
    fn from(samples: Vec<F>) -> Self {
        Self {
            twice: samples.repeat(2),
            newest: 0,
        }
    }
}
