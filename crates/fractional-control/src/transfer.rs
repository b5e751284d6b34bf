//! A fractional transfer function as a value.

use crate::{ControlError, FractionalPolynomial, Term};
use core::fmt;
use num_complex::Complex;

/// `G(s) = Σ b_j s^(β_j) / Σ a_i s^(α_i)`, proper, orders from 0 to 4.
///
/// - *Units*: s in rad/s; G has \[output\]/\[input\].
/// - *Streaming*: [`SampledTransferFunction`](crate::SampledTransferFunction) runs it sample by sample.
/// - *Notation*: read and printed as `1/(0.8s^2.2+0.5s^0.9+1)`; products, quotients, sums and brackets of such are read too. A
///   dead time belongs to a `Plant`.
///
/// ```
/// use fractional_control::FractionalTransferFunction;
/// use num_complex::Complex;
///
/// let plant: FractionalTransferFunction = "1/(0.8s^2.2+0.5s^0.9+1)".parse()?;
/// assert_eq!(plant.to_string(), "1/(0.8s^2.2+0.5s^0.9+1)");
/// assert_eq!(plant.response(0.0), Complex::new(1.0, 0.0));
/// assert!((plant.response(100.0).norm() * 0.8 * 100f64.powf(2.2) - 1.0).abs() < 2e-3);
/// # Ok::<(), fractional_control::ControlError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FractionalTransferFunction {
    numerator: FractionalPolynomial,
    denominator: FractionalPolynomial,
}

impl FractionalTransferFunction {
    /// From the terms of numerator and denominator, in any order.
    ///
    /// # Errors
    /// [`ControlError::Improper`], [`ControlError::CommonOrder`], or a polynomial that is none.
    pub fn new(numerator: &[Term], denominator: &[Term]) -> Result<Self, ControlError> {
        let part = |terms: &[Term], what| match terms {
            [] => Err(ControlError::Empty { what }),
            terms => FractionalPolynomial::new(terms),
        };
        Self::from_polynomials(
            part(numerator, "numerator")?,
            part(denominator, "denominator")?,
        )
    }

    /// The same from polynomials.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn from_polynomials(
        numerator: FractionalPolynomial,
        denominator: FractionalPolynomial,
    ) -> Result<Self, ControlError> {
        let numerator = numerator.checked("numerator")?;
        let denominator = denominator.checked("denominator")?;
        if numerator.degree() > denominator.degree() {
            return Err(ControlError::Improper {
                numerator: numerator.degree(),
                denominator: denominator.degree(),
            });
        }
        let order = libm::fmin(numerator.lowest(), denominator.lowest());
        if order > 0.0 {
            return Err(ControlError::CommonOrder { order });
        }
        Ok(Self {
            numerator,
            denominator,
        })
    }

    /// Σ `b_j s^(β_j)`.
    #[must_use]
    pub fn numerator(&self) -> &FractionalPolynomial {
        &self.numerator
    }

    /// Σ `a_i s^(α_i)`.
    #[must_use]
    pub fn denominator(&self) -> &FractionalPolynomial {
        &self.denominator
    }

    /// True if all orders are whole.
    #[cfg(feature = "std")]
    pub(crate) fn is_whole(&self) -> bool {
        let (above, below) = (self.numerator.terms(), self.denominator.terms());
        let mut terms = above.iter().chain(below);
        terms.all(|term| (term.order - libm::round(term.order)).abs() <= 0.0)
    }

    /// G(s), on the principal branch.
    #[must_use]
    pub fn at(&self, s: Complex<f64>) -> Complex<f64> {
        self.numerator.at(s) / self.denominator.at(s)
    }

    /// G(jω), ω in rad/s.
    #[must_use]
    pub fn response(&self, omega: f64) -> Complex<f64> {
        self.at(Complex::new(0.0, omega))
    }
}

impl fmt::Display for FractionalTransferFunction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let brackets = |f: &mut fmt::Formatter<'_>, part: &FractionalPolynomial| match part.terms()
        {
            [_] => write!(f, "{part}"),
            _ => write!(f, "({part})"),
        };
        match self.denominator.terms() {
            // A constant below is divided by; 1 is left out.
            [one] if one.order == 0.0 && (one.coefficient - 1.0).abs() == 0.0 => {
                write!(f, "{}", self.numerator)
            }
            _ => {
                brackets(f, &self.numerator)?;
                write!(f, "/({})", self.denominator)
            }
        }
    }
}
