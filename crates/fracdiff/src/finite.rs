//! An operator from a list of coefficients.

use crate::differintegrator::past_is_kept;
use crate::fir::FirHistory;
use crate::list::{ListError, check_finite};
use crate::response::polynomial;
use crate::{Differintegrator, FrequencyResponse, Real};
use num_complex::Complex;

/// A finite impulse response of N coefficients at most, whatever they are.
///
/// ```text
/// y[n] = Σ_{j=0}^{n−1} c_j·x[n−j]
/// ```
/// - *Units*: c has \[y\]/\[x\]; nothing is scaled by a sample time.
/// - *Start-up*: zero for ever before. *Not finite*: spoils as many outputs as there are coefficients.
/// - *Cost*: `output` one multiply-add, `advance` one for each other coefficient. No allocation or panic.
///
/// ```
/// use fracdiff::{Channel, Fir};
///
/// // Checked when the program is compiled.
/// const SLOPE: Fir<f32, 2> = match Fir::<f32, 2>::new([1e3, -1e3]) {
///     Ok(slope) => slope,
///     Err(_) => panic!("not finite"),
/// };
/// let mut axis = Channel::new(SLOPE);
/// axis.step(1.0);
/// assert_eq!(axis.step(1.5), 500.0);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Fir<F, const N: usize> {
    used: usize,
    coefficients: [F; N],
}

/// `new` in const context: traits cannot be called there, so each type has its own.
macro_rules! const_new {
    ($float:ty) => {
        impl<const N: usize> Fir<$float, N> {
            /// All N coefficients, that of the newest sample first; also in const context. `N = 0` does not compile.
            ///
            /// # Errors
            /// [`ListError::Value`] for a coefficient that is not finite.
            pub const fn new(coefficients: [$float; N]) -> Result<Self, ListError> {
                const { assert!(N > 0, "there is at least one coefficient") };
                let mut index = 0;
                while index < N {
                    if !coefficients[index].is_finite() {
                        let value = coefficients[index] as f64;
                        return Err(ListError::Value { index, value });
                    }
                    index += 1;
                }
                Ok(Self {
                    used: N,
                    coefficients,
                })
            }
        }
    };
}

const_new!(f32);
const_new!(f64);

impl<F: Real, const N: usize> Fir<F, N> {
    /// Coefficients whose number is known only at run time, that of the newest sample first.
    ///
    /// # Errors
    /// [`ListError::Count`] unless there are 1 to N; [`ListError::Value`] for one that is not finite.
    pub fn from_slice(coefficients: &[F]) -> Result<Self, ListError> {
        const { assert!(N > 0, "there is at least one coefficient") };
        let mut fir = Self::SILENT;
        fir.replace(coefficients)?;
        Ok(fir)
    }

    /// No coefficient: all zero, to the last bit, so that it is made in its place without a copy.
    pub(crate) const SILENT: Self = Self {
        used: 0,
        coefficients: [F::ZERO; N],
    };

    /// Accepts what [`from_slice`](Self::from_slice) accepts.
    pub(crate) fn check(coefficients: &[F]) -> Result<(), ListError> {
        let (count, most) = (coefficients.len(), N);
        if !(1..=most).contains(&count) {
            return Err(ListError::Count { count, most });
        }
        check_finite(coefficients)
    }

    /// Takes other coefficients, in its place; refused ones leave it as it is.
    pub(crate) fn replace(&mut self, coefficients: &[F]) -> Result<(), ListError> {
        Self::check(coefficients)?;
        self.used = coefficients.len();
        let (used, rest) = self.coefficients.split_at_mut(self.used);
        used.copy_from_slice(coefficients);
        rest.fill(F::ZERO);
        Ok(())
    }

    /// Coefficients that are known to be finite; zeros at the end take no part.
    pub(crate) fn of(coefficients: [F; N]) -> Self {
        let last = coefficients.iter().rposition(|c| *c != F::ZERO);
        let used = last.map_or(1, |last| last + 1);
        Self { used, coefficients }
    }

    /// The coefficients, that of the newest sample first.
    #[must_use]
    pub fn coefficients(&self) -> &[F] {
        self.coefficients.get(..self.used).unwrap_or_default()
    }

    /// Those of w¹, w², …
    #[inline]
    fn taps(&self) -> &[F] {
        self.coefficients.get(1..self.used).unwrap_or_default()
    }
}

impl<F: Real, const N: usize> Differintegrator<F> for Fir<F, N> {
    type History = FirHistory<F, N>;

    fn at_rest(&self) -> Self::History {
        FirHistory::at_rest()
    }

    fn settled(&self, x: F) -> Option<Self::History> {
        Some(FirHistory::settled(self.taps(), x))
    }

    past_is_kept!(coefficients[0]);

    #[inline]
    fn advance(&self, history: &mut Self::History, x: F) {
        history.advance(self.taps(), x);
    }

    #[inline]
    fn advance_many<const D: usize>(&self, histories: [&mut Self::History; D], x: [F; D]) {
        FirHistory::advance_many(histories, self.taps(), x);
    }

    fn memory_length(&self) -> Option<usize> {
        Some(self.used)
    }
}

impl<F: Real, const N: usize> FrequencyResponse for Fir<F, N> {
    /// Of the coefficients as they are: in \[y\]/\[x\], not freed of any T^(−μ).
    fn response(&self, theta: f64) -> Complex<f64> {
        polynomial(self.coefficients().iter().map(|c| c.to_f64()), theta)
    }
}
