//! The Muir polynomial `A_n(w, μ)`, and the operator that uses it alone.

use crate::differintegrator::past_is_kept;
use crate::fir::FirHistory;
use crate::order::check_length;
use crate::response::polynomial;
use crate::{Differintegrator, FrequencyResponse, Order, ParameterError, Real, Seconds};
use num_complex::Complex;

/// Coefficients of the Muir polynomial `A_n(w, μ)`, of w⁰ first, into `coefficients`; n is one less than its length.
/// ```text
/// A₀ = 1,   A_n(w, μ) = A_{n−1}(w, μ) − c_n·wⁿ·A_{n−1}(w^(−1), μ),   c_n = μ/n for odd n, else 0
/// ```
/// So A₃ = 1 − μw + (μ²/3)w² − (μ/3)w³, and `A_n` = A_{n−1} for even n. Exact up to rounding; costs about n²/4 multiply-adds. An empty
/// slice stays empty. Source: B. M. Vinagre, Y. Q. Chen, I. Petráš, *Two direct Tustin discretization methods for fractional-order
/// differentiator/integrator*, J. Franklin Inst. 340, 2003, eqs. 13–15.
pub fn muir_coefficients(order: Order, coefficients: &mut [f64]) {
    coefficients.fill(0.0);
    let Some(first) = coefficients.first_mut() else {
        return;
    };
    *first = 1.0;
    for degree in (1..coefficients.len()).step_by(2) {
        let reflection = order.get() / degree as f64;
        // a_i ← a_i − c·a_{n−i}, in place: both ends of each pair at once.
        for low in 0..=degree / 2 {
            let high = degree - low;
            let (a, b) = (coefficients[low], coefficients[high]);
            coefficients[low] = a - reflection * b;
            coefficients[high] = b - reflection * a;
        }
    }
}

/// D^μ ≈ `T^(−μ)·A_n(w, μ)`, n ≤ N: the numerator of the Tustin–Muir form alone, as chapter IV of the dissertation uses it.
/// ```text
/// y[k] = T^(−μ) · Σ_{i=0}^{n} a_i·x[k−i]
/// ```
/// **Not an approximation of (1 − w)^μ**: at μ = 1, n = 3 it is 1 − w + w²/3 − w³/3, and its gain at rest, (1−μ)(3−μ)/3 for n = 3, is −1/3
/// at μ = 2 where the truth is 0. It is here so that the results of that chapter can be computed again; use
/// [`TustinMuir`](crate::TustinMuir) or [`FullMemory`](crate::FullMemory) to render with.
///
/// - *Units*: as [`ShortMemory`](crate::ShortMemory). *Start-up*: zero for ever before.
/// - *Not finite*: spoils n + 1 outputs. *Cost*: `output` one multiply-add, `advance` n.
///
/// Source: O. Tokatlı, *Fractional Order Control in Haptics*, eqs. 3.6, 3.7, 4.2.
#[derive(Clone, Debug, PartialEq)]
pub struct MuirPolynomial<F, const N: usize> {
    rate: f64,
    degree: usize,
    direct: F,
    /// Coefficients of w¹, w², …; zero from the degree on.
    taps: [F; N],
}

impl<F: Real, const N: usize> MuirPolynomial<F, N> {
    /// Degree n = N.
    ///
    /// # Errors
    /// As [`with_degree`](Self::with_degree).
    pub fn new(order: Order, sample_time: Seconds) -> Result<Self, ParameterError> {
        Self::with_degree(order, N, sample_time)
    }

    /// Degree n ≤ N, chosen at run time. Coefficients in `f64`, rounded once.
    ///
    /// # Errors
    /// [`ParameterError::Length`] unless 1 ≤ n ≤ N; [`ParameterError::SampleTime`].
    pub fn with_degree(
        order: Order,
        degree: usize,
        sample_time: Seconds,
    ) -> Result<Self, ParameterError> {
        check_length("polynomial degree", degree, N)?;
        let rate = sample_time.rate_to_the(order)?;
        let (direct, coefficients) = muir_split::<N>(order, degree);
        Ok(Self {
            rate,
            degree,
            direct: F::from_f64(rate * direct),
            taps: coefficients.map(|a| F::from_f64(rate * a)),
        })
    }
}

/// a₀, and [a₁, …, `a_n`, 0, …] for degree n ≤ N.
pub(crate) fn muir_split<const N: usize>(order: Order, degree: usize) -> (f64, [f64; N]) {
    // One word more than N: two arrays side by side, since N + 1 is no const generic.
    let mut both = [[0.0; N]; 2];
    let flat = both.as_flattened_mut();
    muir_coefficients(order, &mut flat[..=degree]);
    let mut taps = [0.0; N];
    taps.copy_from_slice(&flat[1..=N]);
    (flat[0], taps)
}

#[cfg(feature = "std")]
impl<F: Real, const N: usize> MuirPolynomial<F, N> {
    /// The values of [`Form::Taps`](crate::portable::Form::Taps).
    pub(crate) fn list(&self) -> std::vec::Vec<F> {
        let taps = &self.taps[..self.degree];
        core::iter::once(self.direct)
            .chain(taps.iter().copied())
            .collect()
    }
}

impl<F: Real, const N: usize> Differintegrator<F> for MuirPolynomial<F, N> {
    type History = FirHistory<F, N>;

    fn at_rest(&self) -> Self::History {
        FirHistory::AT_REST
    }

    fn settled(&self, x: F) -> Option<Self::History> {
        Some(FirHistory::settled(&self.taps[..self.degree], x))
    }

    past_is_kept!(direct);

    #[inline]
    fn advance(&self, history: &mut Self::History, x: F) {
        history.advance(&self.taps[..self.degree], x);
    }

    fn memory_length(&self) -> Option<usize> {
        Some(self.degree + 1)
    }
}

impl<F: Real, const N: usize> FrequencyResponse for MuirPolynomial<F, N> {
    fn response(&self, theta: f64) -> Complex<f64> {
        let coefficients = core::iter::once(self.direct).chain(self.taps);
        polynomial(coefficients.map(|a| a.to_f64()), theta) / self.rate
    }
}
