//! A Prony series: its modulus is a sum of exponentials, and so is its compliance, at the zeros of the modulus.
//!
//! ```text
//! G(t) = E + Σ E_i·e^(−t/τ_i)
//! M(−r) = E − Σ E_i·rτ_i/(1 − rτ_i)          one zero r_k between any two rates 1/τ_i, and one below the first if E > 0
//! J(t) = 1/(E + ΣE_i) + t/η + Σ w_k·(1 − e^(−r_k·t)),   w_k = 1/Σ E_i·r_kτ_i/(1 − r_kτ_i)²,   1/η = 0 if E > 0, else η = ΣE_iτ_i
//! ```
//! Source: B. Gross, *Mathematical Structure of the Theories of Viscoelasticity*, 1953.

use super::exponentials::{Modes, Response, Spectrum};
use super::form::MaxwellBranch;

/// G as modes.
pub(super) fn relaxation(elastic_modulus_pa: f64, branches: &[MaxwellBranch]) -> Spectrum {
    // Rates rise as times fall.
    let modes = || branches.iter().rev();
    Spectrum {
        response: Response::Relaxation,
        constant: elastic_modulus_pa,
        slope: 0.0,
        modes: Modes::Any {
            rates: modes().map(|one| 1.0 / one.relaxation_time_s).collect(),
            weights: modes().map(|one| one.elastic_modulus_pa).collect(),
        },
        pair: None,
    }
}

/// J as modes.
pub(super) fn creep(elastic_modulus_pa: f64, branches: &[MaxwellBranch]) -> Spectrum {
    let instantaneous =
        (branches.iter()).fold(elastic_modulus_pa, |sum, one| sum + one.elastic_modulus_pa);
    let slope = if elastic_modulus_pa > 0.0 {
        0.0
    } else {
        1.0 / branches.iter().fold(0.0, |sum, one| {
            sum + one.elastic_modulus_pa * one.relaxation_time_s
        })
    };
    let mut rates = Vec::new();
    // From the slowest branch on: a zero below each rate, down to the rate before it.
    let mut below = if elastic_modulus_pa > 0.0 {
        Some(0.0)
    } else {
        None
    };
    for branch in branches.iter().rev() {
        let pole = 1.0 / branch.relaxation_time_s;
        if let Some(below) = below {
            rates.push(zero_between(elastic_modulus_pa, branches, below, pole));
        }
        below = Some(pole);
    }
    let weight = |r: &f64| {
        1.0 / branches.iter().fold(0.0, |sum, one| {
            let x = r * one.relaxation_time_s;
            sum + one.elastic_modulus_pa * x / ((1.0 - x) * (1.0 - x))
        })
    };
    Spectrum {
        response: Response::Creep,
        constant: 1.0 / instantaneous,
        slope,
        modes: Modes::Any {
            weights: rates.iter().map(weight).collect(),
            rates,
        },
        pair: None,
    }
}

/// M(−r) falls from +∞ (or E at 0) to −∞ between two rates.
fn zero_between(elastic_modulus_pa: f64, branches: &[MaxwellBranch], low: f64, high: f64) -> f64 {
    let modulus = |r: f64| {
        branches.iter().fold(elastic_modulus_pa, |sum, one| {
            let x = r * one.relaxation_time_s;
            sum - one.elastic_modulus_pa * x / (1.0 - x)
        })
    };
    let (mut low, mut high) = (low, high);
    // Halving the interval; towards 0 in the logarithm, so that a small zero has its digits too.
    loop {
        let middle = if low > 0.0 {
            libm::sqrt(low) * libm::sqrt(high)
        } else {
            high * 0.001
        };
        if middle <= low || middle >= high {
            return high;
        }
        if modulus(middle) > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
}
