//! Impedances at the hand: of the virtual environment alone, and of the closed loop, read as a spring and a damper.

use crate::{AnalysisError, ForcePath};
use fracdiff::parameter::{not_negative, positive, range};
use fracdiff::{FrequencyResponse, Order};
use num_complex::Complex;
use std::f64::consts::PI;

/// A virtual wall of fractional order, sampled: what the loop computes from a position.
/// ```text
/// H(w) = K + B·T^(−μ)·P(w)
/// ```
/// The force on the device is −H·x: a positive displacement is pushed back. The formulas here and in [`ClosedLoop`] hold for every order an
/// [`Order`] can have; theorems about passivity do not. Source: O. Tokatlı, *Fractional Order Control in Haptics*, eq. 3.8.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampledWall {
    /// K, N/m, at least 0.
    pub stiffness_n_per_m: f64,
    /// B, at least 0. Its unit depends on μ: N·s^μ/m, so N/m at μ = 0, N·s/m at 1, kg at 2.
    pub dissipation_n_s_mu_per_m: f64,
    /// μ of the operator D^μ, any order that an operator can have.
    pub order: Order,
    /// T, s, above 0.
    pub sample_time_s: f64,
}

/// A complex impedance read as a spring and a damper at one frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Effective {
    /// ω, rad/s, at which the impedance was read.
    pub omega_rad_s: f64,
    /// Effective stiffness ES, N/m; positive pushes back.
    pub stiffness_n_per_m: f64,
    /// Effective damping ED, N·s/m; positive takes energy.
    pub damping_n_s_per_m: f64,
}

impl SampledWall {
    /// Effective stiffness and damping with the operator really used, P for this order, at 0 < ω ≤ π/T, rad/s.
    /// ```text
    /// ES(ω) = Re H(e^(−jωT)),    ED(ω) = Im H(e^(−jωT))/ω
    /// ```
    /// For the exact operator ES = K + B(2 sin(θ/2)/T)^μ cos(μ(π−θ)/2), θ = ωT, and ED the same with
    /// a sine, without K, over ω. (The dissertation drops the T^(−μ).)
    ///
    /// # Errors
    /// A parameter or ω outside its range, or a result too large for a number.
    ///
    /// Source: O. Tokatlı, *Fractional Order Control in Haptics*, eqs. 3.10–3.13.
    pub fn effective(
        &self,
        operator: &(impl FrequencyResponse + ?Sized),
        omega_rad_s: f64,
    ) -> Result<Effective, AnalysisError> {
        let h = self.checked()?.response(operator, self.theta(omega_rad_s)?);
        Effective::new(omega_rad_s, h.re, h.im / omega_rad_s)
    }

    /// Impedance at the hand on any linear device: `Z = Z_d + H·e^(−jωT/2)·e^(−jωTd)/((1 + jωτ)·jω)`.
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
        let acting = acting(self.response(operator, theta), theta, path);
        let damping = impedance.re + acting.im / omega;
        Effective::new(omega, acting.re - omega * impedance.im, damping)
    }

    /// H(e^(−jθ)), N/m, at the digital frequency θ, rad.
    pub fn response(
        &self,
        operator: &(impl FrequencyResponse + ?Sized),
        theta: f64,
    ) -> Complex<f64> {
        let rate = libm::pow(self.sample_time_s, -self.order.get());
        operator.response(theta) * (self.dissipation_n_s_mu_per_m * rate) + self.stiffness_n_per_m
    }

    /// θ = ωT, for 0 < ω ≤ π/T; a rounding error above π is π.
    fn theta(&self, omega_rad_s: f64) -> Result<f64, AnalysisError> {
        Ok(turned(omega_rad_s, self.sample_time_s)?.min(PI))
    }

    pub(crate) fn checked(&self) -> Result<Self, AnalysisError> {
        not_negative("stiffness", self.stiffness_n_per_m, "N/m")?;
        not_negative("dissipation", self.dissipation_n_s_mu_per_m, "N·s^μ/m")?;
        positive("sample time", self.sample_time_s, "s")?;
        Ok(*self)
    }
}

impl Effective {
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

/// Device, zero-order hold and virtual environment, as the hand meets them.
/// ```text
/// Z(jω) = jωm + b + H·e^(−jωT(1/2 + d + h))/((1 + jωτ)·jω),   ES(ω) = −ω·Im Z,   ED(ω) = Re Z
/// ```
/// Force in phase with velocity is damping, force in phase with displacement is stiffness; a spring is a positive ES. (The dissertation
/// prints 6.1 with the opposite sign of every term, against its own text, where the mass lowers and K raises the stiffness.) The hold is
/// e^(−jωT/2), its delay: images above π/T are not in it, nor is the droop of sin(ωT/2)/(ωT/2).
///
/// - The hand's stiffness is not part of it: the hand is what feels.
/// - Range of ω: 0 < ω ≤ π/T, rad/s, for the continuous form too.
///
/// Source: O. Tokatlı, *Fractional Order Control in Haptics*, eqs. 6.1, 6.2.
/// ```
/// use fracdiff::{ExactDifference, Order};
/// use haptic_analysis::{ClosedLoop, SampledWall, ForcePath};
///
/// let order = Order::new(0.5)?;
/// let closed = ClosedLoop {
///     mass_kg: 0.065,
///     damping_n_s_per_m: 3.5,
///     environment: SampledWall {
///         stiffness_n_per_m: 500.0,
///         dissipation_n_s_mu_per_m: 0.0,
///         order,
///         sample_time_s: 1e-3,
///     },
///     path: ForcePath::NONE,
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
    /// The environment with its sample time: K, B, μ and T.
    pub environment: SampledWall,
    /// d + h and τ, besides the hold; none in the dissertation.
    pub path: ForcePath,
}

impl ClosedLoop {
    /// Impedance with the derivative s^μ itself in place of a sampled operator. Without delay and lag:
    /// ```text
    /// ES = −mω² + K cos(ωT/2) + B·ω^μ cos((ωT − πμ)/2)
    /// ED = b − (K/ω) sin(ωT/2) − B·ω^(μ−1) sin((ωT − πμ)/2)
    /// ```
    ///
    /// # Errors
    /// A parameter or ω outside its range, or a result too large for a number.
    pub fn continuous(&self, omega_rad_s: f64) -> Result<Effective, AnalysisError> {
        let omega = omega_rad_s;
        let SampledWall {
            stiffness_n_per_m: k,
            dissipation_n_s_mu_per_m: b,
            order,
            ..
        } = self.environment;
        let turn = 0.5 * PI * order.get();
        if self.path != ForcePath::NONE {
            // H = K + B·(jω)^μ
            let size = b * libm::pow(omega, order.get());
            let (sin, cos) = libm::sincos(turn);
            return self.felt(Complex::new(k + size * cos, size * sin), omega);
        }
        let lag = 0.5 * self.theta(omega)?;
        let (angle, mu) = (lag - turn, order.get());
        let spring = k * libm::cos(lag) + b * libm::pow(omega, mu) * libm::cos(angle);
        let damper = k / omega * libm::sin(lag) + b * libm::pow(omega, mu - 1.0) * libm::sin(angle);
        let inertia = self.mass_kg * omega * omega;
        Effective::new(omega, spring - inertia, self.damping_n_s_per_m - damper)
    }

    /// Impedance with the operator the loop really runs, P for this order.
    ///
    /// # Errors
    /// As [`continuous`](Self::continuous).
    pub fn sampled(
        &self,
        operator: &(impl FrequencyResponse + ?Sized),
        omega_rad_s: f64,
    ) -> Result<Effective, AnalysisError> {
        let theta = self.theta(omega_rad_s)?;
        self.felt(self.environment.response(operator, theta), omega_rad_s)
    }

    /// Impedance with any law that has the response H, N/m, in place of the environment: of a tissue, say.
    ///
    /// # Errors
    /// As [`continuous`](Self::continuous).
    pub fn felt(&self, h: Complex<f64>, omega: f64) -> Result<Effective, AnalysisError> {
        let acting = self.rendered(h, omega)?;
        let inertia = self.mass_kg * omega * omega;
        let damping = self.damping_n_s_per_m + acting.im / omega;
        Effective::new(omega, acting.re - inertia, damping)
    }

    /// Force per displacement of a law H, N/m, behind hold, delay and lag, without the device.
    ///
    /// # Errors
    /// A parameter or ω outside its range.
    pub fn rendered(&self, h: Complex<f64>, omega: f64) -> Result<Complex<f64>, AnalysisError> {
        Ok(acting(h, self.theta(omega)?, self.path))
    }

    fn theta(&self, omega_rad_s: f64) -> Result<f64, AnalysisError> {
        positive("mass", self.mass_kg, "kg")?;
        not_negative("damping", self.damping_n_s_per_m, "N·s/m")?;
        self.environment.checked()?.theta(omega_rad_s)
    }
}

/// H behind the hold and the way of the force: (a + jc)/(jω) = c/ω − ja/ω, so ES is its real part and ED its imaginary over ω.
fn acting(h: Complex<f64>, theta: f64, path: ForcePath) -> Complex<f64> {
    let half = 0.5 * theta;
    h * Complex::new(libm::cos(half), -libm::sin(half)) * path.continuous(theta)
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
