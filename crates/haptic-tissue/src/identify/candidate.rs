//! The models that are fitted, as elements and how they are joined.

use num_complex::Complex64;

/// The most elements of a candidate.
pub(super) const ELEMENTS: usize = 3;
/// The most variables: modulus and order of two spring-pots, modulus of a spring.
pub(super) const VARIABLES: usize = 5;

/// A model that can be fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Candidate {
    /// One spring-pot.
    SpringPot,
    /// Two spring-pots side by side.
    FractionalKelvinVoigt,
    /// Two spring-pots in series.
    FractionalMaxwell,
    /// A spring beside two spring-pots in series.
    FractionalZener,
    /// A spring in series with two spring-pots side by side.
    FractionalPoyntingThomson,
}

impl Candidate {
    /// All, those with few parameters first.
    pub const ALL: [Self; 5] = [
        Self::SpringPot,
        Self::FractionalKelvinVoigt,
        Self::FractionalMaxwell,
        Self::FractionalZener,
        Self::FractionalPoyntingThomson,
    ];

    /// Its name, as in a tissue file.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::SpringPot => "spring-pot",
            Self::FractionalKelvinVoigt => "fractional-kelvin-voigt",
            Self::FractionalMaxwell => "fractional-maxwell",
            Self::FractionalZener => "fractional-zener",
            Self::FractionalPoyntingThomson => "fractional-poynting-thomson",
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
    #[must_use]
    pub const fn parameters(self) -> usize {
        2 * self.pots() + self.has_spring() as usize
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
