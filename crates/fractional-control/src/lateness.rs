//! The delay margin of a plant behind a hold: a dead time of a part of a sample turns the loop otherwise than whole samples do.

use crate::margins::Point;
use crate::{Crossing, SampledLoop};
use certified_count::{Late, Unknown, delay_margin};
use core::cell::OnceCell;
use core::f64::consts::PI;
use std::vec::Vec;

/// Number of tried parts of a sample; and of a loop whose dead time turns it so often that its grid is longer than `LONG`.
const PARTS: u32 = 16;
const FEW_PARTS: u32 = 4;
const LONG: usize = 20_000;

/// A loop with more dead time, and the turn of 1 + L without it where a rule stands for its plant: that of the plant behind its hold, which stays
/// the same while the loop is stable, as dead time adds no poles.
struct Later {
    late: SampledLoop,
    turn: Option<f64>,
    grid: OnceCell<Vec<Point>>,
}

impl Later {
    fn grid(&self) -> &[Point] {
        self.grid.get_or_init(|| self.late.grid())
    }
}

impl Late for Later {
    fn crossovers(&self) -> Vec<(f64, f64)> {
        let margins = self.late.phase_margins(self.grid());
        let rate = self.late.rate();
        margins
            .iter()
            .map(|margin| (margin.omega_rad_s / rate, margin.value))
            .collect()
    }

    fn is_turned(&self) -> bool {
        self.late.open(PI).norm() >= 1.0
    }

    fn lost(&self) -> Result<Option<f64>, Unknown> {
        let Some(turn) = self.turn else {
            let verdict = self.late.verdict();
            return Ok((!verdict.stable).then(|| verdict.omega_rad_s / self.late.rate()));
        };
        let turned = (self.late.turn(self.grid()) - turn).abs();
        Ok((turned > 0.5 * PI).then(|| nearest(self.grid())))
    }
}

/// Times the way between two points is halved where 1 + L turns fast.
const FOLLOWED: u32 = 40;
/// A turn of 1 + L that is followed no finer, rad.
const SLOW: f64 = 1.0;

impl SampledLoop {
    /// A delay within [`memory_s`](Self::memory_s): beyond it the loop is not the one that was asked about.
    #[must_use]
    pub fn remembered(&self, delay: Option<Crossing>) -> Option<Crossing> {
        let within = |delay: &Crossing| self.memory_s().is_none_or(|held| delay.value < held);
        delay.filter(within)
    }

    /// The delay margin of a stable loop around a plant behind a hold, s: with any smaller dead time more it is stable; `None` if no dead time loses
    /// it. That of [`margins`](Self::margins), `first`, turns the phase of L as a dead time of whole samples does; a part of a sample turns it
    /// otherwise, for the hold then switches inside a sample. `later` is the loop whose plant has so much more dead time.
    /// ```text
    /// each part h of a sample:  L(h) is lost with no fewer than (π + arg L(h))/θ whole samples more, θ its crossovers
    /// ```
    /// Sixteen parts are tried (four of a very long dead time), and the one that makes the dead time whole, where L changes most; and
    /// the delay is narrowed until the verdicts on both sides of it differ. A loop that is lost for less than a sixteenth of a sample may
    /// be missed. `first` itself of a loop that is not stable. Of a plant that follows a rule it is the margin of the plant behind its
    /// hold.
    ///
    /// # Errors
    /// As `later` gives them.
    pub fn delay_margin<E>(
        first: Option<Crossing>,
        later: &dyn Fn(f64) -> Result<Self, E>,
    ) -> Result<Option<Crossing>, E> {
        let prompt = later(0.0)?;
        if !prompt.verdict().stable {
            return Ok(first);
        }
        let (rate, to_whole) = (prompt.rate(), prompt.to_whole());
        let prompt = prompt.of_plant().unwrap_or(prompt);
        let grid = prompt.grid();
        let turn = prompt.is_held().then(|| prompt.turn(&grid));
        let later = |samples: f64| {
            let late = later(samples / rate)?;
            let late = late.of_plant().unwrap_or(late).beside(&prompt);
            Ok(Later {
                late,
                turn,
                grid: OnceCell::new(),
            })
        };
        let count = if grid.len() > LONG { FEW_PARTS } else { PARTS };
        let equal = (0..count).map(|part| f64::from(part) / f64::from(count));
        let mut mores: Vec<f64> = equal.chain([to_whole]).collect();
        mores.sort_by(f64::total_cmp);
        mores.dedup();
        let zero = self::delay_margin(&later, &mores, 1)?;
        Ok(zero
            .map(|(samples, theta)| Crossing::new(theta * rate, samples / rate))
            .or(first))
    }

    /// Angle by which 1 + L turns from low frequency to half the sample rate, rad.
    fn turn(&self, grid: &[Point]) -> f64 {
        let pairs = grid.windows(2);
        pairs
            .map(|pair| self.turned(pair[0], pair[1], FOLLOWED))
            .sum()
    }

    fn turned(&self, from: Point, to: Point, halvings: u32) -> f64 {
        let turn = ((to.1 + 1.0) / (from.1 + 1.0)).arg();
        if turn.abs() < SLOW || halvings == 0 {
            return turn;
        }
        let theta = libm::sqrt(from.0 * to.0);
        let middle = (theta, self.open(theta));
        self.turned(from, middle, halvings - 1) + self.turned(middle, to, halvings - 1)
    }
}

/// θ of the grid at which L is nearest to −1.
fn nearest(grid: &[Point]) -> f64 {
    let away = |point: &Point| (point.1 + 1.0).norm();
    let nearest = grid.iter().min_by(|a, b| away(a).total_cmp(&away(b)));
    nearest.map_or(PI, |point| point.0)
}
