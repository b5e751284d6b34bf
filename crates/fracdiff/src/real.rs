//! The two floating-point types an operator can stream in.

use core::fmt::{Debug, Display};
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

mod sealed {
    #[cfg(not(feature = "serde"))]
    pub trait Sealed {}
    #[cfg(feature = "serde")]
    pub trait Sealed: serde::Serialize + serde::de::DeserializeOwned {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// A sample or coefficient: `f32` or `f64`.
///
/// Coefficients are always computed in `f64` and rounded once by [`Real::from_f64`]. Sealed:
/// the bit-for-bit promise of this crate is tested for these two types only.
pub trait Real:
    Copy
    + Debug
    + Default
    + Display
    + PartialEq
    + PartialOrd
    + Add<Output = Self>
    + AddAssign
    + Sub<Output = Self>
    + SubAssign
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Send
    + Sync
    + sealed::Sealed
    + 'static
{
    /// Zero.
    const ZERO: Self;
    /// One.
    const ONE: Self;
    /// True if slow recursions need a second word to keep their increments: true for `f32`, false for `f64`.
    const COMPENSATED: bool;
    /// The step from 1 to the next number: a sum or product is off by half of this share of itself at most.
    const EPSILON: Self;
    /// A decayed state below this counts as zero: 2^(−90), 8e-28, or 2^(−900), 1e-271. Far above the subnormal
    /// numbers, so that its products with weights are normal too, and far below any signal.
    const NEGLIGIBLE: Self;

    /// Rounds to nearest, ties to even.
    fn from_f64(value: f64) -> Self;

    /// This number in double precision, exactly.
    fn to_f64(self) -> f64;

    /// Neither infinite nor NaN.
    fn is_finite(self) -> bool;

    /// The size, without the sign.
    fn abs(self) -> Self;

    /// Square root, rounded to nearest; NaN below zero.
    fn sqrt(self) -> Self;

    /// 1/√x within 3.5 %, of a normal number above 0: by its bits, without a step of Newton's.
    fn rough_inverse_root(self) -> Self;
}

macro_rules! real {
    ($float:ty, compensated: $compensated:expr, negligible: $negligible:expr, sqrt: $sqrt:path,
     inverse_root: $magic:literal) => {
        impl Real for $float {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const COMPENSATED: bool = $compensated;
            const EPSILON: Self = <$float>::EPSILON;
            const NEGLIGIBLE: Self = $negligible;

            #[inline]
            fn from_f64(value: f64) -> Self {
                value as Self
            }

            #[inline]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }

            #[inline]
            fn is_finite(self) -> bool {
                <$float>::is_finite(self)
            }

            #[inline]
            fn abs(self) -> Self {
                <$float>::abs(self)
            }

            #[inline]
            fn sqrt(self) -> Self {
                $sqrt(self)
            }

            #[inline]
            fn rough_inverse_root(self) -> Self {
                Self::from_bits($magic - (self.to_bits() >> 1))
            }
        }
    };
}

real!(f32, compensated: true, negligible: f32::from_bits(37 << 23), sqrt: libm::sqrtf,
      inverse_root: 0x5f37_59df);
real!(f64, compensated: false, negligible: f64::from_bits(123 << 52), sqrt: libm::sqrt,
      inverse_root: 0x5fe6_eb50_c7b5_37a9);

/// Adds `increment` and the rounding error kept in `carry` to `sum`, and keeps the new rounding
/// error: Knuth's two-sum, exact for any magnitudes (*The Art of Computer Programming* 2, §4.2.2).
#[inline]
pub(crate) fn add_compensated<F: Real>(sum: &mut F, carry: &mut F, increment: F) {
    let addend = increment + *carry;
    let total = *sum + addend;
    let virtual_addend = total - *sum;
    *carry = (*sum - (total - virtual_addend)) + (addend - virtual_addend);
    *sum = total;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_million_small_increments_are_kept_in_the_carry() {
        // Each alone is lost beside the sum: 2^(−25) of it. Together they are 2^(−5).
        let (mut sum, mut carry) = (1.0_f32, 0.0_f32);
        for _ in 0..1 << 20 {
            add_compensated(&mut sum, &mut carry, 2f32.powi(-25));
        }
        assert_eq!(sum.to_bits(), (1.0_f32 + 2f32.powi(-5)).to_bits());
        // And a large increment does not lose the sum that it swallows.
        let (mut sum, mut carry) = (1.0_f32, 0.0_f32);
        add_compensated(&mut sum, &mut carry, 2f32.powi(30));
        assert_eq!(
            [sum, carry].map(f32::to_bits),
            [2f32.powi(30), 1.0].map(f32::to_bits)
        );
    }

    #[test]
    fn next_to_nothing_is_a_normal_number_with_room_below() {
        assert_eq!(f32::NEGLIGIBLE.to_bits(), 2f32.powi(-90).to_bits());
        assert_eq!(f64::NEGLIGIBLE.to_bits(), 2f64.powi(-900).to_bits());
    }
}
