//! Arithmetic that every finite memory shares: a window of the newest samples, and one dot product.

use crate::Real;

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
    let mut lanes = if tap_blocks.is_empty() {
        [F::ZERO; LANES]
    } else {
        lane_sums(tap_blocks, sample_blocks)
    };
    // The rest goes on in the lanes where the blocks ended: fifteen additions side by side, not in a row.
    for (lane, (&tap, &sample)) in lanes.iter_mut().zip(tap_rest.iter().zip(sample_rest)) {
        *lane += tap * sample;
    }
    sum_of_16(lanes)
}

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
pub struct FirHistory<F, const N: usize> {
    samples: [[F; N]; 2],
    newest: usize,
    pub(crate) past: F,
}

impl<F: Real, const N: usize> FirHistory<F, N> {
    /// A signal that was zero for ever.
    pub(crate) fn at_rest() -> Self {
        Self {
            samples: [[F::ZERO; N]; 2],
            newest: 0,
            past: F::ZERO,
        }
    }

    /// Takes a sample in and sets S\[n\] from the taps of w¹, w², …; N of them at most.
    #[inline]
    pub(crate) fn advance(&mut self, taps: &[F], x: F) {
        self.past = advance(self.samples.as_flattened_mut(), &mut self.newest, taps, x);
    }
}

/// Takes a sample into a buffer that holds each twice, see [`push`], and convolves the newest with
/// `taps`, which are at most half as long as the buffer.
#[inline]
pub(crate) fn advance<F: Real>(twice: &mut [F], newest: &mut usize, taps: &[F], x: F) -> F {
    push(twice, newest, x);
    // The newest half of the buffer is at least as long as the taps.
    let samples = twice.get(*newest..).unwrap_or_default();
    dot(taps, samples.get(..taps.len()).unwrap_or_default())
}

/// Where the newest of N samples goes in a buffer of 2N that holds each sample twice, N apart, so
/// that the newest N always lie in one piece, newest first. No modulo, no wrap in the dot product,
/// and a summation order that does not depend on the position in the ring.
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
