//! `[relax]` and `[creep]`: a tissue that is rendered.

use crate::document::error::FileError;
use crate::document::parameters as p;
use crate::document::parameters::LOOP;
use crate::document::reader::Table;
use crate::experiment::drive::Drive;
use crate::experiment::drive::keys::DRIVE_FORCE_LIMIT;
use crate::experiment::reading::{remote, samples_fit, scheme, sensors, without};
use crate::experiment::rendering::Rendering;
use crate::experiment::rendering::keys::{
    CREEP_DURATION, PRECISION, RAMP_TIME, RELAX_DURATION, STRAIN, STRESS,
};
use crate::experiment::trial::reading::device_model;
use crate::judge::modelled_tissue::{ModelledTissue, TissuePiece};
use crate::run::SAMPLES;
use crate::run::preflight::PreflightRequest;
use crate::run::safety::safety;
use crate::run::schedule::Pace;
use crate::{Creep, Dynamics, Precision, Relaxation, Safety};
use haptic_link::LoopMode;
use haptic_loop::Specimen;
use haptic_loop::units::{Metres, SquareMetres};
use haptic_tissue::Library;

/// The controller that holds the indenter.
fn drive(table: &Table<'_>) -> Result<Drive, FileError> {
    table.required_text(&p::CONTROLLER)?;
    let path = table.file(&p::CONTROLLER)?.unwrap_or_default();
    Ok(Drive {
        force_limit_n: table.number(&DRIVE_FORCE_LIMIT)?,
        ..Drive::read(&path)?
    })
}

pub(crate) fn relax(table: &Table<'_>, drive: Option<&Table<'_>>) -> Result<Relaxation, FileError> {
    let duration_s = table.number(&RELAX_DURATION)?;
    let ramp_time_s = table.number(&RAMP_TIME)?;
    if ramp_time_s >= duration_s {
        let reason = format!("ramp_time_s = {ramp_time_s} is not below duration_s = {duration_s}");
        return Err(table.fail_at("ramp_time_s", reason));
    }
    Ok(Relaxation {
        strain: table.number(&STRAIN)?,
        ramp_time_s,
        duration_s,
        rendering: rendering(table, drive, duration_s)?,
    })
}

pub(crate) fn creep(table: &Table<'_>, drive: Option<&Table<'_>>) -> Result<Creep, FileError> {
    let duration_s = table.number(&CREEP_DURATION)?;
    Ok(Creep {
        stress_pa: table.number(&STRESS)?,
        duration_s,
        rendering: rendering(table, drive, duration_s)?,
    })
}

/// A tissue of the library and a piece of it.
pub(crate) fn piece(table: &Table<'_>) -> Result<TissuePiece, FileError> {
    let folder = table.file(&p::LIBRARY)?;
    let library = Library::load(folder.as_deref())
        .map_err(|error| table.fail_at("library", error.to_string()))?;
    let tissue = table.file(&p::TISSUE)?.unwrap_or_default();
    let material = library
        .find(&tissue.to_string_lossy())
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

/// The safety chain and the pre-flight of a device, whose mass, damping, delay and lag its own keys say, and its device file.
fn guarded(table: &Table<'_>, real: bool) -> Result<(Safety, PreflightRequest), FileError> {
    let mut safety = safety(table)?;
    let model = device_model(table)?;
    if let Some(model) = &model {
        let on_rig = safety.on_rig(&model.guarded(), real);
        safety = on_rig.map_err(|error| table.fail_at(p::DEVICE_MODEL.key, error.to_string()))?;
    }
    let known = safety.device_mass_kg.zip(safety.device_damping_n_s_per_m);
    let dynamics = known.map(|(mass_kg, damping_n_s_per_m)| Dynamics {
        mass_kg,
        damping_n_s_per_m,
        ..model.map_or(Dynamics::ideal(mass_kg, damping_n_s_per_m), |model| {
            model.dynamics()
        })
    });
    let preflight = PreflightRequest {
        dynamics,
        ..PreflightRequest::default()
    };
    Ok((safety, preflight))
}

fn rendering(
    table: &Table<'_>,
    held: Option<&Table<'_>>,
    duration_s: f64,
) -> Result<Rendering, FileError> {
    let remote = remote(table)?;
    let sensors = sensors(table)?;
    if remote.is_some() && !sensors.are_ideal() {
        let reason = "encoder_resolution_m and sensor_noise_m are of the simulated rig: omit them with a serial device, which has its own";
        return Err(table.fail_at(p::ENCODER_RESOLUTION.key, reason.to_owned()));
    }
    let precision = table.choice(&PRECISION)?;
    let there = (remote.as_ref()).is_some_and(|remote| remote.loop_mode == LoopMode::Device);
    if there && precision == Precision::F64 {
        let idle = &format!(
            "in a loop on the device, which computes in f32: give {loop_host}",
            loop_host = LOOP.set_to("host")
        );
        without(table, [&PRECISION], idle)?;
    }
    let (safety, preflight) = guarded(table, remote.is_some())?;
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
        preflight,
        material: *material,
        specimen,
        scheme,
        precision,
        sample_time_s,
        contact: table.choice(&p::CONTACT)?,
        drive: held.map(drive).transpose()?,
        sensors,
        force_limit_n: table.number(&p::FORCE_LIMIT)?,
        force_rate_limit_n_per_s: table.number(&p::FORCE_RATE_LIMIT)?,
        safety,
        pace: Pace::Virtual,
        remote,
    })
}
