//! Factors of a plant that are no quotient of powers of s: powers of a bracket, and diffusion.

use crate::{ControlError, FractionalPolynomial, Term, transfer::short};
use core::fmt;
#[cfg(feature = "std")]
use fracdiff::parameter::range;
use num_complex::Complex;

/// Factors of one plant at most.
const FACTORS_MAX: usize = 4;
/// Powers closer to a whole number than this are whole; digits of the others.
const SAME: f64 = 1e-9;
const DIGITS: f64 = 1e12;

/// `(bs + c)^α` with an α that is not whole, or `exp(−k√(bs + c))`; b > 0, k > 0, c > 0, of diffusion c ≥ 0.
///
/// The first is D. W. Davidson and R. H. Cole's element (*J. Chem. Phys.* 19, 1951), a rod that loses heat, a line with losses; the second is a
/// half-infinite rod seen at a distance. Both are analytic and not 0 for Re s > 0, so they add no pole there; they have a cut from −c/b to −∞.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImplicitFactor {
    pub(crate) is_power: bool,
    /// b, in s of a power with c = 1.
    pub(crate) slope: f64,
    /// c.
    pub(crate) constant: f64,
    /// α, or −k.
    pub(crate) order: f64,
}

impl ImplicitFactor {
    pub(crate) const fn power(slope: f64, constant: f64, order: f64) -> Self {
        let is_power = true;
        Self {
            is_power,
            slope,
            constant,
            order,
        }
    }

    pub(crate) const fn diffusion(slope: f64, constant: f64, order: f64) -> Self {
        let is_power = false;
        Self {
            is_power,
            slope,
            constant,
            order,
        }
    }

    /// Size of s at which its cut begins: c/b, rad/s.
    pub(crate) fn branch(&self) -> f64 {
        self.constant / self.slope
    }

    /// The value, from that of bs + c.
    pub(crate) fn of_base(&self, base: Complex<f64>) -> Complex<f64> {
        if self.is_power {
            let (size, angle) = (libm::hypot(base.re, base.im), libm::atan2(base.im, base.re));
            return Complex::from_polar(libm::pow(size, self.order), self.order * angle);
        }
        (base.sqrt() * self.order).exp()
    }

    #[cfg(feature = "std")]
    fn checked(&self) -> Result<(), ControlError> {
        for (what, value) in [
            ("number before s", self.slope),
            ("number in a bracket", self.constant),
        ] {
            crate::transfer::size_or_0(what, value)?;
        }
        let inside = self.is_power || self.order < 0.0;
        let allowed = "below 0: diffusion does not grow";
        range("factor of the root in exp", self.order, inside, allowed, "")?;
        Ok(())
    }
}

impl fmt::Display for ImplicitFactor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut base = FractionalPolynomial::ZERO;
        for term in [Term::new(self.slope, 1.0), Term::new(self.constant, 0.0)] {
            if term.coefficient != 0.0 {
                base.add(term).map_err(|_| fmt::Error)?;
            }
        }
        if self.is_power {
            write!(f, "({base})^")?;
            return short(f, self.order.abs());
        }
        f.write_str("exp(-")?;
        if (self.order + 1.0).abs() > 0.0 {
            short(f, -self.order)?;
        }
        write!(f, "sqrt({base}))")
    }
}

/// The product of at most four such factors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImplicitFactors {
    all: [ImplicitFactor; FACTORS_MAX],
    count: usize,
}

impl Default for ImplicitFactors {
    fn default() -> Self {
        Self::NONE
    }
}

impl ImplicitFactors {
    /// No factor: 1.
    pub(crate) const NONE: Self = Self {
        all: [ImplicitFactor::power(1.0, 1.0, 0.0); FACTORS_MAX],
        count: 0,
    };

    /// The factors.
    #[must_use]
    pub fn all(&self) -> &[ImplicitFactor] {
        self.all.get(..self.count).unwrap_or_default()
    }

    /// Refuses any factor, where powers of s alone can stand.
    ///
    /// # Errors
    /// [`ControlError::OnlyInPlant`].
    pub fn refused(&self) -> Result<(), ControlError> {
        let refused = |factor: &ImplicitFactor| ControlError::OnlyInPlant {
            what: if factor.is_power {
                "a bracket to the power"
            } else {
                "diffusion, exp(ksqrt(s)) with k ="
            },
            value: factor.order,
        };
        self.all().first().map(refused).map_or(Ok(()), Err)
    }

    /// True of 1.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The frequencies about which they bend, rad/s.
    pub fn corners(&self) -> impl Iterator<Item = f64> {
        self.all().iter().map(|factor| {
            let swings = factor.order * factor.order * factor.slope;
            factor.branch() + if factor.is_power { 0.0 } else { 1.0 / swings }
        })
    }

    /// H(s), on the principal branch.
    #[must_use]
    pub fn at(&self, s: Complex<f64>) -> Complex<f64> {
        let all = self.all().iter();
        all.map(|factor| factor.of_base(s * factor.slope + factor.constant))
            .product()
    }

    /// The sum of its powers, by which it grows with ω; `None` with diffusion, which falls faster than any.
    #[cfg(feature = "std")]
    pub(crate) fn degree(&self) -> Option<f64> {
        let all = self.all();
        let is_known = all.iter().all(|factor| factor.is_power);
        is_known.then(|| all.iter().map(|factor| factor.order).sum())
    }

    /// Multiplies by a factor; the number that is left where that has the branch of another, as (2s + 2)^α = 2^α·(s + 1)^α.
    pub(crate) fn push(&mut self, factor: ImplicitFactor) -> Result<f64, ControlError> {
        let count = self.count;
        let same = |known: &&mut ImplicitFactor| {
            known.is_power == factor.is_power
                && (known.branch() - factor.branch()).abs() <= SAME * factor.branch()
        };
        if let Some(known) = self.all[..count].iter_mut().find(same) {
            let ratio = factor.slope / known.slope;
            let left = if factor.is_power {
                known.order += factor.order;
                libm::pow(ratio, factor.order)
            } else {
                known.order += factor.order * libm::sqrt(ratio);
                1.0
            };
            return Ok(left);
        }
        let Some(free) = self.all.get_mut(count) else {
            let (count, most) = (FACTORS_MAX + 1, FACTORS_MAX);
            return Err(ControlError::TooManyTerms { count, most });
        };
        *free = factor;
        self.count += 1;
        Ok(1.0)
    }

    /// All orders times this number: the power of a product of powers, one over any product.
    pub(crate) fn to_the(mut self, order: f64) -> Self {
        for factor in &mut self.all {
            factor.order *= order;
        }
        self
    }

    /// The factors with powers between −1 and 0, and what is left of the others as whole powers of brackets above and below.
    ///
    /// One may be between 0 and 1 in place of a whole bracket above, where the rest would grow with ω.
    ///
    /// # Errors
    /// A factor outside its range; a rest that still grows, or powers that do not fall beside a rest that moves: its input would jump.
    #[cfg(feature = "std")]
    pub(crate) fn split(
        &self,
        [mut above, mut below]: [FractionalPolynomial; 2],
    ) -> Result<(Self, [FractionalPolynomial; 2]), ControlError> {
        let (mut all, mut orders) = (self.all, [above.degree(), below.degree()]);
        // As it is written: 0.6 is left of 1.6.
        let less = |order: f64, whole: f64| match whole {
            0.0 => order,
            _ => libm::round((order - whole) * DIGITS) / DIGITS,
        };
        // The whole power of each, and by what the rest then grows.
        let mut wholes = [0.0; FACTORS_MAX];
        for (factor, whole) in all.iter_mut().zip(&mut wholes).take(self.count) {
            factor.checked()?;
            let nearest = libm::round(factor.order);
            if factor.is_power {
                orders[usize::from(factor.order < 0.0)] += factor.order.abs();
                if (factor.order - nearest).abs() < SAME {
                    factor.order = nearest;
                }
                // At least the power, and less than it and 1.
                *whole = libm::ceil(factor.order);
                factor.order = less(factor.order, *whole);
            }
        }
        let mut grows = above.degree() - below.degree() + wholes.iter().sum::<f64>();
        for (factor, whole) in all.iter_mut().zip(&mut wholes) {
            if grows > SAME && factor.is_power && factor.order < 0.0 {
                factor.order = less(factor.order, -1.0);
                (*whole, grows) = (*whole - 1.0, grows - 1.0);
            }
            let side = if *whole > 0.0 { &mut above } else { &mut below };
            // A higher power is refused as an order above 4.
            for _ in 0..whole.abs().min(5.0) as usize {
                *side = side.times(&FractionalPolynomial::new(&[
                    Term::new(factor.slope, 1.0),
                    Term::new(factor.constant, 0.0),
                ])?)?;
            }
        }
        let mut left = Self::NONE;
        for factor in all.iter().filter(|factor| factor.order != 0.0) {
            left.push(*factor)?;
        }
        let [numerator, denominator] = orders;
        if left.degree().is_some() && numerator > denominator + SAME {
            return Err(ControlError::Improper {
                numerator,
                denominator,
            });
        }
        let (rises, falls) = (above.degree(), below.degree());
        let moves = rises > 0.0 || falls > 0.0;
        let jumps = |degree: f64| degree > SAME || moves && degree > -SAME;
        let is_fast = rises > falls || left.degree().is_some_and(jumps);
        if is_fast && !left.is_empty() {
            return Err(ControlError::BesideFactors {
                numerator,
                denominator,
            });
        }
        Ok((left, [above, below]))
    }
}
