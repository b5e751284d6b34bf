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
        if !(0.0..=1.0).contains(&order) {
            return Err(ModelError::Range {
                name: "order",
                value: order,
                allowed: "in [0, 1]",
                unit: "",
            });
        }
        Self::named(
            "viscosity_pa_s_alpha",
            viscosity_pa_s_alpha,
            "Pa·s^α",
            order,
        )
    }

    /// A spring of E in Pa: order 0.
    ///
    /// # Errors
    /// If E is not above 0.
    pub fn spring(elastic_modulus_pa: f64) -> Result<Self, ModelError> {
        Self::named("elastic_modulus_pa", elastic_modulus_pa, "Pa", 0.0)
    }

    /// A dashpot of η in Pa·s: order 1.
    ///
    /// # Errors
    /// If η is not above 0.
    pub fn dashpot(viscosity_pa_s: f64) -> Result<Self, ModelError> {
        Self::named("viscosity_pa_s", viscosity_pa_s, "Pa·s", 1.0)
    }

    fn named(
        name: &'static str,
        value: f64,
        unit: &'static str,
        order: f64,
    ) -> Result<Self, ModelError> {
        if !(value > 0.0 && value.is_finite()) {
            return Err(ModelError::Range {
                name,
                value,
                allowed: "above 0 and finite",
                unit,
            });
        }
        Ok(Self {
            viscosity_pa_s_alpha: value,
            order,
        })
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

    /// α = 0.
    pub(super) fn is_spring(&self) -> bool {
        self.order <= 0.0
    }

    /// α = 1.
    pub(super) fn is_dashpot(&self) -> bool {
        self.order >= 1.0
    }

    /// M(s) = V·s^α, Pa, on the principal branch: on the negative axis from above where the imaginary part is +0.
    #[must_use]
    pub fn modulus(&self, s: Complex64) -> Complex64 {
        if self.is_spring() {
            return Complex64::new(self.viscosity_pa_s_alpha, 0.0);
        }
        let size = self.viscosity_pa_s_alpha * libm::pow(libm::hypot(s.re, s.im), self.order);
        let angle = self.order * libm::atan2(s.im, s.re);
        Complex64::new(size * libm::cos(angle), size * libm::sin(angle))
    }

    /// M(s) at s = e^(`ln_r`)·e^(iπ·`half_turns`), on any sheet; its imaginary part is exactly 0 where α·`half_turns` is
    /// whole.
    pub(super) fn modulus_at(&self, ln_r: f64, half_turns: f64) -> Complex64 {
        self.modulus_along(ln_r, turned(self.order * half_turns))
    }

    /// The same with e^(iπα·`half_turns`) known.
    pub(super) fn modulus_along(&self, ln_r: f64, direction: Complex64) -> Complex64 {
        direction * (self.viscosity_pa_s_alpha * libm::exp(self.order * ln_r))
    }

    /// V·t^(−α)/Γ(1−α), Pa, for t > 0.
    pub(super) fn relaxation(&self, time_s: f64) -> f64 {
        if self.is_dashpot() {
            return 0.0;
        }
        self.viscosity_pa_s_alpha * libm::pow(time_s, -self.order) / libm::tgamma(1.0 - self.order)
    }

    /// t^α/(V·Γ(1+α)), 1/Pa, for t > 0.
    pub(super) fn creep(&self, time_s: f64) -> f64 {
        libm::pow(time_s, self.order) / (self.viscosity_pa_s_alpha * libm::tgamma(1.0 + self.order))
    }
}

/// e^(iπx) for x ≥ 0; its parts are exactly 0 where they should be.
pub(super) fn turned(x: f64) -> Complex64 {
    let half_turns = x - 2.0 * libm::floor(x / 2.0);
    // Angle = quarter turns + rest, |rest| ≤ 1/4 of a half turn; x − whole is exact.
    let quarters = libm::round(2.0 * half_turns);
    let rest = core::f64::consts::PI * (half_turns - 0.5 * quarters);
    let (sin, cos) = libm::sincos(rest);
    match quarters as u8 % 4 {
        0 => Complex64::new(cos, sin),
        1 => Complex64::new(-sin, cos),
        2 => Complex64::new(-cos, -sin),
        _ => Complex64::new(sin, -cos),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_is_exact_at_quarters_and_close_elsewhere() {
        assert_eq!(turned(1.0), Complex64::new(-1.0, 0.0));
        assert_eq!(turned(0.5), Complex64::new(0.0, 1.0));
        assert_eq!(turned(0.0), Complex64::new(1.0, 0.0));
        for x in [0.01, 0.3, 0.7, 0.999, 1.2, 1.49, 1.9, 2.3] {
            let want = Complex64::from_polar(1.0, core::f64::consts::PI * x);
            assert!((turned(x) - want).norm() < 1e-15, "{x}");
        }
        // Close to a whole turn nothing cancels: sin(π(1 − δ)) = sin πδ.
        let close = 1.0 - 1e-9;
        let want = libm::sin(core::f64::consts::PI * (1.0 - close));
        assert!((turned(close).im / want - 1.0).abs() < 1e-15);
    }
}
