//! Band-limited operator after Oustaloup, its poles side by side.

use crate::full_memory::{Bank, BankHistory, PORTABLE_TAPS};
use crate::integer_part::{IntegerHistory, WithIntegerPart, operator_from_its_core};
use crate::order::check_length;
use crate::{Order, ParameterError, Real, Seconds};
use core::f64::consts::PI;

/// D^μ between two corner frequencies, from m ≤ N first-order sections, μ = n + φ with the integer part n towards zero.
/// ```text
/// s^φ ≈ ω_h^φ · Π_{i=1}^{m} (s + ω'_i)/(s + ω_i) = ω_h^φ · (1 + Σ_{i=1}^{m} c_i/(s + ω_i)),   r = ω_h/ω_l,
/// ω'_i = ω_l·r^((2i − 1 − φ)/(2m)),   ω_i = ω_l·r^((2i − 1 + φ)/(2m)),
/// c_i = Π_j (ω'_j − ω_i) / Π_{j≠i} (ω_j − ω_i)
/// ```
/// Discretised by the Tustin rule s = (2/T)(1 − w)/(1 + w); the integer part is (1 − w)^n T^(−n).
///
/// - *Units*: as [`ShortMemory`](crate::ShortMemory); corners in Hz, ω = 2πf.
/// - *Accuracy*: with two sections a decade about 3.5 %·|φ| at a decade and a half inside either corner, and 10 %·|φ| at one decade, the
///   edge of the band, whatever their number. Outside the band the gain is flat: no memory beyond about 1/`ω_l`. The Tustin rule
///   bends the top decade below half the sample rate.
/// - *Why side by side*: poles lie close together on a logarithmic scale, and one polynomial of degree m would lose them to
///   rounding. Each as a state of its own does not, and waits for no other, so that they are vectors.
/// - *Start-up*: zero for ever before. *Not finite*: no output is finite until reset.
/// - *Cost*: `output` one multiply-add, `advance` 8 operations a section, counted in eights. N is a multiple of 8, else it does not
///   compile.
///
/// Source: A. Oustaloup, F. Levron, B. Mathieu, F. Nanot, *Frequency-band complex noninteger
/// differentiator*, IEEE Trans. Circuits Syst. I 47(1), 2000.
#[derive(Clone, Debug, PartialEq)]
pub struct Oustaloup<F, const N: usize>(WithIntegerPart<Bank<F, PORTABLE_TAPS, N>>);

/// A frequency band in Hz, lower corner first.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Band {
    /// Lower corner, Hz, above 0.
    pub low_hz: f64,
    /// Upper corner, Hz, above the lower, below half the sample rate.
    pub high_hz: f64,
}

/// History of [`Oustaloup`].
pub type OustaloupHistory<F, const N: usize> = IntegerHistory<F, BankHistory<F, PORTABLE_TAPS, N>>;

impl<F: Real, const N: usize> Oustaloup<F, N> {
    /// m ≤ N sections, chosen at run time. Coefficients in `f64`, rounded once.
    ///
    /// # Errors
    /// [`ParameterError::Length`] unless 1 ≤ m ≤ N; [`ParameterError::SampleTime`];
    /// [`ParameterError::Band`] unless 0 < low < high < half the sample rate.
    pub fn new(
        order: Order,
        sections: usize,
        band: Band,
        sample_time: Seconds,
    ) -> Result<Self, ParameterError> {
        check_length("number of sections", sections, N)?;
        let rate = sample_time.rate_to_the(order)?;
        let Band { low_hz, high_hz } = band;
        let nyquist_hz = 0.5 / sample_time.0;
        if !(low_hz > 0.0 && low_hz < high_hz && high_hz < nyquist_hz) {
            return Err(ParameterError::Band {
                low_hz,
                high_hz,
                nyquist_hz,
            });
        }
        let (integer, fraction) = order.split();
        // Halves of corner frequencies in rad/sample, the highest first: the whole design is dimensionless.
        let low = PI * low_hz * sample_time.0;
        let high = PI * high_hz * sample_time.0;
        let corner = |i: usize, sign: f64| {
            let exponent =
                (2.0 * (sections - i) as f64 - 1.0 + sign * fraction) / (2.0 * sections as f64);
            low * libm::pow(high / low, exponent)
        };
        let (zero, pole) = (|i| corner(i, -1.0), |i| corner(i, 1.0));
        let gain = rate * libm::pow(2.0 * high, fraction);
        let direct = (0..sections).fold(gain, |g, i| g * (1.0 + zero(i)) / (1.0 + pole(i)));
        let modes = (0..sections).map(|i| {
            let p = pole(i);
            let others = (0..sections).filter(|&j| j != i);
            let c = others.fold(zero(i) - p, |c, j| c * (zero(j) - p) / (pole(j) - p));
            // c/(s + ω) under s/2 = (1 − w)/(1 + w), c and p halves of it and of ω:
            // c/(1 + p) + 2c/(1 + p)²·w/(1 − (1 − d)w),   d = 2p/(1 + p)
            (
                2.0 * p / (1.0 + p),
                gain * 2.0 * c / ((1.0 + p) * (1.0 + p)),
            )
        });
        let core = Bank::of_modes(rate, direct, modes, integer);
        Ok(Self(WithIntegerPart { integer, core }))
    }

    /// Integer part, and the values of [`Form::Modes`](crate::portable::Form::Modes).
    #[cfg(feature = "std")]
    pub(crate) fn list(&self) -> (i32, std::vec::Vec<F>) {
        self.0.list(Bank::value)
    }
}

operator_from_its_core!(Oustaloup<N>, OustaloupHistory);
