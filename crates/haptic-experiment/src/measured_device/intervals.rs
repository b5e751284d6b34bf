//! Standard errors of a fit that hold where residuals are no white noise.
//!
//! ```text
//! cov = A⁻¹·M·A⁻¹·(K − 1)/K,   A = JᵀJ,   M = Σ over K blocks of s_k·s_kᵀ,   s_k = J_kᵀ·(1 − H_k)⁻¹·r_k
//! H_k = J_k·A⁻¹·J_kᵀ + S_k·(SᵀS)⁻¹·S_kᵀ,   S the slopes over the state at the start of the piece
//! ```
//! Residuals of an encoder, of friction that varies and of a hand go together for a while, so blocks of [`BLOCK_S`] are taken as what is
//! independent. A fit draws its residuals down, and most of all by the two numbers at the start of each piece, of which there are some five
//! blocks: (1 − `H_k`)⁻¹ makes of them what a fit without the block would leave there. Where the plain σ²A⁻¹ is larger, it is taken: a few
//! blocks may agree by chance.
//!
//! Source: H. White, Econometrica 48, 1980, with sums over blocks; R. M. Bell and D. F. `McCaffrey`, Survey Methodology 28, 2002, the jackknife.

use super::fit::Fitted;
use nalgebra::{DMatrix, DVector, SVD};
use std::ops::Range;

/// Length of a block, about, s, and at least so many samples.
const BLOCK_S: f64 = 0.1;
const BLOCK_SAMPLES: usize = 20;
/// Standard errors on each side of a value between which it lies in 95 of 100 cases: Student's t of some seventy blocks.
pub(super) const SIDES: f64 = 2.0;
/// Directions that the other blocks of a piece tell this much less of, as a share, are told by this block alone.
const ALONE: f64 = 1e-6;
/// Turns of a matrix of a few rows at most.
const TURNS: usize = 1000;

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
        for piece in &fitted.pieces {
            let by_piece = states_of(fitted, piece);
            for block in parts(piece, block) {
                let score = score(fitted, &block, (&information, &scale), &by_piece);
                middle += &score * score.transpose();
                blocks += 1;
            }
        }
        if blocks <= p + 1 {
            return None;
        }
        let small = (blocks - 1) as f64 / blocks as f64;
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

/// A range in parts of about `length`, all as long as can be.
fn parts(range: &Range<usize>, length: usize) -> impl Iterator<Item = Range<usize>> {
    let (start, all) = (range.start, range.len());
    let count = (all / length).max(1);
    (0..count).map(move |n| start + n * all / count..start + (n + 1) * all / count)
}

/// `SᵀS` of a range of ticks.
fn states_of(fitted: &Fitted, range: &Range<usize>) -> DMatrix<f64> {
    DMatrix::from_fn(2, 2, |a, b| {
        let ticks = range.clone();
        ticks
            .map(|n| fitted.by_state[a][n] * fitted.by_state[b][n])
            .sum()
    })
}

/// Jᵀ·(1 − H)⁻¹·r of a block, by the identity of Woodbury: with U = (J S) and C⁻¹ = diag(A, `SᵀS` of the piece)
/// (1 − U·C·Uᵀ)⁻¹ = 1 + U·(C⁻¹ − UᵀU)⁻¹·Uᵀ.
fn score(
    fitted: &Fitted,
    block: &Range<usize>,
    (information, scale): (&DMatrix<f64>, &DVector<f64>),
    by_piece: &DMatrix<f64>,
) -> DVector<f64> {
    let p = fitted.slopes.len();
    // A unit diagonal for both, so that numbers of very different size can be told apart.
    let size = |n: usize| match n.checked_sub(p) {
        None => scale[n],
        Some(state) => by_piece[(state, state)].sqrt().max(f64::MIN_POSITIVE),
    };
    let column = |n: usize| match n.checked_sub(p) {
        None => &fitted.slopes[n],
        Some(state) => &fitted.by_state[state],
    };
    let sum = |a: &[f64], b: &[f64]| -> f64 { block.clone().map(|n| a[n] * b[n]).sum() };
    let inner = DMatrix::from_fn(p + 2, p + 2, |a, b| {
        sum(column(a), column(b)) / (size(a) * size(b))
    });
    let seen = DVector::from_fn(p + 2, |n, _| sum(column(n), &fitted.left) / size(n));
    let whole = DMatrix::from_fn(p + 2, p + 2, |a, b| {
        match (a.checked_sub(p), b.checked_sub(p)) {
            (None, None) => information[(a, b)] / (size(a) * size(b)),
            (Some(x), Some(y)) => by_piece[(x, y)] / (size(a) * size(b)),
            _ => 0.0,
        }
    });
    // Bounded: numbers that are none would be turned for ever.
    let rounding = 5.0 * f64::EPSILON;
    let elsewhere = SVD::try_new_unordered(whole - &inner, true, true, rounding, TURNS)
        .and_then(|turned| turned.pseudo_inverse(ALONE).ok());
    let drawn_down = elsewhere.map_or_else(|| DVector::zeros(p + 2), |inverse| inverse * &seen);
    let score = &seen + &inner * drawn_down;
    DVector::from_fn(p, |n, _| score[n] * size(n))
}

#[cfg(test)]
mod tests {
    use super::super::fit::NUMBERS;
    use super::super::replay::Model;
    use super::*;
    use testkit::Random;

    const PIECES: usize = 6;
    const PIECE: usize = 60;

    /// A straight line in each piece, two slopes beside it, and noise that goes together over a block of 20.
    fn problem() -> Fitted {
        let mut random = Random(7);
        let count = PIECES * PIECE;
        let at = |n: usize| (n % PIECE) as f64 / PIECE as f64;
        let by_state = [vec![1.0; count], (0..count).map(at).collect()];
        let raw = [
            (0..count).map(|n| (0.21 * n as f64).sin()).collect(),
            (0..count).map(|n| (0.037 * n as f64).cos()).collect(),
        ];
        let mut noise = 0.0;
        let read: Vec<f64> = (0..count)
            .map(|n| {
                if n % 20 == 0 {
                    noise = random.between(-1.0, 1.0);
                }
                noise + 0.1 * random.between(-1.0, 1.0)
            })
            .collect();
        let mut fitted = Fitted {
            model: Model::BARE,
            left: read,
            slopes: Vec::from(raw),
            by_state,
            pieces: (0..PIECES).map(|n| n * PIECE..(n + 1) * PIECE).collect(),
            numbers: &NUMBERS[..2],
        };
        let everything: Vec<usize> = (0..count).collect();
        let (slopes, left) = (fitted.slopes.clone(), fitted.left.clone());
        fitted.slopes = slopes.iter().map(|s| without_states(&fitted, s)).collect();
        let theta = solved(&fitted, &left, &everything);
        fitted.left = (0..count)
            .map(|n| left[n] - line(&fitted, &theta, n))
            .collect();
        fitted
    }

    /// What no state can make of a signal.
    fn without_states(fitted: &Fitted, signal: &[f64]) -> Vec<f64> {
        let mut left = signal.to_vec();
        for piece in &fitted.pieces {
            let gram = states_of(fitted, piece);
            let seen = DVector::from_fn(2, |a, _| {
                piece
                    .clone()
                    .map(|n| fitted.by_state[a][n] * signal[n])
                    .sum::<f64>()
            });
            let best = gram.lu().solve(&seen).expect("two states");
            for n in piece.clone() {
                left[n] -= best[0] * fitted.by_state[0][n] + best[1] * fitted.by_state[1][n];
            }
        }
        left
    }

    /// Slopes of a tick over both numbers and all states.
    fn row(fitted: &Fitted, n: usize) -> DVector<f64> {
        let mut row = DVector::zeros(2 + 2 * PIECES);
        let piece = 2 + 2 * (n / PIECE);
        (row[0], row[1]) = (fitted.slopes[0][n], fitted.slopes[1][n]);
        (row[piece], row[piece + 1]) = (fitted.by_state[0][n], fitted.by_state[1][n]);
        row
    }

    fn line(fitted: &Fitted, theta: &DVector<f64>, n: usize) -> f64 {
        row(fitted, n).dot(theta)
    }

    /// Least squares over these ticks.
    fn solved(fitted: &Fitted, read: &[f64], ticks: &[usize]) -> DVector<f64> {
        let size = 2 + 2 * PIECES;
        let (mut gram, mut seen) = (DMatrix::zeros(size, size), DVector::zeros(size));
        for &n in ticks {
            let row = row(fitted, n);
            gram += &row * row.transpose();
            seen += row * read[n];
        }
        gram.lu().solve(&seen).expect("a line")
    }

    #[test]
    fn the_score_of_a_block_is_the_step_of_a_fit_without_it() {
        let fitted = problem();
        let (p, count) = (2, PIECES * PIECE);
        let information = DMatrix::from_fn(p, p, |a, b| {
            (0..count)
                .map(|n| fitted.slopes[a][n] * fitted.slopes[b][n])
                .sum::<f64>()
        });
        let scale = DVector::from_fn(p, |n, _| information[(n, n)].sqrt());
        for piece in &fitted.pieces {
            let by_piece = states_of(&fitted, piece);
            for block in parts(piece, 20) {
                let score = score(&fitted, &block, (&information, &scale), &by_piece);
                let step = information.clone().lu().solve(&score).expect("regular");
                let others: Vec<usize> = (0..count).filter(|n| !block.contains(n)).collect();
                let without = solved(&fitted, &fitted.left, &others);
                for n in 0..p {
                    let (have, want) = (step[n], -without[n]);
                    assert!((have - want).abs() < 1e-9, "{block:?}, {n}: {have} {want}");
                }
            }
        }
    }

    #[test]
    fn a_range_is_cut_into_parts_that_are_about_as_long() {
        let cut: Vec<_> = parts(&(10..257), 100).collect();
        assert_eq!(cut, [10..133, 133..257]);
        let mut whole = parts(&(3..8), 100);
        assert_eq!((whole.next(), whole.next()), (Some(3..8), None));
    }
}
