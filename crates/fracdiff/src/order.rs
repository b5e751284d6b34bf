//! Order μ and sample time T, the two numbers every operator is made from, and parameters outside their range.

use crate::parameter::Shown;
use core::fmt;

/// Order μ of a differintegral, dimensionless, finite, −2 ≤ μ ≤ 2.
///
/// Positive differentiates, zero is the identity, negative integrates. Checked once, here.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Order(f64);

impl Order {
    /// Smallest order: the double integral.
    pub const MIN: f64 = -2.0;
    /// Largest order: the second derivative.
    pub const MAX: f64 = 2.0;

    /// Accepts −2 ≤ μ ≤ 2.
    ///
    /// # Errors
    /// [`ParameterError::Order`] outside that range, or for a NaN.
    pub fn new(order: f64) -> Result<Self, ParameterError> {
        if (Self::MIN..=Self::MAX).contains(&order) {
            // A negative zero would print as "-0".
            Ok(Self(order + 0.0))
        } else {
            Err(ParameterError::Order(order))
        }
    }

    /// The number μ.
    #[must_use]
    pub const fn get(self) -> f64 {
        self.0
    }

    /// μ = n + φ with the integer n towards zero and |φ| < 1: `(n, φ)`.
    ///
    /// Recursive operators take the integer part n exactly, by differences or accumulation, and
    /// approximate only the fractional part φ. A |φ| below 1e-300 counts as 0.
    #[must_use]
    pub fn split(self) -> (i32, f64) {
        let integer = libm::trunc(self.0);
        let fraction = self.0 - integer;
        let fraction = if fraction.abs() < LEAST {
            0.0
        } else {
            fraction
        };
        (integer as i32, fraction)
    }

    /// μ = n − ν with the integer n = ⌈μ⌉ and 0 ≤ ν < 1: `(n, ν)`.
    ///
    /// Full-memory operators are a fractional integral of order ν of the n-th difference: (1 − w)^μ = (1 − w)^n·(1 − w)^(−ν). A 0 < μ so
    /// small that 1 − μ rounds to 1 counts as 0, as does a ν below 1e-300.
    #[must_use]
    pub fn split_up(self) -> (i32, f64) {
        let up = libm::ceil(self.0);
        let integral = up - self.0;
        if integral >= 1.0 {
            return (up as i32 - 1, 0.0);
        }
        let integral = if integral < LEAST { 0.0 } else { integral };
        (up as i32, integral)
    }
}

/// Fractional parts below this count as zero: sin πφ would be subnormal.
const LEAST: f64 = 1e-300;

impl fmt::Display for Order {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// A duration in seconds. Any number; the constructor that takes it checks the range it needs.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Seconds(pub f64);

impl Seconds {
    /// Smallest sample time an operator accepts, in seconds.
    pub const MIN_SAMPLE_TIME: f64 = 1e-9;
    /// Largest sample time an operator accepts, in seconds.
    pub const MAX_SAMPLE_TIME: f64 = 1e6;

    /// T^(−μ), the factor between the dimensionless operator P and D^μ, in s^(−μ).
    ///
    /// # Errors
    /// [`ParameterError::SampleTime`] unless 1e-9 s ≤ T ≤ 1e6 s, which keeps T^(±2) a normal `f32`.
    pub fn rate_to_the(self, order: Order) -> Result<f64, ParameterError> {
        if (Self::MIN_SAMPLE_TIME..=Self::MAX_SAMPLE_TIME).contains(&self.0) {
            Ok(libm::pow(self.0, -order.get()))
        } else {
            Err(ParameterError::SampleTime(self))
        }
    }
}

impl fmt::Display for Seconds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)?;
        f.write_str(" s")
    }
}

/// Smallest tolerance a design accepts.
pub(crate) const TOLERANCE_MIN: f64 = 1e-11;
/// Largest tolerance a design accepts.
pub(crate) const TOLERANCE_MAX: f64 = 0.1;
/// Shortest horizon a design accepts, samples.
pub const HORIZON_MIN: f64 = 1e2;
/// Longest horizon a design accepts, samples: 31 years at 1 kHz.
pub(crate) const HORIZON_MAX: f64 = 1e12;

/// A parameter outside its documented range, with the rejected value.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ParameterError {
    /// An order outside [−2, 2], or a NaN.
    #[error("order {} is not in [{}, {}]", Shown(*.0), Order::MIN, Order::MAX)]
    Order(f64),
    /// A sample time at which T^(±2) would not be a normal `f32`.
    #[error("sample time {} s is not in [{:e}, {:e}] s", Shown(.0.0), Seconds::MIN_SAMPLE_TIME, Seconds::MAX_SAMPLE_TIME)]
    SampleTime(Seconds),
    /// Length of a memory, degree of a polynomial or number of sections.
    #[error("{what} {length} is not in [1, {most}]")]
    #[non_exhaustive]
    Length {
        /// The things counted, for the sentence that refuses their number.
        what: &'static str,
        /// The number that was refused.
        length: usize,
        /// The largest number allowed; the smallest is 1.
        most: usize,
    },
    /// Band of a band-limited operator.
    #[error(
        "band {} Hz to {} Hz is not inside 0 Hz to {} Hz (half the sample rate), lower end first",
        Shown(*low_hz), Shown(*high_hz), Shown(*nyquist_hz)
    )]
    #[non_exhaustive]
    Band {
        /// The lower corner, Hz, which must be above 0.
        low_hz: f64,
        /// The upper corner, Hz, which must be above the lower one.
        high_hz: f64,
        /// Half the sample rate, Hz.
        nyquist_hz: f64,
    },
    /// A tolerance that no design can reach or that says nothing.
    #[error("tolerance {} is not in [{TOLERANCE_MIN:e}, {TOLERANCE_MAX:e}]", Shown(*.0))]
    Tolerance(f64),
    /// Horizon of a design in samples, not longer than the memory it extends, or too long.
    #[error("horizon of {} samples is not in [{HORIZON_MIN:e}, {HORIZON_MAX:e}]", Shown(*.0))]
    Horizon(f64),
    /// A quotient whose recursion may grow.
    #[error(
        "quotient of sums: its coefficients are not all finite, or the newest of the denominator, {newest:e}, is not above {others:e}, the sum of the others' sizes"
    )]
    #[non_exhaustive]
    Quotient {
        /// The newest coefficient of the denominator, a₀.
        newest: f64,
        /// Σ|`a_j`| of the others.
        others: f64,
    },
    /// A mode of a kernel of one's own.
    #[error(
        "mode of rate {rate:e} and weight {weight:e}: the rate must be above 0, and both finite"
    )]
    #[non_exhaustive]
    Mode {
        /// Its rate, which must be above 0, per sample.
        rate: f64,
        /// Its weight, which must be finite.
        weight: f64,
    },
    /// A weight of a kernel of one's own.
    #[error("weight {weight} of lag {lag} is not finite")]
    #[non_exhaustive]
    Weight {
        /// Its lag, samples.
        lag: usize,
        /// The weight, which must be finite.
        weight: f64,
    },
    /// A density of a memory of one's own.
    #[error(
        "density {density} at a rate of {rate:e} per sample is not finite and at least 0, so the memory would not fade"
    )]
    #[non_exhaustive]
    Density {
        /// Its rate, per sample.
        rate: f64,
        /// The density, which must be finite and not negative.
        density: f64,
    },
}

/// Accepts a length, degree or number of sections of 1 to `most`.
pub(crate) fn check_length(
    what: &'static str,
    length: usize,
    most: usize,
) -> Result<usize, ParameterError> {
    if (1..=most).contains(&length) {
        Ok(length)
    } else {
        Err(ParameterError::Length { what, length, most })
    }
}
