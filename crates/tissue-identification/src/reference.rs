//! The reference of a record: the positive spectrum that leaves the least of it, and the test of a candidate against it.
//! ```text
//! G(t) = E + η·δ(t) + Σ gₖ·e^(−t/τₖ)     J(t) = 1/E + t/η + Σ jₖ·(1 − e^(−t/τₖ))     all ≥ 0: whatever relaxes at all
//! ratio = Σe²/(n·floor² at least), of the candidate over the reference      e both residuals through the filter of the reference's noise
//! refused:  the ratio is above that of each of 99 records that the candidate makes with white e of its own size
//! ```
//! Being positive regularises the spectrum: of all τ on a grid a few modes are active, and between two rounds the grid is halved about them.
//! The noise is what the reference leaves, and not what the closest candidate leaves, which would be excused for what it misses. The filter
//! is that of the closest candidate as long as the record is likelier with it than with the spectrum and its noise, by BIC, and white behind it:
//! else the candidate misses something, and the noise is what the spectrum leaves. On its own the spectrum would draw slow noise.
//! A record with fewer than 25 numbers has no reference: there a spectrum leaves next to nothing, and everything would be refused.
//!
//! - *Errors*: none; a record of which the spectrum leaves more than a tenth has white noise and no test.
//! - *Cost*: five to eight non-negative least squares of some 60 columns; two of them for a candidate that fits, 19 to 99 for one that does not.
//! - *Source*: C. L. Lawson, R. J. Hanson, *Solving Least Squares Problems*, 1974, chapter 23; A. C. Davison, D. V. Hinkley, *Bootstrap
//!   Methods and their Application*, 1997, section 4.2 (the test).

use super::elements::Candidate;
use super::fit::criteria;
use super::search::Best;
use super::target::Target;
use super::whitened;
use control_identification::autoregression::{Autoregression, HIGHEST_ORDER};
use fracdiff::full_memory::nearly_least_squares;
use nalgebra::DMatrix;
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng as _, SeedableRng as _};
use rayon::prelude::*;
use spring_pots::{Quantity, SpectralMode};
use std::ops::Range;

/// Numbers of a record without which a spectrum tells nothing.
pub(super) const LEAST: usize = 25;
/// Modes for each factor e of time, at first, and how far they go beyond the record, in ln t.
const MODES: f64 = 2.5;
const BEYOND: f64 = 2.5;
/// A mode enters if what it adds is alike what is left by this many of its deviations.
const ALIKE: f64 = 2.0;
const ROUNDS: usize = 8;
/// Rounds after which the grid leaves no misfit of its own for noise, and share of the sum that a later one has to gain.
const FIRST: usize = 3;
const GAIN: f64 = 0.01;
/// Noise is at most this share of a record, and its filter leaves at least this share of it.
const NOISE: f64 = 0.1;
const NEW: f64 = 0.05;
/// Standard errors of an autocorrelation that are chance.
const CHANCE: f64 = 3.0;
/// Made records of the test: of a candidate that fits the first few show it. After some a ratio this many times the largest is beyond all.
const RECORDS: [Range<u64>; 3] = [0..2, 2..19, 19..99];
const FAR: f64 = 1.5;

/// The positive spectrum of a record.
#[derive(Clone, Debug)]
pub(super) struct Reference<'a> {
    /// The record through the filter of its noise.
    target: Target<'a>,
    noise: Autoregression,
    /// Columns of the modes and what they are to reach, as straight as the residual is near the spectrum.
    columns: Vec<Vec<f64>>,
    wanted: Vec<f64>,
    /// Σe², and the same without filter.
    sum: f64,
    unfiltered: f64,
    /// Modes that are active, with the logarithms of their sizes.
    active: Vec<(SpectralMode, f64)>,
}

/// Misfit of a candidate beside the positive spectrum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Misfit {
    /// Root of its Σe² over that of the spectrum, with or without filter, whichever is more.
    pub(super) ratio: f64,
    /// Active modes of the spectrum.
    pub(super) modes: usize,
}

impl<'a> Reference<'a> {
    /// Spectrum of a record that has enough numbers, if it leaves no more than noise may be; the closest candidate tells how slow its
    /// noise is at most.
    pub(super) fn of(target: &Target<'a>, closest: Option<(Candidate, &Best)>) -> Option<Self> {
        let plain = target.averaged();
        if plain.len() < LEAST {
            return None;
        }
        let [low, high] = plain.ln_times();
        let count = libm::ceil((high - low + 2.0 * BEYOND) * MODES).min(200.0);
        let mut spacing = (high - low + 2.0 * BEYOND) / count;
        let grid =
            (0..=count as usize).map(|n| SpectralMode::Decay(low - BEYOND + spacing * n as f64));
        let grid: Vec<SpectralMode> = grid
            .chain([SpectralMode::Spring, SpectralMode::Dashpot])
            .collect();
        let mut modes: Vec<(SpectralMode, Vec<f64>)> = columns(&plain, grid);
        let coarse = modes.len();
        let is_logarithmic = plain.is_logarithmic();
        let wanted = |n: usize| plain.wanted(n);
        let all = 0..plain.len();
        // The values about which logarithms are straight; 1 where differences are compared.
        let mut about: Vec<f64> = if is_logarithmic {
            all.clone().map(|n| libm::exp(wanted(n))).collect()
        } else {
            vec![1.0; plain.len()]
        };
        let missed = closest.map(|(closest, best)| {
            let missed = whitened::residuals(closest, &plain, &best.elements);
            (missed, closest.parameters())
        });
        let (mut noise, mut before) = (Autoregression::default(), [f64::INFINITY, 0.0]);
        for round in 0..ROUNDS {
            let filtered = plain.filtered(noise);
            let straight = |column: &[f64]| -> Vec<f64> {
                let shares = column
                    .iter()
                    .zip(&about)
                    .map(|(value, about)| value / about);
                filtered.through(&shares.collect::<Vec<f64>>())
            };
            let (scaled, sizes): (Vec<Vec<f64>>, Vec<f64>) = modes
                .iter()
                .map(|(_, column)| unit(straight(column)))
                .unzip();
            let reach = all.clone().map(|n| {
                if is_logarithmic {
                    1.0 - libm::log(about[n]) + wanted(n)
                } else {
                    wanted(n)
                }
            });
            let reach = filtered.through(&reach.collect::<Vec<f64>>());
            let shares = nearly_least_squares(scaled.clone(), reach.clone(), ALIKE);
            let mut model = vec![0.0; plain.len()];
            let sized = shares.iter().zip(&sizes).zip(&modes);
            for ((share, size), (_, column)) in sized.filter(|((share, _), _)| **share > 0.0) {
                let pairs = model.iter_mut().zip(column);
                pairs.for_each(|(model, value)| *model += share / size * value);
            }
            if plain.stops() || is_logarithmic && model.iter().any(|value| *value <= 0.0) {
                return None;
            }
            let left = all.clone().map(|n| {
                if is_logarithmic {
                    libm::log(model[n]) - wanted(n)
                } else {
                    model[n] - wanted(n)
                }
            });
            let left = plain.through(&left.collect::<Vec<f64>>());
            let is_active = |n: &usize| shares[*n] > 0.0;
            let active: Vec<usize> = (0..modes.len()).filter(is_active).collect();
            let rest = left_by(&scaled, &shares, &reach);
            let sum = square(&rest);
            let order = noise.order() as f64;
            let is_settled =
                round > FIRST && sum > (1.0 - GAIN) * before[0] && (order - before[1]).abs() < 0.5;
            before = [sum, order];
            if is_settled || round + 1 == ROUNDS {
                let unfiltered = square(&left);
                let is_noise = unfiltered < NOISE * NOISE * left.len() as f64;
                return is_noise.then_some(Self {
                    target: filtered,
                    noise,
                    columns: scaled,
                    wanted: reach,
                    sum,
                    unfiltered,
                    active: active
                        .iter()
                        .map(|&n| (modes[n].0, libm::log(shares[n] / sizes[n])))
                        .collect(),
                });
            }
            if is_logarithmic {
                about = model;
            }
            let likely = |noise: &Autoregression, left: &[f64], numbers: usize| {
                let numbers = (numbers + noise.order()) as f64;
                let count = plain.len() as f64;
                noise.deviance(&plain.series(left), plain.floor) + numbers * libm::log(count)
            };
            let own = noise_of(&plain, &left);
            let of_closest = missed
                .as_ref()
                .filter(|_| round == FIRST)
                .map(|(missed, numbers)| {
                    let noise = noise_of(&plain, missed);
                    (likely(&noise, missed, *numbers), noise)
                });
            let of_closest = of_closest.filter(|one| one.0 <= likely(&own, &left, active.len()));
            if let Some((_, of_closest)) = of_closest {
                noise = of_closest;
            } else if round >= FIRST && !is_white(&filtered, &rest) {
                noise = own;
            }
            spacing *= 0.5;
            let beside = active.iter().flat_map(|&n| match modes[n].0 {
                SpectralMode::Decay(time) => vec![time - spacing, time + spacing],
                SpectralMode::Spring | SpectralMode::Dashpot => Vec::new(),
            });
            // Two neighbours are mostly one mode between them.
            let mut decays: Vec<(f64, f64)> = (active.iter())
                .filter_map(|&n| match modes[n].0 {
                    SpectralMode::Decay(time) => Some((time, shares[n] / sizes[n])),
                    SpectralMode::Spring | SpectralMode::Dashpot => None,
                })
                .collect();
            decays.sort_by(|a, b| a.0.total_cmp(&b.0));
            let between = decays
                .windows(2)
                .filter(|pair| pair[1].0 - pair[0].0 < 2.5 * spacing);
            let between = between.map(|pair| {
                let share = pair[1].1 / (pair[0].1 + pair[1].1);
                pair[0].0 + share * (pair[1].0 - pair[0].0)
            });
            let beside = beside.chain(between).map(SpectralMode::Decay);
            let beside = columns(&plain, beside.collect());
            let kept = active.iter().filter(|n| **n >= coarse);
            let kept: Vec<_> = kept.map(|&n| modes[n].clone()).collect();
            modes.truncate(coarse);
            modes.extend(kept.into_iter().chain(beside));
        }
        None
    }

    /// The noise through whose filter all candidates are compared.
    pub(super) const fn noise(&self) -> Autoregression {
        self.noise
    }

    /// −2·ln of the likelihood of the record, but for a constant of its length, with a number for each mode.
    pub(super) fn evidence(&self, target: &Target<'_>) -> f64 {
        let count = self.target.len() as f64;
        let square = self.unfiltered * target.scale * target.scale / count;
        let modes = self.active.len() as f64;
        count * libm::log(square.max(f64::MIN_POSITIVE))
            + self.target.ln_sizes()
            + modes * libm::log(count)
    }

    /// The record through the filter of its noise.
    pub(super) const fn target(&self) -> &Target<'a> {
        &self.target
    }

    pub(super) fn active(&self) -> &[(SpectralMode, f64)] {
        &self.active
    }

    /// BIC per number of the record, as that of a model with a parameter for each mode and white noise.
    pub(super) fn bic(&self) -> f64 {
        criteria(&self.target, self.unfiltered, self.active.len())[1] / self.target.len() as f64
    }

    /// Creep compliances, 1/Pa, of a record of creep, at times, s.
    pub(super) fn creep(&self, times_s: &[f64]) -> Vec<f64> {
        let at = |time_s: &f64| {
            let ln_time = libm::log(time_s / self.target.unit_s);
            let modes = self.active.iter();
            let parts = modes
                .map(|(mode, size)| libm::exp(*size) * mode.at(Some(Quantity::Creep), ln_time)[0]);
            parts.sum()
        };
        times_s.iter().map(at).collect()
    }

    /// Misfit of a candidate, fitted through the filter.
    pub(super) fn misfit_of(&self, candidate: Candidate, best: &Best) -> Option<Misfit> {
        let n = self.wanted.len();
        let mut left = vec![0.0; n];
        let mut slopes = DMatrix::zeros(n, best.free.len());
        (self.target).residuals(candidate, &best.elements, |n, root, slope| {
            left[n] = root * slope.value;
            for (k, &variable) in best.free.iter().enumerate() {
                slopes[(n, k)] = root * slope.by[variable];
            }
        });
        let plain = self.target.filtered(Autoregression::default());
        let unfiltered = square(&whitened::residuals(candidate, &plain, &best.elements));
        self.misfit(&left, slopes, unfiltered)
    }

    /// Misfit beyond that of the spectrum of a fit that leaves these residuals through the filter, with their derivatives by what was fitted,
    /// and this sum of squares without it; `None` if it may be chance.
    pub(super) fn misfit(
        &self,
        left: &[f64],
        slopes: DMatrix<f64>,
        unfiltered: f64,
    ) -> Option<Misfit> {
        let (n, fitted) = (left.len(), slopes.ncols());
        let floor = n as f64 * self.target.floor * self.target.floor;
        let over = |sum: f64, least: f64| sum.max(floor) / least.max(floor);
        let sum = square(left);
        let found = over(sum, self.sum);
        if found <= 1.0 {
            return None;
        }
        let freedom = (n as f64 - (fitted + self.target.nuisance) as f64).max(1.0);
        let fitted = slopes.qr().q();
        let size = libm::sqrt(sum / freedom);
        let made = |record: u64| {
            let mut generator = Pcg64::seed_from_u64(record);
            let noise: Vec<f64> = (0..n).map(|_| size * normal(&mut generator)).collect();
            let parts = fitted.column_iter().map(|unit| {
                let part: f64 = unit.iter().zip(&noise).map(|(a, b)| a * b).sum();
                part * part
            });
            let own = square(&noise) - parts.sum::<f64>();
            let reach = (0..n)
                .map(|n| self.wanted[n] + left[n] + noise[n])
                .collect::<Vec<f64>>();
            let shares = nearly_least_squares(self.columns.clone(), reach.clone(), ALIKE);
            over(own, square(&left_by(&self.columns, &shares, &reach)))
        };
        let mut most = 0.0;
        for records in RECORDS {
            let is_far = records.start > 2 && found > FAR * most;
            if is_far {
                break;
            }
            most = records.into_par_iter().map(made).reduce(|| most, f64::max);
            if found <= most {
                return None;
            }
        }
        Some(Misfit {
            ratio: libm::sqrt(found.max(over(unfiltered, self.unfiltered))),
            modes: self.active.len(),
        })
    }
}

/// The modes with their columns, those that the record shows.
fn columns(target: &Target<'_>, modes: Vec<SpectralMode>) -> Vec<(SpectralMode, Vec<f64>)> {
    let all = modes.into_par_iter();
    let all = all.map(|mode| (mode, target.mode(mode)));
    all.filter(|(_, column)| column.iter().any(|value| *value != 0.0))
        .collect()
}

/// The noise of a residual; white where it does not look like noise.
fn noise_of(plain: &Target<'_>, left: &[f64]) -> Autoregression {
    let series = plain.series(left);
    let noise = Autoregression::of(&series);
    let new: f64 = series
        .iter()
        .map(|part| square(&noise.whitened(part)))
        .sum();
    let is_small = square(left) < NOISE * NOISE * left.len() as f64;
    // A spectrum takes what is slow out of white noise: a filter that passes more of a constant than of white noise is its doing.
    let constant = noise.whitened(&[1.0; HIGHEST_ORDER + 1])[HIGHEST_ORDER];
    if is_small && new > NEW * NEW * square(left) && constant < 1.0 {
        noise
    } else {
        Autoregression::default()
    }
}

fn square(values: &[f64]) -> f64 {
    values.iter().map(|value| value * value).sum()
}

/// A column of unit length, and the length that it had.
pub(super) fn unit(mut column: Vec<f64>) -> (Vec<f64>, f64) {
    let size = libm::sqrt(square(&column)).max(f64::MIN_POSITIVE);
    column.iter_mut().for_each(|value| *value /= size);
    (column, size)
}

/// True if neighbours hang together by no more than chance.
fn is_white(target: &Target<'_>, rest: &[f64]) -> bool {
    let series = target.series(rest);
    let product = |part: &&[f64]| part.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>();
    let alike: f64 = series.iter().map(product).sum();
    alike.abs() < CHANCE * square(rest) / libm::sqrt(rest.len() as f64)
}

/// Residual of the columns with these shares.
fn left_by(columns: &[Vec<f64>], shares: &[f64], reach: &[f64]) -> Vec<f64> {
    let mut left = reach.to_vec();
    for (column, share) in columns
        .iter()
        .zip(shares)
        .filter(|(_, share)| **share > 0.0)
    {
        let pairs = left.iter_mut().zip(column);
        pairs.for_each(|(left, value)| *left -= share * value);
    }
    left
}

/// Near enough to a normal number: the sum of twelve uniform ones, whose variance is 1.
pub(super) fn normal(generator: &mut Pcg64) -> f64 {
    let uniform = |_| generator.next_u64() as f64 / u64::MAX as f64 - 0.5;
    (0..12).map(uniform).sum()
}
