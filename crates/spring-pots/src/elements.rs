//! The elements, eᵢ(s) = exp(aᵢ)·(s·t₀)^αᵢ.
//!
//! aᵢ is the logarithm of the modulus at the rate 1/t₀. The variables are a₁, α₁, a₂, α₂, and a₃ of the spring, whose α is 0.

use crate::joint::{ELEMENTS, Joint, variables};
use num_complex::Complex64;

/// The most variables that a model has.
pub const VARIABLES: usize = 5;

/// True for an order, false for the logarithm of a modulus; of the element `variable`/2.
#[must_use]
pub const fn is_order(variable: usize) -> bool {
    variable % 2 == 1
}

/// aᵢ and αᵢ of the elements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elements {
    /// aᵢ, the logarithm of the modulus at the rate 1/t₀.
    pub ln_modulus: [f64; ELEMENTS],
    /// αᵢ, from 0 for a spring to 1 for a dashpot.
    pub order: [f64; ELEMENTS],
}

impl Elements {
    /// Elements from the values of the variables.
    #[must_use]
    pub fn from_variables(values: &[f64]) -> Self {
        let value = |variable: usize| values.get(variable).copied().unwrap_or(0.0);
        Self {
            ln_modulus: [0, 2, 4].map(value),
            order: [1, 3, 5].map(value),
        }
    }

    /// The values of the variables.
    #[must_use]
    pub fn variables(&self, joint: Option<Joint>) -> Vec<f64> {
        let value = |variable: usize| {
            if is_order(variable) {
                self.order[variable / 2]
            } else {
                self.ln_modulus[variable / 2]
            }
        };
        (0..variables(joint)).map(value).collect()
    }

    /// The modulus of each element at s = exp(`ln_size` + i·angle)/t₀.
    #[must_use]
    pub fn at(&self, joint: Option<Joint>, ln_size: f64, angle: f64) -> [Complex64; ELEMENTS] {
        core::array::from_fn(|i| {
            if 2 * i >= variables(joint) {
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
pub struct Slope {
    /// The value.
    pub value: f64,
    /// Its derivatives by the variables.
    pub by: [f64; VARIABLES],
}

impl Slope {
    /// Weighted sum of values and their derivatives.
    #[must_use]
    pub fn sum<'a>(weights: &[f64], terms: impl IntoIterator<Item = &'a Self>) -> Self {
        let mut sum = Self::default();
        for (weight, part) in weights.iter().zip(terms) {
            sum.value += weight * part.value;
            for variable in 0..VARIABLES {
                sum.by[variable] += weight * part.by[variable];
            }
        }
        sum
    }

    /// A value and its derivatives by the aᵢ and the αᵢ, all times `scale`.
    #[must_use]
    pub fn of(
        joint: Option<Joint>,
        scale: f64,
        value: f64,
        by_modulus: [f64; ELEMENTS],
        by_order: [f64; ELEMENTS],
    ) -> Self {
        let mut by = [0.0; VARIABLES];
        for (variable, by) in by.iter_mut().enumerate().take(variables(joint)) {
            let slopes = [by_modulus, by_order][variable % 2];
            *by = scale * slopes[variable / 2];
        }
        Self {
            value: scale * value,
            by,
        }
    }

    /// ln of the value less the wanted logarithm. A value that is not above 0, as rounding makes one of a modulus that has decayed, counts
    /// as the smallest there is.
    #[must_use]
    pub fn logarithm(self, wanted: f64) -> Self {
        let value = self.value.max(f64::MIN_POSITIVE);
        let mut slope = self;
        slope.value = libm::log(value) - wanted;
        for by in &mut slope.by {
            *by /= value;
        }
        slope
    }
}
