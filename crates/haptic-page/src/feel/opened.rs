//! What is felt of an experiment file, a log or a tissue file.
//! ```text
//! [wall], or the log of one ─▶ wall and device, with the sample time        a tissue file ─▶ tissue
//! ```
//! Whatever else is run has no wall or tissue behind a single device, and is refused with what can be done instead.

use super::settings::{DeviceNumbers, FeltFile, WallNumbers};
use haptic_experiment::document::Document;
use haptic_experiment::judge::WallContact;
use haptic_experiment::{ExperimentFile, Failure};
use haptic_tissue::Material;
use std::path::Path;

#[derive(Debug)]
pub(crate) enum Opened {
    Wall(WallNumbers, DeviceNumbers),
    Tissue(Box<Material>),
}

impl FeltFile {
    pub(crate) fn document(&self) -> Document {
        Document::of_text(Path::new(&self.name), &self.text)
    }
}

/// What a document says is to be felt.
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
    let file = ExperimentFile::open(document)?;
    let wall = file.wall();
    let wall =
        wall.ok_or_else(|| Failure::bad_input("the file describes no wall: give another"))?;
    let numbers = WallNumbers {
        order: wall.order.get(),
        stiffness_n_per_m: wall.stiffness_n_per_m,
        dissipation_n_s_mu_per_m: wall.dissipation_n_s_mu_per_m,
        scheme: wall.scheme.to_string(),
        signed: wall.contact == WallContact::Signed,
    };
    let device = DeviceNumbers {
        sample_time_s: wall.sample_time_s,
        ..DeviceNumbers::from(wall.device)
    };
    Ok(Opened::Wall(numbers, device))
}
