//! Models for programs that know Prony series only: finite-element programs, above all.
//!
//! ```text
//! G(t) ≈ E + Σ E_i·e^(−t/τ_i),   E, E_i ≥ 0,   shortest ≤ t ≤ horizon
//! ```

mod fit;
mod text;

pub use fit::{ExportError, PronyFit};
pub use text::ExportFormat;
