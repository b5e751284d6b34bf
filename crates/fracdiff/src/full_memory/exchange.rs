//! The best modes: a sum of n exponentials whose largest relative error is as small as n allow.
//! ```text
//! min_{s,w > 0} max_{L ≤ j ≤ H} |Σ_q w_q·e^(−j·s_q)/c(j) − 1|
//! Σ_q w_q·e^(−j_i·s_q)/c(j_i) = 1 − (−1)^i·ε,   i = 0…2n      at lags j_i where the error is largest between two changes of its sign
//! ```
//! Weights that only fade have one best sum. Its error alternates 2n times, and its weights are all positive (D. Braess, *Nonlinear
//! Approximation Theory*, 1986, ch. VII). The equations for ln s, ln w and ε are solved by Newton's method, the lags exchanged for
//! those of the largest errors until these are alike (E. Ya. Remez, 1934; for exponential sums W. Hackbusch, *Computing and
//! Visualization in Science* 20, 2019). The solution for n modes, stretched, is the start for a few more.

use super::kernel::{DecayingMode, Grid};
use core::f64::consts::PI;
use std::vec;
use std::vec::Vec;

/// Modes of the first solution.
const FEWEST: usize = 3;
/// More of them where they would be farther apart than this in ln s.
const STEP_MOST: f64 = 2.5;
/// Length that both ends add to ln(horizon/taps) in an error that falls like exp(−π²·modes/(ln(horizon/taps) + ENDS)).
const ENDS: f64 = 1.34;
/// Modes that are added at once, at most.
const AT_ONCE: usize = 5;
/// Newton steps at most, and the share of ε that they may leave.
const STEPS: usize = 60;
const SOLVED: f64 = 0.01;
/// Largest change of a logarithm in a step.
const FAR: f64 = 0.4;
/// Errors are alike if none is larger than another by more than this factor.
const ALIKE: f64 = 1.1;
/// Factor as in [`ALIKE`], where the tolerance lies between the errors.
const SAME: f64 = 1.01;
const EXCHANGES: usize = 12;
/// An error of this share of the tolerance that is not enough will not be.
const HOPELESS: f64 = 0.1;
/// Points between two lags where an error is looked for.
const POINTS: usize = 8;

/// A best sum of exponentials over lags from `taps` to `horizon`, for weights that only fade.
#[derive(Clone)]
pub(super) struct Exchange<'a> {
    weight: &'a dyn Fn(f64) -> f64,
    /// ln j of the ends.
    ends: (f64, f64),
    /// ln s and ln w, fastest first.
    rates: Vec<f64>,
    weights: Vec<f64>,
    /// ln j of the equations.
    lags: Vec<f64>,
    error: f64,
}

impl<'a> Exchange<'a> {
    /// Sum of the fewest modes. `exponent`: of the density over ln s where modes are slow, as near as it is known.
    pub(super) fn new(
        weight: &'a dyn Fn(f64) -> f64,
        exponent: f64,
        taps: usize,
        horizon: f64,
        tolerance: f64,
    ) -> Option<Self> {
        let ends = (libm::log(taps as f64), libm::log(horizon));
        let reach = ends.1 - ends.0 + ENDS;
        let expected = libm::fmax(STEP_MOST, Grid::step_of(exponent, 2.0 * tolerance));
        let count = ((reach / expected) as usize).max(FEWEST);
        let step = reach / count as f64;
        // As the best rates are seen to be.
        let fastest = libm::log(2.45 * libm::pow(step, -1.7)) - ends.0;
        let slowest = libm::log(0.75 * step) - ends.1;
        let between = |q: usize| (slowest - fastest) * q as f64 / (count - 1) as f64;
        let mut rates: Vec<f64> = (0..count).map(|q| fastest + between(q)).collect();
        rates[count - 1] += libm::log(exponent);
        // Fall of the weight between the decay of a mode and that of the next slower one.
        let at = |rate: &f64| weight(libm::exp((-rate).clamp(ends.0, ends.1)));
        let left = |q: usize| rates.get(q).map_or(0.0, at);
        let gone = |q: usize| libm::log(left(q) - left(q + 1));
        let weights = (0..count).map(gone).collect();
        // Two a mode, closer at the ends.
        let last = 2 * count;
        let place = |i: usize| match i {
            0 => 0.0,
            i if i == last => i as f64 - 0.85,
            i => i as f64 - 0.3,
        };
        let lags = (0..=last).map(|i| ends.0 + (ends.1 - ends.0) * place(i) / place(last));
        let mut exchange = Self {
            weight,
            ends,
            rates,
            weights,
            lags: lags.collect(),
            error: 0.0,
        };
        exchange.solve(tolerance).then_some(exchange)
    }

    /// The narrowest swing of the error, in ln j.
    fn swing(&self) -> f64 {
        let swings = self.lags.windows(3).map(|lags| lags[2] - lags[0]);
        swings.fold(f64::INFINITY, libm::fmin)
    }

    fn modes(&self) -> Vec<DecayingMode> {
        let logs = self.rates.iter().zip(&self.weights);
        logs.map(|(rate, weight)| DecayingMode {
            rate: libm::exp(*rate),
            weight: libm::exp(*weight),
        })
        .collect()
    }

    /// Adds modes until `enough` accepts the modes and the narrowest swing of their error; false if it never does.
    pub(super) fn until(
        mut self,
        tolerance: f64,
        enough: &mut dyn FnMut(&[DecayingMode], f64) -> bool,
    ) -> bool {
        loop {
            if self.error <= tolerance && enough(&self.modes(), self.swing()) {
                return true;
            }
            if self.error < HOPELESS * tolerance || !self.grow(tolerance) {
                return false;
            }
        }
    }

    /// Adds the modes that the tolerance is expected to need, but not too many at once; false if no number of them succeeds.
    fn grow(&mut self, tolerance: f64) -> bool {
        let have = self.rates.len();
        let each = PI * PI / (self.ends.1 - self.ends.0 + ENDS);
        let wanted = libm::log(self.error / tolerance) / each;
        let mut more = (wanted as usize).clamp(1, (have / 3).min(AT_ONCE));
        while more > 0 {
            let mut grown = self.clone();
            grown.stretch(have + more);
            if grown.solve(tolerance) {
                *self = grown;
                return true;
            }
            more /= 2;
        }
        false
    }

    /// Spreads the modes to a start for `count` modes.
    fn stretch(&mut self, count: usize) {
        // ln s, and the density w/h over it, at as many places in the same span.
        let spacing = |rates: &[f64]| -> Vec<f64> {
            let last = rates.len() - 1;
            let width = |i: usize| {
                let (from, to) = (i.saturating_sub(1), (i + 1).min(last));
                (rates[from] - rates[to]) / (to - from) as f64
            };
            (0..=last).map(|i| libm::log(width(i))).collect()
        };
        let before = spacing(&self.rates);
        for (weight, spacing) in self.weights.iter_mut().zip(before) {
            *weight -= spacing;
        }
        self.rates = stretched(&self.rates, count);
        self.weights = stretched(&self.weights, count);
        for (weight, spacing) in self.weights.iter_mut().zip(spacing(&self.rates)) {
            *weight += spacing;
        }
        self.lags = stretched(&self.lags, 2 * count + 1);
    }

    /// Exchanges lags until the largest errors are alike.
    fn solve(&mut self, tolerance: f64) -> bool {
        for _ in 0..EXCHANGES {
            if !self.newton() {
                return false;
            }
            let (least, most) = self.exchange();
            self.error = most;
            let between = least <= tolerance && tolerance < most;
            if most <= (if between { SAME } else { ALIKE }) * least {
                return true;
            }
        }
        true
    }

    /// Solves the equations at the lags as they are.
    fn newton(&mut self) -> bool {
        let count = self.rates.len();
        let lags = self.lags.iter().map(|ln_lag| libm::exp(*ln_lag));
        let lags: Vec<(f64, f64)> = lags.map(|lag| (lag, (self.weight)(lag))).collect();
        let mut error = 0.0;
        for _ in 0..STEPS {
            let (modes, mut missing) = (self.modes(), 0.0);
            let rows = lags.iter().enumerate().map(|(i, &(lag, true_weight))| {
                let (sign, mut row) = (sign(i), vec![0.0; 2 * count + 2]);
                let mut sum = 0.0;
                for (q, mode) in modes.iter().enumerate().rev() {
                    let share = mode.weight * libm::exp(-lag * mode.rate);
                    sum += share;
                    (row[q], row[count + q]) = (-lag * mode.rate * share, share);
                }
                // ln Σ − ln(1 ± ε): its slopes by ln s, ln w and ε, and what is missing.
                row[..2 * count].iter_mut().for_each(|slope| *slope /= sum);
                let wanted = 1.0 + sign * error;
                row[2 * count] = -sign / wanted;
                row[2 * count + 1] = libm::log(wanted * true_weight / sum);
                let left = row[2 * count + 1].abs();
                if left > missing || left.is_nan() {
                    missing = left;
                }
                row
            });
            let rows: Vec<Vec<f64>> = rows.collect();
            if missing <= SOLVED * error {
                let is_one = |mode: &DecayingMode| mode.rate > 0.0 && mode.weight > 0.0;
                return modes.iter().all(is_one);
            }
            let Some(change) = solution(rows) else {
                return false;
            };
            let sizes = change[..2 * count].iter().map(|x| x.abs());
            let largest = sizes.fold(0.0, libm::fmax);
            if !largest.is_finite() {
                return false;
            }
            let share = libm::fmin(1.0, FAR / largest);
            let logs = self.rates.iter_mut().chain(&mut self.weights);
            for (x, change) in logs.zip(&change) {
                *x += share * change;
            }
            error = (error + share * change[2 * count]).clamp(-0.9, 0.9);
        }
        false
    }

    /// Moves each lag to the largest error of its sign between its neighbours: the least and the largest of these.
    fn exchange(&mut self) -> (f64, f64) {
        let last = self.lags.len() - 1;
        let places = stretched(&self.lags, POINTS * last + 1);
        let modes = self.modes();
        let error = |ln_lag: &f64| {
            let lag = libm::exp(*ln_lag);
            let share = |mode: &DecayingMode| mode.weight * libm::exp(-lag * mode.rate);
            modes.iter().rev().map(share).sum::<f64>() / (self.weight)(lag) - 1.0
        };
        let errors: Vec<f64> = places.iter().map(error).collect();
        let (mut least, mut most) = (f64::INFINITY, 0.0);
        for i in 0..=last {
            let sign = sign(i);
            let from = (POINTS * i).saturating_sub(POINTS - 1);
            let to = (POINTS * i + POINTS - 1).min(errors.len() - 1);
            let (mut place, mut largest) = (POINTS * i, sign * errors[POINTS * i]);
            for (k, error) in errors.iter().enumerate().take(to + 1).skip(from) {
                if sign * error > largest {
                    (place, largest) = (k, sign * error);
                }
            }
            self.lags[i] = places[place];
            least = libm::fmin(least, largest);
            most = libm::fmax(most, largest);
        }
        (least, most)
    }
}

/// The first error is below the weight.
fn sign(i: usize) -> f64 {
    if i.is_multiple_of(2) { -1.0 } else { 1.0 }
}

/// `count` values along the line through the given ones, with the same ends.
fn stretched(values: &[f64], count: usize) -> Vec<f64> {
    let last = values.len() - 1;
    let at = |k: usize| {
        let place = (k * last) as f64 / (count - 1) as f64;
        let index = (place as usize).min(last - 1);
        values[index] + (place - index as f64) * (values[index + 1] - values[index])
    };
    (0..count).map(at).collect()
}

/// x of A·x = b by elimination with the largest pivots; each row has its b at the end. `None` where A is singular.
fn solution(mut rows: Vec<Vec<f64>>) -> Option<Vec<f64>> {
    let count = rows.len();
    for column in 0..count {
        let size = |row: &usize| rows[*row][column].abs();
        let pivot = (column..count).max_by(|a, b| size(a).total_cmp(&size(b)))?;
        rows.swap(column, pivot);
        let (done, below) = rows.split_at_mut(column + 1);
        let pivot = &done[column];
        if pivot[column] == 0.0 {
            return None;
        }
        for row in below {
            let factor = row[column] / pivot[column];
            for (a, p) in row[column..].iter_mut().zip(&pivot[column..]) {
                *a -= factor * p;
            }
        }
    }
    let mut x = vec![0.0; count];
    for row in (0..count).rev() {
        let known = rows[row][row + 1..count].iter().zip(&x[row + 1..]);
        let known = known.fold(0.0, |sum, (a, x)| sum + a * x);
        x[row] = (rows[row][count] - known) / rows[row][row];
    }
    Some(x)
}
