//! The best minimum of many: starts spread evenly, few samples first, the best few on all samples.

use super::candidate::Candidate;
use super::elements::{Elements, Variable, variables};
use super::error::IdentifyError;
use super::problem::{Effort, Minimum, minimise, ranges};
use super::target::Target;

/// Samples of the first pass.
const FEW: usize = 160;
/// Minima of the first pass that are followed on all samples.
const FOLLOWED: usize = 6;
/// Sums closer than this are one minimum.
const SAME: f64 = 1e-4;
const ROUGH: Effort = Effort {
    tolerance: 1e-5,
    patience: 12,
};
/// Enough to see which of the followed minima is the lowest.
const CLOSE: Effort = Effort {
    tolerance: 1e-7,
    patience: 25,
};
/// Effort of a fit that counts.
pub(super) const FINE: Effort = Effort {
    tolerance: 1e-11,
    patience: 100,
};
/// A variable so near to an end of its range, over the range, is at the end.
const AT_END: f64 = 2e-4;
/// A fixed end may cost so much of the sum.
const COST_OF_END: f64 = 1e-5;

/// The best minimum.
#[derive(Clone, Debug)]
pub(super) struct Best {
    pub(super) elements: Elements,
    /// Sum of the squared residuals, weights in.
    pub(super) sum: f64,
    /// Numbers of the variables that are not at an end of their range, in the order of [`variables`].
    pub(super) free: Vec<usize>,
}

/// Fits a candidate from so many starts.
pub(super) fn search(
    candidate: Candidate,
    target: &Target,
    starts: usize,
) -> Result<Best, IdentifyError> {
    if target.len() <= candidate.parameters() {
        return Err(IdentifyError::TooFew {
            model: candidate.kind().name(),
            numbers: target.len(),
            parameters: candidate.parameters(),
        });
    }
    let ranges = ranges(candidate, target);
    let all: Vec<usize> = (0..ranges.len()).collect();
    let few = target.thinned(FEW);
    let mut found: Vec<Minimum> = (0..starts)
        .take_while(|_| !target.stops())
        .map(|n| start(candidate, target, n))
        .map(|start| minimise(candidate, &few, &ranges, &start, &all, ROUGH))
        .filter(|minimum| minimum.sum.is_finite())
        .collect();
    found.sort_by(|a, b| a.sum.total_cmp(&b.sum));
    found.dedup_by(|later, earlier| later.sum <= earlier.sum * (1.0 + SAME));
    found.truncate(FOLLOWED);
    let mut followed: Vec<Minimum> = (found.iter())
        .map(|minimum| minimise(candidate, target, &ranges, &minimum.values, &all, CLOSE))
        .filter(|minimum| minimum.sum.is_finite())
        .collect();
    followed.sort_by(|a, b| a.sum.total_cmp(&b.sum));
    // The lowest that converges; one that creeps along a valley without end is none.
    let best = (followed.iter())
        .map(|minimum| minimise(candidate, target, &ranges, &minimum.values, &all, FINE))
        .find(|minimum| minimum.converged);
    let best = best.ok_or(IdentifyError::NotConverged {
        model: candidate.kind().name(),
    })?;
    Ok(at_ends(candidate, target, &ranges, best))
}

/// Fixes variables that have come to an end of their range, and fits the others once more.
fn at_ends(candidate: Candidate, target: &Target, ranges: &[(f64, f64)], best: Minimum) -> Best {
    let mut values = best.values.clone();
    let mut free = Vec::new();
    for (v, &(low, high)) in ranges.iter().enumerate() {
        let place = (values[v] - low) / (high - low);
        if place < AT_END {
            values[v] = low;
        } else if place > 1.0 - AT_END {
            values[v] = high;
        } else {
            free.push(v);
        }
    }
    let mut chosen = (best.values, best.sum, (0..ranges.len()).collect());
    if free.len() < ranges.len() {
        let fixed = minimise(candidate, target, ranges, &values, &free, FINE);
        if fixed.converged && fixed.sum <= best.sum * (1.0 + COST_OF_END) {
            chosen = (fixed.values, fixed.sum, free);
        }
    }
    let (values, sum, free) = chosen;
    let elements = Elements::from_variables(candidate, &values);
    let sorted = elements.sorted(candidate);
    let free = if sorted == elements {
        free
    } else {
        // The pairs of the two spring-pots change places.
        let mut swapped: Vec<usize> = free
            .iter()
            .map(|&v| if v < 4 { v ^ 2 } else { v })
            .collect();
        swapped.sort_unstable();
        swapped
    };
    Best {
        elements: sorted,
        sum,
        free,
    }
}

/// Start n: the fractional parts of n times the powers of 1/φ, which fill a cube of d dimensions evenly (M. Roberts, *The unreasonable
/// effectiveness of quasirandom sequences*, 2018; φ^(d+1) = φ + 1). Start 0 is the middle.
fn start(candidate: Candidate, target: &Target, n: usize) -> Vec<f64> {
    let variables = variables(candidate);
    let d = variables.len() as f64;
    let mut phi = 1.5;
    for _ in 0..40 {
        phi = libm::pow(1.0 + phi, 1.0 / (d + 1.0));
    }
    let mut share = 0.5;
    // Moduli lie around those of the record: an element in series may be much stiffer, one side by side much softer.
    let spread = target.span + 6.0;
    (variables.iter().enumerate())
        .map(|(k, variable)| {
            let step = libm::pow(phi, -(k as f64 + 1.0));
            share = 0.5 + n as f64 * step;
            share -= libm::floor(share);
            match variable {
                Variable::Modulus(_) => target.middle + (share - 0.5) * spread,
                Variable::Order(i) if n == 0 => [0.6, 0.2][*i],
                Variable::Order(_) => 0.02 + 0.96 * share,
            }
        })
        .collect()
}
