//! Quotients of polynomials with a dead time, as the notation multiplies, divides and adds them.

use crate::{ControlError, FractionalPolynomial, Term};

/// A quotient with a dead time.
#[derive(Clone, Copy)]
pub(crate) struct Quotient {
    pub(crate) above: FractionalPolynomial,
    pub(crate) below: FractionalPolynomial,
    pub(crate) delay_s: f64,
}

impl Quotient {
    pub(crate) fn of(term: Term) -> Result<Self, ControlError> {
        let one = Term::new(1.0, 0.0);
        // A negative power of s stands below.
        let (above, below) = if term.order < 0.0 {
            (
                Term::new(term.coefficient, 0.0),
                Term::new(1.0, -term.order),
            )
        } else {
            (term, one)
        };
        let mut value = Self {
            above: FractionalPolynomial::ZERO,
            below: FractionalPolynomial::ZERO,
            delay_s: 0.0,
        };
        value.above.add(above)?;
        value.below.add(below)?;
        Ok(value)
    }

    pub(crate) fn times(&self, other: &Self) -> Result<Self, ControlError> {
        Ok(Self {
            above: self.above.times(&other.above)?,
            below: self.below.times(&other.below)?,
            delay_s: self.delay_s + other.delay_s,
        }
        .shortened())
    }

    pub(crate) fn over(&self, other: &Self) -> Result<Self, ControlError> {
        other.above.checked("denominator")?;
        self.times(&Self {
            above: other.below,
            below: other.above,
            delay_s: -other.delay_s,
        })
    }

    /// Over a common denominator, the same one where it is the same.
    pub(crate) fn plus(&self, other: &Self) -> Result<Self, ControlError> {
        if self.below == other.below {
            return Ok(Self {
                above: self.above.plus(&other.above)?,
                ..*self
            });
        }
        let (left, right) = (
            self.above.times(&other.below)?,
            other.above.times(&self.below)?,
        );
        Ok(Self {
            above: left.plus(&right)?,
            below: self.below.times(&other.below)?,
            delay_s: self.delay_s,
        })
    }

    /// s/s is 1: a power of s that a product made common to both is taken out. One written so in a sum is not.
    fn shortened(self) -> Self {
        let alone = |part: &FractionalPolynomial| part.terms().len() == 1;
        let common = libm::fmin(self.above.lowest(), self.below.lowest());
        if common > 0.0 && alone(&self.above) && alone(&self.below) {
            return Self {
                above: self.above.divided_by_power(common),
                below: self.below.divided_by_power(common),
                ..self
            };
        }
        self
    }
}
