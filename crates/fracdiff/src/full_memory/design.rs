//! Finding the modes for a tolerance and a horizon, and measuring what they reach.

use super::kernel::{Core, DecayingMode, Grid, Kernel};
use crate::order::{HORIZON_MAX, HORIZON_MIN, TOLERANCE_MAX, TOLERANCE_MIN};
use crate::{Order, ParameterError};
use core::f64::consts::PI;

/// Why no design was found.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum DesignError {
    /// A parameter outside its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// The tolerance takes more modes than there is room for.
    #[error(
        "the tolerance takes {needed} modes, there is room for {room}: allow a larger tolerance, a shorter horizon or more \
         modes"
    )]
    #[non_exhaustive]
    TooManyModes {
        /// Modes that the tolerance takes.
        needed: usize,
        /// Room of the design, in modes: the constant MODES.
        room: usize,
    },
    /// The tolerance cannot be reached in double precision.
    #[error("tolerance {tolerance:e} cannot be reached: the best weights are within {reached:.1e}")]
    #[non_exhaustive]
    Unreachable {
        /// The tolerance that was asked for.
        tolerance: f64,
        /// The best that was found.
        reached: f64,
    },
}

/// The modes of a [`FullMemory`](super::FullMemory), fastest first, with the error they reach.
/// ```text
/// D^μ x[n] = T^(−μ)·Σ_j c_j·Δⁿx[n−j],   n = ⌈μ⌉,   c_j > 0 the weights of a fractional integral of order ν = n − μ
/// |error of the output| ≤ ε·T^(−μ)·Σ_j c_j·|Δⁿx[n−j]|        ε = error_bound()
/// ```
/// For 0 < μ ≤ 1 and a motion in one direction that is ε of the output itself; for μ > 1, and for a motion to and fro, the output is a
/// difference of such sums, and only the bound holds. For μ ≤ 0, where the sum is over x itself, likewise.
///
/// ε is measured, not assumed: the relative error of every weight from lag TAPS to TAPS + 64 and from there on a geometric grid of 48
/// points per swing of the error curve, up to the horizon, against the true weights in closed form.
#[derive(Clone, Debug, PartialEq)]
pub struct Design<const TAPS: usize, const MODES: usize> {
    order: Order,
    /// Differences (> 0) or sums (< 0) around the core.
    integer: i32,
    /// The true weights of the core, of lags 0 to TAPS − 1.
    head: [f64; TAPS],
    horizon: f64,
    modes: [DecayingMode; MODES],
    count: usize,
    error_bound: f64,
}

impl<const TAPS: usize, const MODES: usize> Design<TAPS, MODES> {
    /// The modes in closed form: trapezoid rule in ln s, and two Gauss nodes for all modes too slow
    /// for the horizon to distinguish.
    /// ```text
    /// w_q = h·s_q·ρ(s_q)·sin(πν)/π,    s_q = e^(qh),    relative error ≈ 2|Γ(1 − ν + 2πi/h)|/Γ(1 − ν)
    /// ```
    /// - `tolerance`: the largest ε, 1e-11 to 0.1.
    /// - `horizon`: up to this lag, samples, 1e2 to 1e12.
    /// - *Cost*: some 10⁴ to 10⁵ exponentials in `f64`, no allocation.
    ///
    /// # Errors
    /// [`DesignError::TooManyModes`] or [`DesignError::Unreachable`]; a parameter outside its range.
    pub fn closed_form(
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
        let mut step = Grid::step_for(core, tolerance);
        let mut reached = f64::INFINITY;
        // The step formula is right to a few per cent; the rest is found by trying.
        for _ in 0..TRIES {
            let grid = Grid::new(core, TAPS, tolerance, horizon, step);
            let (needed, room) = (grid.modes().count(), MODES);
            if needed > room {
                return Err(DesignError::TooManyModes { needed, room });
            }
            design.take(grid.modes());
            design.error_bound = design.measure(|lag| core.weight(lag), step);
            if design.error_bound <= tolerance {
                return Ok(design);
            }
            reached = libm::fmin(reached, design.error_bound);
            step *= STEP_SHRINK;
        }
        Err(DesignError::Unreachable { tolerance, reached })
    }

    /// A custom kernel: its weights, and the modes that replace them from lag TAPS on.
    /// ```text
    /// y[n] = T^(−μ)·Σ_j c_j·Δⁿx[n−j],   n = ⌈μ⌉,   c_j ≈ Σ_q w_q·e^(−j·s_q)   for j ≥ TAPS
    /// ```
    /// - `order`: μ, which sets the number n of differences (sums, where negative) and the unit s^(−μ).
    /// - `weight`: `c_j`, dimensionless, at any whole lag j up to the horizon; the first TAPS are
    ///   used unchanged.
    /// - `modes`: rates above 0, weights of either sign. Without a negative one, and with n = 1, the operator is passive
    ///   and loses nothing in single precision, as [`FullMemory`](super::FullMemory) says; else that is open.
    /// - `horizon`: up to this lag, samples, 1e2 to 1e12. [`error_bound`](Self::error_bound) is measured up to there,
    ///   and nothing is refused for being large: look at it.
    /// ```
    /// use fracdiff::full_memory::{Design, FullMemory, Kernel, DecayingMode};
    /// use fracdiff::{Order, Seconds, grunwald_weight};
    ///
    /// // Tempered: the memory of D^0.4 fades with e^(−λj) on top, so every rate is larger by λ.
    /// let (order, rest, lambda) = (Order::new(0.4)?, Order::new(-0.6)?, 1e-3);
    /// let plain = Design::<16, 40>::closed_form(Kernel::Grunwald, order, 1e-6, 1e5)?;
    /// let faster = plain.modes().iter().map(|mode| DecayingMode { rate: mode.rate + lambda, ..*mode });
    /// let tempered = Design::<16, 40>::from_modes(
    ///     order,
    ///     |j| grunwald_weight(rest, j) * (-lambda * j as f64).exp(),
    ///     &faster.collect::<Vec<_>>(),
    ///     1e5,
    /// )?;
    /// assert!(tempered.error_bound() < 2e-6);
    /// let operator = FullMemory::<f32, 16, 40>::new(&tempered, Seconds(1e-3))?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`DesignError::TooManyModes`]; [`ParameterError::Mode`] for a rate that is not above 0 or a number that is not
    /// finite, [`ParameterError::Weight`] for one of the first TAPS weights that is not finite, [`ParameterError::Horizon`].
    pub fn from_modes(
        order: Order,
        weight: impl Fn(u64) -> f64,
        modes: &[DecayingMode],
        horizon: f64,
    ) -> Result<Self, DesignError> {
        Core::check_taps::<TAPS>();
        check_horizon(TAPS, horizon)?;
        let (needed, room) = (modes.len(), MODES);
        if needed > room {
            return Err(DesignError::TooManyModes { needed, room });
        }
        let wrong = |mode: &&DecayingMode| {
            !(mode.rate > 0.0 && mode.rate.is_finite() && mode.weight.is_finite())
        };
        if let Some(&DecayingMode { rate, weight }) = modes.iter().find(wrong) {
            return Err(ParameterError::Mode { rate, weight }.into());
        }
        let head: [f64; TAPS] = core::array::from_fn(|lag| weight(lag as u64));
        if let Some(lag) = head.iter().position(|weight| !weight.is_finite()) {
            let weight = head[lag];
            return Err(ParameterError::Weight { lag, weight }.into());
        }
        let mut design = Self::without_modes(order, order.split_up().0, head, horizon);
        design.take(modes.iter().copied());
        // Fastest first: compensation is a property of the slow end.
        DecayingMode::sort(&mut design.modes[..needed]);
        design.error_bound = design.measure(|lag| weight(lag as u64), OWN_SWING);
        Ok(design)
    }

    const fn without_modes(order: Order, integer: i32, head: [f64; TAPS], horizon: f64) -> Self {
        Self {
            order,
            integer,
            head,
            horizon,
            modes: [DecayingMode {
                rate: 0.0,
                weight: 0.0,
            }; MODES],
            count: 0,
            error_bound: 0.0,
        }
    }

    /// No modes yet; checks the ranges.
    pub(super) fn empty(
        core: Core,
        order: Order,
        tolerance: f64,
        horizon: f64,
    ) -> Result<Self, DesignError> {
        Core::check_taps::<TAPS>();
        check_tolerance(tolerance)?;
        check_horizon(TAPS, horizon)?;
        let head = core::array::from_fn(|lag| core.weight(lag as f64));
        Ok(Self::without_modes(order, core.integer, head, horizon))
    }

    /// Takes the given modes, fastest first, and measures them: against weights at lags.
    #[cfg(feature = "std")]
    pub(super) fn take_measured(
        &mut self,
        modes: &[DecayingMode],
        weights: impl Iterator<Item = (f64, f64)>,
    ) {
        self.take(modes.iter().copied());
        self.error_bound = self.largest_error(weights);
    }

    /// Takes the given modes and measures them, for swings of about `step` in ln j.
    #[cfg(feature = "std")]
    pub(super) fn refill(&mut self, core: Core, modes: &[DecayingMode], step: f64) {
        self.take(modes.iter().copied());
        self.error_bound = self.measure(|lag| core.weight(lag), step);
    }

    /// Takes the given modes, as far as there is room.
    fn take(&mut self, modes: impl Iterator<Item = DecayingMode>) {
        self.modes = [DecayingMode::default(); MODES];
        self.count = 0;
        for (slot, mode) in self.modes.iter_mut().zip(modes) {
            *slot = mode;
            self.count += 1;
        }
    }

    /// Largest relative error of a weight over the check grid, raised by what a peak between two
    /// points of it can hide: a swing of 48 points, cos(π/48). A NaN is an error of its own.
    fn measure(&self, weight: impl Fn(f64) -> f64, step: f64) -> f64 {
        let lags = check_lags(TAPS, self.horizon, step / POINTS_A_SWING);
        self.largest_error(lags.map(|lag| (lag, weight(lag))))
    }

    /// Largest relative error over pairs of lag and weight, raised as in [`measure`](Self::measure).
    fn largest_error(&self, weights: impl Iterator<Item = (f64, f64)>) -> f64 {
        let worst = weights
            .map(|(lag, want)| relative_error(self.mode_sum(lag), want))
            .fold(0.0, |worst, error| {
                if error > worst || error.is_nan() {
                    error
                } else {
                    worst
                }
            });
        worst / libm::cos(PI / POINTS_A_SWING)
    }

    /// `Σ_q` `w_q·e^(−j·s_q)`, what the modes make of `c_j`. Small terms first.
    pub(super) fn mode_sum(&self, lag: f64) -> f64 {
        let modes = self.modes().iter();
        modes
            .map(|mode| mode.weight * libm::exp(-lag * mode.rate))
            .sum()
    }

    /// The core as it runs, `c_j = k_j + Σ_q w_q e^(−j·s_q)`, has the modes from lag 0 on: `k_j`, of lags 0 to
    /// TAPS − 1, is what they leave of the true weight.
    #[must_use]
    pub fn corrections(&self) -> [f64; TAPS] {
        core::array::from_fn(|lag| self.head[lag] - self.mode_sum(lag as f64))
    }

    /// Differences (> 0) or sums (< 0) around the core.
    pub(super) fn integer(&self) -> i32 {
        self.integer
    }

    /// The true weights of the core, of lags 0 to TAPS − 1.
    pub(super) fn head(&self) -> &[f64; TAPS] {
        &self.head
    }

    /// The modes, fastest first. None for an integer order, where taps alone are exact.
    #[must_use]
    pub fn modes(&self) -> &[DecayingMode] {
        &self.modes[..self.count]
    }

    /// The order μ of the operator, not of the integral at its core.
    #[must_use]
    pub fn order(&self) -> Order {
        self.order
    }

    /// The last lag for which the error holds, samples.
    #[must_use]
    pub fn horizon(&self) -> f64 {
        self.horizon
    }

    /// ε, the error of the output in units of T^(−μ)·Σ `c_j`·|Δⁿx\[n−j\]|, for an experiment no longer than the
    /// horizon: the largest relative error of any weight, as measured. 0 for whole orders.
    #[must_use]
    pub fn error_bound(&self) -> f64 {
        self.error_bound
    }

    /// Weight j of the core as the design has it, of the fractional integral of order ν = ⌈μ⌉ − μ: exact for the taps, modes beyond.
    #[must_use]
    pub fn core_weight(&self, lag: u64) -> f64 {
        let head = usize::try_from(lag).ok().and_then(|lag| self.head.get(lag));
        match head {
            Some(weight) => *weight,
            // A sum of no modes would be −0.
            None if self.count == 0 => 0.0,
            None => self.mode_sum(lag as f64),
        }
    }
}

/// Accepts 1e-11 to 0.1.
pub(crate) fn check_tolerance(tolerance: f64) -> Result<f64, ParameterError> {
    if (TOLERANCE_MIN..=TOLERANCE_MAX).contains(&tolerance) {
        Ok(tolerance)
    } else {
        Err(ParameterError::Tolerance(tolerance))
    }
}

/// Accepts 1e2 to 1e12 samples, no fewer than there are taps.
pub(super) fn check_horizon(taps: usize, horizon: f64) -> Result<(), ParameterError> {
    if (HORIZON_MIN.max(taps as f64)..=HORIZON_MAX).contains(&horizon) {
        Ok(())
    } else {
        Err(ParameterError::Horizon(horizon))
    }
}

/// |have/want − 1|. Where both are next to nothing, as far out in a kernel that fades, there is no error.
fn relative_error(have: f64, want: f64) -> f64 {
    if libm::fmax(have.abs(), want.abs()) < NOTHING {
        return 0.0;
    }
    (have / want - 1.0).abs()
}

/// Weights below this are next to nothing: no more than a share of 1e-100 of any weight that matters.
pub(super) const NOTHING: f64 = 1e-100;

/// A swing of the error over ln j in a design of someone else: narrower than any of ours at 1e-11.
pub(super) const OWN_SWING: f64 = 0.3;

/// Points of the check grid in one swing of the error over ln j.
pub(super) const POINTS_A_SWING: f64 = 48.0;

/// Attempts, each with a step 3 % smaller: together a factor 2.
const TRIES: usize = 24;
const STEP_SHRINK: f64 = 0.97;

/// Lags at which a design is measured: 65 in a row, then a geometric grid, then the horizon.
pub(super) fn check_lags(taps: usize, horizon: f64, step: f64) -> impl Iterator<Item = f64> {
    let first = taps as f64;
    let dense = (0..=64).map(move |i| (first + f64::from(i)).min(horizon));
    let ratio = libm::exp(step);
    let sparse = core::iter::successors(Some(first + 64.0), move |lag| Some(lag * ratio));
    let sparse = sparse
        .map(libm::round)
        .take_while(move |&lag| lag < horizon);
    dense.chain(sparse).chain(core::iter::once(horizon))
}
