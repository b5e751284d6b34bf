//! The closed loop as the hand feels it: read as a spring and a damper.

use crate::{AnalysisError, ForcePath, Loop};
use fracdiff::parameter::{not_negative, positive, range};
use fracdiff::{FrequencyResponse, Order};
use num_complex::Complex;
use std::f64::consts::PI;

/// Device, zero-order hold and virtual environment, as the hand meets them.
///
/// ```text
/// Z(jω) = jωm + b + H·e^(−jωT/2)·e^(−jωTd)/(jω)
/// ES(ω) = −ω·Im Z,    ED(ω) = Re Z
/// ```
/// Force in phase with velocity is damping, force in phase with displacement is stiffness; a spring is
/// a positive ES. (The dissertation prints 6.1 with the opposite sign of every term, against its own
/// text, where the mass lowers and K raises the stiffness.) The hold is e^(−jωT/2), its delay: images
/// above π/T are not in it, nor is the droop of sin(ωT/2)/(ωT/2).
///
/// - The hand's stiffness is not part of it: the hand is what feels.
/// - Range of ω: 0 < ω ≤ π/T, rad/s, for the continuous form too.
///
/// Source: O. Tokatlı, *Fractional Order Control in Haptics*, eqs. 6.1, 6.2.
///
/// ```
/// use fracdiff::{ExactDifference, Order};
/// use haptic_analysis::{ClosedLoop, Environment};
///
/// let order = Order::new(0.5)?;
/// let closed = ClosedLoop {
///     mass_kg: 0.065,
///     damping_n_s_per_m: 3.5,
///     environment: Environment {
///         stiffness_n_per_m: 500.0,
///         dissipation_n_s_mu_per_m: 0.0,
///         order,
///         sample_time_s: 1e-3,
///     },
///     delay_samples: 0,
/// };
/// let felt = closed.sampled(&ExactDifference(order), 10.0)?;
/// // K − mω², and the half sample of the hold takes KT/2 of the damping away.
/// assert!((felt.stiffness_n_per_m - (500.0 - 6.5)).abs() < 0.02);
/// assert!((felt.damping_n_s_per_m - (3.5 - 0.25)).abs() < 1e-4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosedLoop {
    /// m, kg, above 0.
    pub mass_kg: f64,
    /// b, N·s/m, at least 0.
    pub damping_n_s_per_m: f64,
    /// K, B, μ, T.
    pub environment: Environment,
    /// d, whole samples between measuring and acting, besides the hold; 0 in the dissertation.
    pub delay_samples: usize,
}

impl ClosedLoop {
    /// The same behind an actuator with a delay, whole or not, and a current lag; its delay comes on top of
    /// `delay_samples`.
    ///
    /// ```text
    /// Z(jω) = jωm + b + H·e^(−jωT(1/2 + d + h))/((1 + jωτ)·jω)
    /// ```
    #[must_use]
    pub fn through(self, path: ForcePath) -> DelayedLoop {
        DelayedLoop { closed: self, path }
    }

    /// With the derivative s^μ itself in place of a sampled operator.
    ///
    /// ```text
    /// ES = −mω² + K cos(ωT/2) + B·ω^μ cos((ωT − πμ)/2)
    /// ED = b − (K/ω) sin(ωT/2) − B·ω^(μ−1) sin((ωT − πμ)/2)
    /// ```
    /// with ωT/2 + ωTd in place of ωT/2 where there is a delay.
    ///
    /// # Errors
    /// A parameter or ω outside its range, or a result too large for a number.
    pub fn continuous(&self, omega_rad_s: f64) -> Result<Effective, AnalysisError> {
        let omega = omega_rad_s;
        let lag = self.lag(omega)?;
        let Environment {
            stiffness_n_per_m: k,
            dissipation_n_s_mu_per_m: b,
            order,
            ..
        } = self.environment;
        let mu = order.get();
        let angle = lag - 0.5 * std::f64::consts::PI * mu;
        let spring = k * libm::cos(lag) + b * libm::pow(omega, mu) * libm::cos(angle);
        let damper = k / omega * libm::sin(lag) + b * libm::pow(omega, mu - 1.0) * libm::sin(angle);
        let inertia = self.mass_kg * omega * omega;
        Effective::new(omega, spring - inertia, self.damping_n_s_per_m - damper)
    }

    /// With the operator the loop really runs, P for this order.
    ///
    /// # Errors
    /// As [`continuous`](Self::continuous).
    pub fn sampled(
        &self,
        operator: &(impl FrequencyResponse + ?Sized),
        omega_rad_s: f64,
    ) -> Result<Effective, AnalysisError> {
        let omega = omega_rad_s;
        let lag = self.lag(omega)?;
        let h = self
            .environment
            .response(operator, self.environment.theta(omega)?);
        // H·e^(−j·lag) = ES part + jω·ED part, since (a + jc)/(jω) = c/ω − ja/ω.
        let acting = h * Complex::new(libm::cos(lag), -libm::sin(lag));
        let inertia = self.mass_kg * omega * omega;
        let damping = self.damping_n_s_per_m + acting.im / omega;
        Effective::new(omega, acting.re - inertia, damping)
    }

    /// ωT/2 + ωTd, after the range checks.
    fn lag(&self, omega_rad_s: f64) -> Result<f64, AnalysisError> {
        positive("mass", self.mass_kg, "kg")?;
        not_negative("damping", self.damping_n_s_per_m, "N·s/m")?;
        let theta = self.environment.checked()?.theta(omega_rad_s)?;
        Ok((self.delay_samples as f64 + 0.5) * theta)
    }
}

/// A [`ClosedLoop`] behind an actuator that is late and lags.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DelayedLoop {
    closed: ClosedLoop,
    path: ForcePath,
}

impl DelayedLoop {
    /// With the derivative s^μ itself in place of a sampled operator.
    ///
    /// # Errors
    /// As [`ClosedLoop::continuous`].
    pub fn continuous(&self, omega_rad_s: f64) -> Result<Effective, AnalysisError> {
        if self.path == ForcePath::NONE {
            return self.closed.continuous(omega_rad_s);
        }
        let environment = &self.closed.environment;
        // H = K + B·(jω)^μ
        let mu = environment.order.get();
        let size = environment.dissipation_n_s_mu_per_m * libm::pow(omega_rad_s, mu);
        let (sin, cos) = libm::sincos(0.5 * std::f64::consts::PI * mu);
        let felt = Complex::new(environment.stiffness_n_per_m + size * cos, size * sin);
        self.felt(felt, omega_rad_s)
    }

    /// With the operator the loop really runs, P for this order.
    ///
    /// # Errors
    /// As [`ClosedLoop::continuous`].
    pub fn sampled(
        &self,
        operator: &(impl FrequencyResponse + ?Sized),
        omega_rad_s: f64,
    ) -> Result<Effective, AnalysisError> {
        if self.path == ForcePath::NONE {
            return self.closed.sampled(operator, omega_rad_s);
        }
        let environment = &self.closed.environment;
        let felt = environment.response(operator, environment.theta(omega_rad_s)?);
        self.felt(felt, omega_rad_s)
    }

    /// Stiffness and damping of Z for a response H of the environment.
    fn felt(&self, h: Complex<f64>, omega_rad_s: f64) -> Result<Effective, AnalysisError> {
        let omega = omega_rad_s;
        let lag = self.closed.lag(omega)?;
        let theta = self.closed.environment.theta(omega)?;
        let hold = Complex::new(libm::cos(lag), -libm::sin(lag));
        let acting = h * hold * self.path.continuous(theta);
        let inertia = self.closed.mass_kg * omega * omega;
        let damping = self.closed.damping_n_s_per_m + acting.im / omega;
        Effective::new(omega, acting.re - inertia, damping)
    }
}

impl Environment {
    /// The same on any linear device: `Z = Z_d + H·e^(−jωT/2)·e^(−jωTd)/((1 + jωτ)·jω)`.
    ///
    /// `impedance` is `Z_d(jω)`, N·s/m, velocity in and force out: jωm + b for a mass on a damper; of a plant with the
    /// transfer function G from force to position, 1/(jω·G(jω)).
    ///
    /// # Errors
    /// A parameter or ω outside its range, an impedance that is not finite, or a result too large for a number.
    pub fn felt_on(
        &self,
        impedance: Complex<f64>,
        path: ForcePath,
        operator: &(impl FrequencyResponse + ?Sized),
        omega_rad_s: f64,
    ) -> Result<Effective, AnalysisError> {
        let omega = omega_rad_s;
        let theta = self.checked()?.theta(omega)?;
        for part in [impedance.re, impedance.im] {
            range("impedance of the device", part, true, "finite", "N·s/m")?;
        }
        let (sin, cos) = libm::sincos(0.5 * theta);
        let acting =
            self.response(operator, theta) * Complex::new(cos, -sin) * path.continuous(theta);
        let damping = impedance.re + acting.im / omega;
        Effective::new(omega, acting.re - omega * impedance.im, damping)
    }
}

impl From<&Loop> for ClosedLoop {
    /// Without extra delay.
    fn from(system: &Loop) -> Self {
        Self {
            mass_kg: system.mass_kg,
            damping_n_s_per_m: system.damping_n_s_per_m,
            environment: Environment::from(system),
            delay_samples: 0,
        }
    }
}

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
