//! A tissue of the library with the model that is rendered.

use crate::failure::Failure;
use fracdiff::Order;
use haptic_loop::Tissue;
use haptic_loop::units::Pascals;
use haptic_tissue::Material;
use std::ops::Deref;

/// A tissue of the library and the fractional Kelvin–Voigt model of it.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelledTissue {
    material: Material,
    tissue: Tissue,
}

impl ModelledTissue {
    /// The model of a tissue.
    ///
    /// # Errors
    /// A model that is not a spring beside a spring-pot; parameters outside the range of the model.
    pub fn new(material: Material) -> Result<Self, Failure> {
        let (Some(modulus), Some(viscosity), Some(order)) = (
            material.elastic_modulus_pa(),
            material.viscosity_pa_s_alpha(),
            material.order(),
        ) else {
            return Err(Failure::bad_input(format_args!(
                "tissue \"{}\" is a {} model, which is not rendered yet: take a spring-pot, or a spring beside one",
                material.name,
                material.model.kind()
            )));
        };
        let order = Order::new(order).map_err(Failure::input)?;
        let tissue = Tissue::new(Pascals(modulus), viscosity, order);
        let tissue = tissue.map_err(Failure::input)?;
        Ok(Self { material, tissue })
    }

    /// α.
    #[must_use]
    pub const fn order(&self) -> Order {
        self.tissue.order()
    }

    /// E₀, Pa: what is left of the modulus at rest.
    #[must_use]
    pub const fn rest_modulus_pa(&self) -> f64 {
        self.tissue.elastic_modulus().0
    }

    /// η, Pa·s^α.
    #[must_use]
    pub const fn viscosity_pa_s_mu(&self) -> f64 {
        self.tissue.viscosity_pa_s_alpha()
    }

    /// The model.
    #[must_use]
    pub const fn tissue(&self) -> &Tissue {
        &self.tissue
    }
}

impl Deref for ModelledTissue {
    type Target = Material;

    fn deref(&self) -> &Material {
        &self.material
    }
}
