//! What a function leaves of a record: noise, or something that it lacks.

use super::record::InputOutput;
use std::vec::Vec;

/// Blocks of a record, and their samples at least.
const BLOCKS: usize = 50;
const SAMPLES: usize = 20;
/// Neighbouring samples of a block that are so much alike are no white noise.
const ALIKE: f64 = 0.8;
/// The same of a whole record, where chance is less.
const ALIKE_ALL: f64 = 0.3;
/// A share of the output of a block that is much.
const MUCH: f64 = 0.05;

/// A stretch of a record that a function does not explain, though what it leaves there is no noise.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Unexplained {
    /// From here on, s.
    pub from_s: f64,
    /// To here, s.
    pub to_s: f64,
    /// Root mean square of what is left, over that of the output there.
    pub share: f64,
}

/// Record less model.
pub(super) fn left(record: &InputOutput, model: &[f64]) -> Vec<f64> {
    let pairs = record.output.iter().zip(model);
    pairs.map(|(y, model)| y - model).collect()
}

/// Correlation of neighbouring samples.
pub(super) fn neighbours(left: &[f64]) -> f64 {
    let shifted = left.get(1..).unwrap_or_default();
    let product = |other: &[f64]| -> f64 { left.iter().zip(other).map(|(a, b)| a * b).sum() };
    let alike = product(shifted) / product(left);
    if alike.is_finite() { alike } else { 0.0 }
}

/// Standard errors of white noise are to be multiplied by this: neighbours that are alike count as fewer samples.
///
/// ```text
/// √((1 + ρ)/(1 − ρ)),   √n at most
/// ```
pub(super) fn less_sure(neighbours: f64, samples: usize) -> f64 {
    let alike = neighbours.clamp(0.0, 1.0);
    libm::sqrt(((1.0 + alike) / (1.0 - alike)).min(samples as f64))
}

/// The block of which most is left, if that is much and no noise. A record that grows is small where it begins, so that what a function
/// lacks there is nothing beside its end.
pub(super) fn unexplained(record: &InputOutput, left: &[f64]) -> Option<Unexplained> {
    if neighbours(left) < ALIKE_ALL {
        return None;
    }
    let samples = (left.len() / BLOCKS).max(SAMPLES);
    let blocks = left
        .chunks_exact(samples)
        .zip(record.output.chunks_exact(samples))
        .zip(record.time_s.chunks_exact(samples));
    let judged = blocks.map(|((left, output), time)| {
        let power = |signal: &[f64]| signal.iter().map(|x| x * x).sum::<f64>();
        let found = Unexplained {
            from_s: time[0],
            to_s: time[samples - 1],
            share: libm::sqrt(power(left) / power(output)),
        };
        (found, neighbours(left))
    });
    judged
        .filter(|(found, alike)| found.share > MUCH && found.share.is_finite() && *alike > ALIKE)
        .map(|(found, _)| found)
        .max_by(|a, b| a.share.total_cmp(&b.share))
}
