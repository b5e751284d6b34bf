//! Order μ and sample time T: the two numbers every operator is made from.

use crate::ParameterError;
use core::fmt;

/// Order μ of a differintegral, dimensionless, finite, −2 ≤ μ ≤ 2.
///
/// Positive differentiates, zero is the identity, negative integrates. Checked once, here.
///
/// ```
/// use fracdiff::Order;
///
/// assert_eq!(Order::new(1.25)?.split(), (1, 0.25)); // a difference, and the quarter derivative of it
/// assert_eq!(Order::new(2.5).unwrap_err().to_string(), "order 2.5 is not in [-2, 2]");
/// # Ok::<(), fracdiff::ParameterError>(())
/// ```
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
    /// Full-memory operators are a fractional integral of order ν of the n-th difference:
    /// (1 − w)^μ = (1 − w)^n·(1 − w)^(−ν). A 0 < μ so small that 1 − μ rounds to 1 counts as 0, as does a ν
    /// below 1e-300.
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
///
/// ```
/// use fracdiff::{Order, Seconds};
///
/// // T^(−1/2) at 10 kHz.
/// assert_eq!(Seconds(1e-4).rate_to_the(Order::new(0.5)?)?, 100.0);
/// # Ok::<(), fracdiff::ParameterError>(())
/// ```
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
