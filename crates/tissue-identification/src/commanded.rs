//! The channel of a table that was commanded, and its levels.
//! ```text
//! level:  s ≤ 1.25·s_Δ/√2     s the standard deviation, s_Δ the root mean square of the first differences; or s ≤ 10⁻³ of the mean
//! ```
//! White noise has `s = s_Δ/√2`, and whatever moves from sample to sample far more. A machine that commands a stress keeps it at levels, one that
//! commands a strain keeps the strain; the answering channel carries the noise that matters, and a fit compares it: a model driven by a noisy answer
//! differentiates its noise. Rows on the way from a level to the next are levels of their own.

use std::ops::Range;

/// s over that of white noise, at most.
const WITHIN: f64 = 1.25;
/// A controlled value may wander by this share of itself.
const CONTROLLED: f64 = 1e-3;
/// Levels of a channel that was commanded, at most.
const LEVELS: usize = 8;
/// Samples of a level that lasts, and a share of the largest that is rest.
const LASTS: usize = 4;
const REST: f64 = 0.01;

/// A stretch of samples at one value.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Level {
    pub(super) rows: Range<usize>,
    /// The mean, or 0 where that is rest.
    pub(super) value: f64,
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// True if the values are one within their own noise.
pub(super) fn is_level(values: &[f64]) -> bool {
    let (mean, freedom) = (mean(values), values.len().saturating_sub(1).max(1) as f64);
    let square: f64 = values.iter().map(|x| (x - mean) * (x - mean)).sum();
    let steps = values.windows(2).map(|pair| pair[1] - pair[0]);
    let white = steps.map(|step| step * step).sum::<f64>() / (2.0 * freedom);
    let deviation = libm::sqrt(square / freedom);
    deviation <= WITHIN * libm::sqrt(white) || deviation <= CONTROLLED * mean.abs()
}

/// The levels of a channel; `None` if it was not commanded: if it moves, or stays at rest.
pub(super) fn levels(values: &[f64]) -> Option<Vec<Level>> {
    let mut open: Vec<Range<usize>> = std::iter::once(0..values.len()).collect();
    let mut found = Vec::new();
    while let Some(rows) = open.pop() {
        if found.len() + open.len() >= LEVELS {
            return None;
        }
        let part = &values[rows.clone()];
        if is_level(part) {
            let value = mean(part);
            found.push(Level { rows, value });
            continue;
        }
        let steps = part.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        let largest = steps.enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let cut = rows.start + largest.0 + 1;
        // The earlier part is looked at first.
        open.extend([cut..rows.end, rows.start..cut]);
    }
    let most = found
        .iter()
        .map(|level| level.value.abs())
        .fold(0.0, f64::max);
    for level in &mut found {
        level.value *= f64::from(u8::from(level.value.abs() > REST * most));
    }
    let lasting = found.iter().filter(|level| level.rows.len() >= LASTS);
    let lasting: usize = lasting.map(|level| level.rows.len()).sum();
    let is_held = most > 0.0 && 2 * lasting > values.len();
    is_held.then_some(found)
}

/// The levels of a commanded stress; none if the strain was commanded, or neither: the one with fewer levels was, the strain if both have as many.
pub(super) fn of_stress(strain: &[f64], stress: &[f64]) -> Option<Vec<Level>> {
    let held = levels(stress)?;
    let is_answer = levels(strain).is_none_or(|strain| {
        // Both at one level are those of a spring.
        strain.len() > held.len() || strain.len() == 1
    });
    is_answer.then_some(held)
}

/// A commanded strain without its noise; others as they are.
pub(super) fn without_noise(strain: &mut [f64]) {
    let lasting = levels(strain).into_iter().flatten();
    for level in lasting.filter(|level| level.rows.len() >= LASTS) {
        strain[level.rows].fill(level.value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Normal numbers from 12 uniform ones.
    fn noise(seed: u64) -> impl FnMut() -> f64 {
        let mut random = testkit::Random(seed);
        move || (0..12).map(|_| random.between(-0.5, 0.5)).sum()
    }

    #[test]
    fn levels_are_told_from_what_answers_them() {
        let times: Vec<f64> = (0..60).map(|n| 0.1 * 1.12_f64.powi(n)).collect();
        for seed in 0..200 {
            for share in [0.0, 1e-3, 0.01] {
                let mut draw = noise(seed);
                let mut noisy = |value: f64| value * (1.0 + share * draw());
                let held: Vec<f64> = (0..60).map(|n| noisy(f64::from(u8::from(n > 0)))).collect();
                let answer: Vec<f64> = times.iter().map(|t| noisy(t.powf(0.15))).collect();
                let found = of_stress(&answer, &held).expect("a stress that is held");
                let ends: Vec<usize> = found.iter().map(|level| level.rows.end).collect();
                assert_eq!(ends, [1, 60], "{seed} {share}");
                assert_eq!(found[0].value.to_bits(), 0.0_f64.to_bits());
                assert!((found[1].value - 1.0).abs() <= share, "{found:?}");
                assert_eq!(of_stress(&held, &answer), None, "{seed} {share}");
            }
        }
    }
}
