//! The models that are fitted, as elements and how they are joined.

use super::error::IdentifyError;
use crate::model::ModelKind;
use num_complex::Complex64;

/// The most elements of a candidate.
pub(super) const ELEMENTS: usize = 3;
/// The most variables: modulus and order of two spring-pots, modulus of a spring.
pub(super) const VARIABLES: usize = 5;

/// The models that are fitted, those with few parameters first.
pub const CANDIDATES: [ModelKind; 5] = [
    ModelKind::SpringPot,
    ModelKind::FractionalKelvinVoigt,
    ModelKind::FractionalMaxwell,
    ModelKind::FractionalZener,
    ModelKind::FractionalPoyntingThomson,
];

/// How the elements of a model that is fitted are joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Candidate {
    SpringPot,
    FractionalKelvinVoigt,
    FractionalMaxwell,
    FractionalZener,
    FractionalPoyntingThomson,
}

impl Candidate {
    #[cfg(test)]
    pub(super) const ALL: [Self; 5] = [
        Self::SpringPot,
        Self::FractionalKelvinVoigt,
        Self::FractionalMaxwell,
        Self::FractionalZener,
        Self::FractionalPoyntingThomson,
    ];

    /// That of a kind of model.
    pub(super) fn of(kind: ModelKind) -> Result<Self, IdentifyError> {
        match kind {
            ModelKind::SpringPot => Ok(Self::SpringPot),
            ModelKind::FractionalKelvinVoigt => Ok(Self::FractionalKelvinVoigt),
            ModelKind::FractionalMaxwell => Ok(Self::FractionalMaxwell),
            ModelKind::FractionalZener => Ok(Self::FractionalZener),
            ModelKind::FractionalPoyntingThomson => Ok(Self::FractionalPoyntingThomson),
            _ => Err(IdentifyError::Record(format!(
                "{kind} is not fitted by itself: take the fractional model that it is a case of; one of {}",
                CANDIDATES.map(ModelKind::name).join(", ")
            ))),
        }
    }

    pub(super) const fn kind(self) -> ModelKind {
        match self {
            Self::SpringPot => ModelKind::SpringPot,
            Self::FractionalKelvinVoigt => ModelKind::FractionalKelvinVoigt,
            Self::FractionalMaxwell => ModelKind::FractionalMaxwell,
            Self::FractionalZener => ModelKind::FractionalZener,
            Self::FractionalPoyntingThomson => ModelKind::FractionalPoyntingThomson,
        }
    }

    /// Number of spring-pots.
    pub(super) const fn pots(self) -> usize {
        match self {
            Self::SpringPot => 1,
            _ => 2,
        }
    }

    /// True if there is a spring beside or behind them.
    pub(super) const fn has_spring(self) -> bool {
        matches!(
            self,
            Self::FractionalZener | Self::FractionalPoyntingThomson
        )
    }

    /// Number of parameters.
    pub(super) const fn parameters(self) -> usize {
        self.kind().parameters().len()
    }

    /// M and its derivatives by the moduli of the elements e₁, e₂ and the spring e₃.
    pub(super) fn join(self, e: [Complex64; ELEMENTS]) -> (Complex64, [Complex64; ELEMENTS]) {
        let (one, zero) = (Complex64::new(1.0, 0.0), Complex64::new(0.0, 0.0));
        match self {
            Self::SpringPot => (e[0], [one, zero, zero]),
            Self::FractionalKelvinVoigt => (e[0] + e[1], [one, one, zero]),
            Self::FractionalMaxwell | Self::FractionalZener => {
                // 1/M = 1/e₁ + 1/e₂, so ∂M/∂e₁ = (e₂/(e₁ + e₂))².
                let inverse = (e[0] + e[1]).inv();
                let (first, second) = (e[1] * inverse, e[0] * inverse);
                let series = e[0] * first;
                let derivatives = [first * first, second * second];
                if self.has_spring() {
                    (series + e[2], [derivatives[0], derivatives[1], one])
                } else {
                    (series, [derivatives[0], derivatives[1], zero])
                }
            }
            Self::FractionalPoyntingThomson => {
                let side_by_side = e[0] + e[1];
                let inverse = (side_by_side + e[2]).inv();
                let (soft, spring) = (e[2] * inverse, side_by_side * inverse);
                (
                    side_by_side * soft,
                    [soft * soft, soft * soft, spring * spring],
                )
            }
        }
    }
}
