#![doc = include_str!("../README.md")]
#![no_std]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]
#[cfg(feature = "alloc")]
extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

#[cfg(feature = "std")]
pub mod batch;
mod bdf2;
mod differintegrator;
#[cfg(feature = "std")]
mod eigenvalues;
#[cfg(feature = "std")]
mod fft;
mod fir;
pub mod full_memory;
mod integer_part;
#[cfg(feature = "std")]
mod linear_motion;
mod list;
mod muir;
mod order;
mod oustaloup;
pub mod parameter;
pub mod portable;
mod real;
mod response;
#[cfg(feature = "std")]
mod roots;
#[cfg(feature = "serde")]
mod saved;
#[cfg(feature = "std")]
pub mod scheme;
mod short_memory;
#[cfg(feature = "alloc")]
mod short_quotient;
mod tustin_muir;
mod weights;

pub use bdf2::{BDF2_TAPS, Bdf2History, Bdf2Memory, bdf2_short_filter};
pub use differintegrator::{Channel, Differintegrator};
#[cfg(feature = "std")]
pub use eigenvalues::eigenvalues;
pub use fir::{Fir, FirHistory};
pub use full_memory::{FullMemory, FullMemoryHistory};
pub use integer_part::IntegerHistory;
#[cfg(feature = "std")]
pub use linear_motion::linear_motion;
pub use muir::{MuirPolynomial, muir_coefficients};
/// The crate of [`Complex`](num_complex::Complex), which responses are.
pub use num_complex;
pub use order::{Order, ParameterError, Seconds};
pub use oustaloup::{Band, Oustaloup, OustaloupHistory};
pub use portable::PortableOperator;
pub use real::Real;
pub use response::{ExactDifference, FrequencyResponse};
#[cfg(feature = "std")]
pub use roots::{product, roots};
#[cfg(feature = "std")]
pub use scheme::{Operator, OperatorHistory, OperatorList, Scheme, SchemeError};
pub use short_memory::ShortMemory;
#[cfg(feature = "alloc")]
pub use short_memory::{ShortHistoryVec, ShortMemoryVec};
#[cfg(feature = "alloc")]
pub use short_quotient::{ShortQuotient, ShortQuotientHistory};
pub use tustin_muir::{RecursionHistory, TustinMuir, TustinMuirHistory};
pub use weights::{grunwald_weight, grunwald_weights, piecewise_linear_weight};
