//! Models of viscoelastic matter: springs, dashpots and spring-pots, side by side and in series.
//!
//! ```text
//! spring-pot                    σ = V·D^α ε             M(s) = V·s^α       a spring is α = 0, a dashpot α = 1
//! side by side: moduli add      M(s) = M₁(s) + M₂(s)
//! in series: compliances add    1/M(s) = 1/M₁(s) + 1/M₂(s)
//! ```
//! Source: A. Bonfanti, J. L. Kaplan, G. Charras, A. Kabla, *Fractional viscoelastic models for power-law materials*,
//! Soft Matter 16, 2020, whose names are used.

mod closed_form;
mod cut;
mod error;
mod exponentials;
mod form;
mod kind;
mod of_kind;
mod parameter;
mod pole;
mod prony;
mod record;
mod spectrum;
mod spring_pot;

pub use error::ModelError;
pub use form::{Form, MaxwellBranch, Model};
pub use kind::ModelKind;
pub use parameter::{Parameter, ParameterRange};
pub use spring_pot::SpringPot;
