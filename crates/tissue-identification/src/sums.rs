//! Sums of Maxwell elements as candidates: a Prony series, and a dashpot beside one element, which is a Jeffreys model.
//! ```text
//! G(t) = E + η₀·δ(t) + Σ gₖ·e^(−t/τₖ)      J(t) = 1/E₀ + t/η + Σ jₖ·(1 − e^(−t/τₖ)),   both of one model
//! ```
//! The active modes of the [reference](super::reference) are nearly such a sum. One after the other is left out or made one with its neighbour,
//! whichever leaves less; sizes and times of the others are refined through the filter of the noise, and the number is that of the least BIC, in
//! which each mode counts two parameters. A creep is fitted by J, all others by G; a Burgers model is that of two modes without a spring. What one
//! spring and one mode are at most is a Zener model and fitted as such.
//!
//! Parameters are those of plain least squares, as of other models, unless the noise is slow: modes draw so much of that, that what they leave tells
//! too little of it, and intervals held four in five truths. There a filter by restricted likelihood stands between. Intervals are those of the standard errors of
//! logarithms; from J to G they go by the derivatives.
//!
//! - *Errors*: none; a sum that does not converge is no candidate, nor is any without a reference.
//! - *Cost*: some three searches for each number of modes, each of some ten evaluations of three columns a mode.
//! - *Source*: B. Gross, *Mathematical Structure of the Theories of Viscoelasticity*, 1953 (from J to G).

use super::fit::{Estimate, Fit, correlation, criteria_of, student};
use super::noise::independent;
use super::reference::{Misfit, Reference, unit};
use super::search::FINE;
use super::target::Target;
use control_identification::autoregression::{Autoregression, HIGHEST_ORDER};
use fracdiff::full_memory::non_negative_least_squares;
use haptic_tissue::ModelKind;
use nalgebra::{DMatrix, DVector};
use spring_pots::{Effort, Problem, Quantity, SpectralMode, minimise};

/// Most branches of a sum, for which there are names.
pub(super) const BRANCHES_MOST: usize = 10;
/// Effort of a search that only counts modes.
const ROUGH: Effort = Effort::to(1e-6, 6);
/// Farthest that the logarithm of a size goes from its start, and that of a time beyond the record.
const FAR: f64 = 12.0;
const BEYOND: f64 = 2.0;
/// Modes of the reference this near in ln τ are one.
const NEAR: f64 = 0.7;
/// Fits by turns with their noise, and correlations that are tried.
const ROUNDS: usize = 3;
const ALIKE_MOST: u16 = 39;
/// Steps of ln τ, and of all logarithms, for slopes.
const STEP: f64 = 1e-4;

macro_rules! names {
    ($($number:literal)*) => {
        [$([concat!("branch_", $number, "_modulus_pa"), concat!("branch_", $number, "_time_s")]),*]
    };
}
const NAMES: [[&str; 2]; BRANCHES_MOST] = names!(1 2 3 4 5 6 7 8 9 10);

/// Modes and the logarithms of their sizes.
#[derive(Clone, Debug)]
struct Sum(Vec<(SpectralMode, f64)>);

/// A sum that was found.
pub(super) struct Found {
    pub(super) fit: Fit,
    /// Misfit beyond that of the reference, if it is no chance.
    pub(super) misfit: Option<Misfit>,
}

/// A sum against a record.
struct Compared<'a>(&'a Sum, &'a Target<'a>);

impl Problem for Compared<'_> {
    fn count(&self) -> usize {
        self.1.len()
    }

    fn exact(&self) -> f64 {
        0.0
    }

    fn residuals(&self, values: &[f64], each: &mut dyn FnMut(usize, f64, &[f64])) -> bool {
        let (left, slopes) = self.0.with(values).residuals(self.1);
        for (n, &left) in left.iter().enumerate() {
            let by: Vec<f64> = slopes.iter().map(|slope| slope[n]).collect();
            each(n, left, &by);
        }
        !self.1.stops() && left.iter().all(|left| left.is_finite())
    }
}

impl Sum {
    fn has(&self, mode: SpectralMode) -> bool {
        self.0.iter().any(|one| one.0 == mode)
    }

    fn decays(&self) -> Vec<(f64, f64)> {
        let times = self.0.iter().filter_map(|&(mode, size)| match mode {
            SpectralMode::Decay(time) => Some((time, size)),
            SpectralMode::Spring | SpectralMode::Dashpot => None,
        });
        let mut decays: Vec<(f64, f64)> = times.collect();
        decays.sort_by(|a, b| a.0.total_cmp(&b.0));
        decays
    }

    /// ln of each size, and of a decay that of its time.
    fn values(&self) -> Vec<f64> {
        let values = self.0.iter().flat_map(|&(mode, size)| match mode {
            SpectralMode::Decay(time) => vec![size, time],
            SpectralMode::Spring | SpectralMode::Dashpot => vec![size],
        });
        values.collect()
    }

    fn with(&self, values: &[f64]) -> Self {
        let mut values = values.iter().copied();
        let mut next = |before| values.next().unwrap_or(before);
        let modes = self.0.iter().map(|&(mode, size)| {
            let size = next(size);
            let mode = match mode {
                SpectralMode::Decay(time) => SpectralMode::Decay(next(time)),
                other @ (SpectralMode::Spring | SpectralMode::Dashpot) => other,
            };
            (mode, size)
        });
        Self(modes.collect())
    }

    /// Values of the model where the target has residuals.
    fn model(&self, target: &Target<'_>) -> Vec<f64> {
        let mut sum = vec![0.0; target.len()];
        for &(mode, size) in &self.0 {
            let pairs = sum.iter_mut().zip(target.mode(mode));
            pairs.for_each(|(sum, value)| *sum += libm::exp(size) * value);
        }
        sum
    }

    /// Model less target, without weights.
    fn misses(&self, target: &Target<'_>) -> Vec<f64> {
        let model = self.model(target).into_iter().enumerate();
        let misses = model.map(|(n, model)| {
            if target.is_logarithmic() {
                libm::log(model.max(f64::MIN_POSITIVE)) - target.wanted(n)
            } else {
                model - target.wanted(n)
            }
        });
        misses.collect()
    }

    /// Residuals with weights and through the filter, and their derivatives by the values.
    fn residuals(&self, target: &Target<'_>) -> (Vec<f64>, Vec<Vec<f64>>) {
        let model = self.model(target);
        let slope = |modes: &[(SpectralMode, f64)]| {
            let mut slope = vec![0.0; target.len()];
            for &(mode, share) in modes {
                let pairs = slope.iter_mut().zip(target.mode(mode));
                pairs.for_each(|(slope, value)| *slope += share * value);
            }
            if target.is_logarithmic() {
                let pairs = slope.iter_mut().zip(&model);
                pairs.for_each(|(slope, model)| *slope /= model.max(f64::MIN_POSITIVE));
            }
            target.through(&slope)
        };
        let slopes = self.0.iter().flat_map(|&(mode, size)| {
            let size = libm::exp(size);
            let by_size = slope(&[(mode, size)]);
            let SpectralMode::Decay(time) = mode else {
                return vec![by_size];
            };
            let share = size / (2.0 * STEP);
            let sides = [(STEP, share), (-STEP, -share)];
            let sides = sides.map(|(step, share)| (SpectralMode::Decay(time + step), share));
            vec![by_size, slope(&sides)]
        });
        let slopes = slopes.collect();
        (target.through(&self.misses(target)), slopes)
    }

    /// The nearest minimum, and true if it is one.
    fn refined(&self, target: &Target<'_>, effort: Effort) -> (Self, bool) {
        let (start, [low, high]) = (self.values(), target.ln_times());
        let ranges = self.0.iter().flat_map(|&(mode, size)| {
            let sizes = (size - FAR, size + FAR);
            match mode {
                SpectralMode::Decay(_) => vec![sizes, (low - BEYOND, high + BEYOND)],
                SpectralMode::Spring | SpectralMode::Dashpot => vec![sizes],
            }
        });
        let ranges: Vec<(f64, f64)> = ranges.collect();
        let free: Vec<usize> = (0..start.len()).collect();
        let problem = Compared(self, target);
        let found = minimise(&problem, &ranges, &start, &free, &[], effort);
        (self.with(&found.values), found.converged)
    }

    /// Sizes of these modes that leave the least, as straight as residuals are near this sum, and what that is.
    fn resized(&self, target: &Target<'_>, modes: Vec<SpectralMode>) -> (f64, Self) {
        let about = if target.is_logarithmic() {
            self.model(target)
        } else {
            vec![1.0; target.len()]
        };
        let columns = modes.iter().map(|&mode| {
            let shares = target.mode(mode).into_iter().zip(&about);
            let shares: Vec<f64> = shares.map(|(value, about)| value / about).collect();
            unit(target.through(&shares))
        });
        let (columns, sizes): (Vec<Vec<f64>>, Vec<f64>) = columns.unzip();
        let reach: Vec<f64> = (0..target.len())
            .map(|n| {
                if target.is_logarithmic() {
                    1.0 - libm::log(about[n]) + target.wanted(n)
                } else {
                    target.wanted(n)
                }
            })
            .collect();
        let mut left = target.through(&reach);
        let shares = non_negative_least_squares(columns.clone(), left.clone());
        for (column, share) in columns.iter().zip(&shares) {
            let pairs = left.iter_mut().zip(column);
            pairs.for_each(|(left, value)| *left -= share * value);
        }
        let sized = modes.into_iter().zip(shares).zip(sizes);
        let active = sized.filter(|((_, share), size)| share / size > 0.0);
        let active = active.map(|((mode, share), size)| (mode, libm::log(share / size)));
        let sum = left.iter().map(|left| left * left).sum();
        (sum, Self(active.collect()))
    }

    /// Sum with one mode fewer: left out, or made one with its neighbour.
    fn fewer(&self, target: &Target<'_>) -> Option<Self> {
        let decays = self.decays();
        let times = |modes: &[(f64, f64)]| {
            let decays = modes.iter().map(|mode| SpectralMode::Decay(mode.0));
            let all = decays.chain([SpectralMode::Spring, SpectralMode::Dashpot]);
            all.collect::<Vec<_>>()
        };
        let without = (0..decays.len()).map(|n| {
            let mut rest = decays.clone();
            rest.remove(n);
            times(&rest)
        });
        let joined = (1..decays.len()).map(|n| {
            let mut rest = decays.clone();
            let (time, size) = rest.remove(n);
            rest[n - 1] = joined(rest[n - 1], (time, size));
            times(&rest)
        });
        let all = without
            .chain(joined)
            .map(|modes| self.resized(target, modes));
        let least = all.min_by(|a, b| a.0.total_cmp(&b.0))?.1;
        // A mode that least squares sets to nothing is one fewer too.
        (!least.0.is_empty()).then_some(least)
    }

    /// The sums that are models, with the modes that this one has at most.
    fn models(&self, target: &Target<'_>, is_creep: bool) -> Vec<(ModelKind, Self)> {
        let count = self.decays().len();
        let (spring, dashpot) = (SpectralMode::Spring, SpectralMode::Dashpot);
        let ways: &[(ModelKind, bool, bool)] = match (is_creep, count) {
            (_, 0) => &[],
            (true, 1) => &[
                (ModelKind::Jeffreys, false, true),
                (ModelKind::Prony, true, true),
            ],
            (false, 1) => &[(ModelKind::Jeffreys, false, true)],
            (true, _) => &[
                (ModelKind::Prony, true, true),
                (ModelKind::Prony, true, false),
            ],
            (false, _) => &[
                (ModelKind::Prony, true, false),
                (ModelKind::Prony, false, false),
            ],
        };
        let can = ways.iter().filter(|(_, has_spring, has_dashpot)| {
            (!has_spring || self.has(spring)) && (!has_dashpot || self.has(dashpot))
        });
        let branches = |has_dashpot: bool| count + usize::from(is_creep && has_dashpot);
        let can = can.filter(|way| branches(way.2) <= BRANCHES_MOST);
        can.map(|&(kind, has_spring, has_dashpot)| {
            let modes = self.0.iter().map(|mode| mode.0);
            let kept = modes.filter(|mode| {
                (has_spring || *mode != spring) && (has_dashpot || *mode != dashpot)
            });
            (kind, self.resized(target, kept.collect()).1)
        })
        .filter(|(_, sum)| sum.decays().len() == count)
        .collect()
    }

    /// Parameters of the model in SI units, without a spring where it has none.
    fn parameters(&self, kind: ModelKind, is_creep: bool, unit_s: f64) -> Vec<f64> {
        let size = |mode| {
            let modes = self.0.iter().filter(|one| one.0 == mode);
            modes.map(|one| libm::exp(one.1)).sum::<f64>()
        };
        let decays = self.decays().into_iter();
        let mut decays: Vec<[f64; 2]> = decays
            .map(|(time, size)| [libm::exp(size), unit_s * libm::exp(time)])
            .collect();
        let mut spring = size(SpectralMode::Spring);
        let mut dashpot = size(SpectralMode::Dashpot) * unit_s;
        if is_creep {
            let fluidity = size(SpectralMode::Dashpot) / unit_s;
            (spring, dashpot, decays) = relaxing(spring, fluidity, &decays);
        }
        if kind == ModelKind::Jeffreys {
            let branch = decays
                .iter()
                .flat_map(|[modulus, time]| [*modulus, modulus * time]);
            return branch.chain([dashpot]).collect();
        }
        let spring = Some(spring).filter(|spring| *spring > 0.0);
        spring.into_iter().chain(decays.concat()).collect()
    }
}

/// Two modes as one, by their sizes.
fn joined((a, size_a): (f64, f64), (b, size_b): (f64, f64)) -> (f64, f64) {
    let share = 1.0 / (1.0 + libm::exp(size_a - size_b));
    let sum = size_a + libm::log1p(libm::exp(size_b - size_a));
    (a + share * (b - a), sum)
}

/// Spring, dashpot and branches of G, of sizes and times, from 1/E₀, 1/η and the modes of J.
/// ```text
/// J*(−r) = 1/E₀ − 1/(ηr) + Σ jₖ/(1 − rτₖ)     a zero rᵢ below the first 1/τₖ if 1/η > 0, between any two, and above the last if 1/E₀ > 0
/// gᵢ = 1/(rᵢ·(1/(ηrᵢ²) + Σ jₖτₖ/(1 − rᵢτₖ)²))      E = 1/(1/E₀ + Σ jₖ) if 1/η = 0      η₀ = 1/(1/η + Σ jₖ/τₖ) if 1/E₀ = 0
/// ```
fn relaxing(soft: f64, fluidity: f64, decays: &[[f64; 2]]) -> (f64, f64, Vec<[f64; 2]>) {
    let value = |r: f64| {
        let parts = decays.iter().map(|[j, time]| j / (1.0 - r * time));
        parts.fold(soft - fluidity / r, |sum, part| sum + part)
    };
    let rates = decays.iter().rev().map(|decay| 1.0 / decay[1]);
    let mut poles: Vec<f64> = rates.collect();
    let reach = decays.iter().map(|decay| decay[0]).sum::<f64>();
    let fastest = poles.last().copied().unwrap_or_default();
    // At the high end no part is above what the spring gives.
    poles
        .extend((soft > 0.0).then(|| 2.0 * fastest * (1.0 + reach / soft) + 2.0 * fluidity / soft));
    if fluidity > 0.0 {
        // At the low end the dashpot gives more than all others.
        let most = soft + 2.0 * reach;
        poles.insert(
            0,
            (0.5 * poles.first().copied().unwrap_or(1.0)).min(fluidity / most) * 0.5,
        );
    }
    let zeros = poles.windows(2).map(|ends| {
        let (mut low, mut high) = (ends[0], ends[1]);
        loop {
            let middle = libm::sqrt(low) * libm::sqrt(high);
            if middle <= low || middle >= high {
                return high;
            }
            if value(middle) < 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
    });
    let branches = zeros.map(|r| {
        let parts = decays.iter().map(|[j, time]| {
            let rest = 1.0 - r * time;
            j * time / (rest * rest)
        });
        [
            1.0 / (r * parts.fold(fluidity / (r * r), |sum, part| sum + part)),
            1.0 / r,
        ]
    });
    let mut branches: Vec<[f64; 2]> = branches.collect();
    branches.reverse();
    let spring = if fluidity > 0.0 {
        0.0
    } else {
        1.0 / (soft + reach)
    };
    let quick = decays.iter().map(|[j, time]| j / time);
    let dashpot = if soft > 0.0 {
        0.0
    } else {
        1.0 / (fluidity + quick.sum::<f64>())
    };
    (spring, dashpot, branches)
}

/// The best sum of each of these kinds.
pub(super) fn found(
    kinds: &[ModelKind],
    target: &Target<'_>,
    reference: &Reference<'_>,
) -> Vec<Found> {
    let (plain, filtered) = (target.averaged(), reference.target());
    let is_creep = target.quantity() == Some(Quantity::Creep);
    let noise = reference.noise();
    let times = plain.ln_times();
    let criteria = |sum: &Sum| {
        let left = plain.through(&sum.misses(&plain));
        let deviance = noise.deviance(&plain.series(&left), plain.floor);
        let numbers = sum.values().len() + plain.nuisance + noise.order();
        let searched = searched(sum.decays().len(), times);
        (plain.len() > numbers + 2).then(|| {
            let [aic, bic] = criteria_of(plain.len(), deviance, numbers);
            [aic, bic + searched]
        })
    };
    let mut next = Some(merged(reference.active()));
    let mut best: Vec<(ModelKind, Sum, [f64; 2])> = Vec::new();
    while let Some(mut sum) = next.take() {
        if target.stops() {
            return Vec::new();
        }
        if sum.decays().len() <= BRANCHES_MOST {
            sum = sum.refined(filtered, ROUGH).0;
        }
        for (kind, sum) in sum.models(filtered, is_creep) {
            let sum = sum.refined(filtered, ROUGH).0;
            let Some([aic, bic]) = criteria(&sum).filter(|_| kinds.contains(&kind)) else {
                continue;
            };
            let known = best.iter().position(|one| one.0 == kind);
            match known {
                Some(known) if best[known].2[1] <= bic => {}
                Some(known) => best[known] = (kind, sum, [aic, bic]),
                None => best.push((kind, sum, [aic, bic])),
            }
        }
        next = (sum.decays().len() > 1)
            .then(|| sum.fewer(filtered))
            .flatten();
    }
    let found = best.into_iter().filter_map(|(kind, sum, _)| {
        let (sum, is_settled) = sum.refined(filtered, FINE);
        let criteria = criteria(&sum).filter(|_| is_settled)?;
        let (left, slopes) = sum.residuals(filtered);
        let slopes = DMatrix::from_fn(left.len(), slopes.len(), |n, k| slopes[k][n]);
        let unfiltered = plain.through(&sum.misses(&plain));
        let unfiltered = unfiltered.iter().map(|left| left * left).sum();
        Some(Found {
            misfit: reference.misfit(&left, slopes, unfiltered),
            fit: fitted(kind, &sum, [target, &plain], criteria)?,
        })
    });
    found.collect()
}

/// 2 ln of the number of ways to place so many modes on the times of a record: who may choose among more sums finds one by chance sooner
/// (J. Chen and Z. Chen, *Extended Bayesian information criteria for model selection with large model spaces*, 2008, γ = 1).
fn searched(modes: usize, [low, high]: [f64; 2]) -> f64 {
    let modes = modes as f64;
    let places = ((high - low + 2.0 * BEYOND) / NEAR).max(modes);
    let ln_factorial = |n: f64| libm::lgamma(n + 1.0);
    2.0 * (ln_factorial(places) - ln_factorial(modes) - ln_factorial(places - modes))
}

/// Modes of a grid, neighbours as one.
fn merged(modes: &[(SpectralMode, f64)]) -> Sum {
    let mut all = Sum(modes.to_vec());
    let mut few: Vec<(f64, f64)> = Vec::new();
    for mode in all.decays() {
        match few.last_mut() {
            Some(last) if mode.0 - last.0 < NEAR => *last = joined(*last, mode),
            _ => few.push(mode),
        }
    }
    all.0
        .retain(|mode| !matches!(mode.0, SpectralMode::Decay(_)));
    let few = few.into_iter();
    all.0
        .extend(few.map(|(time, size)| (SpectralMode::Decay(time), size)));
    all
}

/// Correlation r of neighbours in the noise beside a sum, 0 of white noise.
/// ```text
/// least of (n − p)·ln(Σe²/(n − p)) + ln det(JᵀJ) − Σ ln(1 − r²),   e and J through the filter of r, a term for each series
/// ```
/// That is the restricted likelihood, of what no change of the p parameters makes (H. D. Patterson, R. Thompson, *Recovery of inter-block
/// information when block sizes are unequal*, Biometrika 58, 1971). The correlation counts as a parameter. Below the accuracy of a record nothing is
/// noise.
fn alike_beside(plain: &Target<'_>, left: &[f64], slopes: &[Vec<f64>]) -> f64 {
    let square = left.iter().map(|left| left * left).sum::<f64>();
    if square < plain.floor * plain.floor * left.len() as f64 {
        return 0.0;
    }
    let series = plain.series(left).len() as f64;
    let count = left.len() as f64;
    let freedom = (count - slopes.len() as f64).max(1.0);
    let likelihood = |alike: f64| {
        let noise = noise_alike(alike);
        let through = |column: &[f64]| {
            let parts = plain.series(column).into_iter();
            DVector::from_vec(parts.flat_map(|part| noise.whitened(part)).collect())
        };
        let columns: Vec<DVector<f64>> = slopes.iter().map(|slope| through(slope)).collect();
        let (unit, triangle) = DMatrix::from_columns(&columns).qr().unpack();
        let left = through(left);
        let rest = left.norm_squared() - unit.tr_mul(&left).norm_squared();
        let sizes = triangle.diagonal().map(|size| 2.0 * libm::log(size.abs()));
        freedom * libm::log(rest.max(f64::MIN_POSITIVE) / freedom) + sizes.sum()
            - series * libm::log1p(-alike * alike)
    };
    let all = (1..=ALIKE_MOST).map(|n| {
        let alike = f64::from(n) / f64::from(ALIKE_MOST + 1);
        (likelihood(alike) + libm::log(count), alike)
    });
    let least = all.min_by(|a, b| a.0.total_cmp(&b.0));
    let slow = least.filter(|least| least.0 < likelihood(0.0));
    slow.map_or(0.0, |slow| slow.1)
}

fn noise_alike(alike: f64) -> Autoregression {
    let mut correlations = [0.0; HIGHEST_ORDER];
    correlations[0] = alike;
    Autoregression::of_partial_correlations(correlations)
}

/// The fit through the filter of the noise beside it, with its errors; `None` where it does not settle.
fn fitted(
    kind: ModelKind,
    sum: &Sum,
    [target, plain]: [&Target<'_>; 2],
    [aic, bic]: [f64; 2],
) -> Option<Fit> {
    let is_creep = target.quantity() == Some(Quantity::Creep);
    let (mut sum, mut is_settled) = sum.refined(plain, FINE);
    let (mut alike, mut filtered) = (0.0, plain.clone());
    for _ in 0..ROUNDS {
        let (left, slopes) = sum.residuals(plain);
        let before = std::mem::replace(&mut alike, alike_beside(plain, &left, &slopes));
        if alike.max(before) <= 0.0 {
            break;
        }
        filtered = plain.filtered(noise_alike(alike));
        (sum, is_settled) = sum.refined(&filtered, FINE);
    }
    let (left, slopes) = sum.residuals(&filtered);
    let numbers = slopes.len() + plain.nuisance;
    let independent_of = |left: &[f64]| independent(left, plain.len() / plain.samples(), numbers);
    let square = left.iter().map(|left| left * left).sum::<f64>();
    // Noise in what modes draw goes by σ²/(1 − r)², of which ln has the variance 2/ν: that of σ², and of r, (1 − r²)/n.
    let freedom = (independent_of(&left) - numbers as f64).max(1.0);
    let variance = square / freedom;
    let doubt = if alike > 0.0 {
        2.0 * (1.0 + alike) / (1.0 - alike)
    } else {
        0.0
    };
    let freedom = (freedom / (1.0 + doubt)).max(1.0);
    let independent = independent_of(&plain.through(&sum.misses(plain)));
    let values = sum.values();
    let logarithms = |values: &[f64]| -> Vec<f64> {
        let parameters = sum.with(values).parameters(kind, is_creep, target.unit_s);
        parameters.into_iter().map(libm::log).collect()
    };
    let parameters = logarithms(&values);
    let sides = (0..values.len()).map(|k| {
        let side = |step: f64| {
            let mut values = values.clone();
            values[k] += step;
            logarithms(&values)
        };
        (side(STEP), side(-STEP))
    });
    let sides: Vec<(Vec<f64>, Vec<f64>)> = sides.collect();
    let outer = DMatrix::from_fn(parameters.len(), values.len(), |p, k| {
        (sides[k].0[p] - sides[k].1[p]) / (2.0 * STEP)
    });
    // With a unit diagonal the inverse says whether it is one.
    let slopes = slopes.iter().cloned().map(unit);
    let (slopes, sizes): (Vec<Vec<f64>>, Vec<f64>) = slopes.unzip();
    let normal = DMatrix::from_fn(values.len(), values.len(), |k, l| {
        let pairs = slopes[k].iter().zip(&slopes[l]);
        pairs.map(|(a, b)| a * b).sum::<f64>()
    });
    let inverse = normal.cholesky().map(|parts| parts.inverse());
    let covariance = inverse.map(|inverse| {
        let spread = DMatrix::from_fn(values.len(), values.len(), |k, l| {
            variance * inverse[(k, l)] / (sizes[k] * sizes[l])
        });
        &outer * spread * outer.transpose()
    });
    let names: Vec<(&'static str, &'static str)> = if kind != ModelKind::Prony {
        kind.parameters()
            .iter()
            .map(|one| (one.name, one.unit))
            .collect()
    } else {
        let spring = kind.parameters()[..parameters.len() % 2].iter();
        let branches = NAMES
            .iter()
            .flat_map(|[modulus, time]| [(*modulus, "Pa"), (*time, "s")]);
        spring
            .map(|one| (one.name, one.unit))
            .chain(branches)
            .collect()
    };
    let t = student(freedom);
    let estimates = parameters.iter().zip(names).enumerate();
    let estimates = estimates.map(|(p, (ln, (name, unit)))| {
        let error = covariance
            .as_ref()
            .map(|covariance| libm::sqrt(covariance[(p, p)]));
        let error = error.filter(|error| error.is_finite());
        let end = |t: f64| {
            error
                .map(|error| libm::exp(ln + t * error))
                .filter(|end| end.is_finite())
        };
        let value = libm::exp(*ln);
        Estimate {
            standard_error: error.map(|error| value * error),
            low_95: end(-t),
            high_95: end(t),
            ..Estimate::of_line(name, unit, value, 0.0, 0.0)
        }
    });
    let misses = sum.misses(target);
    let weighted = target.through(&misses);
    let misses = target.undoubted(&misses);
    let weighted = weighted.iter().map(|miss| miss * miss).sum::<f64>() / misses.len() as f64;
    let squares = misses.iter().map(|miss| miss * miss).sum::<f64>();
    let predicted = misses.iter().enumerate();
    is_settled.then(|| Fit {
        kind,
        parameters: estimates.collect(),
        correlation: covariance.as_ref().map(correlation).unwrap_or_default(),
        rms: target.scale * libm::sqrt(squares / misses.len() as f64),
        weighted: target.scale * libm::sqrt(weighted),
        aic,
        bic,
        predicted: predicted
            .map(|(n, miss)| target.modelled(n, *miss))
            .collect(),
        independent: independent * target.len() as f64 / left.len() as f64,
    })
}
