//! The arithmetic of one step, block by block. The order of summation is part of the numerical contract: lane l adds
//! the modes l, l + 8, …

use crate::Real;

/// Modes side by side in one block.
pub(super) const LANES: usize = 8;

/// One step of the modes of D axes, z ← z + (x − d·z), without compensation; adds Σ W·z of each lane to `lanes`.
#[inline(always)]
pub(super) fn advance_plain<F: Real, const D: usize>(
    states: [&mut [[F; LANES]]; D],
    decays: &[[F; LANES]],
    weights: &[[F; LANES]],
    x: [F; D],
    lanes: &mut [[F; LANES]; D],
) {
    let mut sums = *lanes;
    let mut axes = states.map(<[_]>::iter_mut);
    for (decays, weights) in decays.iter().zip(weights) {
        for ((axis, sums), x) in axes.iter_mut().zip(&mut sums).zip(x) {
            if let Some(states) = axis.next() {
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
        }
    }
    *lanes = sums;
}

/// Blocks of states, and of their compensation words.
pub(super) type Compensated<'a, F> = (&'a mut [[F; LANES]], &'a mut [[F; LANES]]);

/// The same with compensation. The sums do not wait for the new words.
#[inline(always)]
pub(super) fn advance_compensated<F: Real, const D: usize>(
    axes: [Compensated<'_, F>; D],
    decays: &[[F; LANES]],
    weights: &[[F; LANES]],
    x: [F; D],
    lanes: &mut [[F; LANES]; D],
) {
    let mut sums = *lanes;
    let mut axes = axes.map(|(states, carries)| states.iter_mut().zip(carries));
    for (decays, weights) in decays.iter().zip(weights) {
        for ((axis, sums), x) in axes.iter_mut().zip(&mut sums).zip(x) {
            if let Some((states, carries)) = axis.next() {
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
        }
    }
    *lanes = sums;
}
