//! The usual notation of a fractional transfer function.
//! ```text
//! sum      = ["-"] product { ("+" | "-") product }
//! product  = power { ["*" | "/"] power }              2s, 2*s and 2 s are the same
//! power    = atom ["^" exponent]                      exponent of s: any number; of a bracket: 0, 1, 2, …
//! atom     = number | "s" | "(" sum ")" | "exp(" ["-"] number ["*"] "s" ")"
//! exponent = ["-"] number | "(" ["-"] number ["/" number] ")" | "{" … "}"
//! ```
//! `exp(-0.5s)`, also `e^(-0.5s)`, is a dead time of 0.5 s; it stands only as a factor of the whole.

use crate::{ControlError, FractionalPolynomial, FractionalTransferFunction, Term};
use core::str::FromStr;
use fracdiff::parameter::RangeError;

const DEPTH_MAX: usize = 16;

/// Transfer function and dead time in s.
pub(crate) fn read(text: &str) -> Result<(FractionalTransferFunction, f64), ControlError> {
    let value = Quotient::read(text)?;
    let function = FractionalTransferFunction::from_polynomials(value.above, value.below)?;
    Ok((function, value.delay_s))
}

/// The summands of a text that [`read`] takes.
#[cfg(feature = "std")]
pub(crate) fn summands(text: &str) -> Result<std::vec::Vec<Quotient>, ControlError> {
    let mut reader = Reader::of(text);
    let mut all = std::vec![reader.summand()?];
    while reader.peek().is_some() {
        all.push(reader.summand()?);
    }
    Ok(all)
}

/// The place of the first factor that follows a division with neither sign nor brackets, as (s+2)
/// in 1/(s+1)(s+2): it multiplies the whole, where a reader may take it for a part of the
/// denominator. `None` without one, or if the text is not in this notation.
/// ```
/// use fractional_control::factor_after_division;
///
/// assert_eq!(factor_after_division("1/(s+1)(s+2)"), Some(7));
/// assert_eq!(factor_after_division("1/((s+1)(s+2))"), None);
/// ```
#[must_use]
pub fn factor_after_division(text: &str) -> Option<usize> {
    Quotient::with_place(text).ok()?.1
}

impl Quotient {
    /// Any quotient, proper or not.
    pub(crate) fn read(text: &str) -> Result<Self, ControlError> {
        Self::with_place(text).map(|(value, _)| value)
    }

    fn with_place(text: &str) -> Result<(Self, Option<usize>), ControlError> {
        let mut reader = Reader::of(text);
        let value = reader.sum()?;
        if reader.peek().is_some() {
            return Err(reader.wrong("+, -, *, / or the end"));
        }
        if value.delay_s < 0.0 {
            return Err(RangeError::new("dead time", value.delay_s, "at least 0 {}", "s").into());
        }
        Ok((value, reader.loose))
    }
}

impl FromStr for FractionalTransferFunction {
    type Err = ControlError;

    fn from_str(text: &str) -> Result<Self, ControlError> {
        let (function, delay_s) = read(text)?;
        if delay_s > 0.0 {
            return Err(
                RangeError::new("dead time", delay_s, "0: only a plant has one", "s").into(),
            );
        }
        Ok(function)
    }
}

struct Reader<'a> {
    text: &'a [u8],
    at: usize,
    depth: usize,
    /// Place of the first factor that follows a division with no sign before it.
    loose: Option<usize>,
}

impl Reader<'_> {
    /// The next character that is no space.
    fn peek(&mut self) -> Option<u8> {
        while self.text.get(self.at).is_some_and(u8::is_ascii_whitespace) {
            self.at += 1;
        }
        self.text.get(self.at).copied()
    }

    fn takes(&mut self, character: u8) -> bool {
        let found = self.peek() == Some(character);
        self.at += usize::from(found);
        found
    }

    fn expects(&mut self, character: u8, expected: &'static str) -> Result<(), ControlError> {
        if self.takes(character) {
            return Ok(());
        }
        Err(self.wrong(expected))
    }

    fn wrong(&self, expected: &'static str) -> ControlError {
        ControlError::Notation {
            at: self.at,
            expected,
        }
    }

    fn sum(&mut self) -> Result<Quotient, ControlError> {
        let mut sum = self.summand()?;
        loop {
            let start = self.at;
            if !matches!(self.peek(), Some(b'+' | b'-')) {
                return Ok(sum);
            }
            let next = self.summand()?;
            if sum.delay_s != 0.0 || next.delay_s != 0.0 {
                self.at = start;
                return Err(self.wrong("a factor (a dead time must precede the whole function)"));
            }
            sum = sum.plus(&next)?;
        }
    }

    /// A product with the sign before it.
    fn summand(&mut self) -> Result<Quotient, ControlError> {
        if self.takes(b'-') {
            let minus = Quotient::of(Term::new(-1.0, 0.0))?;
            return self.product()?.times(&minus);
        }
        self.takes(b'+');
        self.product()
    }

    const fn of(text: &str) -> Reader<'_> {
        Reader {
            text: text.as_bytes(),
            at: 0,
            depth: 0,
            loose: None,
        }
    }

    fn product(&mut self) -> Result<Quotient, ControlError> {
        let mut product = self.power()?;
        let mut divided = false;
        loop {
            product = match self.peek() {
                Some(b'*') => {
                    self.at += 1;
                    product.times(&self.power()?)?
                }
                Some(b'/') => {
                    self.at += 1;
                    divided = true;
                    product.over(&self.power()?)?
                }
                Some(next @ (b's' | b'(' | b'e')) => {
                    if divided && next != b'e' {
                        self.loose.get_or_insert(self.at);
                    }
                    product.times(&self.power()?)?
                }
                _ => return Ok(product),
            };
        }
    }

    fn power(&mut self) -> Result<Quotient, ControlError> {
        if self.takes(b's') {
            let order = if self.takes(b'^') {
                self.exponent()?
            } else {
                1.0
            };
            return Quotient::of(Term::new(1.0, order));
        }
        let base = self.atom()?;
        if !self.takes(b'^') {
            return Ok(base);
        }
        let start = self.at;
        let exponent = self.exponent()?;
        let whole = (libm::trunc(exponent) - exponent).abs() == 0.0;
        if !whole || !(0.0..=4.0).contains(&exponent) {
            self.at = start;
            return Err(self.wrong("0, 1, 2, 3 or 4 as the power of a bracket"));
        }
        let mut power = Quotient::of(Term::new(1.0, 0.0))?;
        for _ in 0..exponent as usize {
            power = power.times(&base)?;
        }
        Ok(power)
    }

    fn atom(&mut self) -> Result<Quotient, ControlError> {
        match self.peek() {
            Some(b'(') => {
                self.at += 1;
                if self.depth == DEPTH_MAX {
                    return Err(self.wrong("within at most 16 nested brackets"));
                }
                self.depth += 1;
                let sum = self.sum()?;
                self.depth -= 1;
                self.expects(b')', "a closing bracket")?;
                Ok(sum)
            }
            Some(b'e') => self.dead_time(),
            Some(b'0'..=b'9' | b'.') => {
                let coefficient = self.number()?;
                if coefficient == 0.0 {
                    return self.zero();
                }
                Quotient::of(Term::new(coefficient, 0.0))
            }
            _ => Err(self.wrong("a number, s or a bracket")),
        }
    }

    /// A coefficient of 0: refused with the order it stands before.
    fn zero(&mut self) -> Result<Quotient, ControlError> {
        self.takes(b'*');
        let order = if self.takes(b's') {
            if self.takes(b'^') {
                self.exponent()?
            } else {
                1.0
            }
        } else {
            0.0
        };
        Err(ControlError::ZeroCoefficient { order })
    }

    /// `exp(-0.5s)` or `e^(-0.5s)`.
    fn dead_time(&mut self) -> Result<Quotient, ControlError> {
        let expected = "exp(-0.5s), a dead time,";
        let rest = self.text.get(self.at..).unwrap_or_default();
        let length = match rest {
            [b'e', b'x', b'p', ..] => 3,
            [b'e', b'^', ..] => 2,
            _ => return Err(self.wrong(expected)),
        };
        self.at += length;
        self.expects(b'(', expected)?;
        let sign = if self.takes(b'-') { 1.0 } else { -1.0 };
        let seconds = if self.peek() == Some(b's') {
            1.0
        } else {
            self.number()?
        };
        self.takes(b'*');
        self.expects(b's', expected)?;
        self.expects(b')', "a closing bracket")?;
        Ok(Quotient {
            delay_s: sign * seconds,
            ..Quotient::of(Term::new(1.0, 0.0))?
        })
    }

    fn exponent(&mut self) -> Result<f64, ControlError> {
        let close = match self.peek() {
            Some(b'(') => b')',
            Some(b'{') => b'}',
            _ => return self.signed(),
        };
        self.at += 1;
        let mut exponent = self.signed()?;
        if self.takes(b'/') {
            exponent /= self.number()?;
        }
        self.expects(close, "a closing bracket")?;
        if exponent.is_finite() {
            Ok(exponent)
        } else {
            Err(self.wrong("a finite exponent"))
        }
    }

    fn signed(&mut self) -> Result<f64, ControlError> {
        if self.takes(b'-') {
            return Ok(-self.number()?);
        }
        self.number()
    }

    /// Digits, a point, an exponent such as `e-3`.
    fn number(&mut self) -> Result<f64, ControlError> {
        self.peek();
        let start = self.at;
        let digits = |reader: &mut Self| {
            while reader.text.get(reader.at).is_some_and(u8::is_ascii_digit) {
                reader.at += 1;
            }
        };
        digits(self);
        match self.text.get(self.at) {
            Some(b'.') => {
                self.at += 1;
                digits(self);
            }
            Some(b',') => return Err(self.wrong("a decimal point")),
            _ => {}
        }
        if let Some(b'e' | b'E') = self.text.get(self.at) {
            let mark = self.at;
            self.at += 1;
            if let Some(b'-' | b'+') = self.text.get(self.at) {
                self.at += 1;
            }
            let first = self.at;
            digits(self);
            if self.at == first {
                // The e of a dead time.
                self.at = mark;
            }
        }
        let written = self.text.get(start..self.at).unwrap_or_default();
        let number = core::str::from_utf8(written).ok();
        let number = number.and_then(|text| text.parse::<f64>().ok());
        match number.filter(|number| number.is_finite()) {
            Some(number) => Ok(number),
            None => {
                self.at = start;
                Err(self.wrong("a number"))
            }
        }
    }
}

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
        // A power of s below both stands there once.
        let common = libm::fmin(self.below.lowest(), other.below.lowest());
        let [own, others] = [self.below, other.below].map(|below| below.divided_by_power(common));
        let (left, right) = (self.above.times(&others)?, other.above.times(&own)?);
        Ok(Self {
            above: left.plus(&right)?,
            below: self.below.times(&others)?,
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
