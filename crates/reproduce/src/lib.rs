//! The dissertation, made again: its figures as data and pictures, its claims judged by computing.
//!
//! Parameters are the dissertation's; where it gives none, the choice stands with the figure. Its
//! chapters use different operators, so each claim is judged with that of its own chapter. Where that is
//! not (1 − w)^μ, the same is computed with (1 − w)^μ beside it.

pub mod claims;
mod evidence;
pub mod figure;
pub mod figures;
mod relaxation;
pub mod report;
mod trial;
mod walls;

pub use claims::Claim;

use fracdiff::{Band, FrequencyResponse, Order, Scheme, Seconds};
use haptic_analysis::num_complex::Complex;
use haptic_analysis::{AnalysisError, LoopOperator};
use std::f64::consts::PI;

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
    /// The third-order Muir polynomial (4.2), of chapter 4 alone.
    Muir,
    /// (1 − w)^μ, of chapters 3 and 5; in a loop that runs, full memory.
    Exact,
    /// s^μ, of chapters 1 and 6.
    Continuous,
    /// Oustaloup's, which is of the kind of chapter 7: fitted over frequencies, then discretised.
    Oustaloup,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::Muir => "A₃",
            Self::Exact => "(1 − w)^μ",
            Self::Continuous => "s^μ",
            Self::Oustaloup => "Oustaloup's operator",
        }
    }

    /// Scheme with which a loop samples it: s^μ by (1 − w)^μ, which is s^μ but for the sampling.
    fn scheme(self) -> Scheme {
        let band = Band {
            low_hz: 1e-5,
            high_hz: 100.0,
        };
        match self {
            Self::Muir => Scheme::Muir { degree: 3 },
            Self::Exact | Self::Continuous => Scheme::Exact,
            Self::Oustaloup => Scheme::Oustaloup { sections: 9, band },
        }
    }

    /// The operator of an order, 0 to 2, as a loop samples it.
    fn operator(self, mu: f64) -> Result<LoopOperator, AnalysisError> {
        LoopOperator::new(self.scheme(), Order::new(mu)?, Seconds(1.0), 1e3)
    }

    /// The operator itself over θ, s^μ unsampled.
    fn response(self, mu: f64) -> Result<Box<dyn FrequencyResponse>, AnalysisError> {
        Ok(match self {
            Self::Continuous => Box::new(Unsampled(mu)),
            Self::Muir | Self::Exact | Self::Oustaloup => Box::new(self.operator(mu)?),
        })
    }

    /// The line of a document that runs it; nothing runs (1 − w)^μ itself, and full memory comes closest.
    fn line(self) -> String {
        match self {
            Self::Exact | Self::Continuous => String::new(),
            Self::Muir | Self::Oustaloup => format!("scheme = \"{}\"\n", self.scheme()),
        }
    }
}

/// s^μ at s = jθ, one sample long.
struct Unsampled(f64);

impl FrequencyResponse for Unsampled {
    fn response(&self, theta: f64) -> Complex<f64> {
        Complex::from_polar(libm::pow(theta, self.0), 0.5 * PI * self.0)
    }
}
