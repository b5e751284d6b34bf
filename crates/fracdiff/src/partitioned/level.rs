//! Taps of one block length: a convolution by FFT whose work is dealt out over the ticks of a block.

use crate::Real;
use crate::fft::{Bins, LANES, accumulate, factors, forward, forward_8, inverse, inverse_8, unit};
use alloc::{vec, vec::Vec};
use core::f64::consts::FRAC_PI_2;

/// Block length of the first level; the head is twice as long, less the newest sample.
pub(super) const FIRST: usize = 32;
/// Block butterflies in one unit of work.
const BUTTERFLIES: usize = 2;
/// Spectra multiplied in one unit of work, at most.
const PRODUCTS: usize = 8;

/// P partitions of B taps each, lags 2B to (P + 2)·B − 1.
/// ```text
/// z[i] = (x[i − B] + j·x[i])·e^(jπi/2B),  i < B:  Z = FFT z,   V = Σ_p Z_p·H_p,   v = IFFT V
/// y[i] = Im(v[i]·e^(−jπi/2B))
/// ```
/// Two real blocks folded into one complex block turn real convolution modulo X^2B + 1 into a cyclic one of B complex numbers; the older
/// half of the result, spoilt by the folding, lies in the real part and is dropped (overlap-save; R. E. Crandall and B. Fagin, *Discrete
/// weighted transforms and large-integer arithmetic*, Math. Comp. 62, 1994). A block is complete after B samples, worked on during the next
/// B ticks and read during the B after that: hence lag 2B (W. G. Gardner, *Efficient convolution without input-output delay*, J. Audio Eng.
/// Soc. 43, 1995).
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Level<F> {
    partitions: usize,
    /// (cos, sin) of πi/2B.
    twist: Vec<[F; 2]>,
    factors: Vec<Bins<F>>,
    /// H, block by block, in each block partition by partition, newest first.
    spectra: Vec<Bins<F>>,
    schedule: Schedule,
}

/// The work of B ticks, in units of about the same cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Schedule {
    /// Blocks of eight bins, B/8; a power of two.
    blocks: usize,
    /// Passes over all blocks, one way.
    passes: usize,
    /// log2 of the units in a pass.
    pass_shift: u32,
    /// log2 of the units that multiply the spectra of one block.
    product_shift: u32,
    /// Partitions in one such unit.
    products: usize,
}

impl Schedule {
    pub(super) fn new(blocks: usize, partitions: usize) -> Self {
        let units = partitions.div_ceil(PRODUCTS).next_power_of_two();
        Self {
            blocks,
            passes: blocks.ilog2() as usize,
            pass_shift: (blocks / 2 / BUTTERFLIES).ilog2(),
            product_shift: units.ilog2(),
            products: partitions.div_ceil(units),
        }
    }

    /// Units of all passes one way.
    fn transform(&self) -> usize {
        self.passes << self.pass_shift
    }

    /// Units of the products.
    fn product(&self) -> usize {
        self.blocks << self.product_shift
    }

    /// All units.
    pub(super) fn units(&self) -> usize {
        2 * self.transform() + self.product()
    }
}

/// The history of one signal in a level.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = "F: Real"))]
pub(super) struct LevelHistory<F> {
    /// The block before the one that is coming in; overwritten as samples come.
    before: Vec<F>,
    /// z, coming in; what is worked on; v, going out. They change places every B ticks.
    coming: Vec<Bins<F>>,
    work: Vec<Bins<F>>,
    going: Vec<Bins<F>>,
    /// Z of the last P blocks, block of bins by block of bins, in each a ring.
    spectra: Vec<Bins<F>>,
    newest: usize,
    tick: usize,
    /// Work done and owed, in units and units times B; both follow from the tick.
    #[cfg_attr(feature = "serde", serde(skip))]
    unit: usize,
    #[cfg_attr(feature = "serde", serde(skip))]
    owed: usize,
}

/// Histories that were saved, if they are whole.
#[cfg(feature = "serde")]
pub(super) fn whole<'de, F: Real, D: serde::Deserializer<'de>>(
    deserializer: D,
) -> Result<Vec<LevelHistory<F>>, D::Error> {
    use serde::{Deserialize as _, de::Error as _};
    let mut levels = Vec::<LevelHistory<F>>::deserialize(deserializer)?;
    for level in &mut levels {
        level.go_on().map_err(D::Error::custom)?;
    }
    Ok(levels)
}

#[cfg(feature = "serde")]
impl<F> LevelHistory<F> {
    /// Checks the lengths and places of a saved history, and finds the work that was done.
    fn go_on(&mut self) -> Result<(), &'static str> {
        let length = self.before.len();
        let blocks = length / LANES;
        if length < FIRST || !length.is_power_of_two() {
            return Err("the block of a history is not 32, 64, 128, … samples long");
        }
        let all = [&self.coming, &self.work, &self.going];
        if all.iter().any(|bins| bins.len() != blocks) {
            return Err("the blocks of a history differ in length");
        }
        let partitions = self.spectra.len() / blocks;
        if partitions == 0 || !self.spectra.len().is_multiple_of(blocks) {
            return Err("the spectra of a history are no whole blocks");
        }
        if self.newest >= partitions || self.tick >= length {
            return Err("a position of a history is outside it");
        }
        let done = self.tick * Schedule::new(blocks, partitions).units();
        (self.unit, self.owed) = (done / length, done % length);
        Ok(())
    }
}

impl<F: Real> Level<F> {
    /// Blocks of B = `length` taps (a power of two, 32 at least), tap i of lag 2B + i; the last block is
    /// filled up with zeros. Spectra are computed in `f64` and rounded once.
    pub(super) fn new(length: usize, taps: &[f64]) -> Self {
        let blocks = length / LANES;
        let partitions = taps.len().div_ceil(length);
        let schedule = Schedule::new(blocks, partitions);
        let phase = |i: usize| FRAC_PI_2 * i as f64 / length as f64;
        let wide = Level::<f64> {
            partitions,
            twist: Vec::new(),
            factors: factors(length),
            spectra: Vec::new(),
            schedule,
        };
        let mut spectra = vec![Bins::default(); blocks * partitions];
        for (p, taps) in taps.chunks(length).enumerate() {
            let mut bins = Bins::<f64>::collect(length, |i| {
                let (cos, sin) = unit(phase(i));
                // The inverse transform is not scaled: 1/B goes in here.
                let tap = taps.get(i).map_or(0.0, |tap| tap / length as f64);
                (tap * cos, tap * sin)
            });
            for unit in 0..schedule.transform() {
                wide.transform(&mut bins, unit, Way::Forward);
            }
            for (b, mut bins) in bins.into_iter().enumerate() {
                forward_8(&mut bins);
                spectra[b * partitions + p] = Bins {
                    re: bins.re.map(F::from_f64),
                    im: bins.im.map(F::from_f64),
                };
            }
        }
        let twist = |i: usize| {
            let (cos, sin) = unit(phase(i));
            [F::from_f64(cos), F::from_f64(sin)]
        };
        Self {
            partitions,
            twist: (0..length).map(twist).collect(),
            factors: factors(length),
            spectra,
            schedule,
        }
    }

    pub(super) fn at_rest(&self) -> LevelHistory<F> {
        let zeros = vec![Bins::default(); self.schedule.blocks];
        LevelHistory {
            before: vec![F::ZERO; self.twist.len()],
            coming: zeros.clone(),
            work: zeros.clone(),
            going: zeros,
            spectra: vec![Bins::default(); self.spectra.len()],
            newest: 0,
            tick: 0,
            unit: 0,
            owed: 0,
        }
    }

    /// True if a history is of this level's shape.
    #[inline]
    pub(super) fn fits(&self, history: &LevelHistory<F>) -> bool {
        history.before.len() == self.twist.len() && history.spectra.len() == self.spectra.len()
    }

    /// Takes x\[n\] in, does the share of this tick, and returns what this level's lags contribute to S\[n+1\].
    #[inline]
    pub(super) fn advance(&self, history: &mut LevelHistory<F>, x: F) -> F {
        let length = self.twist.len();
        let tick = history.tick;
        if let (Some(&[cos, sin]), Some(before), Some(coming)) = (
            self.twist.get(tick),
            history.before.get_mut(tick),
            history.coming.get_mut(tick / LANES),
        ) {
            // z[i] = (x[i − B] + j·x[i])·e^(jπi/2B)
            coming.re[tick % LANES] = *before * cos - x * sin;
            coming.im[tick % LANES] = *before * sin + x * cos;
            *before = x;
        }
        history.owed += self.schedule.units();
        while history.owed >= length {
            history.owed -= length;
            self.work(history);
            history.unit += 1;
        }
        history.tick += 1;
        if history.tick == length {
            history.tick = 0;
            history.unit = 0;
            let newest = history.newest;
            history.newest = if newest == 0 { self.partitions } else { newest } - 1;
            core::mem::swap(&mut history.going, &mut history.work);
            core::mem::swap(&mut history.work, &mut history.coming);
        }
        // y[i] = Im(v[i]·e^(−jπi/2B))
        let tick = history.tick;
        match (self.twist.get(tick), history.going.get(tick / LANES)) {
            (Some(&[cos, sin]), Some(going)) => {
                going.im[tick % LANES] * cos - going.re[tick % LANES] * sin
            }
            // A tick is always below the length.
            _ => F::ZERO,
        }
    }

    /// Does the next unit: forward passes, then products, then inverse passes.
    #[inline]
    fn work(&self, history: &mut LevelHistory<F>) {
        let (transform, product) = (self.schedule.transform(), self.schedule.product());
        let unit = history.unit;
        if unit < transform {
            self.transform(&mut history.work, unit, Way::Forward);
        } else if unit < transform + product {
            self.product(history, unit - transform);
        } else {
            self.transform(&mut history.work, unit - transform - product, Way::Inverse);
        }
    }

    /// One unit of a pass, BUTTERFLIES block butterflies; from the greatest distance to the smallest on the way forward.
    #[inline]
    fn transform(&self, work: &mut [Bins<F>], unit: usize, way: Way) {
        let Schedule {
            passes, pass_shift, ..
        } = self.schedule;
        let pass = unit >> pass_shift;
        let first = (unit & ((1 << pass_shift) - 1)) * BUTTERFLIES;
        let shift = match way {
            Way::Forward => passes - 1 - pass,
            Way::Inverse => pass,
        };
        let half = 1 << shift;
        // A unit is a part of one pair of halves, or several whole pairs.
        let (run, pairs) = if half >= BUTTERFLIES {
            (BUTTERFLIES, 1)
        } else {
            (half, BUTTERFLIES / half)
        };
        for pair in 0..pairs {
            let butterfly = first + pair * run;
            let within = butterfly & (half - 1);
            let start = 2 * (butterfly - within) + within;
            let factors = self.factors.get(half - 1 + within..half - 1 + within + run);
            let Some(pair) = work.get_mut(start..start + half + run) else {
                return;
            };
            if let (Some((low, high)), Some(factors)) = (pair.split_at_mut_checked(half), factors) {
                match way {
                    Way::Forward => forward(low, high, factors),
                    Way::Inverse => inverse(low, high, factors),
                }
            }
        }
    }

    /// One unit of the products of a block of bins. The first stores the new spectrum, the last leaves
    /// the sum ready for the inverse passes.
    #[inline]
    fn product(&self, history: &mut LevelHistory<F>, unit: usize) {
        let Schedule {
            product_shift,
            products,
            ..
        } = self.schedule;
        let block = unit >> product_shift;
        let part = unit & ((1 << product_shift) - 1);
        let (first, newest) = (part * products, history.newest);
        let row = block * self.partitions..(block + 1) * self.partitions;
        let (Some(bins), Some(ring), Some(filter)) = (
            history.work.get_mut(block),
            history.spectra.get_mut(row.clone()),
            self.spectra.get(row),
        ) else {
            return;
        };
        if part == 0 {
            forward_8(bins);
            if let Some(slot) = ring.get_mut(newest) {
                *slot = *bins;
            }
            *bins = Bins::default();
        }
        // V ← V + Σ Z_p·H_p: the ring from the newest to its end, then from its start.
        let (Some((start, end)), last) = (
            ring.split_at_checked(newest),
            (first + products).min(self.partitions),
        ) else {
            return;
        };
        let turn = end.len().clamp(first, last);
        if let (Some(x), Some(h)) = (end.get(first..turn), filter.get(first..turn)) {
            accumulate(bins, x, h);
        }
        let from = turn.max(end.len());
        if let (Some(x), Some(h)) = (
            start.get(from - end.len()..last.max(from) - end.len()),
            filter.get(from..last.max(from)),
        ) {
            accumulate(bins, x, h);
        }
        if part + 1 == 1 << product_shift {
            inverse_8(bins);
        }
    }
}

/// Direction of a transform.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Way {
    Forward,
    Inverse,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_units_of_a_block_are_done_when_it_ends_at_most_two_in_a_tick() {
        for length in [32, 256, 2048] {
            for partitions in [1, 2, 8, 9, 14, 17, 32] {
                let taps = vec![1.0; partitions * length];
                let level = Level::<f64>::new(length, &taps);
                let mut history = level.at_rest();
                let (mut done, mut most) = (0, 0);
                for tick in 0..length {
                    let before = history.unit;
                    level.advance(&mut history, 1.0);
                    if tick + 1 < length {
                        most = most.max(history.unit - before);
                        done = history.unit;
                    }
                }
                let units = level.schedule.units();
                // The last tick does what is left and starts again at 0.
                assert!(
                    units - done <= 2,
                    "{length} {partitions}: {done} of {units}"
                );
                assert!(most <= 2, "{length} {partitions}: {most} units in a tick");
                assert_eq!((history.tick, history.unit, history.owed), (0, 0, 0));
            }
        }
    }
}
