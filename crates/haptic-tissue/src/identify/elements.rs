//! The models that are fitted, as elements eᵢ(s) = exp(aᵢ)·(s·t₀)^αᵢ and how they are joined.
//!
//! aᵢ is the logarithm of the modulus at the rate 1/t₀ in the middle of the record, where it hangs together least with αᵢ.
//! Variables, as parameters of a tissue file: a₁, α₁, a₂, α₂, and a₃ of the spring, whose α is 0.

use super::error::IdentifyError;
use crate::model::{CANDIDATES, ModelKind};
use num_complex::Complex64;

/// The most elements of a candidate.
pub(super) const ELEMENTS: usize = 3;
pub(super) const VARIABLES: usize = 5;

/// One of [`CANDIDATES`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Candidate(ModelKind);

/// True for an order, false for the logarithm of a modulus; of the element `variable`/2.
pub(super) const fn is_order(variable: usize) -> bool {
    variable % 2 == 1
}

/// How much of a variable a reported parameter is: ln Vᵢ = aᵢ + αᵢ ln t₀, an order is itself.
pub(super) fn share(parameter: usize, variable: usize, ln_unit: f64) -> f64 {
    match (parameter, variable) {
        (a, b) if a == b => 1.0,
        (a, b) if is_order(b) && a + 1 == b => ln_unit,
        _ => 0.0,
    }
}

/// A reported parameter of its logarithm, or an order of itself.
pub(super) fn number(parameter: usize, value: f64) -> f64 {
    match is_order(parameter) {
        true => value,
        false => libm::exp(value),
    }
}

impl Candidate {
    #[cfg(test)]
    pub(super) fn all() -> [Self; CANDIDATES.len()] {
        CANDIDATES.map(Self)
    }

    pub(super) fn of(kind: ModelKind) -> Result<Self, IdentifyError> {
        if CANDIDATES.contains(&kind) {
            return Ok(Self(kind));
        }
        Err(IdentifyError::Record(format!(
            "{kind} is not fitted by itself: take one of {}",
            CANDIDATES.map(ModelKind::name).join(", ")
        )))
    }

    pub(super) const fn kind(self) -> ModelKind {
        self.0
    }

    /// Number of parameters, and of variables.
    pub(super) const fn parameters(self) -> usize {
        self.0.parameters().len()
    }

    /// M and its derivatives by the moduli of the elements e₁, e₂ and the spring e₃.
    pub(super) fn join(self, e: [Complex64; ELEMENTS]) -> (Complex64, [Complex64; ELEMENTS]) {
        match self.0.joint() {
            Some(joint) => joint.slopes(e),
            None => (e[0], [Complex64::ONE, Complex64::ZERO, Complex64::ZERO]),
        }
    }
}

/// aᵢ and αᵢ of a candidate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Elements {
    pub(super) ln_modulus: [f64; ELEMENTS],
    pub(super) order: [f64; ELEMENTS],
}

impl Elements {
    /// From the values of the variables.
    pub(super) fn from_variables(values: &[f64]) -> Self {
        let value = |variable: usize| values.get(variable).copied().unwrap_or(0.0);
        Self {
            ln_modulus: [0, 2, 4].map(value),
            order: [1, 3, 5].map(value),
        }
    }

    /// The values of the variables.
    pub(super) fn variables(&self, candidate: Candidate) -> Vec<f64> {
        let value = |variable: usize| match is_order(variable) {
            true => self.order[variable / 2],
            false => self.ln_modulus[variable / 2],
        };
        (0..candidate.parameters()).map(value).collect()
    }

    /// The same model with the larger order first.
    pub(super) fn sorted(mut self, candidate: Candidate) -> Self {
        if candidate.parameters() > 2 && self.order[0] < self.order[1] {
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
        core::array::from_fn(|i| {
            if 2 * i >= candidate.parameters() {
                return Complex64::ZERO;
            }
            let size = libm::exp(self.ln_modulus[i] + self.order[i] * ln_size);
            let turn = self.order[i] * angle;
            Complex64::new(size * libm::cos(turn), size * libm::sin(turn))
        })
    }
}

/// A value and its derivatives by the variables.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Slope {
    pub(super) value: f64,
    pub(super) by: [f64; VARIABLES],
}

impl Slope {
    /// So many times a value and its derivatives by the aᵢ and the αᵢ.
    pub(super) fn of(
        candidate: Candidate,
        scale: f64,
        value: f64,
        by_modulus: [f64; ELEMENTS],
        by_order: [f64; ELEMENTS],
    ) -> Self {
        let mut by = [0.0; VARIABLES];
        for (variable, by) in by.iter_mut().enumerate().take(candidate.parameters()) {
            let slopes = if is_order(variable) {
                &by_order
            } else {
                &by_modulus
            };
            *by = scale * slopes[variable / 2];
        }
        Self {
            value: scale * value,
            by,
        }
    }
}
