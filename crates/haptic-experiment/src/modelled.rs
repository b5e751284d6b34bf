//! A tissue of the library with the model that is rendered.

use haptic_loop::units::Pascals;
use haptic_loop::{ParameterError, Tissue};
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
    /// Parameters outside the range of the model; those of a tissue file are within it.
    pub fn new(material: Material) -> Result<Self, ParameterError> {
        let order = fracdiff::Order::new(material.order)?;
        let modulus = Pascals(material.elastic_modulus_pa);
        let tissue = Tissue::new(modulus, material.viscosity_pa_s_alpha, order)?;
        Ok(Self { material, tissue })
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
