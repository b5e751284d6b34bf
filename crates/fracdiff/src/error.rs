//! Parameters outside their documented range.

use crate::full_memory::{HORIZON_MAX, HORIZON_MIN, TOLERANCE_MAX, TOLERANCE_MIN};
use crate::parameter::Shown;
use crate::{Order, Seconds};
use core::fmt;

/// A parameter outside its documented range, with the rejected value.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ParameterError {
    /// Order μ.
    Order(f64),
    /// Sample time T.
    SampleTime(Seconds),
    /// Length of a memory, degree of a polynomial or number of sections.
    #[non_exhaustive]
    Length {
        /// The things counted.
        what: &'static str,
        /// The rejected number.
        length: usize,
        /// The largest number allowed; the smallest is 1.
        most: usize,
    },
    /// Band of a band-limited operator.
    #[non_exhaustive]
    Band {
        /// Lower corner, Hz.
        low_hz: f64,
        /// Upper corner, Hz.
        high_hz: f64,
        /// Half the sample rate, Hz.
        nyquist_hz: f64,
    },
    /// Tolerance of a design.
    Tolerance(f64),
    /// Horizon of a design in samples, not longer than the memory it extends, or too long.
    Horizon(f64),
    /// A mode of a kernel of one's own.
    #[non_exhaustive]
    Mode {
        /// Its rate, which must be above 0, per sample.
        rate: f64,
        /// Its weight, which must be finite.
        weight: f64,
    },
    /// A weight of a kernel of one's own.
    #[non_exhaustive]
    Weight {
        /// Its lag, samples.
        lag: usize,
        /// The weight, which must be finite.
        weight: f64,
    },
    /// A density of a memory of one's own.
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

impl fmt::Display for ParameterError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Order(order) => {
                let (order, least, most) = (Shown(order), Order::MIN, Order::MAX);
                write!(f, "order {order} is not in [{least}, {most}]")
            }
            Self::SampleTime(sample_time) => write!(
                f,
                "sample time {sample_time} s is not in [{:e}, {:e}] s",
                Seconds::MIN_SAMPLE_TIME,
                Seconds::MAX_SAMPLE_TIME,
                sample_time = Shown(sample_time.0)
            ),
            Self::Length { what, length, most } => {
                write!(f, "{what} {length} is not in [1, {most}]")
            }
            Self::Band {
                low_hz,
                high_hz,
                nyquist_hz,
            } => write!(
                f,
                "band {low_hz} Hz to {high_hz} Hz is not inside 0 Hz to {nyquist_hz} Hz (half the \
                 sample rate), lower end first",
                low_hz = Shown(low_hz),
                high_hz = Shown(high_hz),
                nyquist_hz = Shown(nyquist_hz)
            ),
            Self::Tolerance(tolerance) => write!(
                f,
                "tolerance {} is not in [{TOLERANCE_MIN:e}, {TOLERANCE_MAX:e}]",
                Shown(tolerance)
            ),
            Self::Horizon(horizon) => write!(
                f,
                "horizon of {} samples is not in [{HORIZON_MIN:e}, {HORIZON_MAX:e}]",
                Shown(horizon)
            ),
            Self::Mode { rate, weight } => write!(
                f,
                "mode of rate {rate:e} and weight {weight:e}: the rate is not above 0, or one of the two not finite"
            ),
            Self::Weight { lag, weight } => {
                write!(f, "weight {weight} of lag {lag} is not finite")
            }
            Self::Density { rate, density } => write!(
                f,
                "density {density} at a rate of {rate:e} per sample is negative or not finite: no memory that only fades"
            ),
        }
    }
}

impl core::error::Error for ParameterError {}
