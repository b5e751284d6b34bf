//! Tuning of PI^λD^μ, with the best PID of order 1 beside it.
//! ```text
//! C(s_c)·G(jω_c) = e^(j(φ_m − π))                             crossover and phase margin: two real equations
//! Im(C′/C + G′/G) = ψ at ω_c, over ln ω                       slope of the phase: ψ = 0 is iso-damping
//! ```
//! For given orders λ and μ all three are linear in `K_p`, `K_i` and `K_d`: they are met exactly, by a 3 × 3 system. The rest is a search over λ
//! and μ (and ψ, if the phase need not be flat) for the inequalities, and among what meets them for the overshoot that changes least
//! while the gain goes from half to double. The PID of order 1 is the same search with λ = μ = 1 over ψ.
//!
//! Source: C. A. Monje, B. M. Vinagre, V. Feliu, Y. Chen, *Tuning and auto-tuning of fractional order controllers for
//! industry applications*, Control Engineering Practice 16, 2008, whose five equations these are.

mod open_loop;
mod search;
mod specification;

pub use open_loop::Measures;
pub use search::{Tuned, tune, tune_integer};
pub use specification::{Bound, GAINS, Sampling, Specification, Wish, WishName, steps};
