//! Rows of a block that belong to one measurement.
//! ```text
//! restart   the clock goes back beyond the middle of the run so far, or turns and comes so far
//! label     a column of steps, sets or specimens changes
//! jump      the temperature moves by more than 1 K and by five times its usual step
//! ```
//! A clock is the column of time, or of frequency. No cut leaves fewer than three rows: a stamp out of order stays where it is, and is an
//! error of the record. A motion whose clock runs on over a label is one.

use super::find::Block;
use std::collections::BTreeSet;
use std::ops::Range;

/// Rows of a segment, at least.
const LEAST: usize = 3;
/// A temperature is constant within this, K, or within `USUAL_STEPS` of its usual steps, if that is more.
const WITHIN_K: f64 = 1.0;
const USUAL_STEPS: f64 = 5.0;

/// Rows at which the clock restarts.
pub(super) fn restarts(clock: &[f64]) -> Vec<usize> {
    let known = clock.iter().copied().enumerate();
    let known: Vec<(usize, f64)> = known.filter(|at| at.1.is_finite()).collect();
    let mut cuts = Vec::new();
    let (mut start, mut rises) = (0, None);
    for k in 1..known.len() {
        let step = known[k].1 - known[k - 1].1;
        let up = step > 0.0;
        if step == 0.0 {
            continue;
        }
        let Some(direction) = rises else {
            rises = Some(up);
            continue;
        };
        if up == direction || k - start < LEAST {
            continue;
        }
        let middle = known[usize::midpoint(start, k)].1;
        let is_back = |value: f64| (value <= middle) == direction;
        // The first pair may jump; those that follow must keep the direction.
        let mut further = known[k..]
            .windows(2)
            .take_while(|pair| (pair[1].1 - pair[0].1 > 0.0) == up);
        if is_back(known[k].1) || further.any(|pair| is_back(pair[1].1)) {
            cuts.push(known[k].0);
            (start, rises) = (k, None);
        }
    }
    cuts
}

/// Rows at which the text of a column changes; empty if it changes too often.
pub(super) fn changes(block: &Block, place: usize) -> Vec<usize> {
    let cuts: Vec<usize> = (1..block.rows.len())
        .filter(|&row| block.label(row, place) != block.label(row - 1, place))
        .collect();
    let few = LEAST * (cuts.len() + 1) <= block.rows.len();
    if few { cuts } else { Vec::new() }
}

/// Rows at which the temperature jumps.
pub(super) fn jumps(temperature: &[f64]) -> Vec<usize> {
    let pairs = temperature.windows(2);
    let steps: Vec<f64> = pairs.map(|pair| (pair[1] - pair[0]).abs()).collect();
    let mut sorted = steps.clone();
    sorted.retain(|step| step.is_finite());
    sorted.sort_by(f64::total_cmp);
    let usual = sorted.get(sorted.len() / 2).copied().unwrap_or(0.0);
    let most = WITHIN_K.max(USUAL_STEPS * usual);
    let jumps = steps.iter().enumerate().filter(|(_, step)| **step > most);
    jumps.map(|(row, _)| row + 1).collect()
}

/// Ranges of rows between the cuts, without those that would leave too few rows.
pub(super) fn between(cuts: impl IntoIterator<Item = usize>, rows: usize) -> Vec<Range<usize>> {
    let cuts: BTreeSet<usize> = cuts.into_iter().collect();
    let mut ranges = Vec::new();
    let mut start = 0;
    for cut in cuts {
        if cut - start >= LEAST && rows - cut >= LEAST {
            ranges.push(start..cut);
            start = cut;
        }
    }
    ranges.push(start..rows);
    ranges
}
