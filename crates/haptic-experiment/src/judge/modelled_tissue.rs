//! A tissue of the library with the model that is rendered.

mod closed_form;
mod history;
mod operator;

use crate::document::failure::Failure;
use fracdiff::num_complex::Complex;
use fracdiff::{Order, Seconds};
use haptic_loop::units::Pascals;
use haptic_loop::{Specimen, Tissue};
use haptic_tissue::{Material, Model, SampledModel};
pub(crate) use history::memory;
pub(crate) use operator::loop_operator;
pub use operator::operator;
use std::collections::BTreeMap;
use std::ops::Deref;

/// A tissue of the library and the model of it: what is rendered, and its closed forms.
///
/// ```text
/// σ = E·ε + B·(T^μ·P) D^μ ε        P = 1 of one spring-pot beside a spring; else the memory of all elements at once
/// ```
///
/// ```
/// use haptic_experiment::ModelledTissue;
/// use haptic_tissue::Library;
///
/// let library = Library::load(None)?;
/// let prostate = ModelledTissue::new(library.find("prostate-healthy")?)?;
/// assert_eq!(prostate.order().get(), 0.2154);
/// // Elements in series are rendered by one operator, of the order of what carries the slow motion.
/// let muscle = ModelledTissue::new(library.find("fish-muscle")?)?;
/// assert_eq!((muscle.order().get(), muscle.rest_modulus_pa()), (0.6751, 0.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ModelledTissue {
    material: Material,
    law: Law,
}

/// The laws that are rendered.
#[derive(Clone, Debug, PartialEq)]
enum Law {
    /// One spring-pot beside a spring, by D^α of any scheme.
    KelvinVoigt(Tissue),
    /// Any other model, by its one memory.
    Composed {
        model: Model,
        elastic_modulus_pa: f64,
        viscosity_pa_s_mu: f64,
        order: Order,
    },
}

impl ModelledTissue {
    /// The model of a tissue.
    ///
    /// # Errors
    /// Parameters outside the range of the model; those of a tissue file are within it, but for an element that carries the
    /// slow motion with an order below 1e-6, next to a spring.
    pub fn new(material: Material) -> Result<Self, Failure> {
        let law = match (
            material.elastic_modulus_pa(),
            material.viscosity_pa_s_alpha(),
            material.order(),
        ) {
            (Some(modulus), Some(viscosity), Some(order)) => {
                let order = Order::new(order).map_err(Failure::input)?;
                let tissue = Tissue::new(Pascals(modulus), viscosity, order);
                Law::KelvinVoigt(tissue.map_err(Failure::input)?)
            }
            _ => composed(&material.model)?,
        };
        Ok(Self { material, law })
    }

    /// The model, unless it is one spring-pot beside a spring.
    #[must_use]
    pub const fn composed(&self) -> Option<&Model> {
        match &self.law {
            Law::KelvinVoigt(_) => None,
            Law::Composed { model, .. } => Some(model),
        }
    }

    /// μ of the operator: α of one spring-pot, else that of what carries the slow motion.
    #[must_use]
    pub const fn order(&self) -> Order {
        match &self.law {
            Law::KelvinVoigt(tissue) => tissue.order(),
            Law::Composed { order, .. } => *order,
        }
    }

    /// E, Pa: what is left of the modulus at rest.
    #[must_use]
    pub const fn rest_modulus_pa(&self) -> f64 {
        match &self.law {
            Law::KelvinVoigt(tissue) => tissue.elastic_modulus().0,
            Law::Composed {
                elastic_modulus_pa, ..
            } => *elastic_modulus_pa,
        }
    }

    /// Names and values for metadata: those of the model, and what is rendered of one with more elements.
    pub(crate) fn parameters(&self) -> BTreeMap<String, String> {
        let (modulus, viscosity) = (self.rest_modulus_pa(), self.viscosity_pa_s_mu());
        let order = self.order().get();
        let rendered = |prefix: &str, names: [&str; 3]| {
            let values = [modulus, viscosity, order].map(|value| value.to_string());
            let names = names.map(|name| format!("{prefix}{name}"));
            names.into_iter().zip(values)
        };
        let Some(model) = self.composed() else {
            let names = ["elastic_modulus_pa", "viscosity_pa_s_alpha", "order"];
            return rendered("", names).collect();
        };
        let names = ["modulus_pa", "viscosity_pa_s_mu", "order"];
        let mut all: BTreeMap<String, String> = rendered("rendered_", names).collect();
        all.insert("model".to_owned(), model.kind().name().to_owned());
        for (parameter, value) in model.parameters() {
            // One after the other for the branches of a series.
            let text = all.entry(parameter.name.to_owned()).or_default();
            let space = if text.is_empty() { "" } else { " " };
            *text = format!("{text}{space}{value}");
        }
        all
    }

    /// K in N/m and B in N·s^μ/m of a piece with a shape A/ℓ, m.
    #[must_use]
    pub fn spring_and_damper(&self, shape: f64) -> (f64, f64) {
        (
            shape * self.rest_modulus_pa(),
            shape * self.viscosity_pa_s_mu(),
        )
    }

    /// The B of a piece with a shape A/ℓ, m, of another order that resists as much at an angular frequency, N·s^μ/m.
    ///
    /// ```text
    /// |B'·(jω)^μ| = (A/ℓ)·|M(jω) − E|
    /// ```
    #[must_use]
    pub(crate) fn dissipation_at(&self, shape: f64, order: Order, omega_rad_s: f64) -> f64 {
        match &self.law {
            Law::Composed {
                model, order: own, ..
            } if *own != order => {
                let s = Complex::new(0.0, omega_rad_s);
                let loss = (model.modulus(s) - self.rest_modulus_pa()).norm();
                shape * loss / omega_rad_s.powf(order.get())
            }
            _ => {
                let change = omega_rad_s.powf(self.order().get() - order.get());
                shape * self.viscosity_pa_s_mu() * change
            }
        }
    }

    /// B, Pa·s^μ: E + B·s^μ is the modulus for slow motion.
    #[must_use]
    pub(crate) const fn viscosity_pa_s_mu(&self) -> f64 {
        match &self.law {
            Law::KelvinVoigt(tissue) => tissue.viscosity_pa_s_alpha(),
            Law::Composed {
                viscosity_pa_s_mu, ..
            } => *viscosity_pa_s_mu,
        }
    }
}

fn composed(model: &Model) -> Result<Law, Failure> {
    // E, B and μ are of the model; the sample time of a rendering comes later.
    let sampled = SampledModel::new(model, Seconds(1.0)).map_err(Failure::input)?;
    if sampled.viscosity_pa_s_mu() <= 0.0 {
        // A spring, as a Prony series without branches is.
        let (spring, order) = (Pascals(sampled.elastic_modulus_pa()), Order::new(0.0));
        let tissue = Tissue::new(spring, 0.0, order.map_err(Failure::input)?);
        return Ok(Law::KelvinVoigt(tissue.map_err(Failure::input)?));
    }
    Ok(Law::Composed {
        model: model.clone(),
        elastic_modulus_pa: sampled.elastic_modulus_pa(),
        viscosity_pa_s_mu: sampled.viscosity_pa_s_mu(),
        order: sampled.order(),
    })
}

impl Deref for ModelledTissue {
    type Target = Material;

    fn deref(&self) -> &Material {
        &self.material
    }
}

/// A piece of tissue that is touched.
#[derive(Clone, Debug)]
pub struct TissuePiece {
    /// The tissue.
    pub material: Box<ModelledTissue>,
    /// The piece.
    pub specimen: Specimen,
}

impl TissuePiece {
    /// A/ℓ, m.
    #[must_use]
    pub(crate) fn shape_m(&self) -> f64 {
        self.specimen.area().0 / self.specimen.thickness().0
    }

    /// K in N/m and B in N·s^μ/m.
    #[must_use]
    pub(crate) fn spring_and_damper(&self) -> (f64, f64) {
        self.material.spring_and_damper(self.shape_m())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptic_tissue::{ModelKind, Source};

    fn tissue(series: &[f64]) -> ModelledTissue {
        let model = Model::from_parameters(ModelKind::Prony, series).expect("valid");
        let material = Material::new("gel", "a gel", model, Source::default());
        ModelledTissue::new(material.expect("a name")).expect("sampled")
    }

    #[test]
    fn a_series_without_branches_is_a_spring() {
        let spring = tissue(&[5e3]);
        assert!(spring.composed().is_none());
        assert_eq!(spring.spring_and_damper(0.02), (100.0, 0.0));
    }

    #[test]
    fn metadata_have_the_model_with_its_parameters_and_what_is_rendered() {
        let gel = tissue(&[5e3, 1e3, 0.1, 2e3, 7.0]);
        let all = gel.parameters();
        assert_eq!(all["model"], "prony");
        assert_eq!(all["rendered_modulus_pa"], "5000");
        assert_eq!(all["rendered_order"], "1");
        // Slow motion feels all dashpots: Σ E·τ.
        assert_eq!(all["rendered_viscosity_pa_s_mu"], "14100");
        assert!(all.values().any(|value| value == "1000 2000"), "{all:?}");
    }

    #[test]
    fn another_order_resists_as_much_at_the_frequency() {
        let gel = tissue(&[5e3, 1e3, 0.1]);
        let half = Order::new(0.5).expect("valid");
        // |M(jω) − E| = E₁·ωτ/√(1 + ω²τ²) at ωτ = 1.
        let have = gel.dissipation_at(2.0, half, 10.0) * 10.0_f64.sqrt();
        assert!((have - 2e3 / 2.0_f64.sqrt()).abs() < 1e-9, "{have}");
        assert!((gel.dissipation_at(2.0, gel.order(), 10.0) - 200.0).abs() < 1e-9);
    }
}
