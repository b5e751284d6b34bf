//! Choosing an operator at run time: the names that command lines and experiment files use.
//!
//! ```text
//! grunwald:N                     the N newest samples; beyond 2048 by blocks  ShortMemory, PartitionedMemory
//! muir:N                         Muir polynomial of degree N alone            MuirPolynomial
//! tustin-muir:N                  recursive form of degree N                   TustinMuir
//! oustaloup:N:LOW_HZ:HIGH_HZ     N first-order sections between two corners   Oustaloup
//! full[:TOLERANCE]               full memory, Grünwald kernel                 FullMemory
//! piecewise-linear[:TOLERANCE]   full memory, Caputo L1 kernel                FullMemory
//! full-bdf2[:TOLERANCE]          full memory of second order in T             Bdf2Memory
//! exact                          (1 − w)^μ, for analysis only                 ExactDifference
//! ```

mod operator;
mod sizes;

use crate::batch::Batch;
use crate::error::check_length;
use crate::full_memory::{Design, DesignError, Kernel};
use crate::{
    Band, Bdf2Memory, FullMemory, MuirPolynomial, Order, Oustaloup, ParameterError,
    PartitionedMemory, Real, Seconds, ShortMemoryVec, TustinMuir,
};
use core::fmt;
use core::str::FromStr;
pub use operator::{Operator, OperatorHistory, OperatorList};
pub use sizes::{DEGREE_MAX, FULL_MODES, FULL_TAPS, SHORT_MOST};
use std::boxed::Box;
use std::string::{String, ToString};

/// Default tolerance of `full`, `piecewise-linear` and `full-bdf2`.
pub const DEFAULT_TOLERANCE: f64 = 1e-6;

/// An operator by name and parameters, without order and sample time.
///
/// ```
/// use fracdiff::{Channel, Operator, Order, Scheme, Seconds};
///
/// let scheme: Scheme = "full:1e-4".parse()?; // as a user typed it
/// let operator: Operator<f32> = scheme.build(Order::new(0.2247)?, Seconds(1e-3), 2e5)?;
/// let mut axis = Channel::new(operator);
/// assert!(axis.step(1e-3) > 0.0);
/// # Ok::<(), fracdiff::SchemeError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Scheme {
    /// `grunwald:N`.
    Grunwald {
        /// N, samples.
        length: usize,
    },
    /// `muir:N`.
    Muir {
        /// Degree N.
        degree: usize,
    },
    /// `tustin-muir:N`.
    TustinMuir {
        /// Degree N.
        degree: usize,
    },
    /// `oustaloup:N:LOW_HZ:HIGH_HZ`.
    Oustaloup {
        /// Sections N.
        sections: usize,
        /// Corners.
        band: Band,
    },
    /// `full[:TOLERANCE]` or `piecewise-linear[:TOLERANCE]`.
    Full {
        /// The weights: Grünwald or piecewise linear.
        kernel: Kernel,
        /// ε of [`Design::error_bound`]: of the output, in units of T^(−μ)·Σ `c_j`·|Δⁿx|.
        tolerance: f64,
    },
    /// `full-bdf2[:TOLERANCE]`.
    FullBdf2 {
        /// ε of the full memory in it, of the Grünwald kernel; see [`Bdf2Memory`] for the bound of the output.
        tolerance: f64,
    },
    /// `exact`.
    Exact,
}

/// Error of reading or building a scheme.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SchemeError {
    /// An unknown name, or missing or surplus parameters.
    Unknown(String),
    /// A parameter that is not a number.
    NotANumber(String),
    /// A parameter outside its range.
    Parameter(ParameterError),
    /// No full memory has this tolerance and horizon.
    Design(DesignError),
    /// `exact` cannot run as a filter.
    AnalysisOnly,
}

impl From<ParameterError> for SchemeError {
    fn from(error: ParameterError) -> Self {
        Self::Parameter(error)
    }
}

impl From<DesignError> for SchemeError {
    fn from(error: DesignError) -> Self {
        match error {
            DesignError::Parameter(error) => Self::Parameter(error),
            error => Self::Design(error),
        }
    }
}

impl fmt::Display for SchemeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown(text) => write!(
                f,
                "scheme \"{text}\" is not one of grunwald:N, muir:N, tustin-muir:N, \
                 oustaloup:N:LOW_HZ:HIGH_HZ, full[:TOLERANCE], piecewise-linear[:TOLERANCE], \
                 full-bdf2[:TOLERANCE], exact"
            ),
            Self::NotANumber(text) => {
                write!(
                    f,
                    "\"{text}\" in the scheme is not a number of the kind asked for"
                )
            }
            Self::Parameter(error) => error.fmt(f),
            Self::Design(error) => error.fmt(f),
            Self::AnalysisOnly => {
                f.write_str("scheme exact is for analysis only: use full or piecewise-linear")
            }
        }
    }
}

impl core::error::Error for SchemeError {}

impl FromStr for Scheme {
    type Err = SchemeError;

    fn from_str(text: &str) -> Result<Self, SchemeError> {
        let mut parts = text.split(':');
        let name = parts.next().unwrap_or_default();
        let parameters: std::vec::Vec<&str> = parts.collect();
        match (name, parameters.as_slice()) {
            ("grunwald", [length]) => Ok(Self::Grunwald {
                length: check_length(
                    "memory length",
                    number(length)?,
                    ShortMemoryVec::<f64>::MOST,
                )?,
            }),
            ("muir", [degree]) => Ok(Self::Muir {
                degree: check_length("polynomial degree", number(degree)?, DEGREE_MAX)?,
            }),
            ("tustin-muir", [degree]) => Ok(Self::TustinMuir {
                degree: check_length("polynomial degree", number(degree)?, DEGREE_MAX)?,
            }),
            ("oustaloup", [sections, low_hz, high_hz]) => Ok(Self::Oustaloup {
                sections: check_length("number of sections", number(sections)?, DEGREE_MAX)?,
                band: Band {
                    low_hz: number(low_hz)?,
                    high_hz: number(high_hz)?,
                },
            }),
            ("full", rest @ ([] | [_])) => Ok(Self::Full {
                kernel: Kernel::Grunwald,
                tolerance: tolerance(rest)?,
            }),
            ("piecewise-linear", rest @ ([] | [_])) => Ok(Self::Full {
                kernel: Kernel::PiecewiseLinear,
                tolerance: tolerance(rest)?,
            }),
            ("full-bdf2", rest @ ([] | [_])) => Ok(Self::FullBdf2 {
                tolerance: tolerance(rest)?,
            }),
            ("exact", []) => Ok(Self::Exact),
            _ => Err(SchemeError::Unknown(text.to_string())),
        }
    }
}

fn number<T: FromStr>(text: &str) -> Result<T, SchemeError> {
    let parsed = text.trim().parse();
    parsed.map_err(|_| SchemeError::NotANumber(text.to_string()))
}

/// The optional parameter of a full memory.
fn tolerance(parameters: &[&str]) -> Result<f64, SchemeError> {
    use crate::full_memory::{TOLERANCE_MAX, TOLERANCE_MIN};
    let tolerance = match parameters {
        [tolerance] => number(tolerance)?,
        _ => DEFAULT_TOLERANCE,
    };
    if (TOLERANCE_MIN..=TOLERANCE_MAX).contains(&tolerance) {
        Ok(tolerance)
    } else {
        Err(ParameterError::Tolerance(tolerance).into())
    }
}

impl fmt::Display for Scheme {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Grunwald { length } => write!(f, "grunwald:{length}"),
            Self::Muir { degree } => write!(f, "muir:{degree}"),
            Self::TustinMuir { degree } => write!(f, "tustin-muir:{degree}"),
            Self::Oustaloup {
                sections,
                band: Band { low_hz, high_hz },
            } => write!(f, "oustaloup:{sections}:{low_hz}:{high_hz}"),
            Self::Full {
                kernel: Kernel::Grunwald,
                tolerance,
            } => write!(f, "full:{tolerance:e}"),
            Self::Full {
                kernel: Kernel::PiecewiseLinear,
                tolerance,
            } => write!(f, "piecewise-linear:{tolerance:e}"),
            Self::FullBdf2 { tolerance } => write!(f, "full-bdf2:{tolerance:e}"),
            Self::Exact => f.write_str("exact"),
        }
    }
}

/// Fewest modes for the tolerance, over at least 100 samples.
fn pruned(
    kernel: Kernel,
    order: Order,
    tolerance: f64,
    horizon: f64,
) -> Result<Design<FULL_TAPS, FULL_MODES>, DesignError> {
    let horizon = horizon.max(crate::full_memory::HORIZON_MIN);
    Design::pruned(kernel, order, tolerance, horizon)
}

impl Scheme {
    /// Builds the operator. A full memory is designed for `horizon` samples, at least 100, with the fewest modes
    /// that the tolerance allows.
    ///
    /// # Errors
    /// A parameter outside its range, an unreachable tolerance, or the scheme `exact`.
    pub fn build<F: Real>(
        self,
        order: Order,
        sample_time: Seconds,
        horizon: f64,
    ) -> Result<Operator<F>, SchemeError> {
        Ok(match self {
            Self::Grunwald { length } if length > SHORT_MOST => {
                Operator::PartitionedMemory(PartitionedMemory::new(order, length, sample_time)?)
            }
            Self::Grunwald { length } => {
                Operator::ShortMemory(ShortMemoryVec::new(order, length, sample_time)?)
            }
            Self::Muir { degree } => Operator::MuirPolynomial(Box::new(
                MuirPolynomial::with_degree(order, degree, sample_time)?,
            )),
            Self::TustinMuir { degree } => Operator::TustinMuir(Box::new(TustinMuir::with_degree(
                order,
                degree,
                sample_time,
            )?)),
            Self::Oustaloup { sections, band } => Operator::Oustaloup(Box::new(
                Oustaloup::with_sections(order, sections, band, sample_time)?,
            )),
            Self::Full { kernel, tolerance } => {
                let design = pruned(kernel, order, tolerance, horizon)?;
                Operator::FullMemory(Box::new(FullMemory::new(&design, sample_time)?))
            }
            Self::FullBdf2 { tolerance } => {
                let design = pruned(Kernel::Grunwald, order, tolerance, horizon)?;
                Operator::Bdf2Memory(Box::new(Bdf2Memory::new(&design, sample_time)?))
            }
            Self::Exact => return Err(SchemeError::AnalysisOnly),
        })
    }

    /// The defining sum of the scheme over whole records, cut only by `grunwald:N` and regardless of the tolerance.
    /// `None` for `muir`, `tustin-muir` and `oustaloup`, which have none.
    ///
    /// ```
    /// use fracdiff::{Order, Scheme, Seconds};
    ///
    /// let (half, t) = (Order::new(0.5)?, Seconds(1.0));
    /// let sum = Scheme::Exact.batch(half, t)?.ok_or("no sum")?;
    /// assert!((sum.run(&[1.0, 0.0])[1] + 0.5).abs() < 1e-15); // c₁ = −μ
    /// assert_eq!("muir:3".parse::<Scheme>()?.batch(half, t)?, None);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// A sample time or a length outside its range.
    pub fn batch(self, order: Order, sample_time: Seconds) -> Result<Option<Batch>, SchemeError> {
        let batch = match self {
            Self::Exact => Batch::full_history(Kernel::Grunwald, order, sample_time),
            Self::Full { kernel, .. } => Batch::full_history(kernel, order, sample_time),
            Self::FullBdf2 { .. } => Batch::full_bdf2(order, sample_time),
            Self::Grunwald { length } => Batch::short_memory(order, length, sample_time),
            Self::Muir { .. } | Self::TustinMuir { .. } | Self::Oustaloup { .. } => {
                return Ok(None);
            }
        };
        Ok(Some(batch?))
    }

    /// ε of the full memory that [`build`](Self::build) makes, see [`Design::error_bound`]; `None` for the other schemes.
    ///
    /// # Errors
    /// As [`build`](Self::build).
    pub fn error_bound(self, order: Order, horizon: f64) -> Result<Option<f64>, SchemeError> {
        let Self::Full { kernel, tolerance } = self else {
            return Ok(None);
        };
        let design = pruned(kernel, order, tolerance, horizon)?;
        Ok(Some(design.error_bound()))
    }
}
