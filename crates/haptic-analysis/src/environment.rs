//! The virtual environment alone, as it feels at one frequency.

use crate::{AnalysisError, Loop};
use fracdiff::parameter::{not_negative, positive, range};
use fracdiff::{FrequencyResponse, Order};
use num_complex::Complex;
use std::f64::consts::PI;

/// A virtual wall of fractional order, sampled: what the loop computes from a position.
///
/// ```text
/// H(w) = K + B·T^(−μ)·P(w)
/// ```
/// The force on the device is −H·x: a positive displacement is pushed back. The formulas here and in
/// [`ClosedLoop`](crate::ClosedLoop) hold for every order an [`Order`] can have; theorems about
/// passivity do not.
/// Source: O. Tokatlı, *Fractional Order Control in Haptics*, eq. 3.8.
///
/// ```
/// use fracdiff::{ExactDifference, Order};
/// use haptic_analysis::Environment;
///
/// let order = Order::new(0.5)?;
/// let wall = Environment {
///     stiffness_n_per_m: 500.0,
///     dissipation_n_s_mu_per_m: 3.0,
///     order,
///     sample_time_s: 1e-3,
/// };
/// let felt = wall.effective(&ExactDifference(order), 10.0)?; // at 10 rad/s
/// assert!((felt.stiffness_n_per_m - 506.7).abs() < 0.1); // K + B·ω^μ·cos(πμ/2)
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Environment {
    /// K, N/m, at least 0.
    pub stiffness_n_per_m: f64,
    /// B, N·s^μ/m, at least 0.
    pub dissipation_n_s_mu_per_m: f64,
    /// μ.
    pub order: Order,
    /// T, s, above 0.
    pub sample_time_s: f64,
}

/// A complex impedance read as a spring and a damper at one frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Effective {
    /// ω, rad/s.
    pub omega_rad_s: f64,
    /// Effective stiffness ES, N/m; positive pushes back.
    pub stiffness_n_per_m: f64,
    /// Effective damping ED, N·s/m; positive takes energy.
    pub damping_n_s_per_m: f64,
}

impl Environment {
    /// Effective stiffness and damping with the operator really used.
    ///
    /// ```text
    /// ES(ω) = Re H(e^(−jωT)),    ED(ω) = Im H(e^(−jωT))/ω
    /// ```
    /// For the exact operator ES = K + B(2 sin(θ/2)/T)^μ cos(μ(π−θ)/2), θ = ωT, and ED the same with
    /// a sine, without K, over ω. (The dissertation drops the T^(−μ).)
    ///
    /// - `omega_rad_s`: 0 < ω ≤ π/T, rad/s.
    /// - `operator`: P, made for this order; a response only, so the exact operator too.
    /// - Cost: one response.
    ///
    /// # Errors
    /// A parameter or ω outside its range, or a result too large for a number.
    ///
    /// ```
    /// use fracdiff::{ExactDifference, Order};
    /// use haptic_analysis::Environment;
    ///
    /// let order = Order::new(1.0)?;
    /// let wall = Environment {
    ///     stiffness_n_per_m: 1e4,
    ///     dissipation_n_s_mu_per_m: 100.0,
    ///     order,
    ///     sample_time_s: 1e-3,
    /// };
    /// let felt = wall.effective(&ExactDifference(order), 1.0)?;
    /// assert!((felt.damping_n_s_per_m - 100.0).abs() < 1e-4); // B sin(ωT)/(ωT)
    /// # Ok::<(), haptic_analysis::AnalysisError>(())
    /// ```
    ///
    /// Source: O. Tokatlı, *Fractional Order Control in Haptics*, eqs. 3.10–3.13.
    pub fn effective(
        &self,
        operator: &(impl FrequencyResponse + ?Sized),
        omega_rad_s: f64,
    ) -> Result<Effective, AnalysisError> {
        let h = self.checked()?.response(operator, self.theta(omega_rad_s)?);
        // ES = Re H, ED = Im H/ω
        Effective::new(omega_rad_s, h.re, h.im / omega_rad_s)
    }

    /// H(e^(−jθ)), N/m.
    pub(crate) fn response(
        &self,
        operator: &(impl FrequencyResponse + ?Sized),
        theta: f64,
    ) -> Complex<f64> {
        let rate = libm::pow(self.sample_time_s, -self.order.get());
        operator.response(theta) * (self.dissipation_n_s_mu_per_m * rate) + self.stiffness_n_per_m
    }

    /// θ = ωT, for 0 < ω ≤ π/T; a rounding error above π is π.
    pub(crate) fn theta(&self, omega_rad_s: f64) -> Result<f64, AnalysisError> {
        Ok(turned(omega_rad_s, self.sample_time_s)?.min(PI))
    }

    /// Itself, if its parameters are in range.
    pub(crate) fn checked(&self) -> Result<Self, AnalysisError> {
        not_negative("stiffness", self.stiffness_n_per_m, "N/m")?;
        not_negative("dissipation", self.dissipation_n_s_mu_per_m, "N·s^μ/m")?;
        positive("sample time", self.sample_time_s, "s")?;
        Ok(*self)
    }
}

impl From<&Loop> for Environment {
    fn from(system: &Loop) -> Self {
        Self {
            stiffness_n_per_m: system.stiffness_n_per_m,
            dissipation_n_s_mu_per_m: system.dissipation_n_s_mu_per_m,
            order: system.order,
            sample_time_s: system.sample_time_s,
        }
    }
}

impl Effective {
    /// Refuses what is not a number.
    pub(crate) fn new(
        omega_rad_s: f64,
        stiffness_n_per_m: f64,
        damping_n_s_per_m: f64,
    ) -> Result<Self, AnalysisError> {
        finite("effective stiffness", stiffness_n_per_m, "N/m")?;
        finite("effective damping", damping_n_s_per_m, "N·s/m")?;
        Ok(Self {
            omega_rad_s,
            stiffness_n_per_m,
            damping_n_s_per_m,
        })
    }
}

/// θ = ωT, for 0 < ω ≤ π/T and a rounding error above.
pub(crate) fn turned(omega_rad_s: f64, sample_time_s: f64) -> Result<f64, AnalysisError> {
    let theta = omega_rad_s * sample_time_s;
    let kept = theta > 0.0 && theta <= PI * (1.0 + 1e-12);
    let allowed = "above 0 and at most π/T";
    range("angular frequency", omega_rad_s, kept, allowed, "rad/s")?;
    Ok(theta)
}

/// Refuses a result that overflowed, or that an operator without a response spoiled.
pub(crate) fn finite(
    what: &'static str,
    value: f64,
    unit: &'static str,
) -> Result<f64, AnalysisError> {
    let allowed = "finite for these parameters and this operator";
    Ok(range(what, value, true, allowed, unit)?)
}
