//! A fractional virtual coupler: a device is pushed and thrown into it, an object behind it moves, and all comes to rest or not.
//!
//! ```text
//! m·x'' + b·x' + k·x = push − F,   F = Z_c·(v_h − v_e) = Z_o·v_e through the safety chain,   x(0) = 0, x'(0) = impact
//! Z_c = k_c + b_c·(T/(1 − w))^μ, 0 ≤ μ ≤ 1,   Z_o: mass m_o, damping b_o, spring k_o to the ground
//! at rest, μ = 1: x = push/(k + 1/(1/b_c + 1/k_o)), the object at F/k_o
//! ```
//! - *Below order 1* nothing holds the push: the coupler creeps as t^(1−μ) under it. There is no place of rest then, and the force
//!   alone is verdict, as for a wall without a spring.
//! - *The rule* by which all is at rest is that of a wall, [`settling`](crate::judge::settling).
//! - *Before the run* Llewellyn's criterion and the sampled loop are looked at, see [`CouplerPreflight`].
//! - *The object* is in no log: it follows from the positions, and the table of the run has it.
//! - *A loop on a device* cannot carry it: its firmware renders walls. The loop on the host can.
//!
//! Source: O. Tokatlı, *Fractional Order Control in Haptics*, chapter V.

pub(crate) mod keys;
mod preflight;
pub(crate) mod reading;
mod report;
mod running;
mod specification;
mod verdict;

pub use report::{CouplerCurves, CouplerReport};
pub use specification::CouplerExperiment;
