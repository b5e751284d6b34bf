//! Standard errors of a fit that hold where residuals are no white noise.
//!
//! ```text
//! cov = A⁻¹·M·A⁻¹·K/(K − p),   A = JᵀJ,   M = Σ over K blocks of (Σ J_nᵀ r_n)(Σ J_nᵀ r_n)ᵀ
//! ```
//! Residuals of an encoder, of friction that varies and of a hand go together for a while, so blocks of [`BLOCK_S`] are taken as what is
//! independent. Where the plain σ²A⁻¹ is larger, it is taken: a few blocks may agree by chance.
//!
//! Source: H. White, Econometrica 48, 1980, with sums over blocks.

use super::fit::Fitted;
use nalgebra::{DMatrix, DVector};

/// Length of a block, s, and at least so many samples.
const BLOCK_S: f64 = 0.1;
const BLOCK_SAMPLES: usize = 20;
/// Standard errors on each side of a value between which it lies in 95 of 100 cases: Student's t of some seventy blocks.
pub(super) const SIDES: f64 = 2.0;

/// Standard errors and correlations of the numbers of a fit.
#[derive(Clone, Debug)]
pub(super) struct Spread {
    covariance: DMatrix<f64>,
    plain: DMatrix<f64>,
}

impl Spread {
    /// `known` residuals are of samples that were there; `states` numbers were fitted beside those of the model. `None` if the record says
    /// nothing of one of the numbers.
    pub(super) fn of(
        fitted: &Fitted,
        sample_time_s: f64,
        known: usize,
        states: usize,
    ) -> Option<Self> {
        let p = fitted.slopes.len();
        let slope = |row: usize, n: usize| fitted.slopes[row][n];
        let count = fitted.left.len();
        let product =
            |a: usize, b: usize| (0..count).map(|n| slope(a, n) * slope(b, n)).sum::<f64>();
        let information = DMatrix::from_fn(p, p, product);
        // Numbers of very different size: to a unit diagonal first.
        let scale = DVector::from_fn(p, |n, _| information[(n, n)].sqrt());
        if scale.iter().any(|s| !(s.is_finite() && *s > 0.0)) {
            return None;
        }
        let unit = DMatrix::from_fn(p, p, |a, b| information[(a, b)] / (scale[a] * scale[b]));
        let inverse = unit.try_inverse()?;
        let inverse = DMatrix::from_fn(p, p, |a, b| inverse[(a, b)] / (scale[a] * scale[b]));
        let free = known.checked_sub(p + states).filter(|free| *free > 0)?;
        let squares: f64 = fitted.left.iter().map(|r| r * r).sum();
        let plain = &inverse * (squares / free as f64);
        let block = ((BLOCK_S / sample_time_s) as usize).max(BLOCK_SAMPLES);
        let mut middle = DMatrix::zeros(p, p);
        let mut blocks = 0_usize;
        for start in (0..count).step_by(block) {
            let block = start..(start + block).min(count);
            let score = DVector::from_fn(p, |row, _| {
                block
                    .clone()
                    .map(|n| slope(row, n) * fitted.left[n])
                    .sum::<f64>()
            });
            middle += &score * score.transpose();
            blocks += 1;
        }
        if blocks <= p {
            return None;
        }
        let small = blocks as f64 / (blocks - p) as f64;
        let covariance = &inverse * middle * &inverse * small;
        Some(Self { covariance, plain })
    }

    /// Standard error of a number.
    pub(super) fn error(&self, index: usize) -> f64 {
        let at = (index, index);
        f64::max(self.covariance[at], self.plain[at])
            .max(0.0)
            .sqrt()
    }

    /// Correlation of two numbers, −1 to 1.
    pub(super) fn correlation(&self, a: usize, b: usize) -> f64 {
        self.plain[(a, b)] / (self.plain[(a, a)] * self.plain[(b, b)]).sqrt()
    }
}
