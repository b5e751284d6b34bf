//! A transfer function as the sum of its parts, as an impedance is: `0.02+0.015/(0.9s^0.8+1)+0.0012/s^0.5`.
//!
//! Each part keeps its own coefficients and orders, so a fit has no more numbers than the parts have. For everything else the sum is one function, over
//! the product of the denominators; a power of s that stands below several parts counts once.

use crate::{
    ControlError, FractionalTransferFunction,
    notation::{Quotient, summands},
};
use core::{fmt, str::FromStr};
use num_complex::Complex;
use std::vec::Vec;

/// A transfer function as the sum of its parts, each with a sign of its own.
/// ```
/// use fractional_control::SumOfParts;
///
/// let cell: SumOfParts = "0.02+0.015/(0.9s^0.8+1)+0.0012/s^0.5".parse()?;
/// assert_eq!(cell.parts().len(), 3);
/// assert_eq!(cell.to_string(), "0.02+0.015/(0.9s^0.8+1)+0.0012/(s^0.5)");
/// assert!((cell.response(2.0) - cell.function().response(2.0)).norm() < 1e-15);
/// assert_eq!(SumOfParts::of_plant("exp(-3s)*2(0.02+0.01/s^0.5)")?.to_string(), "0.04+0.02/(s^0.5)");
/// assert_eq!("(2s+0.1)/(20s+1)".parse::<SumOfParts>()?.parts().len(), 1);
/// assert_eq!("2/((1+1/s)*3)".parse::<SumOfParts>()?.parts().len(), 1);
/// # Ok::<(), fractional_control::ControlError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SumOfParts {
    parts: Vec<FractionalTransferFunction>,
    function: FractionalTransferFunction,
}

impl SumOfParts {
    /// Sum of these parts.
    ///
    /// # Errors
    /// No part; a sum that is no transfer function, or has more terms than one has.
    pub fn new(parts: Vec<FractionalTransferFunction>) -> Result<Self, ControlError> {
        let mut sum: Option<Quotient> = None;
        for part in &parts {
            let next = Quotient::plain(*part.numerator(), *part.denominator());
            sum = Some(match sum {
                Some(sum) => sum.plus(&next)?,
                None => next,
            });
        }
        let sum = sum.ok_or(ControlError::Empty { what: "sum" })?;
        Ok(Self {
            parts,
            function: FractionalTransferFunction::from_polynomials(sum.above, sum.below)?,
        })
    }

    /// Parts of a plant, whose dead time [`Plant`](crate::Plant) reads.
    ///
    /// # Errors
    /// A text in another notation; powers of a bracket and diffusion, which are no parts.
    pub fn of_plant(text: &str) -> Result<Self, ControlError> {
        let parts = summands(text)?.into_iter().map(|part| {
            part.factors.refused()?;
            FractionalTransferFunction::from_polynomials(part.above, part.below)
        });
        Self::new(parts.collect::<Result<_, _>>()?)
    }

    /// The parts as they were given, before they are added.
    #[must_use]
    pub fn parts(&self) -> &[FractionalTransferFunction] {
        &self.parts
    }

    /// The sum as one function.
    #[must_use]
    pub const fn function(&self) -> FractionalTransferFunction {
        self.function
    }

    /// Σ G(jω), ω in rad/s.
    #[must_use]
    pub fn response(&self, omega: f64) -> Complex<f64> {
        self.parts.iter().map(|part| part.response(omega)).sum()
    }
}

impl From<FractionalTransferFunction> for SumOfParts {
    fn from(function: FractionalTransferFunction) -> Self {
        let parts = std::vec![function];
        Self { parts, function }
    }
}

impl FromStr for SumOfParts {
    type Err = ControlError;

    /// Reads a transfer function, whose summands are the parts, those of a bracket before or behind a number too.
    fn from_str(text: &str) -> Result<Self, ControlError> {
        text.parse::<FractionalTransferFunction>()?;
        Self::of_plant(text)
    }
}

impl fmt::Display for SumOfParts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (n, part) in self.parts.iter().enumerate() {
            let is_negative = (part.numerator().terms().first())
                .is_some_and(|term| term.coefficient < 0.0 && part.numerator().terms().len() == 1);
            let sign = if n > 0 && !is_negative { "+" } else { "" };
            write!(f, "{sign}{part}")?;
        }
        Ok(())
    }
}
