//! The arithmetic of one step, block by block. The order of summation is part of the numerical contract: lane l adds
//! the modes l, l + 8, …

use crate::Real;

/// Modes side by side in one block.
pub(super) const LANES: usize = 8;

/// A number of each mode of a block.
pub(super) type Block<F> = [F; LANES];

/// d and W of a block.
type Coefficients<'a, F> = (&'a Block<F>, &'a Block<F>);

/// One step of the modes, z ← z + (x − d·z), without compensation: Σ W·z of each lane.
#[inline(always)]
pub(super) fn advance_plain<'a, F: Real>(
    blocks: impl Iterator<Item = (&'a mut Block<F>, Coefficients<'a, F>)>,
    x: F,
) -> Block<F> {
    let mut sums = [F::ZERO; LANES];
    for (states, (decays, weights)) in blocks {
        // A block is loaded, changed and stored as a whole, or it would not become vectors.
        let mut next = *states;
        for lane in 0..LANES {
            next[lane] += x - decays[lane] * next[lane];
        }
        *states = next;
        for lane in 0..LANES {
            sums[lane] += weights[lane] * next[lane];
        }
    }
    sums
}

/// States of a block, and their compensation words.
type Compensated<'a, F> = (&'a mut Block<F>, &'a mut Block<F>);

/// The same with compensation, added to `sums`. They do not wait for the new words.
#[inline(always)]
pub(super) fn advance_compensated<'a, F: Real>(
    blocks: impl Iterator<Item = (Compensated<'a, F>, Coefficients<'a, F>)>,
    x: F,
    mut sums: Block<F>,
) -> Block<F> {
    for ((states, carries), (decays, weights)) in blocks {
        let (mut next, mut rest) = (*states, *carries);
        for lane in 0..LANES {
            let state = next[lane];
            let addend = (x - decays[lane] * state) + rest[lane];
            next[lane] = state + addend;
            // Dekker's sum, three operations instead of Knuth's six: exact while |addend| ≤ |state|. Where the
            // input is larger than a slow state it is the state that is next to nothing.
            rest[lane] = addend - (next[lane] - state);
        }
        (*states, *carries) = (next, rest);
        for lane in 0..LANES {
            sums[lane] += weights[lane] * next[lane];
        }
    }
    sums
}
