//! Finding the modes for a tolerance and a horizon, and measuring what they reach.

use super::kernel::{Core, Kernel};
use crate::range::{HORIZON_MAX, HORIZON_MIN, TOLERANCE_MAX, TOLERANCE_MIN};
use crate::{Order, ParameterError};
use core::f64::consts::PI;
use core::fmt;

/// A decaying mode: it adds weight·e^(−j·rate) to the weight of lag j.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mode {
    /// `s_q` > 0, per sample.
    pub rate: f64,
    /// `w_q` > 0, dimensionless.
    pub weight: f64,
}

/// The modes of a [`FullMemory`](super::FullMemory), fastest first, with the error they reach.
///
/// ```text
/// D^μ x[n] = T^(−μ)·Σ_j c_j·Δⁿx[n−j],   n = ⌈μ⌉,   c_j > 0 the weights of a fractional integral of order ν = n − μ
/// |error of the output| ≤ ε·T^(−μ)·Σ_j c_j·|Δⁿx[n−j]|        ε = error_bound()
/// ```
/// For 0 < μ ≤ 1 and a motion in one direction that is ε of the output itself; for μ > 1, and for a
/// motion to and fro, the output is a difference of such sums, and only the bound holds. For μ ≤ 0, where the sum
/// is over x itself, likewise.
///
/// ε is measured, not assumed: the relative error of every weight from lag TAPS to TAPS + 64 and from
/// there on a geometric grid of 48 points per swing of the error curve, up to the horizon, against the
/// true weights in closed form.
#[derive(Clone, Debug, PartialEq)]
pub struct Design<const TAPS: usize, const MODES: usize> {
    order: Order,
    core: Core,
    horizon: f64,
    modes: [Mode; MODES],
    count: usize,
    error_bound: f64,
}

/// Why no design was found.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum DesignError {
    /// A parameter outside its range.
    Parameter(ParameterError),
    /// The tolerance takes more modes than there is room for.
    TooManyModes {
        /// Modes that the tolerance takes.
        needed: usize,
        /// Room, the constant MODES.
        room: usize,
    },
    /// The tolerance cannot be reached in double precision.
    Unreachable {
        /// The wish.
        tolerance: f64,
        /// The best that was found.
        reached: f64,
    },
}

impl From<ParameterError> for DesignError {
    fn from(error: ParameterError) -> Self {
        Self::Parameter(error)
    }
}

impl fmt::Display for DesignError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Parameter(error) => error.fmt(f),
            Self::TooManyModes { needed, room } => write!(
                f,
                "the tolerance takes {needed} modes, there is room for {room}: allow a larger \
                 tolerance, a shorter horizon or more modes"
            ),
            Self::Unreachable { tolerance, reached } => write!(
                f,
                "tolerance {tolerance:e} cannot be reached: the best weights are within \
                 {reached:.1e}"
            ),
        }
    }
}

impl core::error::Error for DesignError {}

impl<const TAPS: usize, const MODES: usize> Design<TAPS, MODES> {
    /// The modes in closed form: trapezoid rule in ln s, and two Gauss nodes for all that is slower
    /// than the horizon can tell apart.
    ///
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
        let mut design = Self::empty(kernel, order, tolerance, horizon)?;
        if design.core.is_finite() {
            return Ok(design);
        }
        let mut step = Grid::step_for(design.core, tolerance);
        let mut reached = f64::INFINITY;
        // The step formula is right to a few per cent; the rest is found by trying.
        for _ in 0..TRIES {
            design.fill(Grid::new(design.core, TAPS, tolerance, horizon, step))?;
            if design.error_bound <= tolerance {
                return Ok(design);
            }
            reached = libm::fmin(reached, design.error_bound);
            step *= STEP_SHRINK;
        }
        Err(DesignError::Unreachable { tolerance, reached })
    }

    /// No modes yet; checks the ranges.
    pub(super) fn empty(
        kernel: Kernel,
        order: Order,
        tolerance: f64,
        horizon: f64,
    ) -> Result<Self, DesignError> {
        const {
            assert!(
                TAPS >= Core::LEAST_TAPS,
                "a full memory has at least 4 taps"
            );
        };
        if !(TOLERANCE_MIN..=TOLERANCE_MAX).contains(&tolerance) {
            return Err(ParameterError::Tolerance(tolerance).into());
        }
        if !(HORIZON_MIN.max(TAPS as f64)..=HORIZON_MAX).contains(&horizon) {
            return Err(ParameterError::Horizon(horizon).into());
        }
        Ok(Self {
            order,
            core: Core::new(kernel, order),
            horizon,
            modes: [Mode::default(); MODES],
            count: 0,
            error_bound: 0.0,
        })
    }

    /// Takes all modes of a grid, then measures.
    fn fill(&mut self, grid: Grid) -> Result<(), DesignError> {
        let needed = grid.modes().count();
        if needed > MODES {
            return Err(DesignError::TooManyModes {
                needed,
                room: MODES,
            });
        }
        self.count = needed;
        for (slot, mode) in self.modes.iter_mut().zip(grid.modes()) {
            *slot = mode;
        }
        self.error_bound = self.measure(grid.step);
        Ok(())
    }

    /// Takes the given modes, fastest first, and measures them for swings of about `step` in ln j.
    #[cfg(feature = "std")]
    pub(super) fn refill(&mut self, modes: &[Mode], step: f64) {
        self.count = modes.len().min(MODES);
        self.modes = [Mode::default(); MODES];
        self.modes[..self.count].copy_from_slice(&modes[..self.count]);
        self.error_bound = self.measure(step);
    }

    /// Largest relative error of a weight over the check grid, raised by what a peak between two
    /// points of it can hide: a swing of 48 points, cos(π/48). A NaN is an error of its own.
    fn measure(&self, step: f64) -> f64 {
        let worst = check_lags(TAPS, self.horizon, step / POINTS_A_SWING)
            .map(|lag| (self.mode_sum(lag) / self.core.weight(lag) - 1.0).abs())
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

    pub(super) fn core(&self) -> Core {
        self.core
    }

    /// The modes, fastest first. None for an integer order, where taps alone are exact.
    #[must_use]
    pub fn modes(&self) -> &[Mode] {
        &self.modes[..self.count]
    }

    /// The order μ.
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
        let j = lag as f64;
        if lag < TAPS as u64 || self.count == 0 {
            self.core.weight(j)
        } else {
            self.mode_sum(j)
        }
    }
}

/// Points of the check grid in one swing of the error over ln j.
const POINTS_A_SWING: f64 = 48.0;

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

/// Nodes s = e^(kh) of the trapezoid rule that matter between the taps and the horizon.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    core: Core,
    pub(super) step: f64,
    /// Fastest node that still counts at the first lag after the taps.
    first: i32,
    /// Slowest node kept by itself; all slower ones are lumped.
    last: i32,
}

impl Grid {
    pub(super) fn new(core: Core, taps: usize, tolerance: f64, horizon: f64, step: f64) -> Self {
        // Up to where a node adds less than a twentieth of the tolerance at the first lag after
        // the taps.
        let lag = taps as f64;
        let negligible = 0.05 * tolerance * core.weight(lag) / step;
        // Two Gauss nodes for e^(−js) on 0 ≤ s ≤ s₀ with the density s^(−ν) miss about
        // (s₀j)^(5−ν)/4320 of the weight (remainder f⁗/4! times the squared norm of P₂).
        let lumped = libm::pow(1000.0 * tolerance, 1.0 / (4.0 + core.exponent()));
        let slowest = lumped.min(1.0) / horizon;
        let mut fastest = 40.0 / lag;
        // Next to ν = 1 no node may count: all that matters is slower than the horizon.
        while fastest > slowest && core.density(fastest) * libm::exp(-lag * fastest) < negligible {
            fastest *= 0.98;
        }
        let index = |s: f64| libm::floor(libm::log(s) / step) as i32;
        Self {
            core,
            step,
            first: index(fastest) + 1,
            last: index(slowest) + 1,
        }
    }

    /// The largest step that keeps the trapezoid error within half the tolerance.
    pub(super) fn step_for(core: Core, tolerance: f64) -> f64 {
        let exponent = core.exponent();
        // 2|Γ(x+iy)|/Γ(x) = tolerance/2, x = 1 − ν, y = 2π/h, with |Γ(x+iy)| ≈ √(2π)·y^(x−½)·e^(−πy/2)
        let scale = 4.0 * libm::sqrt(2.0 * PI) / (libm::tgamma(exponent) * tolerance);
        let mut y = 10.0;
        for _ in 0..20 {
            y = libm::fmax(
                (libm::log(scale) + (exponent - 0.5) * libm::log(y)) * 2.0 / PI,
                2.0,
            );
        }
        2.0 * PI / y
    }

    fn node(&self, index: i32) -> Mode {
        let rate = libm::exp(f64::from(index) * self.step);
        Mode {
            rate,
            weight: self.step * self.core.density(rate),
        }
    }

    /// All modes, fastest first: nodes one by one, then two for the rest.
    pub(super) fn modes(&self) -> impl Iterator<Item = Mode> + '_ {
        let nodes = (self.last..=self.first).rev().map(|index| self.node(index));
        nodes.chain(self.lump())
    }

    /// Two modes with the moments ∫ s^m dW, m = 0..3, of all nodes slower than the last.
    fn lump(&self) -> [Mode; 2] {
        // In units of the last node's rate, so that moments are of order one.
        let unit = libm::exp(f64::from(self.last) * self.step);
        let mut moments = [0.0; 4];
        let mut index = self.last - 1;
        loop {
            let Mode { rate, weight } = self.node(index);
            let s = rate / unit;
            // Below 1e-18 the density is s^(1−ν) to rounding: the rest is a geometric series.
            let done = rate < 1e-18;
            let mut term = weight;
            for (m, moment) in moments.iter_mut().enumerate() {
                let exponent = self.core.exponent() + m as f64;
                let tail = -libm::expm1(-self.step * exponent);
                *moment += if done { term / tail } else { term };
                term *= s;
            }
            if done {
                break;
            }
            index -= 1;
        }
        gauss_pair(moments).map(|Mode { rate, weight }| Mode {
            rate: rate * unit,
            weight,
        })
    }
}

/// The two-node Gauss rule with the moments m₀ to m₃, faster node first.
///
/// The nodes are the roots of the orthogonal polynomial s² − p·s + q
/// (W. Gautschi, *Orthogonal Polynomials: Computation and Approximation*, 2004, §1.4).
fn gauss_pair([m0, m1, m2, m3]: [f64; 4]) -> [Mode; 2] {
    let determinant = m0 * m2 - m1 * m1;
    let p = (m0 * m3 - m1 * m2) / determinant;
    let q = (m1 * m3 - m2 * m2) / determinant;
    let fast = 0.5 * (p + libm::sqrt(p * p - 4.0 * q));
    let slow = q / fast;
    let weight = (m1 - slow * m0) / (fast - slow);
    [
        Mode { rate: fast, weight },
        Mode {
            rate: slow,
            weight: m0 - weight,
        },
    ]
}
