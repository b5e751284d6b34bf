//! The straight line through the readings of an instrument, with one offset for each way of the force.
//!
//! ```text
//! F = g·u + c↑ or c↓ + e        by least squares: (g, c↑, c↓) = A⁺F,  A⁺ the pseudo-inverse of the rows (u, 1, 0) or (u, 0, 1)
//! ```
//! Half an interval is t·σ·‖row of A⁺‖₂ for the scatter σ with t of Student, and half a step of the instrument times ‖row of A⁺‖₁, at its worst.

use haptic_document::{Failure, bad_input};
use haptic_measurement::MEASURE_FORCE_LIMIT;
use haptic_trial::plant_file::calibration::MeasuredNumber;
use nalgebra::{DMatrix, DVector};
use serde::Serialize;
use tissue_identification::student;

/// A reading of the instrument.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(super) struct Point {
    /// Force that the device says it made, N.
    pub commanded_n: f64,
    /// Force on the instrument, N.
    pub force_n: f64,
    /// Reading of the device's sensor, N; NaN without one.
    pub sensed_n: f64,
    /// The force was reached from above.
    pub falling: bool,
}

/// Half the width of an interval over its value, beyond which it tells no factor.
const TELLS: f64 = 0.5;
/// Singular values below this are zero.
const SINGULAR: f64 = 1e-9;

/// The line through the readings of an instrument with this step, N: its slope, and the force where nothing is commanded, on the way up, N.
///
/// # Errors
/// Readings that tell no slope, each with its remedy; `falls` is that for a force that falls where the command grows.
pub(super) fn line(
    points: &[Point],
    step_n: f64,
    falls: &str,
) -> Result<[MeasuredNumber; 2], Failure> {
    let design = DMatrix::from_fn(points.len(), 3, |row, column| match column {
        0 => points[row].commanded_n,
        way => f64::from(points[row].falling == (way == 2)),
    });
    let force = DVector::from_iterator(points.len(), points.iter().map(|point| point.force_n));
    let freedom = points.len().saturating_sub(design.rank(SINGULAR)) as f64;
    let inverse = design.clone().pseudo_inverse(SINGULAR);
    let inverse = inverse.map_err(Failure::run)?;
    let found = &inverse * &force;
    let scatter = (&force - &design * &found).norm() / libm::sqrt(freedom);
    let about = |row: usize| {
        let gains = inverse.row(row);
        let rounding = 0.5 * step_n * gains.iter().map(|gain| gain.abs()).sum::<f64>();
        let half = libm::hypot(student(freedom) * scatter * gains.norm(), rounding);
        MeasuredNumber::about(found[row], half)
    };
    let slope = about(0);
    if slope.value <= 0.0 {
        return Err(Failure::bad_input(falls));
    }
    if freedom > 0.0 && slope.relative() <= TELLS {
        return Ok([slope, about(1)]);
    }
    Err(bad_input!(
        "the readings tell no factor (within ±{TELLS}): read forces that differ more, with a larger {MEASURE_FORCE_LIMIT} and force limit of the device where friction hides them, or on a finer instrument",
    ))
}
