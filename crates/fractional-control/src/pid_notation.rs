//! A PI^λD^μ in the usual notation, and its loop with a plant as a function.

use crate::polynomial::short;
use crate::quotient::Quotient;
use crate::{ControlError, FractionalTransferFunction, PidParameters};
use core::fmt;
use core::str::FromStr;
use fracdiff::parameter::RangeError;

/// Orders are read to so many parts of 1: 0.9 + 0.5 − 0.9 is 0.5 then.
const ORDER_PARTS: f64 = 1e12;

impl FromStr for PidParameters {
    type Err = ControlError;

    /// As a sum of a gain, one power of 1/s and one of s: `2+3/s^0.9+0.1s^0.5`. What a part of it leaves out has no gain.
    ///
    /// ```
    /// use fractional_control::PidParameters;
    ///
    /// let pd: PidParameters = "20.5+3.7343s^1.15".parse()?;
    /// assert_eq!((pd.proportional, pd.derivative, pd.derivative_order), (20.5, 3.7343, 1.15));
    /// let pi: PidParameters = "2(1+1/(4s^0.9))".parse()?;
    /// assert_eq!((pi.integral, pi.integral_order), (0.5, 0.9));
    /// # Ok::<(), fractional_control::ControlError>(())
    /// ```
    fn from_str(text: &str) -> Result<Self, ControlError> {
        let quotient = Quotient::read(text)?;
        let refused = |what, value| {
            let allowed = "that of a PI^λD^μ: a gain, one power of 1/s and one of s, as in 2+3/s^0.9+0.1s^0.5";
            ControlError::Range(RangeError::new(what, value, allowed, ""))
        };
        if quotient.delay_s > 0.0 {
            return Err(refused("dead time of the controller", quotient.delay_s));
        }
        let [below] = quotient.below.terms() else {
            let count = quotient.below.terms().len();
            return Err(refused(
                "number of terms in the denominator of the controller",
                count as f64,
            ));
        };
        let mut own = Self::NONE;
        for term in quotient.above.terms() {
            let gain = term.coefficient / below.coefficient;
            let order = libm::round((term.order - below.order) * ORDER_PARTS) / ORDER_PARTS;
            let (place, place_order) = if order == 0.0 {
                own.proportional = gain;
                continue;
            } else if order < 0.0 {
                (&mut own.integral, &mut own.integral_order)
            } else {
                (&mut own.derivative, &mut own.derivative_order)
            };
            if *place != 0.0 {
                return Err(refused("further order of the controller", order));
            }
            (*place, *place_order) = (gain, order.abs());
        }
        own.checked()
    }
}

impl fmt::Display for PidParameters {
    /// As it is read; parts without a gain are left out.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let power = |f: &mut fmt::Formatter<'_>, before: &str, order: f64| {
            if (order - 1.0).abs() > 0.0 {
                write!(f, "{before}s^{order}")
            } else {
                write!(f, "{before}s")
            }
        };
        let nothing = self.integral == 0.0 && self.derivative == 0.0;
        let mut sign = "";
        if self.proportional != 0.0 || nothing {
            short(f, self.proportional)?;
            sign = "+";
        }
        for (gain, before, order) in [
            (self.integral, "/", self.integral_order),
            (self.derivative, "", self.derivative_order),
        ] {
            if gain == 0.0 {
                continue;
            }
            let sign_here = if gain < 0.0 { "" } else { sign };
            f.write_str(sign_here)?;
            short(f, gain)?;
            power(f, before, order)?;
            sign = "+";
        }
        Ok(())
    }
}

impl PidParameters {
    /// C·G/(1 + C·G), in continuous time, without a dead time: its poles are those of the loop, as far as sampling is fast.
    ///
    /// # Errors
    /// A function of orders above 4 or with too many terms, an order of the loop that cancels.
    pub fn closed_with(
        &self,
        plant: &FractionalTransferFunction,
    ) -> Result<FractionalTransferFunction, ControlError> {
        use crate::{FractionalPolynomial, Term};
        let rise = if self.integral == 0.0 {
            0.0
        } else {
            self.integral_order
        };
        let mut above = FractionalPolynomial::ZERO;
        for (gain, order) in [
            (self.integral, 0.0),
            (self.proportional, rise),
            (self.derivative, rise + self.derivative_order),
        ] {
            if gain != 0.0 {
                above.add(Term::new(gain, order))?;
            }
        }
        let mut below = FractionalPolynomial::ZERO;
        below.add(Term::new(1.0, rise))?;
        let open = above.times(plant.numerator())?;
        FractionalTransferFunction::from_polynomials(
            open,
            open.plus(&below.times(plant.denominator())?)?,
        )
    }
}
