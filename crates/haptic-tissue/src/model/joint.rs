//! Poles of joined elements: a new joint is written in `spring-pots` and here, its kinds and their parameters
//! in [`kind`](super::kind).

use super::spring_pot::{Response, SpringPot, inverse};
use super::zeros::{Pole, Term, beside_the_cut};
use num_complex::Complex64;
use spring_pots::Joint;

/// Two elements, orders α > β.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Two {
    pub(crate) joint: Joint,
    pub(crate) first: SpringPot,
    pub(crate) second: SpringPot,
    /// E of the spring that Zener and Poynting–Thomson models have, Pa; else 0.
    pub(crate) spring_pa: f64,
}

/// The function of time that is the sum of those of the two elements, if there is one.
pub(super) const fn sum(joint: Joint) -> Option<Response> {
    match joint {
        Joint::KelvinVoigt => Some(Response::Relaxation),
        Joint::Maxwell => Some(Response::Creep),
        Joint::Zener | Joint::PoyntingThomson => None,
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
