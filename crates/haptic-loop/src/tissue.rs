//! Soft tissue after the fractional Kelvin–Voigt (KVFD) model, and the wall that a specimen of it is.

use crate::error::LoopParameterError;
use crate::units::Pascals;
use fracdiff::Order;
use fracdiff::parameter::{not_negative, positive, range};

/// A tissue: three numbers.
///
/// ```text
/// σ = E₀·ε + η·D^α ε        σ stress Pa, ε strain 1
/// ```
/// Source: O. Tokatlı, *Fractional Order Control in Haptics*, ch. VII.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tissue {
    elastic_modulus: Pascals,
    viscosity_pa_s_alpha: f64,
    order: Order,
}

impl Tissue {
    /// E₀ ≥ 0 in Pa, η > 0 in Pa·s^α (0 allowed if E₀ > 0), 0 ≤ α ≤ 1.
    ///
    /// # Errors
    /// Outside these ranges, or if neither E₀ nor η is above 0.
    pub fn new(
        elastic_modulus: Pascals,
        viscosity_pa_s_alpha: f64,
        order: Order,
    ) -> Result<Self, LoopParameterError> {
        not_negative("elastic modulus", elastic_modulus.0, "Pa")?;
        not_negative("viscosity", viscosity_pa_s_alpha, "Pa·s^α")?;
        if elastic_modulus.0 == 0.0 {
            positive(
                "viscosity of a tissue without elastic modulus",
                viscosity_pa_s_alpha,
                "Pa·s^α",
            )?;
        }
        let (alpha, solid) = (order.get(), (0.0..=1.0).contains(&order.get()));
        range("order of a tissue", alpha, solid, "in [0, 1]", "")?;
        Ok(Self {
            elastic_modulus,
            viscosity_pa_s_alpha,
            order,
        })
    }

    /// E₀ in Pa, at least 0.
    #[must_use]
    pub const fn elastic_modulus(&self) -> Pascals {
        self.elastic_modulus
    }

    /// η in Pa·s^α, at least 0.
    #[must_use]
    pub const fn viscosity_pa_s_alpha(&self) -> f64 {
        self.viscosity_pa_s_alpha
    }

    /// α, from 0 to 1.
    #[must_use]
    pub const fn order(&self) -> Order {
        self.order
    }

    /// Stress under a strain that rises to ε₀ in T₀ and is then held, Pa, for α < 1.
    ///
    /// ```text
    /// r = ε₀/T₀,   t ≤ T₀: E₀·r·t + η·r·t^(1−α)/Γ(2−α)
    ///              t > T₀: E₀·ε₀ + η·r·[t^(1−α) − (t−T₀)^(1−α)]/Γ(2−α)
    /// ```
    /// Zero for t ≤ 0. A ramp time of 0 is a step, ε₀(E₀ + η·t^(−α)/Γ(1−α)).
    #[must_use]
    pub fn relaxation_stress(&self, strain: f64, ramp_time_s: f64, time_s: f64) -> Pascals {
        if time_s <= 0.0 {
            return Pascals(0.0);
        }
        let (e, eta, alpha) = (
            self.elastic_modulus.0,
            self.viscosity_pa_s_alpha,
            self.order.get(),
        );
        if ramp_time_s == 0.0 {
            let viscous = eta * libm::pow(time_s, -alpha) / libm::tgamma(1.0 - alpha);
            return Pascals(strain * (e + viscous));
        }
        let rate = strain / ramp_time_s;
        // t^p − (t − T₀)^p without cancellation long after the ramp: t^p·(1 − (1 − T₀/t)^p)
        let p = 1.0 - alpha;
        let since = (ramp_time_s / time_s).min(1.0);
        let remaining = if since < 1.0 {
            -libm::expm1(p * libm::log1p(-since))
        } else {
            1.0
        };
        let viscous = libm::pow(time_s, p) * remaining / libm::tgamma(1.0 + p);
        Pascals(e * rate * time_s.min(ramp_time_s) + eta * rate * viscous)
    }
}
