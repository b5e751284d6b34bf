//! `[relax]` and `[creep]`: a tissue that is rendered.

use super::device::{remote, samples_fit, scheme, sensors};
use super::error::FileError;
use super::reader::Table;
use super::safety::safety;
use crate::drive::Drive;
use crate::modelled::{ModelledTissue, TissuePiece};
use crate::preflight::PreflightRequest;
use crate::rendering::Rendering;
use crate::run::SAMPLES;
use crate::schedule::Pace;
use crate::{Creep, Relaxation, parameters as p};
use haptic_loop::Specimen;
use haptic_loop::units::{Metres, SquareMetres};
use haptic_tissue::Library;
use std::path::Path;

/// The controller that holds the indenter.
fn drive(table: &Table<'_>) -> Result<Drive, FileError> {
    let path = table.beside(table.required_text(&p::CONTROLLER)?);
    Ok(Drive {
        force_limit_n: table.number(&p::DRIVE_FORCE_LIMIT)?,
        ..Drive::read(&path)?
    })
}

pub(super) fn relax(table: &Table<'_>, drive: Option<&Table<'_>>) -> Result<Relaxation, FileError> {
    let duration_s = table.number(&p::RELAX_DURATION)?;
    let ramp_time_s = table.number(&p::RAMP_TIME)?;
    if ramp_time_s >= duration_s {
        let reason = format!("ramp_time_s = {ramp_time_s} is not below duration_s = {duration_s}");
        return Err(table.fail_at("ramp_time_s", reason));
    }
    Ok(Relaxation {
        strain: table.number(&p::STRAIN)?,
        ramp_time_s,
        duration_s,
        rendering: rendering(table, drive, duration_s)?,
    })
}

pub(super) fn creep(table: &Table<'_>, drive: Option<&Table<'_>>) -> Result<Creep, FileError> {
    let duration_s = table.number(&p::CREEP_DURATION)?;
    Ok(Creep {
        stress_pa: table.number(&p::STRESS)?,
        duration_s,
        rendering: rendering(table, drive, duration_s)?,
    })
}

/// A tissue of the library and a piece of it.
pub(super) fn piece(table: &Table<'_>) -> Result<TissuePiece, FileError> {
    let library = table.text(&p::LIBRARY)?;
    let folder = (!library.is_empty()).then(|| table.beside(library));
    let library = Library::load(folder.as_deref())
        .map_err(|error| table.fail_at("library", error.to_string()))?;
    let name = table.text(&p::TISSUE)?;
    let beside = table.beside(name).to_string_lossy().into_owned();
    let is_path = Path::new(name).extension().is_some_and(|e| e == "toml");
    let material = library
        .find(if is_path { &beside } else { name })
        .map_err(|error| table.fail_at("tissue", error.to_string()))?;
    let material = ModelledTissue::new(material)
        .map_err(|error| table.fail_at("tissue", error.to_string()))?;
    let area = table.number(&p::AREA)?;
    let thickness = table.number(&p::THICKNESS)?;
    let specimen = Specimen::new(SquareMetres(area), Metres(thickness))
        .map_err(|error| table.fail(error.to_string()))?;
    Ok(TissuePiece {
        material: Box::new(material),
        specimen,
    })
}

fn rendering(
    table: &Table<'_>,
    held: Option<&Table<'_>>,
    duration_s: f64,
) -> Result<Rendering, FileError> {
    let remote = remote(table)?;
    let sample_time_s = table.number(&p::SAMPLE_TIME)?;
    samples_fit(table, sample_time_s, duration_s, &SAMPLES)?;
    let TissuePiece { material, specimen } = piece(table)?;
    let scheme = scheme(
        table,
        material.composed(),
        material.order(),
        sample_time_s,
        duration_s,
    )?;
    Ok(Rendering {
        preflight: PreflightRequest::default(),
        material: *material,
        specimen,
        scheme,
        precision: table.choice(&p::PRECISION)?,
        sample_time_s,
        contact: table.choice(&p::CONTACT)?,
        drive: held.map(drive).transpose()?,
        sensors: sensors(table)?,
        force_limit_n: table.number(&p::FORCE_LIMIT)?,
        force_rate_limit_n_per_s: table.number(&p::FORCE_RATE_LIMIT)?,
        safety: safety(table)?,
        pace: Pace::Virtual,
        remote,
    })
}
