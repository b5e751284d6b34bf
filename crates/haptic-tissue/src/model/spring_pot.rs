//! The one element that all models are made of.

use super::error::ModelError;
use num_complex::Complex64;

/// A spring-pot: between a spring (α = 0) and a dashpot (α = 1).
///
/// ```text
/// σ = V·D^α ε        M(s) = V·s^α,   G(t) = V·t^(−α)/Γ(1−α),   J(t) = t^α/(V·Γ(1+α))
/// ```
///
/// ```
/// use haptic_tissue::SpringPot;
///
/// let gel = SpringPot::new(8650.0, 0.2247)?; // V in Pa·s^α
/// assert!(SpringPot::new(8650.0, 1.5).is_err());
/// # let _ = gel;
/// # Ok::<(), haptic_tissue::ModelError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpringPot {
    viscosity_pa_s_alpha: f64,
    order: f64,
}

impl SpringPot {
    /// V > 0 in Pa·s^α, 0 ≤ α ≤ 1.
    ///
    /// # Errors
    /// Outside these ranges.
    pub fn new(viscosity_pa_s_alpha: f64, order: f64) -> Result<Self, ModelError> {
        if !(viscosity_pa_s_alpha > 0.0 && viscosity_pa_s_alpha.is_finite()) {
            return Err(ModelError::Range {
                name: "viscosity_pa_s_alpha",
                value: viscosity_pa_s_alpha,
                allowed: "above 0 and finite",
                unit: "Pa·s^α",
            });
        }
        if !(0.0..=1.0).contains(&order) {
            return Err(ModelError::Range {
                name: "order",
                value: order,
                allowed: "in [0, 1]",
                unit: "",
            });
        }
        Ok(Self {
            viscosity_pa_s_alpha,
            order,
        })
    }

    /// A spring of E in Pa: order 0.
    ///
    /// # Errors
    /// If E is not above 0.
    pub fn spring(elastic_modulus_pa: f64) -> Result<Self, ModelError> {
        Self::new(elastic_modulus_pa, 0.0)
    }

    /// A dashpot of η in Pa·s: order 1.
    ///
    /// # Errors
    /// If η is not above 0.
    pub fn dashpot(viscosity_pa_s: f64) -> Result<Self, ModelError> {
        Self::new(viscosity_pa_s, 1.0)
    }

    /// V, Pa·s^α.
    #[must_use]
    pub const fn viscosity_pa_s_alpha(&self) -> f64 {
        self.viscosity_pa_s_alpha
    }

    /// α.
    #[must_use]
    pub const fn order(&self) -> f64 {
        self.order
    }

    /// M(s) = V·s^α, Pa, on the principal branch: on the negative axis from above where the imaginary part is +0.
    #[must_use]
    pub fn modulus(&self, s: Complex64) -> Complex64 {
        if self.order == 0.0 {
            return Complex64::new(self.viscosity_pa_s_alpha, 0.0);
        }
        let size = self.viscosity_pa_s_alpha * libm::pow(libm::hypot(s.re, s.im), self.order);
        let angle = self.order * libm::atan2(s.im, s.re);
        Complex64::new(size * libm::cos(angle), size * libm::sin(angle))
    }
}
