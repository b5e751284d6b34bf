//! Fewer modes for the same tolerance, for a kernel or any memory that only fades: the best ones, or weights fitted by non-negative
//! least squares.

use super::design::{
    Design, DesignError, NOTHING, OWN_SWING, POINTS_A_SWING, check_lags, check_tolerance,
};
use super::exchange::Exchange;
use super::kernel::{Core, DecayingMode, Grid, Kernel, gauss_pair};
use super::memory::{Memory, MemoryWeights};
use super::nnls::non_negative_least_squares;
use crate::Order;
use std::vec::Vec;

impl<const TAPS: usize, const MODES: usize> Design<TAPS, MODES> {
    /// The fewest modes that the tolerance allows: the best sum of exponentials, with as many as it takes.
    /// ```text
    /// min_{s,w > 0} max_{TAPS ≤ j ≤ horizon} |Σ_q w_q·e^(−j·s_q)/c_j − 1|
    /// ```
    /// At 1e-6 over 200 s at 1 kHz these are two thirds of [`closed_form`](Self::closed_form), which is returned where Newton's method
    /// does not converge: next to 1e-11, where the weights have no more digits. Parameters and errors as there. *Cost*: some milliseconds.
    ///
    /// Source: E. Ya. Remez, 1934; D. Braess, *Nonlinear Approximation Theory*, 1986, ch. VII.
    ///
    /// # Errors
    /// As [`closed_form`](Self::closed_form).
    pub fn pruned(
        kernel: Kernel,
        order: Order,
        tolerance: f64,
        horizon: f64,
    ) -> Result<Self, DesignError> {
        let core = Core::new(kernel, order);
        let mut design = Self::empty(core, order, tolerance, horizon)?;
        if core.is_finite() {
            return Ok(design);
        }
        let weight = |lag| core.weight(lag);
        let best = Exchange::new(&weight, core.exponent(), TAPS, horizon, tolerance);
        let mut needed = None;
        let found = best.is_some_and(|best| {
            best.until(tolerance, &mut |modes, swing| {
                if modes.len() > MODES {
                    needed = Some(modes.len());
                    return true;
                }
                design.refill(core, modes, swing);
                design.error_bound() <= tolerance
            })
        });
        match needed {
            Some(needed) => Err(DesignError::TooManyModes {
                needed,
                room: MODES,
            }),
            None if found => Ok(design),
            None => Self::closed_form(kernel, order, tolerance, horizon),
        }
    }

    /// The fewest modes that approximate a [`Memory`] within a tolerance.
    /// ```text
    /// y[n] = T^(−μ)·Σ_j c_j·Δⁿx[n−j],   n = ⌈μ⌉,     c_j the weights of the memory min_w Σ_j (Σ_q
    /// w_q·e^(−j·s_q)/c_j − 1)²,   w_q ≥ 0,   its exact modes unchanged
    /// ```
    /// - *Without exact modes* the best sum, as in [`pruned`](Self::pruned), where Newton's method finds it. Else least squares:
    /// - *Rates* of the other modes: ever finer geometric grids, finer still where the density is narrow, and two Gauss
    ///   nodes for all that is too slow for the horizon to resolve.
    /// - `order`: μ, which sets the number n of differences and the unit s^(−μ).
    /// - `tolerance`: the largest relative error of a weight, 1e-11 to 0.1; `horizon`: up to this lag, samples, 1e2 to 1e12.
    /// - No weight is negative. With n = 1 the operator is passive, and what [`FullMemory`](super::FullMemory) says of
    ///   single precision holds.
    /// - *Cost*: some ten to hundred milliseconds.
    /// ```
    /// use fracdiff::full_memory::{Design, FullMemory, Memory};
    /// use fracdiff::{Order, Seconds};
    ///
    /// /// Two power laws side by side, D^0.3 + D^0.6: (1 − w)^(−0.7) + (1 − w)^(−0.4).
    /// struct Both;
    /// impl Memory for Both {
    ///     fn first(&self) -> f64 {
    ///         2.0
    ///     }
    ///     fn density(&self, rate: f64) -> f64 {
    ///         let law = |nu: f64| (std::f64::consts::PI * nu).sin() * rate.exp_m1().powf(-nu);
    ///         rate * (law(0.7) + law(0.4)) / std::f64::consts::PI
    ///     }
    /// }
    /// let design = Design::<16, 48>::of_memory(Order::new(0.3)?, &Both, 1e-6, 2e5)?;
    /// assert!(design.error_bound() <= 1e-6 && design.modes().len() < 40);
    /// let operator = FullMemory::<f32, 16, 48>::new(&design, Seconds(1e-3))?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`closed_form`](Self::closed_form) and [`MemoryWeights::new`].
    pub fn of_memory(
        order: Order,
        memory: &dyn Memory,
        tolerance: f64,
        horizon: f64,
    ) -> Result<Self, DesignError> {
        check_tolerance(tolerance)?;
        let weights = MemoryWeights::new(memory, horizon)?;
        let mut design = Self::from_modes(
            order,
            |lag| weights.at(lag as f64),
            &[],
            horizon.max(TAPS as f64),
        )?;
        let checked: Vec<(f64, f64)> = check_lags(TAPS, horizon, OWN_SWING_POINT)
            .map(|lag| (lag, weights.at(lag)))
            .collect();
        let search = Search {
            memory,
            weights: &weights,
            taps: TAPS,
            tolerance,
            horizon,
            at_taps: weights.at(TAPS as f64),
        };
        let exact = search.exact();
        let (mut needed, mut reached) = (None, f64::INFINITY);
        if exact.is_empty() {
            let weight = |lag| weights.at(lag);
            let best = Exchange::new(&weight, HALF, TAPS, horizon, tolerance);
            let found = best.is_some_and(|best| {
                best.until(tolerance, &mut |modes, _| {
                    design.take_measured(modes, checked.iter().copied());
                    design.error_bound() <= tolerance && modes.len() <= MODES
                })
            });
            if found {
                return Ok(design);
            }
        }
        let typical = Grid::step_of(HALF, tolerance);
        // Coarse grids first, as they have few modes.
        for twentieths in (6..=34).rev() {
            let modes = search.modes(typical * f64::from(twentieths) / 20.0, &exact);
            if modes.len() > MODES {
                needed = needed.or(Some(modes.len()));
                continue;
            }
            design.take_measured(&modes, checked.iter().copied());
            if design.error_bound() <= tolerance {
                return Ok(design);
            }
            reached = reached.min(design.error_bound());
        }
        Err(match needed {
            Some(needed) => DesignError::TooManyModes {
                needed,
                room: MODES,
            },
            None => DesignError::Unreachable { tolerance, reached },
        })
    }
}

/// The candidates with weights fitted to what others leave of the true weights; those with the weight zero are left out.
/// `step` is that of their grid in ln s. Lags of weight 0 do not count.
fn fit(
    candidates: &[DecayingMode],
    others: &[DecayingMode],
    weight: &dyn Fn(f64) -> f64,
    taps: usize,
    horizon: f64,
    tolerance: f64,
    step: f64,
) -> Vec<DecayingMode> {
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
    let relative = |row: usize, mode: &DecayingMode| {
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
    let scaled = candidates
        .iter()
        .zip(factors)
        .map(|(mode, factor)| DecayingMode {
            rate: mode.rate,
            weight: mode.weight * factor,
        });
    scaled.filter(|mode| mode.weight > 0.0).collect()
}

/// An arbitrary exponent, for a density of unknown exponent.
const HALF: f64 = 0.5;

/// Points of the check grid, in ln j.
const OWN_SWING_POINT: f64 = OWN_SWING / POINTS_A_SWING;

/// The way from a step in ln s to modes.
struct Search<'a> {
    memory: &'a dyn Memory,
    weights: &'a MemoryWeights,
    taps: usize,
    tolerance: f64,
    horizon: f64,
    /// `c_TAPS`.
    at_taps: f64,
}

impl Search<'_> {
    /// The exact modes that are still felt behind the taps.
    fn exact(&self) -> Vec<DecayingMode> {
        let felt = |mode: &&DecayingMode| !self.negligible(mode.rate, mode.weight);
        self.weights.exact().iter().filter(felt).copied().collect()
    }

    /// True if a mode adds less than a twentieth of the tolerance at the first lag after the taps.
    fn negligible(&self, rate: f64, weight: f64) -> bool {
        weight * libm::exp(-(self.taps as f64) * rate) <= 0.05 * self.tolerance * self.at_taps
    }

    /// The modes of a grid with fitted weights beside the exact ones, fastest first.
    fn modes(&self, step: f64, exact: &[DecayingMode]) -> Vec<DecayingMode> {
        let candidates = self.candidates(step);
        // Next to nothing counts as nothing, as in the error.
        let weight = |lag: f64| Some(self.weights.at(lag)).filter(|weight| *weight > NOTHING);
        let weight = |lag: f64| weight(lag).unwrap_or(0.0);
        let mut modes = fit(
            &candidates,
            exact,
            &weight,
            self.taps,
            self.horizon,
            self.tolerance,
            step,
        );
        modes.extend(exact);
        DecayingMode::sort(&mut modes);
        modes
    }

    /// Rates that may get a weight, with the weight of the trapezoid rule.
    fn candidates(&self, step: f64) -> Vec<DecayingMode> {
        let slowest = libm::pow(1000.0 * self.tolerance, 0.25).min(1.0) / self.horizon;
        let index = |s: f64| libm::floor(libm::log(s) / step) as i32;
        let last = libm::exp(f64::from(index(slowest) + 1) * step);
        let grid = (index(slowest) + 1..=index(40.0 / self.taps as f64))
            .map(|k| libm::exp(f64::from(k) * step));
        let narrow = self.weights.narrow(step).filter(|&rate| rate > last);
        let node = |rate: f64| DecayingMode {
            rate,
            weight: step * self.memory.density(rate),
        };
        let mut candidates: Vec<DecayingMode> = grid
            .chain(narrow)
            .map(node)
            .filter(|mode| !self.negligible(mode.rate, mode.weight))
            .collect();
        let slow = gauss_pair(self.weights.moments_below(last)).map(|mode| DecayingMode {
            rate: mode.rate * last,
            ..mode
        });
        let usable =
            |mode: &DecayingMode| mode.rate > 0.0 && mode.weight > 0.0 && mode.weight.is_finite();
        candidates.extend(slow.into_iter().filter(usable));
        DecayingMode::sort(&mut candidates);
        candidates
    }
}
