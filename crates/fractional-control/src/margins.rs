//! Margins and peaks of the loop that is really run.

use crate::SampledLoop;
use certified_count::is_clear;
use core::f64::consts::PI;
use num_complex::Complex;
use std::vec::Vec;

/// The slowest angle of the grid, rad a sample: at 1 kHz that of a time constant of 3000 years.
const SLOWEST: f64 = 1e-14;
/// The grid starts at 1e-8 rad a sample, or below if L has not come to rest there.
const DECADES_BELOW: usize = 6;
/// Points a decade before any is put between.
const A_DECADE: f64 = 100.0;
/// Neighbours are at most so far apart in ln L: gain and phase in rad.
const APART: f64 = 0.2;
/// Largest number of times that points are put between two neighbours.
const HALVINGS: u32 = 12;
/// L moves and turns by less than this share where it has come to rest at low frequency.
const FLAT: f64 = 1e-3;
/// First step from a peak, as a share of its angle, to both sides, doubled each time.
const SIDE: f64 = 1e-11;
/// Smaller gains at which L meets −1 do not count: L jumps there from one end of the numbers to the other, through a pole on the circle.
const AT_A_POLE: f64 = 1e-10;
/// Times the place of a peak is narrowed by the golden section, or that of a crossing halved.
const NARROWED: usize = 60;

/// ln |L| that is 0 but for rounding.
const ROUNDING: f64 = 1e-13;

/// A value and where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// The frequency ω, rad/s, at which the value arises.
    pub omega_rad_s: f64,
    /// The value, in the unit that its field in [`Margins`] states.
    pub value: f64,
}

impl Crossing {
    pub(crate) const fn new(omega_rad_s: f64, value: f64) -> Self {
        Self { omega_rad_s, value }
    }
}

/// Margins and peaks of a [`SampledLoop`], up to half the sample rate, by a grid that is finer
/// where L moves. They say how far a loop is from the boundary, not on which side, which the
/// verdict says.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Margins {
    /// The least phase margin in size, rad, with its crossover; `None` if |L| is never 1.
    pub phase: Option<Crossing>,
    /// Crossovers, |L| = 1.
    pub crossovers: usize,
    /// The least gain above 1 at which L meets −1.
    pub gain_up: Option<Crossing>,
    /// The greatest gain below 1 at which L meets −1.
    pub gain_down: Option<Crossing>,
    /// The least further dead time at which L meets −1, s, with its crossover.
    pub delay_s: Option<Crossing>,
    /// The largest |S| = |1/(1 + L)|.
    pub sensitivity: Crossing,
    /// The largest |T| = |L/(1 + L)|.
    pub complementary: Crossing,
}

/// θ and L.
pub(crate) type Point = (f64, Complex<f64>);

/// Angles on both sides of a peak, up to the step of the grid.
fn beside(peak: f64) -> impl Iterator<Item = f64> {
    let sides = core::iter::successors(Some(SIDE), |side| Some(2.0 * side));
    let sides = sides.take_while(|side| *side < 1.0 / A_DECADE);
    sides.flat_map(move |side| [peak * (1.0 - side), peak * (1.0 + side)])
}

impl SampledLoop {
    /// Margins and peaks of any loop; for an unstable one they mean nothing.
    #[must_use]
    pub fn margins(&self) -> Margins {
        let grid = self.grid();
        let gains = self.gains(&grid);
        let margins = self.phase_margins(&grid);
        let size = |a: &&Crossing, b: &&Crossing| a.value.abs().total_cmp(&b.value.abs());
        let by_value = |a: &&Crossing, b: &&Crossing| a.value.total_cmp(&b.value);
        let whole = |turn: f64| if turn < 0.0 { turn + 2.0 * PI } else { turn };
        let delays = margins.iter().map(|margin| Crossing {
            value: whole(margin.value) / margin.omega_rad_s,
            ..*margin
        });
        let above = gains.iter().filter(|gain| gain.value > 1.0);
        let below = gains.iter().filter(|gain| gain.value < 1.0);
        Margins {
            phase: margins.iter().min_by(size).copied(),
            crossovers: margins.len(),
            gain_up: above.min_by(by_value).copied(),
            gain_down: below.max_by(by_value).copied(),
            delay_s: delays.min_by(|a, b| a.value.total_cmp(&b.value)),
            sensitivity: self.peak(&grid, |l| (l + 1.0).inv().norm()),
            complementary: self.peak(&grid, |l| (l / (l + 1.0)).norm()),
        }
    }

    /// The phase margin of each crossover, rad, −π to π.
    pub(crate) fn phase_margins(&self, grid: &[Point]) -> Vec<Crossing> {
        // A loop that comes to rest at 1 crosses it by rounding only.
        let log = |l: Complex<f64>| libm::log(l.norm());
        let apart = grid.iter().filter(|(_, l)| log(*l).abs() > ROUNDING);
        let apart: Vec<Point> = apart.copied().collect();
        let crossovers = self.where_zero(&apart, log, |_| true);
        let rate = self.rate();
        let margin = |&(theta, l): &Point| Crossing::new(theta * rate, (-l).arg());
        crossovers.iter().map(margin).collect()
    }

    /// The gains, over the present one, at which L meets −1: the least first.
    #[must_use]
    pub fn gain_crossings(&self) -> Vec<Crossing> {
        let mut gains = self.gains(&self.grid());
        gains.sort_by(|a, b| a.value.total_cmp(&b.value));
        gains
    }

    /// The gains at which L meets −1.
    fn gains(&self, grid: &[Point]) -> Vec<Crossing> {
        let mut places = self.where_zero(grid, |l| l.im, |l| l.re < 0.0);
        // At half the sample rate L is real; at rest too, where it has an end.
        let at_rest = grid.get(..2).filter(|pair| {
            let (first, second) = (pair[0].1, pair[1].1);
            (second / first - 1.0).norm() < FLAT && first.im.abs() < FLAT * -first.re
        });
        places.extend(at_rest.and_then(<[Point]>::first));
        places.extend(grid.last().filter(|(_, l)| l.re < 0.0));
        let gains = places
            .into_iter()
            .map(|(theta, l)| Crossing::new(theta * self.rate(), l.norm().recip()));
        let counts = |gain: &Crossing| gain.value.is_finite() && gain.value > AT_A_POLE;
        gains.filter(counts).collect()
    }

    /// The angle at which the grid begins. Below it L is a whole power of θ, as integrators leave one, that crosses neither 1 nor −1.
    fn lowest(&self) -> f64 {
        let theta = |decade: usize| SLOWEST * libm::pow(10.0, decade as f64);
        let values: Vec<Complex<f64>> = (0..=DECADES_BELOW + 1)
            .map(|decade| self.open(theta(decade)))
            .collect();
        let rests = |pair: &&[Complex<f64>]| {
            let moved = pair[1] / pair[0];
            let power = libm::round(libm::log10(moved.norm()));
            let is_power = (moved / libm::pow(10.0, power) - 1.0).norm() < FLAT;
            is_power && (pair[0].norm() > 1.0) == (pair[1].norm() > 1.0)
        };
        let resting = values.windows(2).take_while(rests).count();
        theta(resting.saturating_sub(1))
    }

    /// L from where it is at rest to half the sample rate.
    pub(crate) fn grid(&self) -> Vec<Point> {
        let lowest = self.lowest();
        let decades = libm::log10(PI / lowest);
        let count = libm::ceil(decades * A_DECADE) as usize;
        let even = (0..=count).map(|k| {
            let share = k as f64 / count as f64;
            (lowest * libm::pow(10.0, decades * share)).min(PI)
        });
        let near = self.peaks().angles().iter().flat_map(|peak| beside(*peak));
        let near = near.filter(|theta| *theta > lowest && *theta < PI);
        let mut thetas: Vec<f64> = even.chain(near).collect();
        thetas.sort_by(f64::total_cmp);
        thetas.dedup();
        let mut grid: Vec<Point> = Vec::new();
        for theta in thetas {
            let next = (theta, self.open(theta));
            if let Some(last) = grid.last().copied() {
                self.between(&mut grid, last, next, HALVINGS);
            }
            grid.push(next);
        }
        grid.retain(|(_, l)| l.is_finite());
        grid
    }

    /// Puts points between two until neighbours are close.
    fn between(&self, grid: &mut Vec<Point>, from: Point, to: Point, halvings: u32) {
        // Neither is kept.
        if !from.1.is_finite() && !to.1.is_finite() {
            return;
        }
        let apart = (to.1 / from.1).ln();
        // A response that is small and far from −1 need not be followed.
        let matters = from.1.norm().max(to.1.norm()) > 1e-3;
        if halvings == 0 || !matters || apart.norm() < APART {
            return;
        }
        let theta = libm::sqrt(from.0 * to.0);
        let middle = (theta, self.open(theta));
        self.between(grid, from, middle, halvings - 1);
        grid.push(middle);
        self.between(grid, middle, to, halvings - 1);
    }

    /// The places where this changes its sign and L is so, by halving.
    fn where_zero(
        &self,
        grid: &[Point],
        of: impl Fn(Complex<f64>) -> f64,
        counts: impl Fn(Complex<f64>) -> bool,
    ) -> Vec<Point> {
        let changes = |pair: &&[Point]| of(pair[0].1) * of(pair[1].1) < 0.0;
        let places = grid.windows(2).filter(changes).map(|pair| {
            let (mut low, mut high) = (pair[0], pair[1]);
            for _ in 0..NARROWED {
                let theta = 0.5 * (low.0 + high.0);
                let middle = (theta, self.open(theta));
                if of(middle.1) * of(low.1) > 0.0 {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            high
        });
        places.filter(|(_, l)| counts(*l)).collect()
    }

    /// The largest value, narrowed between the neighbours of the largest on the grid.
    fn peak(&self, grid: &[Point], of: impl Fn(Complex<f64>) -> f64) -> Crossing {
        let value = |point: &Point| of(point.1);
        let best = (0..grid.len()).max_by(|&a, &b| value(&grid[a]).total_cmp(&value(&grid[b])));
        let best = best.unwrap_or(0);
        let at = |index: usize| grid.get(index).map_or(PI, |point| point.0);
        let (mut low, mut high) = (at(best.saturating_sub(1)), at(best + 1));
        let golden = 0.5 * (libm::sqrt(5.0) - 1.0);
        for _ in 0..NARROWED {
            let (a, b) = (high - golden * (high - low), low + golden * (high - low));
            if of(self.open(a)) > of(self.open(b)) {
                high = b;
            } else {
                low = a;
            }
        }
        let theta = 0.5 * (low + high);
        let narrowed = of(self.open(theta));
        let on_grid = grid.get(best).map_or(f64::NAN, value);
        let (theta, value) = if narrowed >= on_grid {
            (theta, narrowed)
        } else {
            (at(best), on_grid)
        };
        Crossing::new(theta * self.rate(), value)
    }
}

impl SampledLoop {
    /// Margins and peaks of the loop around the plant behind its hold. `own` are the
    /// [`margins`](Self::margins) of this loop, `later` is the loop whose plant has this much more
    /// dead time, s; if this is refused, the delay margin is in whole samples.
    ///
    /// A delay is one that the memory [holds](Self::remembered). Cost: that of [`delay_margin`](Self::delay_margin), some dozen verdicts.
    pub fn margins_of_plant<E>(
        &self,
        own: Margins,
        later: &dyn Fn(f64) -> Result<Self, E>,
    ) -> Margins {
        let held = self.of_plant();
        let mut margins = held.map_or(own, |held| held.margins());
        let first = self.remembered(margins.delay_s);
        margins.delay_s = self.remembered(
            Self::delay_margin(first, &|delay_s| Ok::<_, E>(later(delay_s)?.beside(self)))
                .unwrap_or(first),
        );
        margins
    }
}

/// Range of the gains, over the nominal one.
const GAIN_RANGE: [f64; 2] = [0.01, 100.0];
/// Share by which the interval stays away from the gains at which L meets −1.
const AWAY: f64 = 1e-3;
/// Times the interval is narrowed to half its logarithm, where a margin was missed by the grid.
const INTERVAL_NARROWED: usize = 8;

impl SampledLoop {
    /// True if it is proved that the loop is stable for every gain of the plant from `low` to `high` times the present one, 0 < low ≤ high.
    /// ```text
    /// A_C·A_G + k·B_C·B_G is 0 nowhere on the circle for any of these k: the number of zeros within is the same for all
    /// ```
    /// *Cost*: that of two verdicts.
    #[must_use]
    pub fn is_stable_over(&self, low: f64, high: f64) -> bool {
        let gains = [self.gain() * low, self.gain() * high];
        let is_interval = gains[0] > 0.0 && low <= high && gains[1].is_finite();
        is_interval
            && self.with_gain(gains[0]).verdict().stable
            && is_clear(|arc| self.parts(arc), gains)
    }

    /// The gains of the plant, over the present one, between which the loop is proved stable: as far as the gain margins, within a hundredth
    /// to a hundred times. `None` for a loop that is not stable.
    #[must_use]
    pub fn gain_interval(&self, margins: &Margins) -> Option<[f64; 2]> {
        let low = margins.gain_down.map_or(0.0, |down| down.value);
        let high = margins.gain_up.map_or(f64::INFINITY, |up| up.value);
        if !self.is_stable_over(1.0, 1.0) {
            return None;
        }
        let low = (low * (1.0 + AWAY)).clamp(GAIN_RANGE[0], 1.0);
        let high = (high * (1.0 - AWAY)).clamp(1.0, GAIN_RANGE[1]);
        // Each side for itself, towards 1 where it is not proved.
        let nearer = |gain: &f64| Some(libm::sqrt(*gain));
        let tried = |gain: f64| core::iter::successors(Some(gain), nearer).take(INTERVAL_NARROWED);
        let low = tried(low).find(|low| self.is_stable_over(*low, 1.0));
        let high = tried(high).find(|high| self.is_stable_over(1.0, *high));
        Some([low.unwrap_or(1.0), high.unwrap_or(1.0)])
    }
}
