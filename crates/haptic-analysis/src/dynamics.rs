//! A device with its hand, its delay and its motor, in SI units.

use crate::{
    AnalysisError, ForcePath, LoopOperator, Nondimensional, OnePort, SampledLoop, SampledPlant,
    SampledWall,
};
use fracdiff::parameter::{not_negative, positive};

/// The device model of every analysis, with its hand, its delay and its motor.
/// ```text
/// m·x'' + b·x' + k·x = f,     τ·f' = u(t − delay) − f,   or f = u(t − delay) if τ = 0
/// ```
/// u is the command, held for one sample. Positions are not delayed: a late measurement does to a
/// loop what a late force does, so put both into `delay_s`.
/// ```
/// use fracdiff::{Order, Scheme, Seconds};
/// use haptic_analysis::{Dynamics, SampledWall, LoopOperator};
///
/// let order = Order::new(1.0)?;
/// let operator = LoopOperator::new(Scheme::Exact, order, Seconds(1e-3), 1e3)?;
/// let wall = SampledWall {
///     stiffness_n_per_m: 20e3,
///     dissipation_n_s_mu_per_m: 20.0,
///     order,
///     sample_time_s: 1e-3,
/// };
/// let ideal = Dynamics::ideal(0.065, 3.5);
/// let real = Dynamics { delay_s: 0.3e-3, current_lag_s: 0.7e-3, ..ideal };
/// assert!(ideal.closed(&wall, &operator)?.is_stable());
/// assert!(!real.closed(&wall, &operator)?.is_stable());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dynamics {
    /// m of device and hand, kg, above 0.
    pub mass_kg: f64,
    /// b of device and hand, N·s/m, at least 0.
    pub damping_n_s_per_m: f64,
    /// k of the hand, N/m, at least 0.
    pub hand_stiffness_n_per_m: f64,
    /// Delay from a measurement to the force that answers it, beyond the hold: s, 0 to 10 000
    /// sample times.
    pub delay_s: f64,
    /// τ, time constant of the motor current, s, 0 to 1e6 sample times.
    pub current_lag_s: f64,
}

impl Dynamics {
    /// A mass on a damper: no hand, no delay, no lag.
    #[must_use]
    pub const fn ideal(mass_kg: f64, damping_n_s_per_m: f64) -> Self {
        Self {
            mass_kg,
            damping_n_s_per_m,
            hand_stiffness_n_per_m: 0.0,
            delay_s: 0.0,
            current_lag_s: 0.0,
        }
    }

    /// Returns the same device if every parameter is in its range; delay and lag have an upper end
    /// in samples, see [`Self::path`].
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn checked(self) -> Result<Self, AnalysisError> {
        positive("mass", self.mass_kg, "kg")?;
        not_negative("damping", self.damping_n_s_per_m, "N·s/m")?;
        not_negative("hand stiffness", self.hand_stiffness_n_per_m, "N/m")?;
        not_negative("delay", self.delay_s, "s")?;
        not_negative("current lag", self.current_lag_s, "s")?;
        Ok(self)
    }

    /// The delay and lag of the force, in samples.
    ///
    /// # Errors
    /// The sample time, the delay or the lag outside its range.
    pub fn path(&self, sample_time_s: f64) -> Result<ForcePath, AnalysisError> {
        let t = positive("sample time", sample_time_s, "s")?;
        let delay = not_negative("delay", self.delay_s, "s")?;
        let lag = not_negative("current lag", self.current_lag_s, "s")?;
        ForcePath::new(delay / t, lag / t)
    }

    /// The device as the loop sees it once a sample.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn plant(&self, sample_time_s: f64) -> Result<SampledPlant, AnalysisError> {
        let t = positive("sample time", sample_time_s, "s")?;
        let Self {
            mass_kg: m,
            damping_n_s_per_m: b,
            hand_stiffness_n_per_m: k,
            ..
        } = self.checked()?;
        SampledPlant::behind(b * t / m, k * t * t / m, self.path(t)?)
    }

    /// α, β, δ, γ of this device under a wall.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn nondimensional(&self, wall: &SampledWall) -> Result<Nondimensional, AnalysisError> {
        let m = positive("mass", self.mass_kg, "kg")?;
        let t = positive("sample time", wall.sample_time_s, "s")?;
        let b = not_negative("damping", self.damping_n_s_per_m, "N·s/m")?;
        let k = not_negative("hand stiffness", self.hand_stiffness_n_per_m, "N/m")?;
        wall.checked()?;
        Nondimensional {
            alpha: wall.stiffness_n_per_m * t * t / m,
            beta: wall.dissipation_n_s_mu_per_m * libm::pow(t, 2.0 - wall.order.get()) / m,
            delta: b * t / m,
            gamma: k * t * t / m,
        }
        .checked()
    }

    /// The loop of this device and a wall, for stability and margins. `operator` is the one that
    /// runs; it must have the wall's order.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn closed<'a>(
        &self,
        wall: &SampledWall,
        operator: &'a LoopOperator,
    ) -> Result<SampledLoop<'a>, AnalysisError> {
        let Nondimensional { alpha, beta, .. } = self.nondimensional(wall)?;
        SampledLoop::with_plant(self.plant(wall.sample_time_s)?, alpha, beta, operator)
    }

    /// The port of this device's actuator, for passivity: its delay and lag, and the memory of the operator.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn port<'a>(
        &self,
        sample_time_s: f64,
        operator: &'a LoopOperator,
    ) -> Result<OnePort<'a, LoopOperator>, AnalysisError> {
        let port = OnePort::new(operator, operator.order())?.through(self.path(sample_time_s)?)?;
        Ok(port.with_memory(operator.memory()))
    }
}
