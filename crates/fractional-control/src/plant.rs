//! The thing to be controlled: a transfer function, matrices, or a measured response, each with a dead time.

use crate::{
    ControlError, FractionalTransferFunction, ImplicitFactor, ImplicitFactors, StateSpace,
    poles::OnAxis,
};
use core::{fmt, str::FromStr};
use fracdiff::parameter::{RangeError, not_negative, positive, range};
use num_complex::Complex;
use std::{boxed::Box, string::ToString, vec::Vec};

/// A plant with a dead time.
/// ```
/// use fractional_control::Plant;
///
/// let oven: Plant = "3.13*exp(-50s)/(433.33s+1)".parse()?;
/// let response = oven.response(0.008).expect("at any frequency");
/// assert!((response.norm() - 3.13 / (433.33_f64 * 0.008).hypot(1.0)).abs() < 1e-12);
/// let rod: Plant = "exp(-sqrt(3s))/(s+1)".parse()?;
/// let response = rod.response(6.0).expect("at any frequency");
/// assert!((response.norm() - f64::exp(-3.0) / 6.0_f64.hypot(1.0)).abs() < 1e-12);
/// # Ok::<(), fractional_control::ControlError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Plant {
    pub(crate) model: Model,
    pub(crate) delay_s: f64,
    /// Further factors of a transfer function.
    pub(crate) factors: ImplicitFactors,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Model {
    Transfer(Box<FractionalTransferFunction>),
    StateSpace(StateSpace),
    Measured(Measured),
}

/// ln ω, ln |G| and the unwrapped phase, ω rising.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Measured(Vec<[f64; 3]>);

impl Plant {
    /// A transfer function behind a dead time, s.
    ///
    /// # Errors
    /// A negative dead time, or one above 1e10 s.
    pub fn transfer(
        function: FractionalTransferFunction,
        delay_s: f64,
    ) -> Result<Self, ControlError> {
        Ok(Self {
            model: Model::Transfer(Box::new(function)),
            delay_s: dead_time(delay_s)?,
            factors: ImplicitFactors::default(),
        })
    }

    /// Matrices behind a dead time, s.
    ///
    /// # Errors
    /// A negative dead time, or one above 1e10 s.
    pub fn state_space(states: StateSpace, delay_s: f64) -> Result<Self, ControlError> {
        Ok(Self {
            model: Model::StateSpace(states),
            delay_s: dead_time(delay_s)?,
            factors: ImplicitFactors::default(),
        })
    }

    /// A measured response, dead time included: (ω in rad/s, G(jω)), in any order. Between two points ln |G| and the phase are straight
    /// lines over ln ω, so neighbours must be less than half a turn apart. It can be tuned for, but not run.
    ///
    /// # Errors
    /// Fewer than three points, a frequency that is not above 0 or occurs twice, a
    /// response that is 0 or not finite.
    pub fn measured(points: &[(f64, Complex<f64>)]) -> Result<Self, ControlError> {
        let count = points.len() as f64;
        let allowed = "at least 3";
        range("number of frequencies", count, count >= 3.0, allowed, "")?;
        let mut sorted = points.to_vec();
        sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut rows: Vec<[f64; 3]> = Vec::new();
        for (omega, response) in sorted {
            positive("frequency", omega, "rad/s")?;
            positive("measured gain", response.norm(), "")?;
            let mut phase = response.arg();
            if let Some(&[last, _, before]) = rows.last() {
                let next = libm::log(omega);
                range("frequency", omega, next > last, "given once", "rad/s")?;
                let turn = 2.0 * core::f64::consts::PI;
                phase += turn * libm::round((before - phase) / turn);
            }
            rows.push([libm::log(omega), libm::log(response.norm()), phase]);
        }
        Ok(Self {
            model: Model::Measured(Measured(rows)),
            delay_s: 0.0,
            factors: ImplicitFactors::default(),
        })
    }

    /// Dead time, s. Of a measured response it is in the response.
    #[must_use]
    pub fn delay_s(&self) -> f64 {
        self.delay_s
    }

    /// Adds dead time, s.
    ///
    /// # Errors
    /// A negative one, more than 1e10 s; any at all for a measured response, which has its own.
    pub fn delayed(self, further_s: f64) -> Result<Self, ControlError> {
        let further_s = not_negative("dead time", further_s, "s")?;
        if further_s > 0.0 && self.is_measured() {
            let allowed = "0: a measured response has its own";
            return Err(RangeError::new("dead time", further_s, allowed, "s").into());
        }
        let delay_s = dead_time(self.delay_s + further_s)?;
        Ok(Self { delay_s, ..self })
    }

    /// Removes the dead time; `None` for a measured response, which contains its own.
    #[must_use]
    pub(crate) fn without_dead_time(&self) -> Option<Self> {
        (!self.is_measured()).then(|| Self {
            delay_s: 0.0,
            ..self.clone()
        })
    }

    /// True of a response that was measured, of which nothing is known beyond its band.
    fn is_measured(&self) -> bool {
        matches!(self.model, Model::Measured(_))
    }

    /// The transfer function without the dead time, of a plant that is one and has no further factors.
    #[must_use]
    pub fn function(&self) -> Option<&FractionalTransferFunction> {
        self.beside_factors().filter(|_| self.factors.is_empty())
    }

    /// The transfer function beside dead time and further factors, which has all the poles.
    pub(crate) fn beside_factors(&self) -> Option<&FractionalTransferFunction> {
        let Model::Transfer(function) = &self.model else {
            return None;
        };
        Some(function)
    }

    /// Powers of brackets and diffusion, by which its transfer function is multiplied: no pole, but cuts.
    #[must_use]
    pub fn factors(&self) -> &ImplicitFactors {
        &self.factors
    }

    /// G(jω) with the dead time; `None` outside the band of a measured response.
    #[must_use]
    pub fn response(&self, omega: f64) -> Option<Complex<f64>> {
        let response = match &self.model {
            Model::Transfer(function) => function.response(omega),
            Model::StateSpace(states) => states.response(omega),
            Model::Measured(measured) => return measured.at(omega),
        };
        let (sin, cos) = libm::sincos(omega * self.delay_s);
        let factors = self.factors.at(Complex::new(0.0, omega));
        Some(response * factors * Complex::new(cos, -sin))
    }

    /// The lowest and the highest frequency at which something is known, rad/s.
    #[must_use]
    pub fn band(&self) -> (f64, f64) {
        let Model::Measured(Measured(rows)) = &self.model else {
            return (0.0, f64::INFINITY);
        };
        let at = |row: Option<&[f64; 3]>| row.map_or(0.0, |row| libm::exp(row[0]));
        (at(rows.first()), at(rows.last()))
    }

    /// d ln G/d ln ω at ω, by a central difference.
    #[must_use]
    pub fn slope(&self, omega: f64) -> Option<Complex<f64>> {
        // Of a measured response across a kink between two straight lines.
        let h = if self.is_measured() { 1e-2 } else { 1e-5 };
        let above = self.response(omega * libm::exp(h))?;
        let below = self.response(omega * libm::exp(-h))?;
        Some((above / below).ln() / (2.0 * h))
    }

    /// The number of its poles with Re s > 0; 0 where that is not known.
    #[must_use]
    pub fn unstable_poles(&self) -> usize {
        match &self.model {
            Model::Transfer(function) => function.growing_poles().unwrap_or(0),
            Model::StateSpace(states) => states.unstable_poles(),
            Model::Measured(_) => 0,
        }
    }

    /// The sign that the integral part of its controller must have: that of b/a, b the coefficient of its numerator that acts at low
    /// frequency and a that of its denominator that acts at high frequency. Of a plant with an odd number of unstable poles it is not
    /// that of the gain at low frequency.
    #[must_use]
    pub fn sign(&self) -> f64 {
        if let Model::Transfer(function) = &self.model
            && let Some(above) = function.numerator().terms().last()
            && let Some(below) = function.denominator().terms().first()
        {
            return above.coefficient.signum() * below.coefficient.signum();
        }
        let low = self.band().0.max(1e-6) * 1.02;
        let response = self.response(low).unwrap_or_default();
        let order = self.slope(low).unwrap_or_default().re;
        let (sin, cos) = libm::sincos(0.5 * core::f64::consts::PI * order);
        let turned = (response * Complex::new(cos, -sin)).re;
        let odd = self.unstable_poles() % 2 == 1;
        if (turned < 0.0) == odd { 1.0 } else { -1.0 }
    }

    /// The phase of sign·G for ω → 0, rad: ω^n turns by nπ/2, and a pole that grows begins with half a turn of lag. `low` is a frequency
    /// at which the slope is that at rest.
    #[must_use]
    pub fn phase_at_rest(&self, low: f64) -> f64 {
        let order = self.slope(low).unwrap_or_default().re;
        core::f64::consts::PI * (0.5 * order - self.unstable_poles() as f64)
    }

    /// The degree of the denominator; 0 of a measured response, which is taken for one without poles that grow.
    #[must_use]
    pub fn degree(&self) -> f64 {
        match &self.model {
            Model::Transfer(function) => function.denominator().degree(),
            Model::StateSpace(states) => states.poles().len() as f64,
            Model::Measured(_) => 0.0,
        }
    }

    /// ln of the size of the denominator at jω, and its direction, with a positive coefficient of the highest power.
    #[must_use]
    pub fn denominator(&self, omega: f64) -> (f64, Complex<f64>) {
        let (scale, value) = match &self.model {
            Model::Transfer(function) => {
                let (axis, x) = (OnAxis(function.denominator()), libm::log(omega));
                let scale = axis.scale(x);
                let terms = function.denominator().terms();
                let sign = terms.first().map_or(1.0, |term| term.coefficient.signum());
                (scale, axis.at(x, scale) * sign)
            }
            Model::StateSpace(states) => {
                let factors = states.poles().into_iter();
                let factors = factors.map(|pole| Complex::new(0.0, omega) - pole);
                (0.0, factors.product())
            }
            Model::Measured(_) => (0.0, Complex::new(1.0, 0.0)),
        };
        let size = value.norm();
        (scale + libm::log(size), value / size)
    }

    /// The angle by which the denominator turns from this frequency on, rad.
    #[must_use]
    pub fn denominator_turn_from(&self, omega: f64) -> f64 {
        match &self.model {
            Model::Transfer(function) => OnAxis(function.denominator()).turn_from(omega),
            Model::StateSpace(states) => {
                let poles = states.poles().into_iter();
                let left = poles
                    .map(|pole| (Complex::new(0.0, 1.0) / (Complex::new(0.0, omega) - pole)).arg());
                left.sum()
            }
            Model::Measured(_) => 0.0,
        }
    }

    /// Refuses a plant that is to be simulated alone but does not settle.
    ///
    /// # Errors
    /// [`ControlError::UnstablePlant`].
    pub fn stable_by_itself(&self) -> Result<(), ControlError> {
        match &self.model {
            Model::Transfer(function) => function.stable_by_itself(),
            Model::StateSpace(states) => match states.undamped_poles() {
                0 => Ok(()),
                poles => Err(ControlError::UnstablePlant { poles }),
            },
            Model::Measured(_) => Ok(()),
        }
    }

    /// The order of the factor s^a that it has at rest, below 0 where it adds up; 0 of a plant that is no transfer function.
    #[must_use]
    pub fn order_at_rest(&self) -> f64 {
        self.beside_factors().map_or(0.0, |function| {
            function.numerator().lowest() - function.denominator().lowest()
        })
    }

    /// Its poles s: of a function whose orders are multiples of one those on the principal branch,
    /// of matrices the eigenvalues; `None` for any other.
    #[must_use]
    pub fn poles(&self) -> Option<Vec<Complex<f64>>> {
        match &self.model {
            Model::Transfer(function) => Some(function.commensurate().ok()?.poles()),
            Model::StateSpace(states) => Some(states.poles()),
            Model::Measured(_) => None,
        }
    }
}

/// A dead time in its range: 10 000 of the longest samples.
fn dead_time(seconds: f64) -> Result<f64, RangeError> {
    let inside = (0.0..=1e10).contains(&seconds);
    range("dead time", seconds, inside, "from 0 to 1e10 {}", "s")
}

impl Measured {
    fn at(&self, omega: f64) -> Option<Complex<f64>> {
        let x = libm::log(omega);
        let above = self.0.iter().position(|row| row[0] >= x)?;
        let pair = self.0.get(above.max(1) - 1..=above.max(1))?;
        let [a, b] = pair else { return None };
        let share = (x - a[0]) / (b[0] - a[0]);
        if share < -1e-9 {
            return None;
        }
        let between = |k: usize| a[k] + share * (b[k] - a[k]);
        let (sin, cos) = libm::sincos(between(2));
        Some(Complex::new(cos, sin) * libm::exp(between(1)))
    }
}

impl FromStr for Plant {
    type Err = ControlError;

    /// Reads a transfer function; `exp(-0.5s)` as a factor is a dead time of 0.5 s, `exp(-sqrt(3s))` diffusion, and `(0.2s+1)^0.6` any power.
    fn from_str(text: &str) -> Result<Self, ControlError> {
        let (function, delay_s, factors) = crate::notation::plant(text)?;
        let plant = Self::transfer(function, delay_s)?;
        Ok(Self { factors, ..plant })
    }
}

/// The notation that is read; of matrices and of a measured response their kind alone.
impl fmt::Display for Plant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.delay_s > 0.0 {
            f.write_str("exp(-")?;
            crate::transfer::short(f, self.delay_s)?;
            f.write_str("s)*")?;
        }
        let function = match &self.model {
            Model::Transfer(function) => function.to_string(),
            Model::StateSpace(_) => return f.write_str("matrices"),
            Model::Measured(_) => return f.write_str("measured response"),
        };
        let (powers, diffusion): (Vec<ImplicitFactor>, Vec<_>) = self
            .factors
            .all()
            .iter()
            .copied()
            .partition(|factor: &ImplicitFactor| factor.is_power);
        for (n, factor) in diffusion.iter().enumerate() {
            write!(f, "{}{factor}", if n > 0 { "*" } else { "" })?;
        }
        match function.strip_prefix('1') {
            Some(below) if !diffusion.is_empty() && !below.starts_with(|next| next != '/') => {
                f.write_str(below)?;
            }
            _ if !diffusion.is_empty() => write!(f, "*{function}")?,
            _ => f.write_str(&function)?,
        }
        for factor in powers {
            let sign = if factor.order < 0.0 { "/" } else { "*" };
            write!(f, "{sign}{factor}")?;
        }
        Ok(())
    }
}
