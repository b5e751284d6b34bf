//! Standard errors of a fit that hold where residuals are no white noise.
//!
//! ```text
//! cov = (K − 1)/K·Σ over K pieces of d_k·d_kᵀ,   d_k = (A − A_k)⁻¹·J_kᵀ·r_k,   A_k = J_kᵀ·J_k,   A = Σ A_k
//! ```
//! Residuals of an encoder, of friction that varies and of a hand go together for a while, so whole pieces are taken as what is independent.
//! `d_k` is the step of the fit without piece k: what the numbers owe to it. As J is without what the states at the starts can make, they need no
//! terms of their own.
//!
//! Where what is left goes on from sample to sample, it is none of the sensor but a fault of the model, and another model may be as good
//! whose residual is larger by as much again:
//!
//! ```text
//! half an interval = max(2·√cov, √(ρ·Σr²·A⁻¹)),   ρ = Σ r_n·r_(n−1)/Σ r²   where that is above 0.05
//! ```
//! Source: the jackknife, with sums over pieces; R. M. Bell and D. F. `McCaffrey`, Survey Methodology 28, 2002.

use super::fit::{Fitted, square};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// Standard errors on each side of a value between which it lies in 95 of 100 cases: Student's t of some hundred pieces.
pub(super) const SIDES: f64 = 2.0;

/// Correlation of successive residuals that white ones do not have.
pub(super) const GOES_ON: f64 = 0.05;

/// Correlation of successive residuals.
pub(super) fn goes_on(left: &[f64]) -> f64 {
    left.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>() / square(left).max(f64::MIN_POSITIVE)
}

/// What is known of the numbers of a fit.
#[derive(Clone, Debug)]
pub(super) struct Spread {
    covariance: DMatrix<f64>,
    /// What the fault of the model allows.
    fault: DMatrix<f64>,
}

impl Spread {
    /// `None` if the record says nothing of one of the numbers.
    pub(super) fn of(fitted: &Fitted, is_simple: bool) -> Option<Self> {
        let (p, pieces) = (fitted.slopes.len(), fitted.pieces.len());
        let all = products(fitted, 0..fitted.left.len());
        // Numbers of very different size: to a unit diagonal first.
        let scale = all.diagonal().map(f64::sqrt);
        if pieces <= p + 1 || scale.iter().any(|s| !(s.is_finite() && *s > 0.0)) {
            return None;
        }
        let mut sum = DMatrix::zeros(p, p);
        for piece in &fitted.pieces {
            let others = &all - products(fitted, piece.clone());
            let others = others.component_div(&(&scale * scale.transpose()));
            let seen = |n: usize| {
                let ticks = piece.clone();
                let seen = ticks.map(|tick| fitted.slopes[n][tick] * fitted.left[tick]);
                seen.sum::<f64>() / scale[n]
            };
            let step = others.try_inverse()? * DVector::from_fn(p, |n, _| seen(n));
            let step = step.component_div(&scale);
            sum += &step * step.transpose();
        }
        let unit = all.component_div(&(&scale * scale.transpose()));
        let inverse = unit
            .try_inverse()?
            .component_div(&(&scale * scale.transpose()));
        let left = &fitted.left;
        let share = match goes_on(left) {
            share if is_simple && share <= GOES_ON => 0.0,
            share => share.max(GOES_ON),
        };
        let fault = share * square(left);
        Some(Self {
            covariance: sum * ((pieces - 1) as f64 / pieces as f64),
            fault: inverse * fault,
        })
    }

    /// Half the interval of a sum of numbers with these weights.
    pub(super) fn side(&self, weights: &DVector<f64>) -> f64 {
        let along = |matrix: &DMatrix<f64>| weights.dot(&(matrix * weights)).max(0.0).sqrt();
        f64::max(SIDES * along(&self.covariance), along(&self.fault))
    }

    /// Correlation of two such sums, −1 to 1.
    pub(super) fn correlation(&self, a: &DVector<f64>, b: &DVector<f64>) -> f64 {
        let of = |a: &DVector<f64>, b: &DVector<f64>| a.dot(&(&self.covariance * b));
        of(a, b) / (of(a, a) * of(b, b)).sqrt()
    }
}

/// `JᵀJ` of a range of ticks.
fn products(fitted: &Fitted, range: Range<usize>) -> DMatrix<f64> {
    let p = fitted.slopes.len();
    DMatrix::from_fn(p, p, |a, b| {
        let ticks = range.clone();
        ticks
            .map(|n| fitted.slopes[a][n] * fitted.slopes[b][n])
            .sum()
    })
}

#[cfg(test)]
mod tests {
    use super::super::fit::NUMBERS;
    use super::super::replay::Model;
    use super::*;
    use testkit::Random;

    const PIECES: usize = 12;
    const PIECE: usize = 60;

    /// Least squares of y by two slopes, without the ticks of one piece.
    fn without(slopes: &[Vec<f64>], y: &[f64], piece: Option<usize>) -> DVector<f64> {
        let ticks = || (0..y.len()).filter(|n| Some(n / PIECE) != piece);
        let sum = |a: &[f64], b: &[f64]| ticks().map(|n| a[n] * b[n]).sum::<f64>();
        let gram = DMatrix::from_fn(2, 2, |a, b| sum(&slopes[a], &slopes[b]));
        let seen = DVector::from_fn(2, |a, _| sum(&slopes[a], y));
        gram.lu().solve(&seen).expect("regular")
    }

    /// Two sines and noise that is new every `hold` ticks, fitted.
    fn problem(hold: usize) -> (Fitted, Vec<f64>) {
        let mut random = Random(7);
        let mut noise = 0.0;
        let y: Vec<f64> = (0..PIECES * PIECE)
            .map(|n| {
                if n % hold == 0 {
                    noise = random.between(-1.0, 1.0);
                }
                noise
            })
            .collect();
        let wave = |step: f64| (0..y.len()).map(|n| (step * n as f64).sin()).collect();
        let slopes = vec![wave(0.21), wave(0.037)];
        let theta = without(&slopes, &y, None);
        let left = |n: usize| slopes[0][n] * theta[0] + slopes[1][n] * theta[1] - y[n];
        let fitted = Fitted {
            model: Model::BARE,
            left: (0..y.len()).map(left).collect(),
            pieces: (0..PIECES).map(|n| n * PIECE..(n + 1) * PIECE).collect(),
            numbers: &NUMBERS[..2],
            slopes,
        };
        (fitted, y)
    }

    #[test]
    fn an_interval_is_what_fits_without_each_piece_make_of_it() {
        let (fitted, y) = problem(1);
        let best = without(&fitted.slopes, &y, None);
        let spread = Spread::of(&fitted, true).expect("tells");
        for n in 0..2 {
            let steps = (0..PIECES).map(|k| without(&fitted.slopes, &y, Some(k))[n] - best[n]);
            let variance = steps.map(|step| step * step).sum::<f64>() * 11.0 / 12.0;
            let only = DVector::from_fn(2, |m, _| if m == n { 1.0 } else { 0.0 });
            let (have, want) = (spread.side(&only), SIDES * variance.sqrt());
            assert!((have / want - 1.0).abs() < 1e-9, "{n}: {have} {want}");
        }
    }

    #[test]
    fn what_goes_on_from_sample_to_sample_widens_an_interval() {
        let (fitted, _) = problem(20);
        let share = goes_on(&fitted.left);
        assert!((share - 0.95).abs() < 0.03, "{share}");
        let only = DVector::from_vec(vec![1.0, 0.0]);
        let gram = products(&fitted, 0..PIECES * PIECE);
        let inverse = gram.try_inverse().expect("regular");
        let want = (share * square(&fitted.left) * inverse[(0, 0)]).sqrt();
        let have = Spread::of(&fitted, true).expect("tells").side(&only);
        assert!((have / want - 1.0).abs() < 1e-9, "{have} {want}");
        // Of white ones nothing is added, unless the model is known to be off.
        let (fitted, _) = problem(1);
        let side = |is_simple| Spread::of(&fitted, is_simple).expect("tells").side(&only);
        assert!(goes_on(&fitted.left) < GOES_ON && side(false) > side(true));
    }
}
