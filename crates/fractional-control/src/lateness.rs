//! The delay margin of a plant behind a hold: a dead time of a part of a sample turns the loop otherwise than whole samples do.

use crate::margins::Point;
use crate::{Crossing, SampledLoop};
use core::f64::consts::PI;
use std::vec::Vec;

/// Parts of a sample that are looked at; and of a loop whose dead time turns it so often that it has more than so many points.
const PARTS: u32 = 16;
const FEW_PARTS: u32 = 4;
const LONG: usize = 20_000;
/// Suspects that turn out to be none, at most.
const NEAR_MISSES: usize = 64;

/// Who says whether a later loop is stable: the verdict of the loop; where a rule stands for its plant, the turns of 1 + L of the plant behind its
/// hold, which are those of the stable loop without more dead time, as dead time adds no poles.
#[derive(Clone, Copy, Debug)]
struct Judge {
    turn: Option<f64>,
}

impl Judge {
    /// By the loop without more dead time, and its grid.
    fn new(prompt: &SampledLoop, grid: &[Point]) -> Self {
        Self {
            turn: prompt.is_held().then(|| prompt.turn(grid)),
        }
    }

    /// `None` if it is stable, else the θ at which it is nearest to the boundary.
    fn lost(self, late: &SampledLoop) -> Option<f64> {
        match self.turn {
            Some(_) => self.lost_on(late, &late.grid()),
            None => self.lost_on(late, &[]),
        }
    }

    /// The same with the grid of L, of which a verdict makes no use.
    fn lost_on(self, late: &SampledLoop, grid: &[Point]) -> Option<f64> {
        match self.turn {
            Some(turn) => ((late.turn(grid) - turn).abs() > 0.5 * PI).then(|| nearest(grid)),
            None => {
                let verdict = late.verdict();
                (!verdict.stable).then(|| verdict.omega_rad_s / late.rate())
            }
        }
    }
}

/// What is known of the delays with one part of a sample, in samples.
#[derive(Clone, Debug)]
struct Part {
    more: f64,
    /// True if the loop is stable with the part alone.
    stable: bool,
    /// θ of the crossovers, and the whole turn, 0 to 2π, that takes L to −1 there.
    crossovers: Vec<(f64, f64)>,
}

/// A delay, in samples, at which a loop may be lost, the first for its part; and about where L meets −1, with its θ.
#[derive(Clone, Copy, Debug)]
struct Suspect {
    delay: f64,
    near: (f64, f64),
}

impl Part {
    fn new(late: &SampledLoop, judge: Judge, more: f64) -> Self {
        let grid = late.grid();
        let margins = late.phase_margins(&grid);
        let whole = |turn: f64| if turn < 0.0 { turn + 2.0 * PI } else { turn };
        let mut crossovers: Vec<(f64, f64)> = margins
            .iter()
            .map(|margin| (margin.omega_rad_s / late.rate(), whole(margin.value)))
            .collect();
        // At half the sample rate each whole sample turns L round, and a stable loop has L > −1 there.
        if late.open(PI).norm() >= 1.0 {
            crossovers.push((PI, PI));
        }
        Self {
            more,
            stable: judge.lost_on(late, &grid).is_none(),
            crossovers,
        }
    }

    /// The first one beyond a delay up to which the loop is stable wherever it was looked at.
    fn suspect(&self, after: f64) -> Option<Suspect> {
        if !self.stable {
            let delay = self.more;
            return (delay > after).then_some(Suspect {
                delay,
                near: (delay, PI),
            });
        }
        // The last delay of this part that was looked at.
        let last = libm::floor(after - self.more).max(0.0);
        let meets = self.crossovers.iter().map(|&(theta, turn)| {
            let turns = libm::ceil((last * theta - turn) / (2.0 * PI)).max(0.0);
            ((turn + 2.0 * PI * turns) / theta, theta)
        });
        let (first, theta) = meets.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(Suspect {
            delay: libm::ceil(first).max(last + 1.0) + self.more,
            near: (first + self.more, theta),
        })
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
    /// Sixteen parts are looked at (four of a very long dead time), and the one that makes the dead time whole, where L changes most; and
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
        let judge = Judge::new(&prompt, &grid);
        let at = |samples: f64| {
            let late = later(samples / rate)?;
            Ok(late.of_plant().unwrap_or(late).beside(&prompt))
        };
        let count = if grid.len() > LONG { FEW_PARTS } else { PARTS };
        let equal = (0..count).map(|part| f64::from(part) / f64::from(count));
        let mut mores: Vec<f64> = equal.chain([to_whole]).collect();
        mores.sort_by(f64::total_cmp);
        mores.dedup();
        let mut parts: Vec<Part> = Vec::new();
        for more in mores {
            parts.push(Part::new(&at(more)?, judge, more));
            if !parts.iter().all(|part| part.stable) {
                break;
            }
        }
        let mut after = 0.0;
        for _ in 0..NEAR_MISSES {
            let next = parts.iter().filter_map(|part| part.suspect(after));
            let Some(next) = next.min_by(|a, b| a.delay.total_cmp(&b.delay)) else {
                break;
            };
            if judge.lost(&at(next.delay)?).is_some() {
                let (samples, theta) = narrowed(&at, judge, &next, 1.0 / f64::from(count))?;
                return Ok(Some(Crossing::new(theta * rate, samples / rate)));
            }
            after = next.delay;
        }
        Ok(first)
    }

    /// How far 1 + L turns from low frequency to half the sample rate, rad.
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

/// θ at which L is nearest to −1, of those that are looked at.
fn nearest(grid: &[Point]) -> f64 {
    let away = |point: &Point| (point.1 + 1.0).norm();
    let nearest = grid.iter().min_by(|a, b| away(a).total_cmp(&away(b)));
    nearest.map_or(PI, |point| point.0)
}

/// Times a delay margin is made better at most, by secants.
const REFINED: usize = 8;
/// What is left of a delay margin, as a share of it, that is nothing.
const SETTLED: f64 = 1e-9;
/// The verdicts so near a delay margin, as a share of it, differ.
const BESIDE: f64 = 1e-7;
/// Times the interval of a delay margin is halved.
const HALVED: usize = 30;

/// The delay, in samples, at which the loop is lost, within a part of a sample before one at which it is.
fn narrowed<E>(
    at: &dyn Fn(f64) -> Result<SampledLoop, E>,
    judge: Judge,
    suspect: &Suspect,
    part: f64,
) -> Result<(f64, f64), E> {
    let (mut low, mut high) = ((suspect.delay - part).max(0.0), suspect.delay);
    let is_stable = |delay: f64| Ok(judge.lost(&at(delay)?).is_none());
    if let Some(found) = by_phase(at, suspect.near, low, high)?
        && is_stable(found.0 * (1.0 - BESIDE))?
        && !is_stable(found.0 * (1.0 + BESIDE))?
    {
        return Ok(found);
    }
    let mut theta = suspect.near.1;
    for _ in 0..HALVED {
        let middle = 0.5 * (low + high);
        if let Some(lost) = judge.lost(&at(middle)?) {
            (high, theta) = (middle, lost);
        } else {
            low = middle;
        }
    }
    Ok((high, theta))
}

/// φ(d)/θ(d) = 0 for the phase margin φ of the loop that is d late, at the crossover θ next to that before, within two delays.
fn by_phase<E>(
    at: &dyn Fn(f64) -> Result<SampledLoop, E>,
    near: (f64, f64),
    low: f64,
    high: f64,
) -> Result<Option<(f64, f64)>, E> {
    let (mut delay, mut theta) = (near.0.clamp(low, high), near.1);
    let mut before: Option<(f64, f64)> = None;
    for _ in 0..REFINED {
        let late = at(delay)?;
        let margins = late.phase_margins(&late.grid());
        let away = |margin: &Crossing| libm::log(margin.omega_rad_s / late.rate() / theta).abs();
        let nearest = margins.iter().min_by(|a, b| away(a).total_cmp(&away(b)));
        let Some(nearest) = nearest else {
            return Ok(None);
        };
        theta = nearest.omega_rad_s / late.rate();
        let left = nearest.value / theta;
        if left.abs() <= SETTLED * delay {
            return Ok(Some((delay, theta)));
        }
        // The slope of what is left: −1 but for the hold.
        let slope = before.map_or(-1.0, |(last, more)| (more - left) / (last - delay));
        let slope = if slope < -0.5 { slope } else { -1.0 };
        before = Some((delay, left));
        delay = (delay - left / slope).clamp(low, high);
    }
    Ok(None)
}
