//! Noise whose samples are alike: an autoregression of a residual, and the filter that makes it white.
//!
//! ```text
//! x_n = Σ a_k·x_(n−k) + e_n,   k from 1 to the order;   f_m[n] = f_(m−1)[n] − r_m·b_(m−1)[n−1],   b_m[n] = b_(m−1)[n−1] − r_m·f_(m−1)[n]
//! ```
//! `r_m` are the partial correlations, each of them that with the least `Σ(f_m² + b_m²)`, so that the filter is stable whatever the residual; the order
//! has the least n·ln(variance of e) + order·ln n. The first samples are predicted by those before them alone and are brought to the variance of the
//! others, so none is lost and the filter is the inverse root of the covariance: least squares of filtered columns are generalized least squares.
//!
//! - *Cost*: two multiplications for each order and sample. *Source*: J. P. Burg, *Maximum entropy spectral analysis*, 1975, of the partial
//!   correlations; G. Schwarz, *Estimating the dimension of a model*, Annals of Statistics 6(2), 1978, of the order.

/// The highest order that is tried.
pub const HIGHEST_ORDER: usize = 6;
/// Least number of samples of a residual for each order tried.
const SAMPLES_PER_ORDER: usize = 8;
/// Largest partial correlation: a signal predicted more closely is not noise.
const MOST_ALIKE: f64 = 1.0 - 1e-9;

/// An autoregression. The default has order 0: white noise, whose filter changes nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Autoregression {
    correlations: [f64; HIGHEST_ORDER],
    order: usize,
}

impl Autoregression {
    /// White noise: successive values are not correlated.
    pub const WHITE: Self = Self {
        correlations: [0.0; HIGHEST_ORDER],
        order: 0,
    };

    /// The autoregression with these partial correlations, 0 behind the last that counts; each is brought within ±1: all such are stationary.
    #[must_use]
    pub fn of_partial_correlations(correlations: [f64; HIGHEST_ORDER]) -> Self {
        let last = correlations.iter().rposition(|r| *r != 0.0);
        Self {
            correlations: correlations.map(|r| r.clamp(-MOST_ALIKE, MOST_ALIKE)),
            order: last.map_or(0, |last| last + 1),
        }
    }

    /// That of a residual in one or several segments, none of which knows of another. One that is not finite, or zero, counts as white.
    #[must_use]
    pub fn of(segments: &[&[f64]]) -> Self {
        let samples: usize = segments.iter().map(|segment| segment.len()).sum();
        let count = samples as f64;
        let mut errors: Vec<[Vec<f64>; 2]> = segments
            .iter()
            .map(|segment| [segment.to_vec(), segment.to_vec()])
            .collect();
        let mut correlations = [0.0; HIGHEST_ORDER];
        let (mut criterion, mut best, mut order) = (0.0, 0.0, 0);
        let tried = samples / SAMPLES_PER_ORDER;
        for (place, correlation) in correlations.iter_mut().enumerate().take(tried) {
            let (mut product, mut power) = (0.0, 0.0);
            for [forward, backward] in &errors {
                for (f, b) in forward.iter().skip(1).zip(backward) {
                    product += f * b;
                    power += f * f + b * b;
                }
            }
            let r = (2.0 * product / power).clamp(-MOST_ALIKE, MOST_ALIKE);
            if !r.is_finite() {
                break;
            }
            *correlation = r;
            for [forward, backward] in &mut errors {
                let pairs = forward.iter().skip(1).zip(backward.iter());
                let next = pairs.map(|(f, b)| (f - r * b, b - r * f));
                (*forward, *backward) = next.unzip();
            }
            criterion += count * libm::log1p(-r * r) + libm::log(count);
            if criterion < best {
                (best, order) = (criterion, place + 1);
            }
        }
        correlations[order..].fill(0.0);
        Self {
            correlations,
            order,
        }
    }

    /// Number of past samples that predict the next one; 0 of white noise.
    #[must_use]
    pub const fn order(&self) -> usize {
        self.order
    }

    fn correlations(&self) -> &[f64] {
        &self.correlations[..self.order]
    }

    /// The factors of the first samples, and that of all others, 1.
    fn scales(&self) -> Vec<f64> {
        let mut scale = 1.0;
        let mut scales = Vec::with_capacity(self.order() + 1);
        scales.push(scale);
        for r in self.correlations().iter().rev() {
            scale *= libm::sqrt((1.0 - r) * (1.0 + r));
            scales.push(scale);
        }
        scales.reverse();
        scales
    }

    /// A signal of one segment through the filter, of equal length: a residual, a column of a model, an output.
    #[must_use]
    pub fn whitened(&self, signal: &[f64]) -> Vec<f64> {
        let (order, scales) = (self.order, self.scales());
        let mut backward = [0.0; HIGHEST_ORDER];
        let filter = |(n, x): (usize, &f64)| {
            let (mut f, mut b) = (*x, *x);
            for (m, r) in self.correlations().iter().enumerate().take(n + 1) {
                let before = core::mem::replace(&mut backward[m], b);
                if m < n {
                    (f, b) = (f - r * before, before - r * f);
                }
            }
            f * scales[n.min(order)]
        };
        signal.iter().enumerate().map(filter).collect()
    }

    /// −2·ln of the likelihood of a residual in segments, with the variance that makes it largest, but for a constant of its length. A variance
    /// below that of `floor` counts as that.
    /// ```text
    /// n·ln(Σ e²/n) + Σ ln(variance of f_m/variance of e),   m below the order, in each segment
    /// ```
    #[must_use]
    pub fn deviance(&self, segments: &[&[f64]], floor: f64) -> f64 {
        let scales = self.scales();
        let (mut power, mut samples, mut beginnings) = (0.0, 0.0, 0.0);
        for segment in segments {
            power += self.whitened(segment).iter().map(|e| e * e).sum::<f64>();
            samples += segment.len() as f64;
            let first = scales.iter().take(segment.len().min(self.order()));
            beginnings -= 2.0 * first.map(|scale| libm::log(*scale)).sum::<f64>();
        }
        samples * libm::log((power / samples).max(floor * floor)) + beginnings
    }
}
