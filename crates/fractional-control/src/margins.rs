//! Margins and peaks of the loop that is really run.

use crate::SampledControlLoop;
use certified_count::{Arc, AtAngle, Bounds, LoopTerms, OpenLoop, Peak, is_clear};
use core::f64::consts::PI;
use num_complex::Complex;
use std::{vec, vec::Vec};

/// The slowest angle of the grid, rad a sample: at 1 kHz that of a time constant of 3000 years.
const SLOWEST: f64 = 1e-14;
/// The grid starts at 1e-8 rad a sample, or below if L has not come to rest there.
const DECADES_BELOW: usize = 6;
/// L moves and turns by less than this share where it has come to rest at low frequency.
const FLAT: f64 = 1e-3;
/// Smaller gains at which L meets −1 do not count: L jumps there from one end of the numbers to the other, through a pole on the circle.
const AT_A_POLE: f64 = 1e-10;
/// Share by which a peak may be exceeded, of a plant behind its hold, of whose response one derivative is bounded.
const PEAK: f64 = 1e-6;
const PEAK_HELD: f64 = 1e-3;
/// |L| is 1, or L real, but for rounding.
const ROUNDING: f64 = 1e-13;
/// A derivative that is not known is found over this share of an angle.
const BESIDE: f64 = 1e-6;

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

/// Margins and peaks of a [`SampledControlLoop`], from where L has come to rest to half the sample rate. They say how far a loop is from the boundary,
/// not on which side, which the verdict says. No crossing is missed, as [`OpenLoop`] says, and no peak exceeds its value by more than
/// 1e-6, of a plant behind its hold 1e-3.
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

/// L as A below B, with the angle at which it has come to rest.
pub(crate) struct Open<'a>(pub &'a SampledControlLoop, f64);

impl OpenLoop for Open<'_> {
    type Node = ();

    fn terms(&self, theta: f64) -> LoopTerms<()> {
        let parts = self.0.open_parts(&Arc::new(theta, theta));
        LoopTerms {
            theta,
            parts: parts.map(|part| part.middle),
            node: (),
        }
    }

    fn sloped(&self, theta: f64) -> LoopTerms<()> {
        let mut terms = self.terms(theta);
        if terms.parts.iter().any(|part| part.rate.is_nan()) {
            let ends = [theta * (1.0 - BESIDE), (theta * (1.0 + BESIDE)).min(PI)];
            let [before, behind] = ends.map(|theta| self.terms(theta).parts);
            let rate = |k: usize| (behind[k].value - before[k].value) / (ends[1] - ends[0]);
            (terms.parts[0].rate, terms.parts[1].rate) = (rate(0), rate(1));
        }
        terms
    }

    fn bounds(&self, a: &LoopTerms<()>, b: &LoopTerms<()>) -> [Bounds; 2] {
        let arc = Arc::new(a.theta, b.theta);
        self.0
            .open_parts(&arc)
            .map(|part| part.within(&arc).bounds(&arc))
    }

    fn least(&self) -> f64 {
        self.1
    }

    fn angles(&self) -> Vec<f64> {
        let eighths = core::iter::successors(Some(PI), |theta| Some(0.125 * theta));
        let mut angles: Vec<f64> = eighths.take_while(|theta| *theta > self.1).collect();
        angles.push(self.1);
        angles.reverse();
        angles
    }

    fn ends(&self) -> Vec<f64> {
        vec![PI]
    }

    fn narrow(&self, theta: f64) -> f64 {
        let share = if self.0.is_held() { 1e-6 } else { 1e-11 };
        share * theta
    }

    fn noise(&self) -> f64 {
        ROUNDING
    }
}

impl SampledControlLoop {
    /// Margins and peaks of any loop; for an unstable one they mean nothing.
    #[must_use]
    pub fn margins(&self) -> Margins {
        let (open, rate) = (Open(self, self.lowest()), self.rate());
        let gains = self.gain_crossings();
        let margins: Vec<Crossing> = self
            .turns()
            .map(|(theta, turn)| Crossing::new(theta * rate, turn))
            .collect();
        let size = |a: &&Crossing, b: &&Crossing| a.value.abs().total_cmp(&b.value.abs());
        let whole = |turn: f64| if turn < 0.0 { turn + 2.0 * PI } else { turn };
        let delays = margins.iter().map(|margin| Crossing {
            value: whole(margin.value) / margin.omega_rad_s,
            ..*margin
        });
        let tolerance = if self.is_held() { PEAK_HELD } else { PEAK };
        let peak = |peak| {
            let at = open.peak(peak, tolerance);
            Crossing::new(at.theta * rate, at.value)
        };
        Margins {
            phase: margins.iter().min_by(size).copied(),
            crossovers: margins.len(),
            gain_up: gains.iter().find(|gain| gain.value > 1.0).copied(),
            gain_down: gains.iter().rfind(|gain| gain.value < 1.0).copied(),
            delay_s: delays.min_by(|a, b| a.value.total_cmp(&b.value)),
            sensitivity: peak(Peak::Sensitivity),
            complementary: peak(Peak::Complementary),
        }
    }

    /// The angles at which |L| = 1, and the turn, −π to π, that takes L to −1 there.
    pub(crate) fn turns(&self) -> impl Iterator<Item = (f64, f64)> {
        // |L| is that without whole samples of dead time, and found sooner.
        let prompt = self.prompt();
        let angles = Open(&prompt, self.lowest()).crossovers();
        angles
            .into_iter()
            .map(|theta| (theta, (-self.open(theta)).arg()))
    }

    /// The gains, over the present one, at which L meets −1: the least first.
    #[must_use]
    pub fn gain_crossings(&self) -> Vec<Crossing> {
        let lowest = self.lowest();
        let mut found = Open(self, lowest).gain_crossings();
        // At rest too, where L has an end.
        let [first, second] = [lowest, lowest * (1.0 + FLAT)].map(|theta| self.open(theta));
        let is_end =
            (second / first - 1.0).norm() < FLAT * FLAT && first.im.abs() < FLAT * -first.re;
        found.extend(is_end.then(|| AtAngle::new(first.norm().recip(), lowest)));
        let counts = |gain: &AtAngle| gain.value.is_finite() && gain.value > AT_A_POLE;
        found.retain(counts);
        found.sort_by(|a, b| a.value.total_cmp(&b.value));
        found.dedup_by(|a, b| a.value - b.value < 1e-9 * a.value);
        let rate = self.rate();
        let crossings = found
            .into_iter()
            .map(|at| Crossing::new(at.theta * rate, at.value));
        crossings.collect()
    }

    /// The angle at which a search begins. Below it L is a whole power of θ, as integrators leave one, that crosses neither 1 nor −1.
    pub(crate) fn lowest(&self) -> f64 {
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
}

impl SampledControlLoop {
    /// Margins and peaks of the loop around the plant behind its hold. `later` is the loop whose plant has this much more
    /// dead time, s; if this is refused, the delay margin is in whole samples.
    ///
    /// A delay is one that the memory [holds](Self::remembered). Cost: that of [`delay_margin`](Self::delay_margin), some dozen verdicts.
    pub fn margins_of_plant<E>(&self, later: &dyn Fn(f64) -> Result<Self, E>) -> Margins {
        let held = if self.is_held() {
            None
        } else {
            self.of_plant()
        };
        let mut margins = held.as_ref().unwrap_or(self).margins();
        let first = self.remembered(margins.delay_s);
        let delay_s = Self::delay_margin(first, later).unwrap_or(first);
        margins.delay_s = self.remembered(delay_s);
        margins
    }
}

/// Range of the gains, over the nominal one.
const GAIN_RANGE: [f64; 2] = [0.01, 100.0];
/// Share by which the interval stays away from the gains at which L meets −1.
const AWAY: f64 = 1e-3;
/// Times the interval is narrowed to half its logarithm, where it is not proved as far as the margins.
const INTERVAL_NARROWED: usize = 8;

impl SampledControlLoop {
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
