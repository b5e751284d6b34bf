//! The best minimum of many: starts spread evenly, few samples first, the best few on all samples. Each is found by [`minimise`].

use super::elements::Candidate;
use super::error::IdentifyError;
use super::target::Target;
use spring_pots::{Effort, Elements, Minimum, Problem, Slope, is_order, minimise};

/// Samples of the first pass.
const FEW: usize = 160;
/// Minima of the first pass that are followed on all samples.
const FOLLOWED: usize = 6;
/// Sums closer than this are one minimum.
const SAME: f64 = 1e-4;
/// Enough to see which of the followed minima is the lowest.
const CLOSE: Effort = Effort::to(1e-7, 25);
/// Effort of a fit that counts.
pub(super) const FINE: Effort = Effort::to(1e-11, 100);
/// A variable this near to an end of its range, over the range, is at the end.
const AT_END: f64 = 2e-4;
/// Share of the sum that a fixed end may cost.
const COST_OF_END: f64 = 1e-5;

#[derive(Clone, Debug)]
pub(super) struct Best {
    pub(super) elements: Elements,
    /// Sum of the squared residuals, weights in.
    pub(super) sum: f64,
    /// Numbers of the variables that are not at an end of their range, in order.
    pub(super) free: Vec<usize>,
    /// Minima beside it, and points of valleys that lead to it.
    pub(super) others: Vec<Minimum>,
}

/// Fits a candidate from `starts` starts.
pub(super) fn search(
    candidate: Candidate,
    target: &Target,
    starts: usize,
) -> Result<Best, IdentifyError> {
    // The noise is a parameter too, and the criterion of small samples divides by the remaining degrees of freedom.
    if target.len() <= candidate.parameters() + 2 {
        return Err(IdentifyError::TooFew {
            model: candidate.kind().name(),
            numbers: target.len(),
            parameters: candidate.parameters(),
        });
    }
    let ranges = ranges(candidate, target);
    let all = loose(&ranges);
    let few = target.thinned(FEW);
    let to = |target: &Target, start: &[f64], effort: Effort| {
        minimise(
            &Compared(candidate, target),
            &ranges,
            start,
            &all,
            &[],
            effort,
        )
    };
    // Few variables have few minima.
    let most = [1, 2, 5, 20].get(all.len()).copied().unwrap_or(starts);
    let mut found: Vec<Minimum> = (0..starts.min(most))
        .take_while(|_| !target.stops())
        .map(|n| to(&few, &start(candidate, target, n), CLOSE))
        .filter(|minimum| minimum.sum.is_finite())
        .collect();
    found.sort_by(|a, b| a.sum.total_cmp(&b.sum));
    found.dedup_by(|later, earlier| later.sum <= earlier.sum * (1.0 + SAME));
    found.truncate(FOLLOWED);
    let mut followed: Vec<Minimum> = (found.iter())
        .map(|minimum| to(target, &minimum.values, CLOSE))
        .filter(|minimum| minimum.sum.is_finite() && is_in_order(minimum, candidate))
        .collect();
    followed.sort_by(|a, b| a.sum.total_cmp(&b.sum));
    let best = polished(candidate, target, followed.iter().map(|one| &one.values))?;
    for minimum in &mut followed {
        let elements = candidate.sorted(Elements::from_variables(&minimum.values));
        minimum.values = elements.variables(candidate.joint());
    }
    Ok(Best {
        others: followed,
        ..best
    })
}

/// The minimum next to the first of these starts that leads to one, which may be a limit at the end of a valley.
pub(super) fn polished<'a>(
    candidate: Candidate,
    target: &Target,
    mut starts: impl Iterator<Item = &'a Vec<f64>>,
) -> Result<Best, IdentifyError> {
    let ranges = ranges(candidate, target);
    let all = loose(&ranges);
    let best = starts.find_map(|start| {
        let along =
            |from: &[f64]| minimise(&Compared(candidate, target), &ranges, from, &all, &[], FINE);
        let valley = along(start);
        let best = if valley.converged {
            Some(valley)
        } else {
            limit(candidate, target, &ranges, &valley, &all).or_else(|| {
                // A valley that falls no further in as many steps again counts as level.
                let further = along(&valley.values);
                let is_level = valley.sum <= further.sum * (1.0 + COST_OF_END);
                (further.converged || is_level).then_some(further)
            })
        };
        best.filter(|best| is_in_order(best, candidate))
    });
    let best = best.ok_or(IdentifyError::NotConverged {
        model: candidate.kind().name(),
    })?;
    Ok(at_ends(candidate, target, &ranges, best))
}

/// The limit of a valley along which a modulus goes to an end of its range, where its element is rigid or nothing: the slope dies out
/// on the way there, so no step ever meets the end. The modulus is put there and the others fitted.
fn limit(
    candidate: Candidate,
    target: &Target,
    ranges: &[(f64, f64)],
    valley: &Minimum,
    free: &[usize],
) -> Option<Minimum> {
    let moduli = free.iter().filter(|v| !is_order(**v));
    let ends = moduli.flat_map(|&v| [(v, ranges[v].0), (v, ranges[v].1)]);
    let limits = ends.map(|(end, at)| {
        let mut start = valley.values.clone();
        start[end] = at;
        let rest: Vec<usize> = free.iter().copied().filter(|v| *v != end).collect();
        let limit = minimise(
            &Compared(candidate, target),
            ranges,
            &start,
            &rest,
            &[],
            FINE,
        );
        (limit, rest)
    });
    let near = limits.filter(|(limit, _)| limit.sum <= valley.sum * (1.0 + COST_OF_END));
    let (limit, rest) = near.min_by(|a, b| a.0.sum.total_cmp(&b.0.sum))?;
    if limit.converged {
        Some(limit)
    } else {
        self::limit(candidate, target, ranges, &limit, &rest)
    }
}

/// The variables that are not fixed.
pub(super) fn loose(ranges: &[(f64, f64)]) -> Vec<usize> {
    let loose = |v: &usize| ranges[*v].0 < ranges[*v].1;
    (0..ranges.len()).filter(loose).collect()
}

/// Puts variables that are near an end of their range there, and fits the others once more, if that costs next to nothing.
fn at_ends(candidate: Candidate, target: &Target, ranges: &[(f64, f64)], best: Minimum) -> Best {
    // From 0 at the low end of the range to 1 at the high one.
    let share = |values: &[f64], v: usize| {
        let (low, high) = ranges[v];
        (values[v] - low) / (high - low)
    };
    let free = |values: &[f64], near: f64| -> Vec<usize> {
        let is_free = |v: &usize| (share(values, *v) - 0.5).abs() < 0.5 - near;
        (0..values.len()).filter(is_free).collect()
    };
    let inside = free(&best.values, AT_END);
    let mut ends = best.values.clone();
    for v in (0..ends.len()).filter(|v| !inside.contains(v)) {
        let (low, high) = ranges[v];
        ends[v] = if share(&ends, v) < 0.5 { low } else { high };
    }
    let fixed = minimise(
        &Compared(candidate, target),
        ranges,
        &ends,
        &inside,
        &[],
        FINE,
    );
    let is_good = fixed.converged && fixed.sum <= best.sum * (1.0 + COST_OF_END);
    let Minimum { values, sum, .. } = if is_good { fixed } else { best };
    let elements = candidate.sorted(Elements::from_variables(&values));
    Best {
        elements,
        sum,
        free: free(&elements.variables(candidate.joint()), 0.0),
        others: Vec::new(),
    }
}

/// Start n: the fractional parts of n times the powers of 1/φ, which fill a cube of d dimensions evenly (M. Roberts, *The unreasonable
/// effectiveness of quasirandom sequences*, 2018; φ^(d+1) = φ + 1). Start 0 is the middle.
fn start(candidate: Candidate, target: &Target, n: usize) -> Vec<f64> {
    let d = candidate.variables() as f64;
    let mut phi = 1.5;
    for _ in 0..40 {
        phi = libm::pow(1.0 + phi, 1.0 / (d + 1.0));
    }
    let mut share = 0.5;
    // Moduli lie around those of the record: an element in series may be much stiffer, one side by side much softer.
    let spread = target.span + 6.0;
    let mut values: Vec<f64> = (0..candidate.variables())
        .map(|k| {
            let step = libm::pow(phi, -(k as f64 + 1.0));
            share = 0.5 + n as f64 * step;
            share -= libm::floor(share);
            let (low, high) = candidate.range(k);
            match (is_order(k), n) {
                (false, _) => target.middle + (share - 0.5) * spread,
                (true, 0) => low + [0.6, 0.2][k / 2] * (high - low),
                (true, _) => low + (0.02 + 0.96 * share) * (high - low),
            }
        })
        .collect();
    for k in 0..values.len() {
        values[k] += match values.get(k + 1).filter(|_| !is_order(k)) {
            Some(order) => order * target.shift,
            None => 0.0,
        };
    }
    values
}

/// Largest ratio of a modulus to the moduli of the record, as a logarithm: e^14 is 10⁶.
const BEYOND: f64 = 14.0;

/// Low and high end of each variable.
pub(super) fn ranges(candidate: Candidate, target: &Target) -> Vec<(f64, f64)> {
    let width = BEYOND + 0.5 * target.span + target.shift.abs();
    (0..candidate.variables())
        .map(|variable| {
            if is_order(variable) || candidate.is_held(variable) {
                candidate.range(variable)
            } else {
                (target.middle - width, target.middle + width)
            }
        })
        .collect()
}

/// True unless the second order is the larger one, as it may be where a modulus is held.
fn is_in_order(minimum: &Minimum, candidate: Candidate) -> bool {
    let elements = candidate.sorted(Elements::from_variables(&minimum.values));
    !candidate.has_two_orders() || elements.order[0] >= elements.order[1]
}

/// A candidate against a record.
pub(super) struct Compared<'a>(pub(super) Candidate, pub(super) &'a Target<'a>);

impl Problem for Compared<'_> {
    fn count(&self) -> usize {
        self.1.len()
    }

    fn exact(&self) -> f64 {
        self.1.exact
    }

    fn residuals(&self, values: &[f64], each: &mut dyn FnMut(usize, f64, &[f64])) -> bool {
        let elements = Elements::from_variables(values);
        let each = |n, root: f64, slope: Slope| {
            each(n, root * slope.value, &slope.by.map(|by| root * by));
        };
        self.1.residuals(self.0, &elements, each)
    }
}

/// The next place at which to look for the least sum, of places in order with their sums: the vertex of the parabola through the
/// lowest three neighbours, or outwards as far as the range goes. None once a step is as near as wanted, or of fewer than three places.
pub(super) fn next_place(
    points: &[[f64; 2]],
    range: [f64; 2],
    near: f64,
    round: usize,
) -> Option<f64> {
    let last = points.len().checked_sub(3)? + 2;
    let lowest = (0..=last).min_by(|&a, &b| points[a][1].total_cmp(&points[b][1]))?;
    let place = |n: usize| points[n][0];
    let is_new = |at: f64| points.iter().all(|point| (point[0] - at).abs() > near);
    let outwards = match lowest {
        0 => (3.0 * place(0) - 2.0 * place(1)).max(range[0]),
        n if n == last => (3.0 * place(n) - 2.0 * place(n - 1)).min(range[1]),
        n => place(n),
    };
    if is_new(outwards) {
        return Some(outwards);
    }
    let three = lowest.clamp(1, last - 1);
    let three = [three - 1, three, three + 1];
    let [a, m, z] = three.map(place);
    let [fa, fm, fz] = three.map(|n| points[n][1] / points[lowest][1]);
    // Newton's form: f = fa + s·(x − a) + c·(x − a)(x − m).
    let s = (fm - fa) / (m - a);
    let c = ((fz - fm) / (z - m) - s) / (z - a);
    let vertex = (0.5 * (a + m) - 0.5 * s / c).clamp(a, z);
    let is_there = c > 0.0 && (vertex - place(lowest)).abs() <= near;
    if is_there || c.is_nan() || z - a <= 2.0 * near {
        return None;
    }
    // Every third step halves the wider side, in case the vertices come from one side.
    Some(if c > 0.0 && is_new(vertex) && !round.is_multiple_of(3) {
        vertex
    } else if z - m > m - a {
        0.5 * (m + z)
    } else {
        0.5 * (a + m)
    })
}
