//! Wall or tissue of an experiment file, a log or a tissue file, to be felt.
//! ```text
//! [wall], or the log of one ─▶ wall and device, with the sample time        a tissue file ─▶ tissue
//! ```
//! Other experiments have no wall or tissue behind a single device, and are refused with an alternative.

use haptic_answer::Number;
use haptic_answer::feel::{DeviceNumbers, WallNumbers};
use haptic_document::Document;
use haptic_experiment::DocumentOfKind as _;
use haptic_experiment::{ExperimentFile, Failure, parameters};
use haptic_tissue::Material;
use std::collections::BTreeMap;

#[derive(Debug)]
pub(crate) enum Opened {
    Wall(WallNumbers, DeviceNumbers),
    Tissue(Box<Material>),
}

/// Wall or tissue of a document, to be felt.
///
/// # Errors
/// A document that is wrong, with its line; one of something else, with what to do with it.
pub(crate) fn opened(document: &Document) -> Result<Opened, Failure> {
    let (path, text) = (document.path(), document.text());
    let table: toml::Table = text.parse().unwrap_or_default();
    if table.contains_key("parameters") {
        let material = Material::parse(path, text).map_err(Failure::input)?;
        return Ok(Opened::Tissue(Box::new(material)));
    }
    let kind = document.kind()?;
    if kind != "wall" {
        return Err(Failure::bad_input(format_args!(
            "{}: a [{kind}] is not felt on the page, only a [wall] or a tissue file is: start it in Runs",
            path.display()
        )));
    }
    if table.contains_key(parameters::DRIVE_TABLE) {
        return Err(Failure::bad_input(format_args!(
            "{}: on the page a hand pushes into the wall, and not the device of [drive]: omit [drive], or start it in Runs",
            path.display()
        )));
    }
    if table.contains_key(parameters::ADMITTANCE_TABLE) {
        return Err(Failure::bad_input(format_args!(
            "{}: on the page a hand moves a device of forces, and not the robot of [admittance]: omit [admittance], or start it in Runs",
            path.display()
        )));
    }
    ExperimentFile::open(document)?;
    // All of its keys with their values, given or by default, those of its device file too.
    let mut metadata = BTreeMap::new();
    document.keep_in(&mut metadata)?;
    let word = |key: &str| metadata.get(key).cloned().unwrap_or_default();
    let number = |key: &str| word(key).parse().unwrap_or(f64::NAN);
    let numbers = WallNumbers {
        order: number(parameters::ORDER.key),
        stiffness_n_per_m: number(parameters::STIFFNESS.key),
        dissipation_n_s_mu_per_m: number(parameters::DISSIPATION.key),
        scheme: word(parameters::SCHEME.key),
        signed: word(parameters::WALL_CONTACT.key) == "signed",
    };
    let device = DeviceNumbers::names().map(|name| (name.to_owned(), Number(number(name))));
    let device = DeviceNumbers::default().with(&device.collect());
    let of_file = |error| Failure::bad_input(format_args!("{}: {error}", path.display()));
    Ok(Opened::Wall(numbers, device.map_err(of_file)?))
}
