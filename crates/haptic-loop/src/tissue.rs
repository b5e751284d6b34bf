//! Soft tissue after the fractional Kelvin–Voigt (KVFD) model, and a specimen of it.

use crate::SpringDamper;
use crate::error::ParameterError;
use crate::units::{Metres, Newtons, Pascals, SquareMetres};
use fracdiff::parameter::{not_negative, positive, range};
use fracdiff::{Differintegrator, Order, Real};

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

/// A piece of tissue: how large, how thick.
///
/// ```text
/// ε = x/ℓ        F = A·σ
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Specimen {
    area: SquareMetres,
    thickness: Metres,
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
    ) -> Result<Self, ParameterError> {
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

    /// E₀.
    #[must_use]
    pub const fn elastic_modulus(&self) -> Pascals {
        self.elastic_modulus
    }

    /// η, Pa·s^α.
    #[must_use]
    pub const fn viscosity_pa_s_alpha(&self) -> f64 {
        self.viscosity_pa_s_alpha
    }

    /// α.
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

impl Specimen {
    /// A > 0, ℓ > 0.
    ///
    /// # Errors
    /// Outside these ranges.
    pub fn new(area: SquareMetres, thickness: Metres) -> Result<Self, ParameterError> {
        positive("area", area.0, "m²")?;
        positive("thickness", thickness.0, "m")?;
        Ok(Self { area, thickness })
    }

    /// x = ε·ℓ.
    #[must_use]
    pub fn displacement(&self, strain: f64) -> Metres {
        Metres(strain * self.thickness.0)
    }

    /// ε = x/ℓ.
    #[must_use]
    pub fn strain(&self, displacement: Metres) -> f64 {
        displacement.0 / self.thickness.0
    }

    /// F = A·σ.
    #[must_use]
    pub fn force(&self, stress: Pascals) -> Newtons {
        Newtons(self.area.0 * stress.0)
    }

    /// A.
    #[must_use]
    pub const fn area(&self) -> SquareMetres {
        self.area
    }

    /// ℓ.
    #[must_use]
    pub const fn thickness(&self) -> Metres {
        self.thickness
    }
}

impl<F: Real, O: Differintegrator<F>> SpringDamper<F, O> {
    /// A specimen of tissue: f = −(A/ℓ)·(E₀·x + η·D^α x), K = A·E₀/ℓ and B = A·η/ℓ. `operator` is D^α with the tissue's α
    /// and the loop's sample time.
    ///
    /// # Errors
    /// If K or B overflows.
    pub fn of_tissue(
        tissue: &Tissue,
        specimen: &Specimen,
        operator: O,
    ) -> Result<Self, ParameterError> {
        let (modulus, viscosity) = (tissue.elastic_modulus, tissue.viscosity_pa_s_alpha);
        Self::of_specimen(modulus, viscosity, specimen, operator)
    }

    /// A specimen of any matter whose stress is a spring beside one operator: K = A·E/ℓ, B = A·B/ℓ.
    ///
    /// ```text
    /// σ = E·ε + B·O(ε)        E Pa, B Pa·s^μ, O the operator in s^(−μ)
    /// ```
    /// Fractional Maxwell, Zener, Poynting–Thomson models and Prony series are of this form, for the memory of elements in
    /// series is one operator too: `SampledModel` of the crate `haptic-tissue` gives E, B and its design.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn of_specimen(
        elastic_modulus: Pascals,
        viscosity_pa_s_mu: f64,
        specimen: &Specimen,
        operator: O,
    ) -> Result<Self, ParameterError> {
        let shape = specimen.area.0 / specimen.thickness.0;
        Self::new(
            shape * elastic_modulus.0,
            shape * viscosity_pa_s_mu,
            operator,
        )
    }
}
