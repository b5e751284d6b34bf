//! Tissues: a model, where its parameters come from, and where they hold.

mod error;
mod file;
mod parameters;
mod parts;
mod writer;

use crate::model::{Model, ModelKind};
use crate::text_file::read_text;
pub use error::MaterialError;
use parts::{KelvinVoigt, is_name};
pub use parts::{Material, Source, ValidRange};
use serde::ser::SerializeMap as _;
use serde::{Serialize, Serializer};
use std::path::Path;

impl Material {
    /// A tissue of a model.
    ///
    /// # Errors
    /// A name that is not made of lower-case letters, digits and hyphens.
    pub fn new(
        name: &str,
        description: &str,
        model: Model,
        source: Source,
    ) -> Result<Self, MaterialError> {
        if !is_name(name) {
            return Err(MaterialError::Name(name.to_owned()));
        }
        let mut material = Self {
            name: name.to_owned(),
            description: description.to_owned(),
            kelvin_voigt: KelvinVoigt::of(&model),
            model,
            range: ValidRange::default(),
            source,
            text: String::new(),
            two_elements: false,
        };
        material.text = material.to_toml();
        Ok(material)
    }

    /// The same with where it holds.
    #[must_use]
    pub fn with_range(mut self, range: ValidRange) -> Self {
        self.range = range;
        self.text = self.to_toml();
        self
    }

    /// E₀ in Pa, if the model is a spring beside a spring-pot; 0 without the spring.
    #[must_use]
    pub const fn elastic_modulus_pa(&self) -> Option<f64> {
        self.kelvin_voigt.elastic_modulus_pa
    }

    /// η in Pa·s^α, if the model is a spring beside a spring-pot.
    #[must_use]
    pub const fn viscosity_pa_s_alpha(&self) -> Option<f64> {
        self.kelvin_voigt.viscosity_pa_s_alpha
    }

    /// α, if the model is a spring beside a spring-pot.
    #[must_use]
    pub const fn order(&self) -> Option<f64> {
        self.kelvin_voigt.order
    }

    /// Reads one material from the text of its file; `path` is for messages.
    ///
    /// # Errors
    /// [`MaterialError::File`] with line and reason.
    pub fn parse(path: &Path, text: &str) -> Result<Self, MaterialError> {
        file::parse(text).map_err(|(offset, reason)| MaterialError::File {
            path: path.to_owned(),
            line: 1 + text[..offset.min(text.len())].matches('\n').count(),
            reason,
        })
    }

    /// Reads a material file.
    ///
    /// # Errors
    /// If it cannot be read or is wrong.
    pub fn read(path: &Path) -> Result<Self, MaterialError> {
        let text =
            read_text(path).map_err(|error| MaterialError::Unreadable(path.to_owned(), error))?;
        Self::parse(path, &text)
    }

    /// The text of a file of it, which reads back to the same numbers to the bit. Comments of the file that it was read
    /// from are not in it; [`Material::text`] has them.
    #[must_use]
    pub fn to_toml(&self) -> String {
        writer::write(self)
    }
}

/// `model` by name, `parameters` by name and number, those of branches as lists; and E₀, η and α of a spring beside a
/// spring-pot, null for other models.
impl Serialize for Material {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("name", &self.name)?;
        map.serialize_entry("description", &self.description)?;
        map.serialize_entry("elastic_modulus_pa", &self.elastic_modulus_pa())?;
        map.serialize_entry("viscosity_pa_s_alpha", &self.viscosity_pa_s_alpha())?;
        map.serialize_entry("order", &self.order())?;
        map.serialize_entry("model", self.model.kind().name())?;
        map.serialize_entry("parameters", &Named(&self.model))?;
        map.serialize_entry("range", &self.range)?;
        map.serialize_entry("source", &self.source)?;
        map.end()
    }
}

struct Named<'a>(&'a Model);

impl Serialize for Named<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let values = self.0.parameters();
        let kind: ModelKind = self.0.kind();
        let mut map = serializer.serialize_map(Some(kind.parameters().len()))?;
        for parameter in kind.parameters() {
            let own = values.iter().filter(|(known, _)| *known == parameter);
            let own: Vec<f64> = own.map(|(_, value)| *value).collect();
            if parameter.for_each_branch {
                map.serialize_entry(parameter.name, &own)?;
            } else {
                map.serialize_entry(parameter.name, &own[0])?;
            }
        }
        map.end()
    }
}
