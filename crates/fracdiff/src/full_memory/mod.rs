//! Full memory: recent taps exactly, everything older as a sum of decaying modes.
//!
//! A power law is a sum of exponentials. For −1 < φ < 1 the weights of D^φ are moments of a density
//! that does not change sign,
//!
//! ```text
//! c_j = −(sin πφ/π) ∫₀^∞ e^(−js) ρ(s) ds ≈ ∓ Σ_q w_q·e^(−j·s_q),     w_q > 0,  j ≥ L
//! ρ(s) = e^(φs)(1 − e^(−s))^φ    Grünwald        ρ(s) = s^(φ−2)(2 sinh(s/2))²    piecewise linear
//! ```
//! so the first L = TAPS weights are kept as they are, and the rest of a history of any length is a
//! few dozen first-order modes: all weights of one sign, all poles in (0, 1), stable by construction.
//! [`Design`] finds them for a tolerance and a horizon, and says what it reached; [`FullMemory`] runs
//! them. Orders outside (−1, 1) are split, D^μ = D^n D^φ, and the integer part taken exactly.

mod bank;
mod design;
mod kernel;
#[cfg(feature = "std")]
mod prune;

pub(crate) use bank::{Bank, PORTABLE_TAPS};
pub use bank::{BankHistory, FullMemory, FullMemoryHistory};
pub use design::{Design, DesignError};
pub use kernel::Kernel;

/// Smallest tolerance a design accepts.
pub const TOLERANCE_MIN: f64 = 1e-11;
/// Largest tolerance a design accepts.
pub const TOLERANCE_MAX: f64 = 0.1;
/// Shortest horizon a design accepts, samples.
pub const HORIZON_MIN: f64 = 1e2;
/// Longest horizon a design accepts, samples: 31 years at 1 kHz.
pub const HORIZON_MAX: f64 = 1e12;
