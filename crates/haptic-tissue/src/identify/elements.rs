//! Moduli and orders of the elements of a candidate, as the fit varies them.

use super::candidate::{Candidate, ELEMENTS, VARIABLES};
use num_complex::Complex64;

/// Elements eᵢ(s) = exp(aᵢ)·(s·t₀)^αᵢ: aᵢ is the logarithm of the modulus at the rate 1/t₀ in the middle of the record, where
/// it hangs together least with αᵢ. A spring has α = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Elements {
    /// aᵢ.
    pub(super) ln_modulus: [f64; ELEMENTS],
    /// αᵢ.
    pub(super) order: [f64; ELEMENTS],
}

/// A variable: of which element, and its order or its modulus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Variable {
    Modulus(usize),
    Order(usize),
}

/// The variables of a candidate: modulus and order of each spring-pot, then the modulus of the spring.
pub(super) fn variables(candidate: Candidate) -> Vec<Variable> {
    let pots = (0..candidate.pots()).flat_map(|i| [Variable::Modulus(i), Variable::Order(i)]);
    let spring = candidate
        .has_spring()
        .then_some(Variable::Modulus(ELEMENTS - 1));
    pots.chain(spring).collect()
}

impl Elements {
    /// From the values of the variables.
    pub(super) fn from_variables(candidate: Candidate, values: &[f64]) -> Self {
        let mut elements = Self {
            ln_modulus: [0.0; ELEMENTS],
            order: [0.0; ELEMENTS],
        };
        for (variable, &value) in variables(candidate).iter().zip(values) {
            match *variable {
                Variable::Modulus(i) => elements.ln_modulus[i] = value,
                Variable::Order(i) => elements.order[i] = value,
            }
        }
        elements
    }

    /// The values of the variables.
    pub(super) fn variables(&self, candidate: Candidate) -> Vec<f64> {
        (variables(candidate).iter())
            .map(|variable| match *variable {
                Variable::Modulus(i) => self.ln_modulus[i],
                Variable::Order(i) => self.order[i],
            })
            .collect()
    }

    /// The same model with the larger order first.
    pub(super) fn sorted(mut self, candidate: Candidate) -> Self {
        if candidate.pots() == 2 && self.order[0] < self.order[1] {
            self.ln_modulus.swap(0, 1);
            self.order.swap(0, 1);
        }
        self
    }

    /// The modulus of each element at s = exp(`ln_size` + i·angle)/t₀.
    pub(super) fn at(
        &self,
        candidate: Candidate,
        ln_size: f64,
        angle: f64,
    ) -> [Complex64; ELEMENTS] {
        let mut e = [Complex64::new(0.0, 0.0); ELEMENTS];
        for (i, element) in e.iter_mut().enumerate() {
            if self.is_used(candidate, i) {
                let size = libm::exp(self.ln_modulus[i] + self.order[i] * ln_size);
                let turn = self.order[i] * angle;
                *element = Complex64::new(size * libm::cos(turn), size * libm::sin(turn));
            }
        }
        e
    }

    /// True if the candidate has this element.
    pub(super) const fn is_used(&self, candidate: Candidate, i: usize) -> bool {
        i < candidate.pots() || (i == ELEMENTS - 1 && candidate.has_spring())
    }
}

/// A value and its derivatives by the variables.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Slope {
    pub(super) value: f64,
    pub(super) by: [f64; VARIABLES],
}
