//! Arithmetic that every finite memory shares: a window of the newest samples, and one dot product.

use crate::Real;

/// Number of partial sums in a dot product. Part of the numerical contract: the order of summation
/// depends on it, and on nothing else, on every target.
const LANES: usize = 16;

/// Σ taps\[i\]·samples\[i\], summed in lanes: lane l adds i = l, l + 16, … in order; then the lanes
/// are added in pairs; then the rest that fills no block. Same bits on every target.
#[inline]
pub(crate) fn dot<F: Real>(taps: &[F], samples: &[F]) -> F {
    let (tap_blocks, tap_rest) = taps.as_chunks::<LANES>();
    let (sample_blocks, sample_rest) = samples.as_chunks::<LANES>();
    let mut lanes = [F::ZERO; LANES];
    for (taps, samples) in tap_blocks.iter().zip(sample_blocks) {
        for lane in 0..LANES {
            lanes[lane] += taps[lane] * samples[lane];
        }
    }
    let mut rest = F::ZERO;
    for (&tap, &sample) in tap_rest.iter().zip(sample_rest) {
        rest += tap * sample;
    }
    sum_of_16(lanes) + rest
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

/// Where the newest of N samples goes in a buffer of 2N that holds each sample twice, N apart, so
/// that the newest N always lie in one piece, newest first. No modulo, no wrap in the dot product,
/// and a summation order that does not depend on the position in the ring.
#[inline]
pub(crate) fn push<F: Real>(twice: &mut [F], newest: &mut usize, x: F) {
    let length = twice.len() / 2;
    *newest = if *newest == 0 { length } else { *newest } - 1;
    twice[*newest] = x;
    twice[*newest + length] = x;
}

/// The newest `count` samples, newest first.
#[inline]
pub(crate) fn window<F>(twice: &[F], newest: usize, count: usize) -> &[F] {
    &twice[newest..newest + count]
}
