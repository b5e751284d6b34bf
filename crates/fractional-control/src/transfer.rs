//! A fractional transfer function as a value.

use crate::ControlError;
use core::fmt;
use fracdiff::parameter::{RangeError, range};
use num_complex::Complex;

/// `G(s) = Σ b_j s^(β_j) / Σ a_i s^(α_i)`, proper, orders from 0 to 4.
///
/// - *Units*: s in rad/s; G has \[output\]/\[input\].
/// - *Streaming*: [`SampledTransferFunction`](crate::SampledTransferFunction) runs it sample by sample.
/// - *Notation*: read and printed as `1/(0.8s^2.2+0.5s^0.9+1)`; products, quotients, sums and brackets of such are read too. A
///   dead time belongs to a `Plant`.
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
    /// Function from the terms of numerator and denominator, in any order.
    ///
    /// # Errors
    /// [`ControlError::Improper`], [`ControlError::CommonOrder`], or an invalid
    /// polynomial.
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

    /// Function from polynomials.
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

    /// G(s) where s goes to 0: infinite where it integrates, 0 where it differentiates.
    #[must_use]
    pub fn gain_at_rest(&self) -> f64 {
        let [above, below] = [&self.numerator, &self.denominator].map(|side| {
            let term = side.terms().last();
            term.map_or((0.0, 0.0), |term| (term.coefficient, term.order))
        });
        match (above.1 > 0.0, below.1 > 0.0) {
            (true, _) => 0.0,
            (false, true) => f64::INFINITY.copysign(above.0 / below.0),
            (false, false) => above.0 / below.0,
        }
    }

    /// True if all orders are integers.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        let (above, below) = (self.numerator.terms(), self.denominator.terms());
        let mut terms = above.iter().chain(below);
        terms.all(|term| (term.order - libm::round(term.order)).abs() <= 0.0)
    }

    /// G(s), on the principal branch.
    #[must_use]
    pub fn at(&self, s: Complex<f64>) -> Complex<f64> {
        self.numerator.at(s) / self.denominator.at(s)
    }

    /// G(jω) on the principal branch, ω in rad/s.
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

const TERMS_MAX: usize = 16;
const ORDER_MAX: f64 = 4.0;
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

/// The number in the type of the samples, where it must not be beyond its largest.
///
/// # Errors
/// One that is infinite there: of `f32` one over 3.4e38.
pub(crate) fn in_samples<F: fracdiff::Real>(
    what: &'static str,
    value: f64,
) -> Result<F, RangeError> {
    let rounded = F::from_f64(value);
    let allowed = "a number in the type of the samples: give plant and controller in other units, or use `f64`";
    range(what, value, rounded.is_finite(), allowed, "")?;
    Ok(rounded)
}

/// A coefficient and the power of s it stands before, in s^order·\[…\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Term {
    /// The coefficient, from 1e-60 to 1e60 in size.
    pub coefficient: f64,
    /// The order, 0 to 4.
    pub order: f64,
}

impl Term {
    /// A term with this coefficient and order, which are not checked.
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

    /// Terms may come in any order; equal powers are added.
    ///
    /// # Errors
    /// No term; a coefficient that is 0, that cancels, or that is not from 1e-60 to 1e60 in size; an order outside 0 to 4; more than
    /// 16 terms.
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
        let terms = &mut self.terms[..self.count];
        if let Some(same) = terms
            .iter_mut()
            .find(|t| (t.order - term.order).abs() < SAME)
        {
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

    /// The highest order, by which it grows with ω.
    #[must_use]
    pub fn degree(&self) -> f64 {
        self.terms[0].order
    }

    /// The lowest order, by which it behaves at rest; 0 with a constant term.
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

    pub(crate) fn scaled(mut self, factor: f64) -> Self {
        for term in &mut self.terms[..self.count] {
            term.coefficient *= factor;
        }
        self
    }

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
