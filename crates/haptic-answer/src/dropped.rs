//! TOML files that fall on the page: a plant, a controller or a tissue.

use crate::words::TextFile;
use haptic_document::Failure;
use haptic_judge::modelled_tissue::{ModelledTissue, TissuePiece};
use haptic_tissue::Material;
use haptic_trial::{ControllerFile, PlantModel};
use serde_json::{Value, json};
use std::path::Path;

/// Kind of a TOML file; `None` of one that is neither a plant nor a controller nor a tissue.
///
/// # Errors
/// A file that is not TOML; a tissue that is wrong.
pub fn looked_at(file: &TextFile) -> Result<Option<Value>, Failure> {
    let path = Path::new(&file.name);
    let table: toml::Table = toml::from_str(&file.text).map_err(|error| {
        let why = error.message();
        Failure::bad_input(format_args!("{}: not TOML: {why}", file.name))
    })?;
    // A function is a plant unless a loop is beside it.
    let is_law = |name: &str| PlantModel::tables().all(|plant| plant != name);
    let mut laws = ControllerFile::laws().filter(|name| is_law(name));
    if table.contains_key("loop") || laws.any(|name| table.contains_key(name)) {
        return Ok(Some(json!({"is": "controller"})));
    }
    if PlantModel::tables().any(|name| table.contains_key(name)) {
        return Ok(Some(json!({"is": "plant"})));
    }
    if table.contains_key("parameters") {
        let tissue = Material::parse(path, &file.text).map_err(Failure::input)?;
        return Ok(Some(json!({"is": "tissue", "name": tissue.name})));
    }
    Ok(None)
}

/// Refuses a tissue that cannot be felt, before it joins the library.
///
/// # Errors
/// A tissue without a model that is felt.
pub fn can_be_felt(tissue: &Material) -> Result<(), Failure> {
    let felt = ModelledTissue::new(tissue.clone())?;
    TissuePiece::usual(felt).map_err(Failure::input)?;
    Ok(())
}

/// The tissue of a text under a name of its own, if it can be felt; `path` is where its file will be.
///
/// # Errors
/// A text that is no tissue, an unknown name, a tissue that cannot be felt.
pub fn named(path: &Path, name: &str, text: &str) -> Result<Material, Failure> {
    let mut tissue = Material::parse(Path::new("the tissue"), text).map_err(Failure::input)?;
    name.clone_into(&mut tissue.name);
    let tissue = Material::parse(path, &tissue.to_toml()).map_err(Failure::input)?;
    can_be_felt(&tissue)?;
    Ok(tissue)
}

/// The experiment of a file as the page has it: kind, text, and the parameters of its form.
#[must_use]
pub fn of_file(text: &str) -> Value {
    let table: toml::Table = toml::from_str(text).unwrap_or_default();
    let Some((kind, parameters)) = table.into_iter().next() else {
        return Value::Null;
    };
    json!({"kind": kind, "text": text, "parameters": parameters})
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_file_of_a_proposal_is_a_form_too() {
        let text = "# A comment.\n[wall]\nmass_kg = 0.065\nscheme = \"full\"\none_sided = false\n";
        let shown = of_file(text);
        assert_eq!(
            (&shown["kind"], &shown["text"]),
            (&json!("wall"), &json!(text))
        );
        assert_eq!(shown["parameters"]["mass_kg"], 0.065);
        assert_eq!(of_file("no file"), Value::Null);
    }
}
