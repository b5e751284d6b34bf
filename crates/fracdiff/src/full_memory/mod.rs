//! Full memory: recent taps exactly, everything older as a sum of decaying modes.
//!
//! With n = ⌈μ⌉ and ν = n − μ, (1 − w)^μ = (1 − w)^n·(1 − w)^(−ν): the operator is a fractional integral of order 0 ≤ ν < 1 of the n-th
//! difference. Its weights are positive and a power law, and a power law is a sum of exponentials: they are moments of a positive density,
//! ```text
//! c_j = (sin πν/π) ∫₀^∞ e^(−js) ρ(s) ds ≈ Σ_q w_q·e^(−j·s_q),     w_q > 0,  j ≥ L
//! ρ(s) = (e^s − 1)^(−ν)                 Grünwald
//! ρ(s) = s^(−1−ν)(1 − e^(−s))           piecewise linear, μ > 0
//! ρ(s) = s^(−2−ν)(2 sinh(s/2))²         piecewise linear, −1 < μ ≤ 0
//! ```
//! so the first L = TAPS weights are kept as they are, and the rest of a history of any length is a few dozen first-order modes: all
//! weights positive, all poles in (0, 1), stable by construction. [`Design`] finds them for a tolerance and a horizon, and says what it
//! reached; [`FullMemory`] runs them. Differences, and for μ ≤ −1 sums, are taken exactly. So P(1) = 0 for every μ > 0, nothing large
//! cancels, and for μ ≤ 1 every mode (1 − w)/(1 − pw) is passive.

mod bank;
mod design;
#[cfg(feature = "std")]
mod exchange;
#[cfg(feature = "std")]
mod fitted;
mod kernel;
#[cfg(feature = "std")]
mod memory;
#[cfg(feature = "std")]
mod nnls;

pub use crate::order::HORIZON_MIN;
#[cfg(feature = "std")]
pub(crate) use bank::plain_modes;
pub(crate) use bank::{Bank, PORTABLE_TAPS};
pub use bank::{BankHistory, FullMemory, FullMemoryHistory};
#[cfg(feature = "std")]
pub(crate) use design::check_tolerance;
pub use design::{Design, DesignError};
pub use kernel::{DecayingMode, Kernel};
#[cfg(feature = "std")]
pub use memory::{Memory, MemoryWeights};
#[cfg(feature = "std")]
pub use nnls::{nearly_least_squares, non_negative_least_squares};
