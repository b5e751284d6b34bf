//! Correlation of the noise by its residuals, white or slow, and whether several motions have one variance.
//! ```text
//! ρ_k = c_k/c₀,  c_k = Σ rᵢ rᵢ₊ₖ        τ = (1 + 2 Σ_{k ≤ W} ρ_k)/(1 − (2W + 1)p/n),   W the least with W ≥ 2.5 τ
//! n residuals are worth n/τ independent ones
//! B = (ν ln s² − Σ ν_m ln s_m²)/(1 + (Σ 1/ν_m − 1/ν)/(3(M − 1)))       ν = Σ ν_m,  s² = Σ ν_m s_m²/ν,  M motions
//! ```
//! τ is the integrated autocorrelation time in samples, twice that of the source. A fit of p parameters takes the slow part of the noise
//! out of the residuals, (2W + 1)p/n of the sum, and the divisor, ½ at least, gives that back. White noise keeps τ = 1: what is above 1
//! by less than 2.1 times its standard error √(2(2W + 1)/n) is chance. That widens 2 to 5 % of the intervals of white noise. A short record
//! cannot show it: 50 residuals with an autocorrelation of 0.5 at lag 1 are taken for white in one of two cases, 30 with 0.7 in four
//! of ten, and their intervals are too narrow.
//!
//! B is that of Bartlett: of M motions of the same noise it is χ² of M − 1 degrees of freedom. Below its 99 % point the noise of one
//! load cell is assumed, which is absolute; above it each motion has its own.
//!
//! - *Cost*: n products for each of the lags, beyond 50 for one in 50 of them: a hundred for the slowest noise of 1000 samples.
//! - *Source*: A. D. Sokal, *Monte Carlo methods in statistical mechanics: foundations and new algorithms*, 1997, section 3: the window
//!   and the variance of the estimate; M. S. Bartlett, *Properties of sufficiency and statistical tests*, Proceedings of the Royal
//!   Society A 160, 1937; E. B. Wilson, M. M. Hilferty, *The distribution of chi-square*, PNAS 17, 1931 (its 99 % point).

const WINDOW: f64 = 2.5;
/// Fewest lags that are summed of a window that has more.
const LAGS: usize = 50;
/// Standard errors above 1 that are chance.
const CHANCE: f64 = 2.1;

/// n/τ of the residuals of a fit with `parameters` parameters; they are `parts` series of equal length, one after the other.
pub(super) fn independent(residuals: &[f64], parts: usize, parameters: usize) -> f64 {
    let n = residuals.len();
    let length = n / parts.max(1);
    let series = || residuals.chunks_exact(length.max(1));
    let product = |lag: usize| -> f64 {
        series()
            .map(|r| r.iter().zip(&r[lag..]).map(|(a, b)| a * b).sum::<f64>())
            .sum()
    };
    let square = product(0);
    if square <= 0.0 {
        return n as f64;
    }
    let (mut sum, mut window) = (1.0, 0);
    while (window as f64) < WINDOW * sum && window < length / 2 {
        let step = (window / LAGS).max(1);
        window += step;
        sum += 2.0 * step as f64 * product(window) / square;
    }
    let width = (2 * window + 1) as f64 / n as f64;
    let time = sum / (1.0 - width * parameters as f64).max(0.5);
    let chance = CHANCE * libm::sqrt(2.0 * width);
    n as f64 / if time > 1.0 + chance { time } else { 1.0 }
}

/// 99 % point of the normal distribution.
const SURE: f64 = 2.326;
/// Interpolation error of a history, as a share of the stress.
const EXACT: f64 = 1e-6;

/// Standard deviations of several motions from the residuals of a fit with `parameters` parameters: one for all, or one of each if they
/// differ.
pub(super) fn of_motions(residuals: &[&[f64]], stresses: &[&[f64]], parameters: usize) -> Vec<f64> {
    let mean_square = |values: &[f64]| {
        let square: f64 = values.iter().map(|value| value * value).sum();
        square / values.len() as f64
    };
    let counts: Vec<f64> = residuals.iter().map(|r| independent(r, 1, 0)).collect();
    let count: f64 = counts.iter().sum();
    // The fit takes its share of each.
    let share = (1.0 - parameters as f64 / count).max(0.1);
    let squares: Vec<f64> = (residuals.iter().zip(stresses))
        .map(|(r, stress)| (mean_square(r) / share).max(EXACT * EXACT * mean_square(stress)))
        .collect();
    let pairs = || counts.iter().zip(&squares);
    let pooled = pairs().map(|(n, square)| n * square).sum::<f64>() / count;
    let apart = pairs().map(|(n, square)| n * share * libm::log(pooled / square));
    let inverse = counts.iter().map(|n| 1.0 / (n * share)).sum::<f64>() - 1.0 / (count * share);
    let freedom = (counts.len() - 1) as f64;
    let bartlett = apart.sum::<f64>() / (1.0 + inverse / (3.0 * freedom));
    let part = 2.0 / (9.0 * freedom);
    let limit = freedom * libm::pow(1.0 - part + SURE * libm::sqrt(part), 3.0);
    if bartlett > limit {
        squares.iter().map(|square| libm::sqrt(*square)).collect()
    } else {
        vec![libm::sqrt(pooled)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_distr::{Distribution as _, StandardNormal};
    use rand_pcg::Pcg64;
    use rand_pcg::rand_core::SeedableRng as _;

    /// n over the independent ones, of a series of which each value is like the one before by so much; in parts of equal length.
    fn time(length: usize, parts: usize, alike: f64, seed: u64) -> f64 {
        let mut generator = Pcg64::seed_from_u64(seed);
        let mut draw = || -> f64 { StandardNormal.sample(&mut generator) };
        let mut series = Vec::new();
        for _ in 0..parts {
            let mut last = draw();
            for _ in 0..length {
                series.push(last);
                last = alike * last + (1.0 - alike * alike).sqrt() * draw();
            }
        }
        series.len() as f64 / independent(&series, parts, 0)
    }

    #[test]
    fn white_noise_is_left_alone() {
        for (length, parts) in [(6, 1), (30, 1), (100, 2), (2000, 1)] {
            let times: Vec<f64> = (0..400)
                .map(|seed| time(length, parts, 0.0, seed))
                .collect();
            let white = times.iter().filter(|time| **time <= 1.0).count();
            assert!(white >= 388, "{white} of 400 with {length} samples");
        }
    }

    /// An AR(1) process has τ = (1 + ρ)/(1 − ρ).
    #[test]
    #[ignore = "long: `.ci/run` does it, or --include-ignored"]
    fn slow_noise_is_measured() {
        for (length, parts, alike) in [
            (2000, 1, 0.5),
            (1000, 2, 0.8),
            (2000, 1, 0.9),
            (20_000, 1, 0.98),
        ] {
            let times = (0..100).map(|seed| time(length, parts, alike, seed));
            let mean = times.sum::<f64>() / 100.0;
            let wanted = (1.0 + alike) / (1.0 - alike);
            assert!(
                (mean / wanted - 1.0).abs() < 0.12,
                "{alike}: {mean} {wanted}"
            );
        }
    }

    /// Short series: slow noise is seen as far as 50 residuals can show it.
    #[test]
    fn slow_noise_of_short_series_is_seen_more_often_than_not() {
        for (alike, least) in [(0.6, 260), (0.7, 300)] {
            let times = (0..400).map(|seed| time(50, 1, alike, seed));
            let slow = times.filter(|time| *time > 1.0).count();
            assert!(slow >= least, "{slow} of 400 alike by {alike}");
        }
    }

    #[test]
    fn a_series_that_never_turns_counts_as_few() {
        let ramp: Vec<f64> = (0..1000).map(|i| f64::from(i) - 499.5).collect();
        let few = independent(&ramp, 1, 2);
        assert!(few < 10.0, "{few}");
        assert!(independent(&[0.0; 10], 1, 2) >= 10.0);
        assert!(independent(&[0.1], 1, 1) >= 1.0);
    }
}
