//! PI^λD^μ and TID.

use crate::ControlError;
use crate::notation::Quotient;
use crate::transfer::{short, size_or_0};
use core::fmt;
use core::str::FromStr;
use fracdiff::parameter::{RangeError, range};
use num_complex::Complex;

/// `K_p + K_i s^(−λ) + K_d s^μ`, as numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PidParameters {
    /// `K_p`, \[u\]/\[y\].
    pub proportional: f64,
    /// `K_i`, \[u\]/\[y\]·s^(−λ).
    pub integral: f64,
    /// λ, above 0 and at most 2; without a meaning where `K_i` is 0.
    pub integral_order: f64,
    /// `K_d`, \[u\]/\[y\]·s^μ.
    pub derivative: f64,
    /// μ, above 0 and at most 2; without a meaning where `K_d` is 0.
    pub derivative_order: f64,
}

/// k·s^μ of (weight·r − y).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BranchParameters {
    pub(crate) gain: f64,
    /// μ, −2 to 2.
    pub(crate) order: f64,
    pub(crate) weight: f64,
}

impl BranchParameters {
    const fn new(gain: f64, order: f64, weight: f64) -> Self {
        Self {
            gain,
            order,
            weight,
        }
    }
}

impl PidParameters {
    /// No gain; orders 1.
    pub const NONE: Self = Self {
        proportional: 0.0,
        integral: 0.0,
        integral_order: 1.0,
        derivative: 0.0,
        derivative_order: 1.0,
    };

    /// C(jω) of the continuous law, ω in rad/s.
    #[must_use]
    pub fn response(&self, omega: f64) -> Complex<f64> {
        let power = |gain: f64, order: f64| {
            if gain == 0.0 {
                return Complex::new(0.0, 0.0);
            }
            let (sin, cos) = libm::sincos(0.5 * core::f64::consts::PI * order);
            Complex::new(cos, sin) * (gain * libm::pow(omega, order))
        };
        power(self.integral, -self.integral_order)
            + power(self.derivative, self.derivative_order)
            + self.proportional
    }

    pub(crate) fn checked(self) -> Result<Self, ControlError> {
        for (what, gain) in [
            ("proportional gain", self.proportional),
            ("integral gain", self.integral),
            ("derivative gain", self.derivative),
        ] {
            size_or_0(what, gain)?;
        }
        let (lambda, mu) = (self.integral_order, self.derivative_order);
        for (what, order, gain) in [
            ("order of the integral", lambda, self.integral),
            ("order of the derivative", mu, self.derivative),
        ] {
            let inside = gain == 0.0 || (order > 0.0 && order <= 2.0);
            range(what, order, inside, "above 0 and at most 2", "")?;
        }
        Ok(self)
    }

    pub(crate) fn branches(&self, set_point: SetPoint) -> [BranchParameters; 3] {
        let (lambda, mu) = (whole(self.integral_order), whole(self.derivative_order));
        [
            BranchParameters::new(self.proportional, 0.0, set_point.proportional),
            BranchParameters::new(self.integral, -lambda, 1.0),
            BranchParameters::new(self.derivative, mu, set_point.derivative),
        ]
    }
}

/// An order, and next to a whole number that: it needs no memory then.
fn whole(order: f64) -> f64 {
    let nearest = libm::round(order);
    if (order - nearest).abs() < 1e-9 {
        nearest
    } else {
        order
    }
}

/// The share of the reference that each part sees: b·r − y and c·r − y. The integral sees all of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SetPoint {
    /// b, of the proportional part.
    pub proportional: f64,
    /// c, of the derivative; 0 differentiates the measurement alone.
    pub derivative: f64,
}

impl SetPoint {
    /// b = 1, c = 0: the derivative of the measurement, no kick by a step of the reference.
    pub const DEFAULT: Self = Self {
        proportional: 1.0,
        derivative: 0.0,
    };
    /// b = c = 1: everything acts on the error.
    pub const ERROR: Self = Self {
        proportional: 1.0,
        derivative: 1.0,
    };

    pub(crate) fn checked(self) -> Result<Self, ControlError> {
        range("set-point weight b", self.proportional, true, "finite", "")?;
        range("set-point weight c", self.derivative, true, "finite", "")?;
        Ok(self)
    }
}

/// `K_t s^(−1/n) + K_i/s + K_d s`, as numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TidParameters {
    /// `K_t`, \[u\]/\[y\]·s^(−1/n).
    pub tilt: f64,
    /// n of the tilt, at least 1 (2 and 3 are usual).
    pub tilt_divisor: f64,
    /// `K_i`, \[u\]/\[y\]/s.
    pub integral: f64,
    /// `K_d`, \[u\]/\[y\]·s.
    pub derivative: f64,
}

impl TidParameters {
    /// C(jω) of the continuous law, ω in rad/s.
    #[must_use]
    pub fn response(&self, omega: f64) -> Complex<f64> {
        let order = 1.0 / self.tilt_divisor;
        let (sin, cos) = libm::sincos(0.5 * core::f64::consts::PI * order);
        let tilt = Complex::new(cos, -sin) * (self.tilt * libm::pow(omega, -order));
        tilt + Complex::new(0.0, self.derivative * omega - self.integral / omega)
    }

    pub(crate) fn branches(
        &self,
        derivative_weight: f64,
    ) -> Result<[BranchParameters; 3], ControlError> {
        let n = self.tilt_divisor;
        range("divisor of the tilt", n, n >= 1.0, "at least 1", "")?;
        for (what, gain) in [
            ("tilt gain", self.tilt),
            ("integral gain", self.integral),
            ("derivative gain", self.derivative),
        ] {
            size_or_0(what, gain)?;
        }
        range("set-point weight c", derivative_weight, true, "finite", "")?;
        Ok([
            BranchParameters::new(self.tilt, -1.0 / self.tilt_divisor, 1.0),
            BranchParameters::new(self.integral, -1.0, 1.0),
            BranchParameters::new(self.derivative, 1.0, derivative_weight),
        ])
    }
}

/// Orders are rounded to this many parts of 1: 0.9 + 0.5 − 0.9 is 0.5 then.
const ORDER_PARTS: f64 = 1e12;

impl FromStr for PidParameters {
    type Err = ControlError;

    /// Reads a sum of a gain, one power of 1/s and one of s: `2+3/s^0.9+0.1s^0.5`. What a part of it leaves out has no gain.
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
        let mut filters = Self::NONE;
        for term in quotient.above.terms() {
            let gain = term.coefficient / below.coefficient;
            let order = libm::round((term.order - below.order) * ORDER_PARTS) / ORDER_PARTS;
            let (place, place_order) = if order == 0.0 {
                filters.proportional = gain;
                continue;
            } else if order < 0.0 {
                (&mut filters.integral, &mut filters.integral_order)
            } else {
                (&mut filters.derivative, &mut filters.derivative_order)
            };
            if *place != 0.0 {
                return Err(refused("further order of the controller", order));
            }
            (*place, *place_order) = (gain, order.abs());
        }
        filters.checked()
    }
}

impl fmt::Display for PidParameters {
    /// Writes the parameters as they are read; parts without a gain are left out.
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
