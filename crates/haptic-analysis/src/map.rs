//! Certified verdicts on all walls of a grid.
//!
//! F is affine in α and β. For all walls within r and s of a middle α, β it stays near that of the middle:
//! ```text
//! |F − F_middle| ≤ r·|S| + s·|S·P|
//! ```
//! If |F| of the middle is proved to exceed that all round the circle, none of these walls has a pole on it. Zeros move
//! continuously with α and β, so that all have as many unstable poles as the middle: one count serves all. Walls for which
//! this cannot be proved are divided in four, down to single ones, so that the work goes with the length of the boundary
//! and not with the number of walls.
//!
//! *The same verdicts as one by one*: bounds of many walls hold for each of them, so a single wall is judged at no other angles
//! than its box, and |F| has passed the tolerance of the boundary at all of those.

use crate::characteristic::{Characteristic, Walls};
use crate::stability::{BOUNDARY, Circle, flushed};
use crate::{AnalysisError, LoopOperator, Nondimensional, SampledPlant};
use core::ops::Range;
use fracdiff::parameter::range;

/// The unstable poles of each wall of a grid of α and β.
/// ```
/// use fracdiff::{Order, Scheme, Seconds};
/// use haptic_analysis::{LoopOperator, SampledPlant, StabilityMap};
///
/// let damper = LoopOperator::new(Scheme::Exact, Order::new(1.0)?, Seconds(1e-3), 1e3)?;
/// let free = SampledPlant::new(0.0, 0.0)?;
/// // Without damping of the device: α < 2β(2 − β)/(2 + β) = 2/3 at β = 1, and nothing at β = 2.
/// let map = StabilityMap::new(free, &damper, &[0.3, 0.66, 0.67], &[1.0, 2.0])?;
/// assert!(map.is_stable(1, 0) && !map.is_stable(2, 0) && !map.is_stable(0, 1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct StabilityMap {
    /// Row by row, one row for each α.
    unstable_poles: Vec<Option<usize>>,
    columns: usize,
    counts: usize,
}

impl StabilityMap {
    /// Judges all walls of the grid on a plant, whose delay and lag are its own. Each has the verdict that it has as a
    /// [`SampledLoop`](crate::SampledLoop); one that drifts is on the boundary.
    ///
    /// *Cost*: one certified count for each box that is tried, some twenty for each wall along the longer side of the grid.
    ///
    /// # Errors
    /// An α or β that is negative, not finite, above 1e12, or less than the one before it.
    pub fn new(
        plant: SampledPlant,
        operator: &LoopOperator,
        alphas: &[f64],
        betas: &[f64],
    ) -> Result<Self, AnalysisError> {
        let (alphas, betas) = (checked("alpha", alphas)?, checked("beta", betas)?);
        let characteristic = Characteristic::new(plant, operator);
        let mut map = Self {
            unstable_poles: vec![None; alphas.len() * betas.len()],
            columns: betas.len(),
            counts: 0,
        };
        let grid = Grid {
            circle: characteristic.circle(),
            alphas,
            betas,
        };
        map.judge(&grid, 0..grid.alphas.len(), 0..grid.betas.len());
        Ok(map)
    }

    /// Poles with |z| > 1 of the wall with this α and β, by their indices; `None` on the boundary, as in a
    /// [`StabilityVerdict`](crate::StabilityVerdict).
    ///
    /// # Panics
    /// An index beyond the grid.
    #[must_use]
    pub fn unstable_poles(&self, alpha: usize, beta: usize) -> Option<usize> {
        self.unstable_poles[alpha * self.columns..][..self.columns][beta]
    }

    /// No pole on or outside the unit circle.
    ///
    /// # Panics
    /// An index beyond the grid.
    #[must_use]
    pub fn is_stable(&self, alpha: usize, beta: usize) -> bool {
        self.unstable_poles(alpha, beta) == Some(0)
    }

    /// Certified counts that it took.
    #[must_use]
    pub const fn counts(&self) -> usize {
        self.counts
    }

    fn judge(&mut self, grid: &Grid<'_>, rows: Range<usize>, columns: Range<usize>) {
        if rows.is_empty() || columns.is_empty() {
            return;
        }
        self.counts += 1;
        let walls = Walls::between(
            ends(&grid.alphas[rows.clone()]),
            ends(&grid.betas[columns.clone()]),
        );
        let zeros = grid.circle.count(walls, BOUNDARY, false).zeros;
        if zeros.is_some() || rows.len() * columns.len() == 1 {
            for row in rows {
                let first = row * self.columns;
                self.unstable_poles[first + columns.start..first + columns.end].fill(zeros);
            }
            return;
        }
        for rows in halves(rows) {
            for columns in halves(columns.clone()) {
                self.judge(grid, rows.clone(), columns);
            }
        }
    }
}

struct Grid<'a> {
    circle: Circle<'a>,
    alphas: Vec<f64>,
    betas: Vec<f64>,
}

fn checked(what: &'static str, values: &[f64]) -> Result<Vec<f64>, AnalysisError> {
    let mut last = 0.0;
    let value = |&value: &f64| {
        let kept = (0.0..=Nondimensional::WALL_MAX).contains(&value);
        range(what, value, kept, "from 0 to 1e12", "")?;
        range(what, value, value >= last, "at least the one before it", "")?;
        last = value;
        Ok(flushed(value))
    };
    values.iter().map(value).collect()
}

fn ends(values: &[f64]) -> [f64; 2] {
    [values[0], values[values.len() - 1]]
}

/// The second is empty if there is only one.
fn halves(range: Range<usize>) -> [Range<usize>; 2] {
    let middle = range.start + range.len().div_ceil(2);
    [range.start..middle, middle..range.end]
}
