//! The usual notation of a fractional transfer function.
//! ```text
//! sum      = ["-"] product { ("+" | "-") product }
//! product  = power { ["*" | "/"] power }              2s, 2*s and 2 s are the same
//! power    = atom ["^" exponent]                      exponent of a bracket: whole, or any number of one such as (0.2s+1)
//! atom     = number | "s" | "(" sum ")" | root | "exp(" ["-"] [number] ["*"] ("s" ["^0.5"] | root) ")"
//! root     = "sqrt(" sum ")"
//! exponent = ["-"] number | "(" ["-"] number ["/" number] ")" | "{" … "}"
//! ```
//! `exp(-0.5s)`, also `e^(-0.5s)`, is a dead time of 0.5 s; `exp(-sqrt(3s))` is diffusion. Both, and powers of a bracket that are not whole, stand
//! only in a plant, as factors of the whole.

use crate::{
    ControlError, FractionalPolynomial, FractionalTransferFunction, Term,
    implicit::{ImplicitFactor, ImplicitFactors},
};
use core::str::FromStr;
use fracdiff::parameter::RangeError;

const DEPTH_MAX: usize = 16;

/// A plant: transfer function, dead time in s, and the other factors.
#[cfg(feature = "std")]
pub(crate) fn plant(
    text: &str,
) -> Result<(FractionalTransferFunction, f64, ImplicitFactors), ControlError> {
    let (value, _) = Quotient::with_place(text)?;
    let (factors, [above, below]) = value.factors.split([value.above, value.below])?;
    let function = FractionalTransferFunction::from_polynomials(above, below)?;
    Ok((function, value.delay_s, factors))
}

/// The summands of a plant. A bracket that is a sum of quotients, with numbers and a dead time beside it, stands for its own.
#[cfg(feature = "std")]
pub(crate) fn summands(text: &str) -> Result<std::vec::Vec<Quotient>, ControlError> {
    let mut reader = Reader::of(text);
    let mut all = std::vec![];
    while all.is_empty() || reader.peek().is_some() {
        let begin = reader.at;
        let whole = reader.summand()?;
        let written = text.get(begin..reader.at).unwrap_or_default();
        match within_bracket(written)? {
            Some(parts) => all.extend(parts),
            None => all.push(whole),
        }
    }
    Ok(all)
}

/// The summands of the first bracket of a product, with what stands beside it; `None` where that moves, or where they have one denominator.
#[cfg(feature = "std")]
fn within_bracket(product: &str) -> Result<Option<std::vec::Vec<Quotient>>, ControlError> {
    let mut depth = 0_i32;
    let mut last = ' ';
    let open = product.char_indices().find_map(|(place, next)| {
        let multiplies = !(last.is_alphabetic() || last == '^' || last == '/');
        let begins = next == '(' && depth == 0 && multiplies;
        depth += i32::from(next == '(') - i32::from(next == ')');
        last = if next.is_whitespace() { last } else { next };
        begins.then_some(place)
    });
    let Some(open) = open else { return Ok(None) };
    let mut inside = Reader {
        at: open,
        ..Reader::of(product)
    };
    inside.bracket()?;
    let [first, bracket, last] = [0..open, open + 1..inside.at - 1, inside.at..product.len()]
        .map(|part| product.get(part).unwrap_or_default());
    if last.trim_start().starts_with('^') {
        return Ok(None);
    }
    let (beside, _) = Quotient::with_place(&std::format!("{first}(1){last}"))?;
    let parts = summands(bracket)?;
    let stands = |side: &FractionalPolynomial| side.degree() == 0.0;
    let is_number = stands(&beside.above) && stands(&beside.below) && beside.factors.is_empty();
    if !is_number || parts.iter().all(|part| stands(&part.below)) {
        return Ok(None);
    }
    let parts = parts.iter().map(|part| part.times(&beside));
    parts.collect::<Result<_, _>>().map(Some)
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
    /// Any quotient, proper or not, perhaps with a dead time.
    pub(crate) fn read(text: &str) -> Result<Self, ControlError> {
        let (value, _) = Self::with_place(text)?;
        value.factors.refused()?;
        Ok(value)
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
        let value = Quotient::read(text)?;
        if value.delay_s > 0.0 {
            let allowed = "0: only a plant has one";
            return Err(RangeError::new("dead time", value.delay_s, allowed, "s").into());
        }
        Self::from_polynomials(value.above, value.below)
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
            let is_plain = |part: &Quotient| part.delay_s == 0.0 && part.factors.is_empty();
            if !is_plain(&sum) || !is_plain(&next) {
                self.at = start;
                return Err(self.wrong(
                    "a factor (a dead time must precede the whole function, as must exp(-sqrt(s)) or (s+1)^0.6)",
                ));
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
        if !self.is_root() && self.takes(b's') {
            let order = self.power_of_s()?;
            return Quotient::of(Term::new(1.0, order));
        }
        let base = self.atom()?;
        if !self.takes(b'^') {
            return Ok(base);
        }
        let start = self.at;
        let exponent = self.exponent()?;
        self.raised(&base, exponent, start)
    }

    fn raised(&self, base: &Quotient, exponent: f64, at: usize) -> Result<Quotient, ControlError> {
        if (libm::trunc(exponent) - exponent).abs() == 0.0 && exponent.abs() > 4.0 {
            let allowed = "from -4 to 4, the highest order: write a further lag as a dead time, as in exp(-s)/(s+1)^4";
            return Err(RangeError::new("power of a bracket", exponent, allowed, "").into());
        }
        base.raised_to(exponent)?.ok_or(ControlError::Notation {
            at,
            expected: "0, 1, 2, 3 or 4 as the power of this bracket: any power has one such as (0.2s+1), both numbers above 0",
        })
    }

    /// The exponent after s, 1 without one.
    fn power_of_s(&mut self) -> Result<f64, ControlError> {
        if self.takes(b'^') {
            self.exponent()
        } else {
            Ok(1.0)
        }
    }

    fn is_root(&mut self) -> bool {
        self.peek();
        let rest = self.text.get(self.at..).unwrap_or_default();
        rest.starts_with(b"sqrt(")
    }

    /// The sum in the brackets of a root.
    fn root(&mut self) -> Result<Quotient, ControlError> {
        self.at += b"sqrt".len();
        self.bracket()
    }

    fn bracket(&mut self) -> Result<Quotient, ControlError> {
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

    fn atom(&mut self) -> Result<Quotient, ControlError> {
        match self.peek() {
            Some(b'(') => self.bracket(),
            Some(b's') if self.is_root() => {
                let start = self.at;
                let base = self.root()?;
                self.raised(&base, 0.5, start)
            }
            Some(b'e') => self.exponential(),
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
            self.power_of_s()?
        } else {
            0.0
        };
        Err(ControlError::ZeroCoefficient { order })
    }

    /// `exp(-0.5s)` or `e^(-0.5s)`; `exp(-2sqrt(s+1))`.
    fn exponential(&mut self) -> Result<Quotient, ControlError> {
        let expected = "exp(-0.5s), a dead time, or exp(-sqrt(0.5s)), diffusion";
        let rest = self.text.get(self.at..).unwrap_or_default();
        let length = match rest {
            [b'e', b'x', b'p', ..] => 3,
            [b'e', b'^', ..] => 2,
            _ => return Err(self.wrong(expected)),
        };
        self.at += length;
        self.expects(b'(', expected)?;
        let sign = if self.takes(b'-') { -1.0 } else { 1.0 };
        let size = if self.peek() == Some(b's') {
            1.0
        } else {
            self.number()?
        };
        self.takes(b'*');
        let factor = sign * size;
        let mut value = Quotient::of(Term::new(1.0, 0.0))?;
        let start = self.at;
        let of_base =
            |[slope, constant]: [f64; 2]| ImplicitFactor::diffusion(slope, constant, factor);
        let diffusion = if self.is_root() {
            self.root()?.bracket().map(of_base)
        } else {
            self.expects(b's', expected)?;
            let order = self.power_of_s()?;
            if (order - 1.0).abs() == 0.0 {
                value.delay_s = -factor;
                self.expects(b')', "a closing bracket")?;
                return Ok(value);
            }
            ((order - 0.5).abs() == 0.0).then(|| of_base([1.0, 0.0]))
        };
        let Some(diffusion) = diffusion else {
            self.at = start;
            return Err(self.wrong(expected));
        };
        value.factors.push(diffusion)?;
        self.expects(b')', "a closing bracket")?;
        Ok(value)
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
    pub above: FractionalPolynomial,
    pub below: FractionalPolynomial,
    pub delay_s: f64,
    pub factors: ImplicitFactors,
}

impl Quotient {
    pub(crate) const fn plain(above: FractionalPolynomial, below: FractionalPolynomial) -> Self {
        Self {
            above,
            below,
            delay_s: 0.0,
            factors: ImplicitFactors::NONE,
        }
    }

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
        let mut value = Self::plain(FractionalPolynomial::ZERO, FractionalPolynomial::ZERO);
        value.above.add(above)?;
        value.below.add(below)?;
        Ok(value)
    }

    pub(crate) fn times(&self, other: &Self) -> Result<Self, ControlError> {
        let mut factors = self.factors;
        let mut left = 1.0;
        for factor in other.factors.all() {
            left *= factors.push(*factor)?;
        }
        Ok(Self {
            above: self.above.times(&other.above)?.scaled(left),
            below: self.below.times(&other.below)?,
            delay_s: self.delay_s + other.delay_s,
            factors,
        }
        .shortened())
    }

    pub(crate) fn over(&self, other: &Self) -> Result<Self, ControlError> {
        other.above.checked("denominator")?;
        self.times(&Self {
            above: other.below,
            below: other.above,
            delay_s: -other.delay_s,
            factors: other.factors.to_the(-1.0),
        })
    }

    /// b and c of bs + c, neither below 0 and b above it.
    fn bracket(&self) -> Option<[f64; 2]> {
        let is_plain = self.delay_s == 0.0 && self.factors.is_empty();
        let number = match self.below.terms() {
            [below] if is_plain && below.order == 0.0 => below.coefficient,
            _ => return None,
        };
        let is_one = |term: &Term| (term.order - 1.0).abs() == 0.0;
        let numbers = match self.above.terms() {
            [slope] if is_one(slope) => [slope.coefficient / number, 0.0],
            [slope, constant] if is_one(slope) && constant.order == 0.0 => {
                [slope.coefficient / number, constant.coefficient / number]
            }
            _ => return None,
        };
        (numbers[0] > 0.0 && numbers[1] >= 0.0).then_some(numbers)
    }

    /// A power; `None` of one that is not whole, or above 4, and of no product of single terms and brackets bs + c.
    fn raised_to(&self, exponent: f64) -> Result<Option<Self>, ControlError> {
        let one = Self::of(Term::new(1.0, 0.0))?;
        let whole = (libm::trunc(exponent) - exponent).abs() == 0.0;
        if whole && (-4.0..=4.0).contains(&exponent) {
            let mut power = one;
            for _ in 0..exponent.abs() as usize {
                power = power.times(self)?;
            }
            return if exponent < 0.0 {
                one.over(&power).map(Some)
            } else {
                Ok(Some(power))
            };
        }
        let powers = self.factors.all().iter().all(|factor| factor.is_power);
        if whole || self.delay_s != 0.0 || !powers {
            return Ok(None);
        }
        let factors = self.factors.to_the(exponent);
        let mut power = Self { factors, ..one };
        for (side, exponent) in [(self.above, exponent), (self.below, -exponent)] {
            let next = match side.terms() {
                [one] if one.coefficient > 0.0 => Self::of(Term::new(
                    libm::pow(one.coefficient, exponent),
                    exponent * one.order,
                ))?,
                _ => {
                    let Some([slope, constant]) = Self::plain(side, one.below).bracket() else {
                        return Ok(None);
                    };
                    let mut next = one;
                    let factor = ImplicitFactor::power(slope, constant, exponent);
                    next.factors.push(factor)?;
                    next
                }
            };
            power = power.times(&next)?;
        }
        Ok(Some(power))
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
            ..*self
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
