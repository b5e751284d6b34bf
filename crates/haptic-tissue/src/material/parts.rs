//! The parts of a tissue.

use crate::model::{Form, Model};
use serde::{Deserialize, Serialize};

/// A tissue by name, with its source.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name on the command line: lower-case letters, digits and hyphens.
    pub name: String,
    /// A few words for people.
    pub description: String,
    /// E₀, η and α of a spring beside a spring-pot, as its file has them.
    pub(super) kelvin_voigt: KelvinVoigt,
    /// The model with its parameters.
    pub model: Model,
    /// Where the parameters hold.
    pub range: ValidRange,
    /// The origin of the numbers.
    pub source: Source,
    /// The text of its file.
    pub text: String,
    /// A file without `model`: E₀, η and α are as they were written.
    pub(super) two_elements: bool,
}

/// E₀, η and α, where the model is a spring beside a spring-pot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct KelvinVoigt {
    pub(super) elastic_modulus_pa: Option<f64>,
    pub(super) viscosity_pa_s_alpha: Option<f64>,
    pub(super) order: Option<f64>,
}

impl KelvinVoigt {
    pub(super) fn new(elastic_modulus_pa: f64, viscosity_pa_s_alpha: f64, order: f64) -> Self {
        Self {
            elastic_modulus_pa: Some(elastic_modulus_pa),
            viscosity_pa_s_alpha: Some(viscosity_pa_s_alpha),
            order: Some(order),
        }
    }

    pub(super) fn of(model: &Model) -> Self {
        match model.form() {
            Form::SpringPot(one) => Self::new(0.0, one.viscosity_pa_s_alpha(), one.order()),
            Form::FractionalKelvinVoigt { first, second } if second.order() <= 0.0 => Self::new(
                second.viscosity_pa_s_alpha(),
                first.viscosity_pa_s_alpha(),
                first.order(),
            ),
            _ => Self::default(),
        }
    }
}

/// The times, frequencies and strains of the measurement; `None` where the source says nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ValidRange {
    /// Shortest time, s.
    pub time_from_s: Option<f64>,
    /// Longest time, s.
    pub time_to_s: Option<f64>,
    /// Lowest angular frequency, rad/s.
    pub omega_from_rad_s: Option<f64>,
    /// Highest angular frequency, rad/s.
    pub omega_to_rad_s: Option<f64>,
    /// Largest strain.
    pub strain_to: Option<f64>,
}

/// The origin of a material's parameters.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Source {
    /// Author, title, year, and where in it.
    pub citation: String,
    /// The conditions of the measurement.
    pub conditions: String,
    /// True if the numbers were compared with the cited source itself.
    pub checked: bool,
    /// Anything else.
    #[serde(default)]
    pub note: String,
    /// The day of the measurement or of the fit; empty where unknown, as all below.
    #[serde(default)]
    pub date: String,
    /// The specimen: kind, number, size, preparation.
    #[serde(default)]
    pub sample: String,
    /// Its temperature, with unit.
    #[serde(default)]
    pub temperature: String,
    /// How far the model is from the record.
    #[serde(default)]
    pub residual: String,
}

/// True for lower-case letters, digits and hyphens.
pub(super) fn is_name(name: &str) -> bool {
    let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    !name.is_empty() && name.chars().all(plain)
}
