//! Tissue files: TOML with units in the names. Errors have a place in the text.

use super::parameters::{Named, TwoElements};
use super::parts::{KelvinVoigt, Material, Source, ValidRange, is_name};
use crate::model::{Model, ModelKind};
use fracdiff::parameter::Shown;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use toml::Spanned;

/// Place and reason.
pub(super) type Wrong = (usize, String);

/// A tissue file as it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File<P> {
    name: Spanned<String>,
    description: String,
    #[serde(rename = "model")]
    _model: Option<String>,
    parameters: Spanned<P>,
    range: Option<Spanned<ValidRange>>,
    source: Source,
}

/// The part that says how to read the rest.
#[derive(Deserialize)]
struct Head {
    model: Option<Spanned<String>>,
}

/// The material of a file of this text.
pub(super) fn parse(text: &str) -> Result<Material, Wrong> {
    let head: Head = from_toml(text)?;
    match head.model {
        None => {
            let file: File<TwoElements> = from_toml(text)?;
            let block = file.parameters.span().start;
            let (kelvin_voigt, model) = (file.parameters.get_ref().model())
                .map_err(|(offset, reason)| (offset.unwrap_or(block), reason))?;
            material(text, &file, (kelvin_voigt, model), true)
        }
        Some(name) => {
            let kind = ModelKind::from_name(name.get_ref()).ok_or_else(|| {
                let known: Vec<&str> = ModelKind::ALL.iter().map(|kind| kind.name()).collect();
                let reason = format!(
                    "model \"{}\" is not known: take one of {}",
                    name.get_ref(),
                    known.join(", ")
                );
                (name.span().start, reason)
            })?;
            let file: File<Named> = from_toml(text)?;
            let block = file.parameters.span().start;
            let model = (file.parameters.get_ref().model(kind))
                .map_err(|(offset, reason)| (offset.unwrap_or(block), reason))?;
            material(text, &file, (KelvinVoigt::of(&model), model), false)
        }
    }
}

fn from_toml<T: DeserializeOwned>(text: &str) -> Result<T, Wrong> {
    toml::from_str(text).map_err(|error| {
        let offset = error.span().map_or(0, |span| span.start);
        // One line; TOML's own message may have several.
        let reason = error.message().lines().collect::<Vec<_>>().join("; ");
        (offset, reason)
    })
}

fn material<P>(
    text: &str,
    file: &File<P>,
    (kelvin_voigt, model): (KelvinVoigt, Model),
    two_elements: bool,
) -> Result<Material, Wrong> {
    let name = file.name.get_ref();
    if !is_name(name) {
        let reason =
            format!("name \"{name}\" is not made of lower-case letters, digits and hyphens");
        return Err((file.name.span().start, reason));
    }
    let range = match &file.range {
        None => ValidRange::default(),
        Some(range) => {
            checked(range.get_ref()).map_err(|reason| (range.span().start, reason))?;
            *range.get_ref()
        }
    };
    Ok(Material {
        name: name.clone(),
        description: file.description.clone(),
        kelvin_voigt,
        model,
        range,
        source: file.source.clone(),
        text: text.to_owned(),
        two_elements,
    })
}

fn checked(range: &ValidRange) -> Result<(), String> {
    let ends = [
        (
            "time_from_s",
            range.time_from_s,
            "time_to_s",
            range.time_to_s,
        ),
        (
            "omega_from_rad_s",
            range.omega_from_rad_s,
            "omega_to_rad_s",
            range.omega_to_rad_s,
        ),
        ("strain_from", None, "strain_to", range.strain_to),
    ];
    for (from_name, from, to_name, to) in ends {
        for (name, value) in [(from_name, from), (to_name, to)] {
            let value = value.unwrap_or(0.0);
            if !(value >= 0.0 && value.is_finite()) {
                return Err(format!(
                    "{name} = {value} is not a finite number of at least 0",
                    value = Shown(value)
                ));
            }
        }
        if let (Some(from), Some(to)) = (from, to)
            && from > to
        {
            return Err(format!(
                "{to_name} = {to} is below {from_name} = {from}: exchange them",
                to = Shown(to),
                from = Shown(from)
            ));
        }
    }
    Ok(())
}
