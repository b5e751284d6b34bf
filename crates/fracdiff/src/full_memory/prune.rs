//! Fewer modes for the same tolerance: weights fitted by non-negative least squares.

use super::design::{Design, check_lags};
use super::design_error::DesignError;
use super::grid::Grid;
use super::kernel::{Core, Kernel};
use super::mode::Mode;
use super::nnls::non_negative_least_squares;
use crate::Order;
use std::vec::Vec;

impl<const TAPS: usize, const MODES: usize> Design<TAPS, MODES> {
    /// The fewest modes that the tolerance allows: on ever finer grids of rates, the weights that fit
    /// the kernel best in the least-squares sense of the relative error, none negative.
    ///
    /// ```text
    /// min_w Σ_j (Σ_q w_q·e^(−j·s_q)/c_j − 1)²,   w_q ≥ 0
    /// ```
    /// Most weights of such a fit come out as exactly zero; their modes are dropped. At 1e-6 over a
    /// day at 1 kHz this leaves about nine tenths of
    /// [`closed_form`](Self::closed_form), which is returned where it is no worse.
    /// Parameters and errors as there. *Cost*: some ten milliseconds.
    ///
    /// Source: C. L. Lawson, R. J. Hanson, *Solving Least Squares Problems*, 1974, ch. 23.
    ///
    /// # Errors
    /// As [`closed_form`](Self::closed_form).
    pub fn pruned(
        kernel: Kernel,
        order: Order,
        tolerance: f64,
        horizon: f64,
    ) -> Result<Self, DesignError> {
        let closed = Self::closed_form(kernel, order, tolerance, horizon);
        let core = Core::new(kernel, order);
        let mut fitted = Self::empty(core, order, tolerance, horizon)?;
        if core.is_finite() {
            return closed;
        }
        let fine = Grid::step_for(core, tolerance);
        // Coarse grids, so few modes, first.
        for twentieths in (12..=32).rev() {
            let step = fine * f64::from(twentieths) / 20.0;
            let grid = Grid::new(core, TAPS, tolerance, horizon, step);
            let candidates: Vec<Mode> = grid.modes().collect();
            let weight = |lag| core.weight(lag);
            let modes = fit(&candidates, &[], weight, TAPS, horizon, tolerance, step);
            if modes.len() > MODES {
                continue;
            }
            fitted.refill(core, &modes, step);
            if fitted.error_bound() <= tolerance {
                return match closed {
                    Ok(closed) if closed.modes().len() <= modes.len() => Ok(closed),
                    _ => Ok(fitted),
                };
            }
        }
        closed
    }
}

/// The candidates with weights fitted to what others leave of the true weights; those with the weight zero are left out.
/// `step` is that of their grid in ln s. Lags of weight 0 do not count.
pub(super) fn fit(
    candidates: &[Mode],
    others: &[Mode],
    weight: impl Fn(f64) -> f64,
    taps: usize,
    horizon: f64,
    tolerance: f64,
    step: f64,
) -> Vec<Mode> {
    // The taps cover lags below `taps`, whatever the modes give there. But a fast mode that is all
    // but gone at the first lag that counts must not take a huge weight, which the taps would have to
    // cancel and single precision would lose: a miss by the whole weight counts as the tolerance.
    let early = (1..taps).map(|lag| (lag as f64, tolerance));
    let late = check_lags(taps, horizon, step / 8.0).map(|lag| (lag, 1.0));
    // Lag, importance, true weight.
    let lags: Vec<(f64, f64, f64)> = early
        .chain(late)
        .map(|(lag, importance)| (lag, importance, weight(lag)))
        .filter(|&(_, _, weight)| weight > 0.0)
        .collect();
    // Columns in units of the closed-form weight, so that a solution near 1 is expected.
    let relative = |row: usize, mode: &Mode| {
        let (lag, importance, weight) = lags[row];
        importance * mode.weight * libm::exp(-lag * mode.rate) / weight
    };
    let columns = candidates
        .iter()
        .map(|mode| (0..lags.len()).map(|row| relative(row, mode)).collect());
    let left = |row: usize| {
        let others = others.iter().map(|mode| relative(row, mode));
        lags[row].1 - others.sum::<f64>()
    };
    let target = (0..lags.len()).map(left).collect();
    let factors = non_negative_least_squares(columns.collect(), target);
    let scaled = candidates.iter().zip(factors).map(|(mode, factor)| Mode {
        rate: mode.rate,
        weight: mode.weight * factor,
    });
    scaled.filter(|mode| mode.weight > 0.0).collect()
}
