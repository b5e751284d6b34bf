//! Sums of real powers of s, in a fixed room.

use crate::ControlError;
use core::fmt;
use fracdiff::parameter::{RangeError, range};
use num_complex::Complex;

/// Terms of a polynomial at most.
pub const TERMS_MAX: usize = 16;
/// Largest order of a term.
pub const ORDER_MAX: f64 = 4.0;
/// Orders closer than this are one.
const SAME: f64 = 1e-9;
/// Sizes of coefficients, gains and entries of matrices: far beyond what any unit makes, and far from where numbers end.
const SIZES: core::ops::RangeInclusive<f64> = 1e-60..=1e60;
const SIZES_IN_WORDS: &str = "from 1e-60 to 1e60 in size: give plant and controller in other units";
const SIZES_OR_0_IN_WORDS: &str =
    "0, or from 1e-60 to 1e60 in size: give plant and controller in other units";

/// A number of a plant or a controller that a loop can be made of, or 0.
///
/// # Errors
/// One that is so small or so large that a loop of it is no numbers any more.
pub(crate) fn size_or_0(what: &'static str, value: f64) -> Result<(), RangeError> {
    let inside = value == 0.0 || SIZES.contains(&value.abs());
    range(what, value, inside, SIZES_OR_0_IN_WORDS, "").map(drop)
}

/// A coefficient and the power of s it stands before, in s^order·\[…\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Term {
    /// The coefficient, from 1e-60 to 1e60 in size.
    pub coefficient: f64,
    /// The order, 0 to [`ORDER_MAX`].
    pub order: f64,
}

impl Term {
    /// Both numbers, unchecked.
    #[must_use]
    pub const fn new(coefficient: f64, order: f64) -> Self {
        Self { coefficient, order }
    }

    fn checked(&self) -> Result<(), ControlError> {
        let Self { coefficient, order } = *self;
        let inside = (0.0..=ORDER_MAX).contains(&order);
        range("order of a term", order, inside, "in [0, 4]", "")?;
        if coefficient == 0.0 {
            return Err(ControlError::ZeroCoefficient { order });
        }
        let inside = SIZES.contains(&coefficient.abs());
        range("coefficient", coefficient, inside, SIZES_IN_WORDS, "")?;
        Ok(())
    }
}

/// `Σ a_i·s^(α_i)`, highest order first, each order once.
///
/// ```
/// use fractional_control::{FractionalPolynomial, Term};
///
/// let a = FractionalPolynomial::new(&[Term::new(1.0, 0.0), Term::new(0.8, 2.2)])?;
/// assert_eq!(a.degree(), 2.2);
/// assert_eq!(a.to_string(), "0.8s^2.2+1");
/// # Ok::<(), fractional_control::ControlError>(())
/// ```
#[derive(Clone, Copy, PartialEq)]
pub struct FractionalPolynomial {
    terms: [Term; TERMS_MAX],
    count: usize,
}

impl FractionalPolynomial {
    /// No term: zero. Only on the way to something else.
    pub(crate) const ZERO: Self = Self {
        terms: [Term::new(0.0, 0.0); TERMS_MAX],
        count: 0,
    };

    /// In any order of terms; equal orders are added.
    ///
    /// # Errors
    /// No term; a coefficient that is 0, that cancels, or that is not from 1e-60 to 1e60 in size; an order outside 0 to [`ORDER_MAX`]; more than
    /// [`TERMS_MAX`] terms.
    pub fn new(terms: &[Term]) -> Result<Self, ControlError> {
        let mut sum = Self::ZERO;
        for term in terms {
            term.checked()?;
            sum.add(*term)?;
        }
        sum.checked("polynomial")
    }

    /// Adds a term where its order belongs, one next to a whole number as that.
    pub(crate) fn add(&mut self, mut term: Term) -> Result<(), ControlError> {
        let whole = libm::round(term.order);
        if (term.order - whole).abs() < SAME {
            term.order = whole;
        }
        let own = &mut self.terms[..self.count];
        if let Some(same) = own.iter_mut().find(|t| (t.order - term.order).abs() < SAME) {
            same.coefficient += term.coefficient;
            return Ok(());
        }
        if self.count == TERMS_MAX {
            let (count, most) = (TERMS_MAX + 1, TERMS_MAX);
            return Err(ControlError::TooManyTerms { count, most });
        }
        let place = self.terms().iter().position(|t| t.order < term.order);
        let place = place.unwrap_or(self.count);
        self.terms.copy_within(place..self.count, place + 1);
        self.terms[place] = term;
        self.count += 1;
        Ok(())
    }

    /// Itself, if it has terms, none of them 0, within the largest order.
    pub(crate) fn checked(self, what: &'static str) -> Result<Self, ControlError> {
        if self.count == 0 {
            return Err(ControlError::Empty { what });
        }
        for term in self.terms() {
            term.checked()?;
        }
        Ok(self)
    }

    /// The terms, highest order first.
    #[must_use]
    pub fn terms(&self) -> &[Term] {
        self.terms.get(..self.count).unwrap_or_default()
    }

    /// The highest order.
    #[must_use]
    pub fn degree(&self) -> f64 {
        self.terms[0].order
    }

    /// The lowest order.
    #[must_use]
    pub fn lowest(&self) -> f64 {
        self.terms().last().map_or(0.0, |term| term.order)
    }

    /// The value at s, on the principal branch.
    #[must_use]
    pub fn at(&self, s: Complex<f64>) -> Complex<f64> {
        let (size, angle) = (libm::hypot(s.re, s.im), libm::atan2(s.im, s.re));
        let terms = self.terms().iter().rev();
        terms
            .map(|term| {
                let (sin, cos) = libm::sincos(term.order * angle);
                Complex::new(cos, sin) * (term.coefficient * libm::pow(size, term.order))
            })
            .sum()
    }

    /// The product.
    pub(crate) fn times(&self, other: &Self) -> Result<Self, ControlError> {
        let mut product = Self::ZERO;
        for a in self.terms() {
            for b in other.terms() {
                product.add(Term {
                    coefficient: a.coefficient * b.coefficient,
                    order: a.order + b.order,
                })?;
            }
        }
        Ok(product.without_zeros())
    }

    /// The terms that are not 0: of (s − 1)(s + 1) that of s is.
    fn without_zeros(self) -> Self {
        let mut rest = Self::ZERO;
        for term in self.terms().iter().filter(|term| term.coefficient != 0.0) {
            rest.terms[rest.count] = *term;
            rest.count += 1;
        }
        rest
    }

    /// The sum.
    pub(crate) fn plus(mut self, other: &Self) -> Result<Self, ControlError> {
        for term in other.terms() {
            self.add(*term)?;
        }
        Ok(self)
    }

    /// All orders less this one, which is at most the lowest.
    pub(crate) fn divided_by_power(mut self, order: f64) -> Self {
        for term in &mut self.terms[..self.count] {
            term.order -= order;
        }
        self
    }
}

impl fmt::Debug for FractionalPolynomial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// Writes a number so that it reads back: with an exponent where it would have many digits.
pub(crate) fn short(f: &mut fmt::Formatter<'_>, value: f64) -> fmt::Result {
    if value == 0.0 || (1e-6..1e15).contains(&value.abs()) {
        write!(f, "{value}")
    } else {
        write!(f, "{value:e}")
    }
}

impl fmt::Display for FractionalPolynomial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, term) in self.terms().iter().enumerate() {
            let sign = match (index, term.coefficient < 0.0) {
                (0, false) => "",
                (_, false) => "+",
                (_, true) => "-",
            };
            f.write_str(sign)?;
            let size = term.coefficient.abs();
            if term.order == 0.0 || (size - 1.0).abs() > 0.0 {
                short(f, size)?;
            }
            if (term.order - 1.0).abs() < f64::EPSILON {
                f.write_str("s")?;
            } else if term.order != 0.0 {
                f.write_str("s^")?;
                short(f, term.order)?;
            }
        }
        Ok(())
    }
}
