//! The parameters of a loop, with units and without.
//!
//! ```text
//! α = K·T²/m,   β = B·T^(2−μ)/m,   δ = b·T/m,   γ = k·T²/m
//! ```
//! Source: O. Tokatlı, *Fractional Order Control in Haptics*, eq. 3.9.

use crate::{AnalysisError, SampledPlant};
use fracdiff::Order;
use fracdiff::parameter::{not_negative, positive, range};

/// A haptic loop with units: device (with the hand, when coupled), sampling, virtual environment.
///
/// ```
/// use fracdiff::Order;
/// use haptic_analysis::Loop;
///
/// let testbed = Loop {
///     mass_kg: 0.065,
///     damping_n_s_per_m: 3.5,
///     hand_stiffness_n_per_m: 0.0,
///     sample_time_s: 2e-3,
///     order: Order::new(1.0)?,
///     stiffness_n_per_m: 1000.0,
///     dissipation_n_s_mu_per_m: 10.0,
/// };
/// let without_units = testbed.nondimensional()?;
/// assert!((without_units.delta - 0.10769).abs() < 1e-5);
/// assert!((without_units.alpha - 0.06154).abs() < 1e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loop {
    /// m, kg, above 0.
    pub mass_kg: f64,
    /// b, N·s/m, at least 0.
    pub damping_n_s_per_m: f64,
    /// k of the hand, N/m, at least 0; 0 without a hand.
    pub hand_stiffness_n_per_m: f64,
    /// T, s, above 0.
    pub sample_time_s: f64,
    /// μ.
    pub order: Order,
    /// K, N/m, at least 0.
    pub stiffness_n_per_m: f64,
    /// B, at least 0. Its unit depends on μ: N·s^μ/m, so N/m at μ = 0, N·s/m at 1, kg at 2.
    pub dissipation_n_s_mu_per_m: f64,
}

/// The same loop without units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nondimensional {
    /// α = K·T²/m, 0 to 1e12.
    pub alpha: f64,
    /// β = B·T^(2−μ)/m, 0 to 1e12.
    pub beta: f64,
    /// δ = b·T/m, 0 to 1e6.
    pub delta: f64,
    /// γ = k·T²/m, 0 to 1e12.
    pub gamma: f64,
}

impl Loop {
    /// α, β, δ, γ.
    ///
    /// # Errors
    /// A parameter outside the range given with it.
    pub fn nondimensional(&self) -> Result<Nondimensional, AnalysisError> {
        let m = positive("mass", self.mass_kg, "kg")?;
        let t = positive("sample time", self.sample_time_s, "s")?;
        let b = not_negative("damping", self.damping_n_s_per_m, "N·s/m")?;
        let k = not_negative("hand stiffness", self.hand_stiffness_n_per_m, "N/m")?;
        let stiffness = not_negative("stiffness", self.stiffness_n_per_m, "N/m")?;
        let dissipation = not_negative("dissipation", self.dissipation_n_s_mu_per_m, "N·s^μ/m")?;
        Nondimensional {
            alpha: stiffness * t * t / m,
            beta: dissipation * libm::pow(t, 2.0 - self.order.get()) / m,
            delta: b * t / m,
            gamma: k * t * t / m,
        }
        .checked()
    }
}

impl Nondimensional {
    /// Largest α and β.
    pub const WALL_MAX: f64 = 1e12;

    /// Itself, if all four are within their ranges.
    ///
    /// # Errors
    /// The first that is not.
    pub fn checked(self) -> Result<Self, AnalysisError> {
        let (wall, allowed) = (Self::WALL_MAX, "from 0 to 1e12");
        let (damping, hand) = (SampledPlant::DELTA_MAX, SampledPlant::GAMMA_MAX);
        for (what, value, most, allowed) in [
            ("alpha", self.alpha, wall, allowed),
            ("beta", self.beta, wall, allowed),
            ("delta", self.delta, damping, "from 0 to 1e6"),
            ("gamma", self.gamma, hand, allowed),
        ] {
            range(what, value, (0.0..=most).contains(&value), allowed, "")?;
        }
        Ok(self)
    }

    /// The loop that has these parameters with a given mass, sample time and order.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn with_units(
        self,
        mass_kg: f64,
        sample_time_s: f64,
        order: Order,
    ) -> Result<Loop, AnalysisError> {
        self.checked()?;
        let m = positive("mass", mass_kg, "kg")?;
        let t = positive("sample time", sample_time_s, "s")?;
        Ok(Loop {
            mass_kg: m,
            damping_n_s_per_m: self.delta * m / t,
            hand_stiffness_n_per_m: self.gamma * m / (t * t),
            sample_time_s: t,
            order,
            stiffness_n_per_m: self.alpha * m / (t * t),
            dissipation_n_s_mu_per_m: self.beta * m / libm::pow(t, 2.0 - order.get()),
        })
    }
}
