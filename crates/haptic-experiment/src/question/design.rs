//! The designer's question: what is the most that a device can render, and with which order μ?
//!
//! For each order of a grid the best wall under a requirement is computed, not searched by trying:
//!
//! ```text
//! stable    (gα, gβ) on the boundary of the stability region, so that the wall as a whole may grow by
//!           the gain margin g before it is unstable, or shrink by it; the region by D-decomposition
//! passive   δ > sup_θ (α·u + β·v), Theorem 1 for the operator really used. The right side grows in
//!           proportion to the wall, so α = δ/sup(u + t·v) for a given t = β/α, and that sup is convex
//!           in t: its minimum by golden sections gives the largest α, and the same with roles
//!           exchanged the largest β
//! ```
//! - *Stiffest wall*: the largest α, with the β that allows it.
//! - *Most damping* at ω: the largest β, since the effective damping Im H/ω grows with B alone. The
//!   very largest β leaves no choice of α, and at α = 0 the device creeps away. So β is 99 % of it, and
//!   α is in the middle of what that leaves.
//! - *Tissue*: K, B and μ are given by tissue and specimen; the question is by which factor the
//!   specimen may grow. For other orders K is the same, and B makes |B·s^μ| the same at a frequency.
//!
//! - *Noise*: steps q of the encoder make a noise of the force, rms B·(q/√12)·T^(−μ)·√Σc², c the weights
//!   of the operator. A limit on it is a limit on B.
//! - *The device* is the one on the desk: delay and current lag are in the analysis, friction and encoder in
//!   the trial. If none is given an ideal device is assumed, and the trial on a realistic one stands beside.
//!
//! A wall "on the boundary" is made a ten-thousandth weaker, because Theorem 1 is strict.

mod answer;
mod bench;
mod candidate;
mod comparison;
pub mod coupler;
pub(crate) mod keys;
mod names;
mod noise;
mod passive;
mod question;
pub(crate) mod reading;
mod stable;
mod trial;

pub use candidate::{Candidate, DesignReport, RealisticTrial, TissueVerdict};
pub(crate) use names::{RequireName, WishName};
pub use question::{Design, Device, Requirement, Wish};
