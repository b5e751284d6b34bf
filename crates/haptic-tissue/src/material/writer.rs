//! A tissue as the text of a file.

use super::parts::{Material, Source, ValidRange};
use crate::model::ModelKind;

/// TOML; `{:?}` of a number is the shortest text that reads back to the same bits.
pub(super) fn write(material: &Material) -> String {
    let mut text = format!(
        "name = {}\ndescription = {}\n",
        quoted(&material.name),
        quoted(&material.description)
    );
    if material.two_elements {
        text += "\n[parameters]\n";
        for (name, value) in [
            (
                "elastic_modulus_pa",
                material.kelvin_voigt.elastic_modulus_pa,
            ),
            (
                "viscosity_pa_s_alpha",
                material.kelvin_voigt.viscosity_pa_s_alpha,
            ),
            ("order", material.kelvin_voigt.order),
        ] {
            text += &number(name, value);
        }
    } else {
        text += &format!("model = \"{}\"\n\n[parameters]\n", material.model.kind());
        text += &parameters(material);
    }
    text + &range(&material.range) + &source(&material.source)
}

fn parameters(material: &Material) -> String {
    let kind: ModelKind = material.model.kind();
    let values = material.model.parameters();
    let line = |parameter: &crate::model::Parameter| {
        let own = values.iter().filter(|(known, _)| *known == parameter);
        let own: Vec<f64> = own.map(|(_, value)| *value).collect();
        if parameter.for_each_branch {
            format!("{} = {own:?}\n", parameter.name)
        } else {
            number(parameter.name, own.first().copied())
        }
    };
    kind.parameters().iter().map(line).collect()
}

fn range(range: &ValidRange) -> String {
    if *range == ValidRange::default() {
        return String::new();
    }
    let lines = [
        ("time_from_s", range.time_from_s),
        ("time_to_s", range.time_to_s),
        ("omega_from_rad_s", range.omega_from_rad_s),
        ("omega_to_rad_s", range.omega_to_rad_s),
        ("strain_to", range.strain_to),
    ];
    let lines = lines.map(|(name, value)| number(name, value));
    format!("\n[range]\n{}", lines.concat())
}

fn source(source: &Source) -> String {
    let mut text = format!(
        "\n[source]\ncitation = {}\nconditions = {}\nchecked = {}\n",
        quoted(&source.citation),
        quoted(&source.conditions),
        source.checked
    );
    for (name, words) in [
        ("note", &source.note),
        ("date", &source.date),
        ("sample", &source.sample),
        ("temperature", &source.temperature),
        ("residual", &source.residual),
    ] {
        if !words.is_empty() {
            text += &format!("{name} = {}\n", quoted(words));
        }
    }
    text
}

fn number(name: &str, value: Option<f64>) -> String {
    value.map_or_else(String::new, |value| format!("{name} = {value:?}\n"))
}

fn quoted(words: &str) -> String {
    toml::Value::from(words).to_string()
}
