//! How two elements are joined, and all that follows from it: a new joint is written here, its kinds and their parameters
//! in [`kind`](super::kind).

use super::spring_pot::{Response, SpringPot, inverse};
use super::zeros::{Pole, Term, beside_the_cut};
use num_complex::Complex64;

/// How two elements, and a spring where the model has one, are joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Joint {
    KelvinVoigt,
    Maxwell,
    Zener,
    PoyntingThomson,
}

/// Two elements, orders α > β.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Two {
    pub(crate) joint: Joint,
    pub(crate) first: SpringPot,
    pub(crate) second: SpringPot,
    /// E of the spring that Zener and Poynting–Thomson models have, Pa; else 0.
    pub(crate) spring_pa: f64,
}

impl Joint {
    /// The model from its two elements and the spring, by what side by side and in series mean for them: moduli, limits and
    /// the sums of a sampled model all come from this one definition.
    pub(crate) fn of<T>(
        self,
        [first, second, spring]: [T; 3],
        beside: impl Fn(T, T) -> T,
        series: impl Fn(T, T) -> T,
    ) -> T {
        match self {
            Self::KelvinVoigt => beside(first, second),
            Self::Maxwell => series(first, second),
            Self::Zener => beside(series(first, second), spring),
            Self::PoyntingThomson => series(beside(first, second), spring),
        }
    }

    /// The function of time that is the sum of those of the two elements, if one is.
    pub(super) const fn sum(self) -> Option<Response> {
        match self {
            Self::KelvinVoigt => Some(Response::Relaxation),
            Self::Maxwell => Some(Response::Creep),
            Self::Zener | Self::PoyntingThomson => None,
        }
    }

    /// M and its derivatives by the moduli of the elements and of the spring.
    #[cfg(feature = "identify")]
    pub(crate) fn slopes(self, moduli: [Complex64; 3]) -> (Complex64, [Complex64; 3]) {
        // A modulus, and its derivatives by those that it is made of.
        type Part = (Complex64, [Option<Complex64>; 3]);
        let part = |element: usize| -> Part {
            let mut slopes = [None; 3];
            slopes[element] = Some(Complex64::new(1.0, 0.0));
            (moduli[element], slopes)
        };
        let either = |a: Part, b: Part| [0, 1, 2].map(|n| a.1[n].or(b.1[n]));
        let beside = |a: Part, b: Part| (a.0 + b.0, either(a, b));
        let series = |a: Part, b: Part| {
            // 1/M = 1/a + 1/b, so ∂M/∂a = (b/(a + b))².
            let inverse = (a.0 + b.0).inv();
            let shares = [b.0 * inverse, a.0 * inverse];
            let by = |part: Part, share: Complex64| {
                (
                    part.0,
                    part.1.map(|slope| slope.map(|one| one * (share * share))),
                )
            };
            let slopes = either(by(a, shares[0]), by(b, shares[1]));
            (a.0 * shares[0], slopes)
        };
        let (modulus, slopes) = self.of([part(0), part(1), part(2)], beside, series);
        (modulus, slopes.map(Option::unwrap_or_default))
    }
}

impl Two {
    /// The pole of M or 1/M beside the cut.
    pub(super) fn pole(&self, response: Response) -> Option<Pole> {
        let (first, second, spring_pa) = (self.first, self.second, self.spring_pa);
        let term = |factor: f64, power: f64| Term { factor, power };
        match (self.joint, response) {
            // V·s^α + G·s^β = 0, that is G + V·s^(α−β) = 0
            (Joint::Maxwell | Joint::Zener, Response::Relaxation)
            | (Joint::KelvinVoigt | Joint::PoyntingThomson, Response::Creep) => {
                let leading = term(first.size, first.order - second.order);
                beside_the_cut(second.size, leading, None)
            }
            // E + V·s^α + G·s^β = 0
            (Joint::PoyntingThomson, Response::Relaxation) => {
                let lower = term(second.size, second.order);
                beside_the_cut(spring_pa, term(first.size, first.order), Some(lower))
            }
            // E + K₁K₂/(K₁ + K₂) = 0, times (K₁ + K₂)/(V·s^β): EG/V + G·s^α + E·s^(α−β) = 0
            (Joint::Zener, Response::Creep) => {
                let (v, g) = (first.size, second.size);
                let constant = spring_pa * (g / v);
                if second.is_spring() {
                    return beside_the_cut(constant, term(g + spring_pa, first.order), None);
                }
                let lower = term(spring_pa, first.order - second.order);
                beside_the_cut(constant, term(g, first.order), Some(lower))
            }
            (Joint::KelvinVoigt, Response::Relaxation) | (Joint::Maxwell, Response::Creep) => None,
        }
    }

    /// The residue of M or 1/M in ln s at its [`pole`](Self::pole).
    pub(super) fn residue(&self, response: Response, pole: Pole) -> Complex64 {
        let at = |one: &SpringPot| one.modulus_at(pole.ln_r, pole.half_turns());
        let (k1, k2, e) = (at(&self.first), at(&self.second), self.spring_pa);
        let (a, b) = (self.first.order, self.second.order);
        let side_by_side = k1 * a + k2 * b;
        let in_series = inverse(k1) * a + inverse(k2) * b;
        match (self.joint, response) {
            // M = 1/(1/K₁ + 1/K₂), with a spring or without
            (Joint::Maxwell | Joint::Zener, Response::Relaxation) => -inverse(in_series),
            // M = E + 1/(1/K₁ + 1/K₂), the second part is −E
            (Joint::Zener, Response::Creep) => inverse(in_series * (e * e)),
            // 1/M = 1/E + 1/K, K = K₁ + K₂ is −E
            (Joint::PoyntingThomson, Response::Relaxation) => -inverse(side_by_side) * (e * e),
            // 1/M = 1/(K₁ + K₂), with a spring or without; the sums have no pole.
            (Joint::KelvinVoigt, _)
            | (Joint::Maxwell | Joint::PoyntingThomson, Response::Creep) => inverse(side_by_side),
        }
    }
}
