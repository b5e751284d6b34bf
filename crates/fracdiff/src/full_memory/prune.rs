//! Fewer modes for the same tolerance: weights fitted by non-negative least squares.

use super::design::{Design, DesignError, check_lags};
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
            let modes = fit(core, &grid, TAPS, horizon, tolerance);
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

/// The modes of a grid with fitted weights; those with the weight zero are left out.
fn fit(core: Core, grid: &Grid, taps: usize, horizon: f64, tolerance: f64) -> Vec<Mode> {
    let candidates: Vec<Mode> = grid.modes().collect();
    // The taps cover lags below `taps`, whatever the modes give there. But a fast mode that is all
    // but gone at the first lag that counts must not take a huge weight, which the taps would have to
    // cancel and single precision would lose: a miss by the whole weight counts as the tolerance.
    let early = (1..taps).map(|lag| (lag as f64, tolerance));
    let late = check_lags(taps, horizon, grid.step / 8.0).map(|lag| (lag, 1.0));
    let lags: Vec<(f64, f64)> = early.chain(late).collect();
    // Columns in units of the closed-form weight, so that a solution near 1 is expected.
    let relative = |row: usize, column: usize| {
        let ((lag, importance), mode) = (lags[row], candidates[column]);
        importance * mode.weight * libm::exp(-lag * mode.rate) / core.weight(lag)
    };
    let columns = (0..candidates.len()).map(|q| (0..lags.len()).map(|i| relative(i, q)).collect());
    let target = lags.iter().map(|&(_, importance)| importance).collect();
    let factors = non_negative_least_squares(columns.collect(), target);
    let scaled = candidates.iter().zip(factors).map(|(mode, factor)| Mode {
        rate: mode.rate,
        weight: mode.weight * factor,
    });
    scaled.filter(|mode| mode.weight > 0.0).collect()
}
