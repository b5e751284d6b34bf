//! The dissertation, made again: every figure as data and picture, every claim computed twice.
//!
//! Parameters are the dissertation's; where it gives none, the choice stands with the figure. Each
//! claim is computed with the dissertation's A₃ and with the exact operator, and the verdict follows
//! from the two.

pub mod claims;
mod evidence;
pub mod figure;
pub mod figures;
mod relaxation;
pub mod report;
mod walls;

pub use claims::Claim;

use fracdiff::{Order, Scheme, Seconds};
use haptic_analysis::{AnalysisError, LoopOperator};

/// Device of section 4.4: m = 65 g, b = 3.5 N·s/m, T = 2 ms.
const MASS_KG: f64 = 0.065;
const DAMPING_N_S_PER_M: f64 = 3.5;
const SAMPLE_TIME_S: f64 = 0.002;
/// δ = bT/m of that device: 0.10769.
const DELTA: f64 = DAMPING_N_S_PER_M * SAMPLE_TIME_S / MASS_KG;
/// The orders the dissertation draws.
const ORDERS: [f64; 5] = [0.0, 0.5, 1.0, 1.5, 2.0];

/// Operator that a claim is computed with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// The dissertation's third-order Muir polynomial (4.2).
    Muir,
    /// (1 − w)^μ itself.
    Exact,
}

impl Kind {
    /// The operator of an order, 0 to 2.
    fn operator(self, mu: f64) -> Result<LoopOperator, AnalysisError> {
        let scheme = match self {
            Self::Muir => Scheme::Muir { degree: 3 },
            Self::Exact => Scheme::Exact,
        };
        LoopOperator::new(scheme, Order::new(mu)?, Seconds(1.0), 1e3)
    }
}
