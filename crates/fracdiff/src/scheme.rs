//! Choosing an operator at run time: the names that command lines and experiment files use.
//! ```text
//! grunwald:N                     the N newest samples, N up to 2²⁰              ShortMemory
//! muir:N                         Muir polynomial of degree N alone            MuirPolynomial
//! tustin-muir:N                  recursive form of degree N                   TustinMuir
//! oustaloup:N:LOW_HZ:HIGH_HZ     N first-order sections between two corners   Oustaloup
//! full[:TOLERANCE]               full memory, Grünwald kernel                 FullMemory
//! piecewise-linear[:TOLERANCE]   full memory, Caputo L1 kernel                FullMemory
//! full-bdf2[:TOLERANCE]          full memory of second order in T             Bdf2Memory
//! exact                          (1 − w)^μ, for analysis only                 ExactDifference
//! ```

use crate::batch::Batch;
use crate::differintegrator::one_of;
use crate::full_memory::{Design, DesignError, HORIZON_MIN, Kernel, check_tolerance};
use crate::list::Form;
use crate::order::check_length;
use crate::{
    Band, Bdf2History, Bdf2Memory, Differintegrator, FirHistory, FrequencyResponse, FullMemory,
    FullMemoryHistory, MuirPolynomial, Order, Oustaloup, OustaloupHistory, ParameterError, Real,
    Seconds, ShortHistoryVec, ShortMemoryVec, ShortQuotient, ShortQuotientHistory, TustinMuir,
    TustinMuirHistory,
};
use core::fmt;
use core::str::FromStr;
use num_complex::Complex;
use std::boxed::Box;
use std::string::{String, ToString};
use std::vec::Vec;

/// Largest degree or number of sections a scheme accepts.
pub const DEGREE_MAX: usize = 64;
/// Recent samples that a full memory keeps as they are.
pub const FULL_TAPS: usize = 16;
/// Room for modes: enough for a tolerance of 1e-11 over 1e12 samples.
pub const FULL_MODES: usize = 112;
/// Default tolerance of `full`, `piecewise-linear` and `full-bdf2`.
pub const DEFAULT_TOLERANCE: f64 = 1e-6;

/// An operator by name and parameters, without order and sample time.
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
        /// N, the number of samples that are remembered.
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
        /// N, the number of first-order sections.
        sections: usize,
        /// The band in which the phase of the power is met.
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

/// Each scheme as it is written, and a few words.
const GRAMMAR: &str =
    "  full[:TOLERANCE]              full memory, Gruenwald kernel (default, tolerance 1e-6)
  piecewise-linear[:TOLERANCE]  full memory, Caputo L1 kernel
  full-bdf2[:TOLERANCE]         full memory, second order in the sample time; not on a device
  grunwald:N                    ring buffer of the last N samples
  tustin-muir:N                 recursive filter of degree N
  oustaloup:N:LOW_HZ:HIGH_HZ    N first-order sections in a frequency band
  muir:N                        polynomial A_N of the dissertation's chapter 4, for comparison
  exact                         the exact operator (1 - w)^mu, for analysis only
";

/// The schemes as they are written, for a sentence.
fn known() -> String {
    let first = |line: &'static str| line.split_whitespace().next();
    GRAMMAR
        .lines()
        .filter_map(first)
        .collect::<Vec<_>>()
        .join(", ")
}

/// Error of reading or building a scheme.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SchemeError {
    /// An unknown name, or missing or surplus parameters.
    #[error("scheme \"{}\" is not one of {}", .0, known())]
    Unknown(String),
    /// A parameter that is not a number.
    #[error("\"{0}\" in the scheme is not a number that may stand there")]
    NotANumber(String),
    /// A parameter outside its range.
    #[error("{0}: change it")]
    Parameter(#[from] ParameterError),
    /// No full memory has this tolerance and horizon.
    #[error(transparent)]
    Design(#[from] DesignError),
    /// `exact` cannot run as a filter.
    #[error("scheme exact is for analysis only: use full or piecewise-linear")]
    AnalysisOnly,
}

impl FromStr for Scheme {
    type Err = SchemeError;

    fn from_str(text: &str) -> Result<Self, SchemeError> {
        let mut parts = text.split(':');
        let name = parts.next().unwrap_or_default();
        let parameters: std::vec::Vec<&str> = parts.collect();
        let degree = |text| {
            let degree = number(text)?;
            Ok(check_length("polynomial degree", degree, DEGREE_MAX)?)
        };
        match (name, parameters.as_slice()) {
            ("grunwald", [length]) => {
                let most = ShortMemoryVec::<f64>::MOST;
                let length = check_length("memory length", number(length)?, most)?;
                Ok(Self::Grunwald { length })
            }
            ("muir", [text]) => degree(text).map(|degree| Self::Muir { degree }),
            ("tustin-muir", [text]) => degree(text).map(|degree| Self::TustinMuir { degree }),
            ("oustaloup", [sections, low_hz, high_hz]) => Ok(Self::Oustaloup {
                sections: check_length("number of sections", number(sections)?, DEGREE_MAX)?,
                band: Band {
                    low_hz: number(low_hz)?,
                    high_hz: number(high_hz)?,
                },
            }),
            ("exact", []) => Ok(Self::Exact),
            (name, rest @ ([] | [_])) => {
                let tolerance = |rest: &[&str]| match rest {
                    [text] => Ok(check_tolerance(number(text)?)?),
                    _ => Ok(DEFAULT_TOLERANCE),
                };
                let full = |kernel| {
                    Ok(Self::Full {
                        kernel,
                        tolerance: tolerance(rest)?,
                    })
                };
                match name {
                    "full" => full(Kernel::Grunwald),
                    "piecewise-linear" => full(Kernel::PiecewiseLinear),
                    "full-bdf2" => tolerance(rest).map(|tolerance| Self::FullBdf2 { tolerance }),
                    _ => Err(SchemeError::Unknown(text.to_string())),
                }
            }
            _ => Err(SchemeError::Unknown(text.to_string())),
        }
    }
}

fn number<T: FromStr>(text: &str) -> Result<T, SchemeError> {
    let parsed = text.trim().parse();
    parsed.map_err(|_| SchemeError::NotANumber(text.to_string()))
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
            Self::Full { kernel, tolerance } => {
                let name = match kernel {
                    Kernel::Grunwald => "full",
                    Kernel::PiecewiseLinear => "piecewise-linear",
                };
                write!(f, "{name}:{tolerance:e}")
            }
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
    let horizon = horizon.max(HORIZON_MIN);
    Design::pruned(kernel, order, tolerance, horizon)
}

impl Scheme {
    /// A line for each scheme: how it is written, and a few words.
    #[must_use]
    pub const fn help() -> &'static str {
        GRAMMAR
    }

    /// Length of the past that counts, s: `None` means the whole past. For the recursive forms it is
    /// the time that their slowest part takes to fade, about one period of the lower corner or N
    /// samples.
    #[must_use]
    pub fn memory_s(self, sample_time: Seconds) -> Option<f64> {
        let t = sample_time.0;
        match self {
            Self::Grunwald { length } => Some(length as f64 * t),
            Self::Muir { degree } => Some((degree + 1) as f64 * t),
            Self::TustinMuir { degree } => Some(degree as f64 * t),
            Self::Oustaloup { band, .. } => Some(1.0 / band.low_hz),
            Self::Full { .. } | Self::FullBdf2 { .. } | Self::Exact => None,
        }
    }

    /// Builds the operator. A full memory is designed for `horizon` samples, at least 100, with the fewest modes that the tolerance allows.
    ///
    /// # Errors
    /// A parameter outside its range, an unreachable tolerance, or the scheme `exact`.
    pub fn build<F: Real>(
        self,
        order: Order,
        sample_time: Seconds,
        horizon: f64,
    ) -> Result<Operator<F>, SchemeError> {
        let t = sample_time;
        Ok(match self {
            Self::Grunwald { length } => {
                Operator::ShortMemory(ShortMemoryVec::new(order, length, t)?)
            }
            Self::Muir { degree } => {
                Operator::MuirPolynomial(Box::new(MuirPolynomial::with_degree(order, degree, t)?))
            }
            Self::TustinMuir { degree } => {
                Operator::TustinMuir(Box::new(TustinMuir::with_degree(order, degree, t)?))
            }
            Self::Oustaloup { sections, band } => {
                Operator::Oustaloup(Box::new(Oustaloup::new(order, sections, band, t)?))
            }
            Self::Full { kernel, tolerance } => {
                let design = pruned(kernel, order, tolerance, horizon)?;
                Operator::FullMemory(Box::new(FullMemory::new(&design, t)?))
            }
            Self::FullBdf2 { tolerance } => {
                let design = pruned(Kernel::Grunwald, order, tolerance, horizon)?;
                Operator::Bdf2Memory(Box::new(Bdf2Memory::new(&design, t)?))
            }
            Self::Exact => return Err(SchemeError::AnalysisOnly),
        })
    }

    /// The defining sum of the scheme over whole records, cut only by `grunwald:N` and regardless of the tolerance.
    /// `None` for `muir`, `tustin-muir` and `oustaloup`, which have none.
    ///
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

/// Any operator, chosen at run time; on the heap.
///
/// A history belongs to the operator that made it. Given the history of another kind, `output` is
/// NaN and `advance` does nothing: no panic in a sample path, and nothing that looks like a result.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Operator<F> {
    /// `grunwald:N`.
    ShortMemory(ShortMemoryVec<F>),
    /// `muir:N`.
    MuirPolynomial(Box<MuirPolynomial<F, DEGREE_MAX>>),
    /// `tustin-muir:N`.
    TustinMuir(Box<TustinMuir<F, DEGREE_MAX>>),
    /// `oustaloup:N:LOW_HZ:HIGH_HZ`.
    Oustaloup(Box<Oustaloup<F, DEGREE_MAX>>),
    /// `full` and `piecewise-linear`.
    FullMemory(Box<FullMemory<F, FULL_TAPS, FULL_MODES>>),
    /// `full-bdf2`.
    Bdf2Memory(Box<Bdf2Memory<F, FULL_TAPS, FULL_MODES>>),
    /// Several elements of `grunwald:N` in series.
    ShortQuotient(ShortQuotient<F>),
}

/// History of [`Operator`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = "F: Real"))]
#[non_exhaustive]
pub enum OperatorHistory<F> {
    /// History of `grunwald:N`.
    ShortMemory(ShortHistoryVec<F>),
    /// History of `muir:N`.
    MuirPolynomial(Box<FirHistory<F, DEGREE_MAX>>),
    /// History of `tustin-muir:N`.
    TustinMuir(Box<TustinMuirHistory<F, DEGREE_MAX>>),
    /// History of `oustaloup:N:LOW_HZ:HIGH_HZ`.
    Oustaloup(Box<OustaloupHistory<F, DEGREE_MAX>>),
    /// History of `full` and `piecewise-linear`.
    FullMemory(Box<FullMemoryHistory<F, FULL_TAPS, FULL_MODES>>),
    /// History of `full-bdf2`.
    Bdf2Memory(Box<Bdf2History<F, FULL_TAPS, FULL_MODES>>),
    /// History of `grunwald:N` of elements in series.
    ShortQuotient(ShortQuotientHistory<F>),
}

/// An operator as numbers, see [`portable`](crate::portable).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct OperatorList<F> {
    /// The meaning of the values.
    pub form: Form,
    /// Differences (> 0) or sums (< 0) around them.
    pub integer: i8,
    /// The values, in the order that the form has.
    pub values: Vec<F>,
    /// Coefficients of a finite impulse response behind it: those of `full-bdf2`, else none.
    pub filter: Vec<F>,
}

impl<F: Real> OperatorList<F> {
    /// Number of modes, fastest first, that are run without a compensation word, padding included; 0 for other forms.
    /// Whoever runs a list with other code needs it for the same bits.
    #[must_use]
    pub fn plain_modes(&self) -> usize {
        match self.form {
            Form::Modes => crate::full_memory::plain_modes(&self.values, self.integer.into()),
            Form::Taps | Form::Recursion => 0,
        }
    }
}

impl<F: Real> Operator<F> {
    /// The operator as numbers, for [`PortableOperator`](crate::PortableOperator). `None` for `full-bdf2`: no form of
    /// list holds its two parts, which [`OperatorList::from`] gives.
    #[must_use]
    pub fn list(&self) -> Option<OperatorList<F>> {
        Some(OperatorList::from(self)).filter(|list| list.filter.is_empty())
    }
}

impl<F: Real> From<&Operator<F>> for OperatorList<F> {
    fn from(operator: &Operator<F>) -> Self {
        let (form, (integer, values)) = match operator {
            Operator::ShortMemory(o) => (Form::Taps, (0, o.list())),
            Operator::MuirPolynomial(o) => (Form::Taps, (0, o.list())),
            Operator::TustinMuir(o) => (Form::Recursion, o.list()),
            Operator::ShortQuotient(o) => (Form::Recursion, (0, o.list())),
            Operator::Oustaloup(o) => (Form::Modes, o.list()),
            Operator::FullMemory(o) => return Self::from(&**o),
            Operator::Bdf2Memory(o) => return Self::from(&**o),
        };
        Self {
            form,
            // −2 to 2, as orders are.
            integer: integer as i8,
            values,
            filter: Vec::new(),
        }
    }
}

impl<F: Real, const MODES: usize> From<&FullMemory<F, FULL_TAPS, MODES>> for OperatorList<F> {
    fn from(memory: &FullMemory<F, FULL_TAPS, MODES>) -> Self {
        let (integer, values) = memory.list();
        Self {
            form: Form::Modes,
            integer: integer as i8,
            values,
            filter: Vec::new(),
        }
    }
}

impl<F: Real, const MODES: usize> From<&Bdf2Memory<F, FULL_TAPS, MODES>> for OperatorList<F> {
    fn from(operator: &Bdf2Memory<F, FULL_TAPS, MODES>) -> Self {
        let (memory, filter) = operator.parts();
        Self {
            filter: filter.to_vec(),
            ..Self::from(memory)
        }
    }
}

impl<F: Real> Differintegrator<F> for Operator<F> {
    type History = OperatorHistory<F>;

    one_of!(
        OperatorHistory, Differintegrator::advance:
        ShortMemory MuirPolynomial TustinMuir Oustaloup FullMemory Bdf2Memory ShortQuotient
    );
}

impl<F: Real> FrequencyResponse for Operator<F> {
    fn response(&self, theta: f64) -> Complex<f64> {
        match self {
            Self::ShortMemory(o) => o.response(theta),
            Self::MuirPolynomial(o) => o.response(theta),
            Self::TustinMuir(o) => o.response(theta),
            Self::Oustaloup(o) => o.response(theta),
            Self::FullMemory(o) => o.response(theta),
            Self::Bdf2Memory(o) => o.response(theta),
            Self::ShortQuotient(o) => o.response(theta),
        }
    }
}
