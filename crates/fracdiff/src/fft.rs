//! The passes of a complex FFT, one lane block at a time.
//!
//! Forward: decimation in frequency, natural order in, bit-reversed out. Inverse: decimation in time,
//! the other way round. Products of two spectra do not care about the order, so nothing is permuted.
//! The last three stages stay inside a block of eight ([`forward_8`], [`inverse_8`]).

use crate::Real;
use alloc::vec::Vec;
use core::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};
use core::sync::atomic::{Ordering, compiler_fence};

/// Complex numbers side by side. Fixed, so that every target rounds alike.
pub(crate) const LANES: usize = 8;

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Bins<F> {
    pub(crate) re: [F; LANES],
    pub(crate) im: [F; LANES],
}

impl<F: Real> Bins<F> {
    /// `n` complex numbers, n a multiple of eight, in blocks.
    pub(crate) fn collect(n: usize, value: impl Fn(usize) -> (f64, f64)) -> Vec<Self> {
        let block = |b: usize| {
            let mut bins = Self::default();
            for l in 0..LANES {
                let (re, im) = value(LANES * b + l);
                (bins.re[l], bins.im[l]) = (F::from_f64(re), F::from_f64(im));
            }
            bins
        };
        (0..n / LANES).map(block).collect()
    }

    /// self ← self + x·h, in each lane.
    #[inline(always)]
    pub(crate) fn add_product(&mut self, x: &Self, h: &Self) {
        for l in 0..LANES {
            self.re[l] += x.re[l] * h.re[l] - x.im[l] * h.im[l];
            self.im[l] += x.re[l] * h.im[l] + x.im[l] * h.re[l];
        }
    }
}

/// e^(−jπi/half) for i = 0, …, half − 1, of halves 8, 16, …, size/2 one after the other, without a sine for each: those of the pass
/// over distances of b blocks start at block b − 1.
pub(crate) fn factors_from(turn: &QuarterTurn) -> Vec<Bins<f64>> {
    let size = turn.size();
    let factor = |half: usize, i: usize| match 2 * size * i / half {
        k if k < size => {
            let (cos, sin) = turn.at(k);
            (cos, -sin)
        }
        k => {
            let (cos, sin) = turn.at(k - size);
            (-sin, -cos)
        }
    };
    let mut factors = Vec::with_capacity(size / LANES);
    let mut half = LANES;
    while half < size {
        factors.extend(Bins::collect(half, |i| factor(half, i)));
        half *= 2;
    }
    factors
}

pub(crate) fn unit(phase: f64) -> (f64, f64) {
    (libm::cos(phase), libm::sin(phase))
}

/// e^(jπk/2S), k = 0, …, S − 1, S a power of two: by the sines of some thousand angles, which stay in the cache, instead
/// of a table as long as the record.
/// ```text
/// e^(j(φ + ε)) = A + A·d,   A = e^(jφ),   d = e^(jε) − 1 = −2·sin²(ε/2) + j·sin ε
/// ```
/// A·d is small, so its rounding is lost in that of A and of the sum: to 3e-16, as the sines themselves.
pub(crate) struct QuarterTurn {
    coarse: Vec<(f64, f64)>,
    /// d; their number is a power of two.
    rests: Vec<(f64, f64)>,
}

impl QuarterTurn {
    pub(crate) fn new(size: usize) -> Self {
        let coarse = size.min(1024);
        let angle = |k: usize, count: usize| FRAC_PI_2 * (k as f64 / count as f64);
        // From the nearer end, where an angle has more digits.
        let exact = |k: usize| {
            if 2 * k <= coarse {
                return unit(angle(k, coarse));
            }
            let (sin, cos) = unit(angle(coarse - k, coarse));
            (cos, sin)
        };
        let rest = |k: usize| {
            let half = libm::sin(0.5 * angle(k, size));
            (-2.0 * half * half, libm::sin(angle(k, size)))
        };
        Self {
            coarse: (0..coarse).map(exact).collect(),
            rests: (0..size / coarse).map(rest).collect(),
        }
    }

    pub(crate) fn size(&self) -> usize {
        self.coarse.len() * self.rests.len()
    }

    #[inline]
    pub(crate) fn at(&self, k: usize) -> (f64, f64) {
        let (re, im) = self.coarse[k >> self.rests.len().trailing_zeros()];
        let (c, s) = self.rests[k & (self.rests.len() - 1)];
        (re + (re * c - im * s), im + (re * s + im * c))
    }
}

/// Costs no instruction. With wide vectors LLVM would otherwise take one lane of eight blocks, by gathers, instead of
/// the eight lanes of one: twice the time.
#[inline(always)]
fn one_block_at_a_time() {
    compiler_fence(Ordering::AcqRel);
}

/// Forward butterflies: (a, b) ← (a + b, (a − b)·f).
#[inline(never)]
pub(crate) fn forward<F: Real>(low: &mut [Bins<F>], high: &mut [Bins<F>], factors: &[Bins<F>]) {
    for (a, (b, f)) in low.iter_mut().zip(high.iter_mut().zip(factors)) {
        for l in 0..LANES {
            let (re, im) = (a.re[l] - b.re[l], a.im[l] - b.im[l]);
            a.re[l] += b.re[l];
            a.im[l] += b.im[l];
            b.re[l] = re * f.re[l] - im * f.im[l];
            b.im[l] = re * f.im[l] + im * f.re[l];
        }
        one_block_at_a_time();
    }
}

/// Inverse butterflies: (a, b) ← (a + b·f*, a − b·f*).
#[inline(never)]
pub(crate) fn inverse<F: Real>(low: &mut [Bins<F>], high: &mut [Bins<F>], factors: &[Bins<F>]) {
    for (a, (b, f)) in low.iter_mut().zip(high.iter_mut().zip(factors)) {
        for l in 0..LANES {
            let re = b.re[l] * f.re[l] + b.im[l] * f.im[l];
            let im = b.im[l] * f.re[l] - b.re[l] * f.im[l];
            b.re[l] = a.re[l] - re;
            b.im[l] = a.im[l] - im;
            a.re[l] += re;
            a.im[l] += im;
        }
        one_block_at_a_time();
    }
}

/// The last three forward passes.
#[inline]
pub(crate) fn forward_8<F: Real>(x: &mut Bins<F>) {
    let h = F::from_f64(FRAC_1_SQRT_2);
    let (r, i) = (x.re, x.im);
    // Distance 4, factors e^(−jπk/4).
    let s_re: [F; 4] = core::array::from_fn(|k| r[k] + r[k + 4]);
    let s_im: [F; 4] = core::array::from_fn(|k| i[k] + i[k + 4]);
    let d_re: [F; 4] = core::array::from_fn(|k| r[k] - r[k + 4]);
    let d_im: [F; 4] = core::array::from_fn(|k| i[k] - i[k + 4]);
    let t_re = [
        d_re[0],
        h * (d_re[1] + d_im[1]),
        d_im[2],
        h * (d_im[3] - d_re[3]),
    ];
    let t_im = [
        d_im[0],
        h * (d_im[1] - d_re[1]),
        -d_re[2],
        -(h * (d_re[3] + d_im[3])),
    ];
    let ([a, b, c, d], [e, f, g, p]) = (forward_4(s_re, s_im), forward_4(t_re, t_im));
    x.re = [a.0, b.0, c.0, d.0, e.0, f.0, g.0, p.0];
    x.im = [a.1, b.1, c.1, d.1, e.1, f.1, g.1, p.1];
}

/// Distances 2 and 1, factors 1 and −j.
#[inline]
fn forward_4<F: Real>(re: [F; 4], im: [F; 4]) -> [(F, F); 4] {
    let (s0, s1) = (
        (re[0] + re[2], im[0] + im[2]),
        (re[1] + re[3], im[1] + im[3]),
    );
    let (d0, d1) = (
        (re[0] - re[2], im[0] - im[2]),
        (im[1] - im[3], re[3] - re[1]),
    );
    [
        (s0.0 + s1.0, s0.1 + s1.1),
        (s0.0 - s1.0, s0.1 - s1.1),
        (d0.0 + d1.0, d0.1 + d1.1),
        (d0.0 - d1.0, d0.1 - d1.1),
    ]
}

/// The first three inverse passes.
#[inline]
pub(crate) fn inverse_8<F: Real>(x: &mut Bins<F>) {
    let h = F::from_f64(FRAC_1_SQRT_2);
    let (r, i) = (x.re, x.im);
    let s = inverse_4([r[0], r[1], r[2], r[3]], [i[0], i[1], i[2], i[3]]);
    let d = inverse_4([r[4], r[5], r[6], r[7]], [i[4], i[5], i[6], i[7]]);
    // Distance 4, factors e^(jπk/4).
    let t = [
        d[0],
        (h * (d[1].0 - d[1].1), h * (d[1].0 + d[1].1)),
        (-d[2].1, d[2].0),
        (-(h * (d[3].0 + d[3].1)), h * (d[3].0 - d[3].1)),
    ];
    for k in 0..4 {
        x.re[k] = s[k].0 + t[k].0;
        x.im[k] = s[k].1 + t[k].1;
        x.re[k + 4] = s[k].0 - t[k].0;
        x.im[k + 4] = s[k].1 - t[k].1;
    }
}

/// Distances 1 and 2, factors 1 and j.
#[inline]
fn inverse_4<F: Real>(re: [F; 4], im: [F; 4]) -> [(F, F); 4] {
    let (s0, s1) = (
        (re[0] + re[1], im[0] + im[1]),
        (re[2] + re[3], im[2] + im[3]),
    );
    let (d0, d1) = (
        (re[0] - re[1], im[0] - im[1]),
        (im[3] - im[2], re[2] - re[3]),
    );
    [
        (s0.0 + s1.0, s0.1 + s1.1),
        (d0.0 + d1.0, d0.1 + d1.1),
        (s0.0 - s1.0, s0.1 - s1.1),
        (d0.0 - d1.0, d0.1 - d1.1),
    ]
}

/// All forward passes over 2^k blocks, with the factors of their size or more. Depth first, so that what is worked
/// on soon fits the cache.
pub(crate) fn forward_all<F: Real>(x: &mut [Bins<F>], all: &[Bins<F>]) {
    let half = x.len() / 2;
    let (low, high) = x.split_at_mut(half);
    if half == 0 {
        high.iter_mut().for_each(forward_8);
        return;
    }
    forward(low, high, &all[half - 1..2 * half - 1]);
    forward_all(low, all);
    forward_all(high, all);
}

/// All inverse passes, not scaled: [`forward_all`] backwards, times the number of complex numbers.
pub(crate) fn inverse_all<F: Real>(x: &mut [Bins<F>], all: &[Bins<F>]) {
    let half = x.len() / 2;
    let (low, high) = x.split_at_mut(half);
    if half == 0 {
        high.iter_mut().for_each(inverse_8);
        return;
    }
    inverse_all(low, all);
    inverse_all(high, all);
    inverse(low, high, &all[half - 1..2 * half - 1]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;

    #[test]
    fn a_forward_transform_is_the_defining_sum_in_bit_reversed_order() {
        let size = 64;
        let signal = |n: usize| ((0.3 * n as f64).sin() + 0.1, (0.7 * n as f64).cos());
        let mut bins = Bins::<f64>::collect(size, signal);
        forward_all(&mut bins, &factors_from(&QuarterTurn::new(size)));
        for k in 0..size {
            let (mut re, mut im) = (0.0, 0.0);
            for n in 0..size {
                let (c, s) = unit(-2.0 * PI * (k * n) as f64 / size as f64);
                let (a, b) = signal(n);
                re += a * c - b * s;
                im += a * s + b * c;
            }
            let at = k.reverse_bits() >> (usize::BITS - size.ilog2());
            let have = (
                bins[at / LANES].re[at % LANES],
                bins[at / LANES].im[at % LANES],
            );
            assert!(
                (have.0 - re).abs() < 1e-13 * size as f64
                    && (have.1 - im).abs() < 1e-13 * size as f64,
                "bin {k}: have {have:?}, want {re} {im}"
            );
        }
    }

    #[test]
    fn a_quarter_turn_has_the_sines_and_cosines_of_its_angles() {
        for size in [8, 1024, 1 << 16] {
            let turn = QuarterTurn::new(size);
            assert_eq!(turn.size(), size);
            for k in 0..size {
                let ((cos, sin), (c, s)) = (turn.at(k), unit(FRAC_PI_2 * (k as f64 / size as f64)));
                let off = (cos - c).abs().max((sin - s).abs());
                assert!(off < 4e-16, "{k} of {size}: off by {off:e}");
            }
        }
    }

    #[test]
    fn the_inverse_undoes_the_forward_transform() {
        let size = 128;
        let signal = |n: usize| ((0.3 * n as f64).sin(), 1.0 / (n + 1) as f64);
        let mut bins = Bins::<f64>::collect(size, signal);
        let factors = factors_from(&QuarterTurn::new(size));
        forward_all(&mut bins, &factors);
        inverse_all(&mut bins, &factors);
        for n in 0..size {
            let (have, want) = (bins[n / LANES].re[n % LANES] / size as f64, signal(n).0);
            assert!(
                (have - want).abs() < 1e-14,
                "sample {n}: have {have}, want {want}"
            );
            let (have, want) = (bins[n / LANES].im[n % LANES] / size as f64, signal(n).1);
            assert!(
                (have - want).abs() < 1e-14,
                "sample {n}: have {have}, want {want}"
            );
        }
    }
}
