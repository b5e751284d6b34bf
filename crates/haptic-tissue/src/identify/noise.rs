//! What the residuals say of the noise: white, or slow.
//! ```text
//! ρ_k = c_k/c₀,  c_k = Σ rᵢ rᵢ₊ₖ        τ = (1 + 2 Σ_{k ≤ W} ρ_k)/(1 − (2W + 1)p/n),   W the least with W ≥ 2.5 τ
//! n residuals are worth n/τ independent ones
//! ```
//! τ is the integrated autocorrelation time in samples, twice that of the source. A fit of p parameters takes the slow part of the noise
//! out of the residuals, (2W + 1)p/n of the sum, and the divisor, ½ at least, gives that back. White noise keeps τ = 1: what is above 1
//! by less than three times its standard error √(2(2W + 1)/n) is chance.
//!
//! - *Cost*: n products for each of the lags, beyond 50 for one in 50 of them: a hundred for the slowest noise of 1000 samples.
//! - *Source*: A. D. Sokal, *Monte Carlo methods in statistical mechanics: foundations and new algorithms*, 1997, section 3: the window
//!   and the variance of the estimate.

/// Correlation of neighbouring residuals.
pub(super) fn neighbours(residuals: &[f64]) -> f64 {
    let product: f64 = residuals.windows(2).map(|pair| pair[0] * pair[1]).sum();
    let square: f64 = residuals.iter().map(|r| r * r).sum();
    if square > 0.0 { product / square } else { 0.0 }
}

/// W over τ.
const WINDOW: f64 = 2.5;
/// Lags between which each one counts by itself.
const LAGS: usize = 50;
/// Standard errors above 1 that are chance.
const CHANCE: f64 = 3.0;

/// n/τ of the residuals of a fit of so many parameters; they are so many series of equal length, one after the other.
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
