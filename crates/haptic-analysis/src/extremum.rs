//! Global maximum of a function of the digital frequency θ on [0, π].
//!
//! A grid brackets every local maximum, golden sections refine it: no derivative, and no maximum
//! narrower than the grid can hide as long as the function oscillates no faster than stated.

use std::f64::consts::PI;

/// Grid points per decade of θ near 0, and of π − θ near π.
const PER_DECADE: f64 = 8.0;
/// Smallest θ of the grid.
const NEAR_ZERO: f64 = 1e-12;
/// Smallest π − θ of the grid, apart from 0: below it π − θ is mostly rounding.
const NEAR_PI: f64 = 1e-8;
/// Fewest points the linear part would need for the whole of [0, π].
const LINEAR_MIN: usize = 256;
/// Grid points per period of the fastest oscillation.
const PER_PERIOD: usize = 8;
/// Golden sections: they shrink a bracket by 0.618^40 = 4e-9, hence the value by its square.
const SECTIONS: usize = 40;
/// Values closer than this, relative, are the same maximum.
const TIE: f64 = 1e-14;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Maximum {
    pub(crate) theta: f64,
    pub(crate) value: f64,
}

/// The grid: geometric near 0 and near π, linear between, ascending, π last and 0 not in it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Grid {
    thetas: Vec<f64>,
}

impl Grid {
    /// A grid for functions whose fastest oscillation is cos(`samples`·θ): memory length plus delay.
    /// Holds about 4·`samples` + 400 points, at least 8 a period.
    pub(crate) fn new(samples: usize) -> Self {
        let step = PI / (PER_PERIOD * samples / 2).max(LINEAR_MIN) as f64;
        let ratio = libm::pow(10.0, 1.0 / PER_DECADE);
        // Geometric as long as its steps are the smaller ones.
        let widest = step / (ratio - 1.0);
        let geometric = |first: f64| {
            std::iter::successors(Some(first), move |x| Some(x * ratio))
                .take_while(move |x| *x < widest)
        };
        let mut thetas: Vec<f64> = geometric(NEAR_ZERO).collect();
        let start = thetas.last().copied().unwrap_or(NEAR_ZERO);
        let upper: Vec<f64> = geometric(NEAR_PI).collect();
        let stop = PI - upper.last().copied().unwrap_or(NEAR_PI);
        let inner = libm::ceil((stop - start) / step) as usize;
        thetas.extend((1..inner).map(|i| start + (stop - start) * i as f64 / inner as f64));
        thetas.extend(upper.iter().rev().map(|x| PI - x));
        thetas.push(PI);
        Self { thetas }
    }

    pub(crate) fn thetas(&self) -> &[f64] {
        &self.thetas
    }

    /// The largest value on [0, π], relative error about 1e-13, and where; `None` if the function is
    /// NaN anywhere. `at_zero` is its limit for θ → 0; the function itself is called for θ > 0 only.
    ///
    /// - −∞ excludes a frequency; +∞ is a maximum like any other.
    /// - Of equal maxima π goes first, then 0, then the larger θ.
    /// - Cost: one call per grid point, and 41 for every local maximum that can still be the largest.
    pub(crate) fn maximum(&self, at_zero: f64, f: &dyn Fn(f64) -> f64) -> Option<Maximum> {
        let values: Vec<f64> = self.thetas.iter().map(|&theta| f(theta)).collect();
        if at_zero.is_nan() || values.iter().any(|value| value.is_nan()) {
            return None;
        }
        let last = values.len() - 1;
        let ends = [(PI, values[last]), (0.0, at_zero)];
        let mut found = ends.map(|(theta, value)| Maximum { theta, value }).to_vec();
        let mut best = values.iter().copied().fold(at_zero, f64::max);
        // Local maxima, each with what it could reach: a parabola sampled three times rises above
        // the middle sample by at most an eighth of the larger drop, so the whole drop is safe.
        let mut brackets: Vec<(f64, usize)> = (0..last)
            .filter_map(|i| {
                let left = if i == 0 { at_zero } else { values[i - 1] };
                let drop = values[i] - left.min(values[i + 1]);
                let is_peak = values[i] >= left && values[i] >= values[i + 1];
                (is_peak && values[i].is_finite()).then_some((values[i] + drop, i))
            })
            .collect();
        brackets.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (reach, i) in brackets {
            let peak = Maximum {
                theta: self.thetas[i],
                value: values[i],
            };
            // A plateau has a peak at every sample: refine what can gain more than rounding.
            if reach <= best + 10.0 * TIE * best.abs() {
                found.push(peak);
                continue;
            }
            let below = if i == 0 { 0.0 } else { self.thetas[i - 1] };
            let refined = golden(f, below, self.thetas[i + 1], peak)?;
            best = best.max(refined.value);
            found.push(refined);
        }
        // Infinite samples have no bracket.
        let infinite = (self.thetas.iter().zip(&values)).filter(|(_, value)| value.is_infinite());
        found.extend(infinite.map(|(&theta, &value)| Maximum { theta, value }));
        let level = if best.is_finite() {
            best - TIE * best.abs()
        } else {
            best
        };
        let equal = |maximum: &&Maximum| maximum.value >= level;
        let first_end = found[..2].iter().find(equal);
        let inner = || found[2..].iter().filter(equal);
        let theta = match first_end {
            Some(end) => end.theta,
            None => inner().map(|maximum| maximum.theta).fold(0.0, f64::max),
        };
        Some(Maximum { theta, value: best })
    }
}

/// Golden sections of [a, b] around a known inner value; `None` for a NaN.
fn golden(f: &dyn Fn(f64) -> f64, mut a: f64, mut b: f64, known: Maximum) -> Option<Maximum> {
    const SHRINK: f64 = 0.618_033_988_749_894_9;
    let mut best = known;
    let mut at = |theta: f64| {
        let value = f(theta);
        if value > best.value {
            best = Maximum { theta, value };
        }
        (!value.is_nan()).then_some(value)
    };
    let (mut c, mut d) = (b - SHRINK * (b - a), a + SHRINK * (b - a));
    let (mut at_c, mut at_d) = (at(c)?, at(d)?);
    for _ in 1..SECTIONS {
        if at_c >= at_d {
            (b, d, at_d) = (d, c, at_c);
            c = b - SHRINK * (b - a);
            at_c = at(c)?;
        } else {
            (a, c, at_c) = (c, d, at_d);
            d = a + SHRINK * (b - a);
            at_d = at(d)?;
        }
    }
    Some(best)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_grid_ascends_from_near_zero_to_pi_and_keeps_its_promise_per_period() {
        for samples in [0, 1, 20, 1000, 12_345] {
            let grid = Grid::new(samples);
            let thetas = grid.thetas();
            assert!(thetas.windows(2).all(|pair| pair[0] < pair[1]), "{samples}");
            assert_eq!(thetas[thetas.len() - 1].to_bits(), PI.to_bits());
            let steps = thetas.windows(2).map(|pair| pair[1] - pair[0]);
            let widest = steps.fold(0.0, f64::max);
            let period = 2.0 * PI / samples.max(1) as f64;
            assert!(widest <= 1.001 * period / 8.0, "{samples}: {widest}");
            assert!(thetas.len() <= 4 * samples + 500, "{samples}");
        }
    }

    #[test]
    fn a_narrow_inner_peak_is_found_to_rounding() {
        // The peak sits at θ₀ with height 1 + 0.3·cos of the slow part; two rivals are lower.
        for peak in [1e-6, 1e-3, 0.1, 1.0, 2.5, 3.1, PI - 1e-4] {
            let smooth = |theta: f64| {
                let x = (theta - peak) / (0.5 * peak.min(PI - peak));
                2.0 / (1.0 + x * x)
            };
            let rippled = |theta: f64| smooth(theta) + 0.2 * (40.0 * theta).sin().abs();
            let found = Grid::new(40).maximum(0.0, &smooth).expect("no NaN");
            assert!((found.value - 2.0).abs() < 1e-14, "{peak}: {found:?}");
            assert!(
                (found.theta - peak).abs() < 1e-6 * peak,
                "{peak}: {found:?}"
            );
            let found = Grid::new(40).maximum(0.0, &rippled).expect("no NaN");
            assert!(found.value >= 2.0, "{peak}: {found:?}");
        }
    }

    #[test]
    fn the_largest_of_many_equal_looking_ripples_is_taken() {
        // sin(n(θ − 1))·e^(−(θ − 1)²): the crest next to θ = 1 beats its neighbours by little.
        for n in [100, 1000] {
            let f = |theta: f64| {
                (n as f64 * (theta - 1.0)).cos() * (1.0 - 0.01 * (theta - 1.0) * (theta - 1.0))
            };
            let found = Grid::new(n).maximum(-1.0, &f).expect("no NaN");
            assert!((found.value - 1.0).abs() < 1e-13, "{found:?}");
            assert!((found.theta - 1.0).abs() < 1e-6, "{found:?}");
        }
    }

    #[test]
    fn of_equal_maxima_pi_goes_first_and_then_zero() {
        let grid = Grid::new(1);
        let flat = grid.maximum(1.0, &|_| 1.0).expect("no NaN");
        assert_eq!(flat.theta.to_bits(), PI.to_bits());
        let falling = grid.maximum(2.0, &|theta| 2.0 - theta).expect("no NaN");
        assert_eq!(falling.theta.to_bits(), 0.0_f64.to_bits());
    }

    #[test]
    fn excluded_frequencies_are_skipped_and_a_nan_or_an_infinity_is_not_hidden() {
        let grid = Grid::new(1);
        let half = |theta: f64| {
            if theta < 1.0 {
                f64::NEG_INFINITY
            } else {
                -theta
            }
        };
        let found = grid.maximum(f64::NEG_INFINITY, &half).expect("no NaN");
        assert!((found.value + 1.0).abs() < 0.02, "{found:?}");
        assert!(grid.maximum(0.0, &|theta| (theta - 4.0).sqrt()).is_none());
        let pole = |theta: f64| if theta > 3.0 { f64::INFINITY } else { 0.0 };
        assert!(
            grid.maximum(0.0, &pole)
                .expect("no NaN")
                .value
                .is_infinite()
        );
    }
}
