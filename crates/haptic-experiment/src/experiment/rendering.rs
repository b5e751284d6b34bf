//! A tissue, the operator that renders it, and the rig it is rendered on: what relaxation and creep share, and their keys.

use super::kind::Conduct;
use super::reading::{device_model, piece, remote, samples_fit, scheme, sensors, without};
use crate::document::error::FileError;
use crate::document::named::Named;
use crate::document::parameters as p;
use crate::document::parameters::kind::{Parameter, joined, parameters};
use crate::document::parameters::range::{
    DAMPINGS, DURATIONS, FORCES_ABOVE_0, MASSES, REACHES_ABOVE_0, STRAINS, STRESSES,
};
use crate::document::reader::Table;
use crate::experiment::drive;
use crate::experiment::indentation::Indentation;
use crate::judge::modelled_tissue::TissuePiece;
use crate::run::SAMPLES;
use crate::run::safety::Safety;
use crate::run::safety::safety;
use haptic_analysis::Dynamics;
use haptic_link::LoopMode;
use haptic_loop::plant::RigDrive;
use serde::Serialize;

parameters! {
    /// Depth of a relaxation, m.
    DEPTH = optional("depth_m", REACHES_ABOVE_0, "Depth to hold, instead of a strain");
    STRAIN = number("strain", 0.05, "5%", STRAINS, "Strain to hold");
    /// Ramp of a relaxation, s.
    RAMP_TIME = number("ramp_time_s", 1.0, "1s", DURATIONS, "Time to reach it");
    /// End of a relaxation, s.
    RELAX_DURATION = number("duration_s", 200.0, "200s", DURATIONS,
        "Duration, from the start of the ramp");
    /// Stress of a creep test, Pa.
    STRESS = number("stress_pa", 100.0, "100Pa", STRESSES, "Stress to hold");
    /// Force of a creep test, N.
    FORCE = optional("force_n", FORCES_ABOVE_0, "Force to hold, instead of a stress");
    /// End of a creep test, s.
    CREEP_DURATION = number("duration_s", 200.0, "200s", DURATIONS, "Duration");
    /// Contact of the rig of a creep test: what has a mass shows itself before the tissue.
    CREEP_CONTACT = text(p::CONTACT.key, "ideal",
        "Contact between indenter and tissue; with a controller or a device it is compliant");
    /// Mass of each of the two actuators of the rig, kg.
    RIG_MASS = number("rig_mass_kg", 0.065, "65g", MASSES, "Mass of each of the rig's two actuators");
    RIG_DAMPING = number("rig_damping_n_s_per_m", 3.5, "3.5", DAMPINGS, "Viscous damping of each");
    /// Number type of the loop.
    PRECISION = text("precision", "f64", "Number type of the loop");
}

/// Of `[relax]`, beside [`RENDERING`].
pub(crate) const RELAX: &[Parameter] = &[STRAIN, DEPTH, RAMP_TIME, RELAX_DURATION, p::CONTACT];

/// Of `[creep]`, beside [`RENDERING`].
pub(crate) const CREEP: &[Parameter] = &[STRESS, FORCE, CREEP_DURATION, CREEP_CONTACT];

/// Of the rendering: the tissue, and how it is rendered.
pub(crate) const RENDERING: &[Parameter] = &joined::<19>(&[
    p::PIECE,
    &[p::SCHEME, PRECISION, p::SAMPLE_TIME, RIG_MASS, RIG_DAMPING],
    &[p::ENCODER_RESOLUTION, p::SENSOR_NOISE, p::SEED],
    &[p::FORCE_LIMIT, p::FORCE_RATE_LIMIT, p::DEVICE_MODEL],
]);

/// Contact of the indenter with the renderer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Contact {
    /// A stiff, one-sided spring and damper between two masses, as on a real rig.
    Compliant,
    /// The indentation or the push is imposed exactly; a push still moves the renderer's mass.
    Rigid,
    /// The indentation or the push is imposed exactly on the tissue alone: nothing has a mass.
    Ideal,
}

impl Named for Contact {
    const CHOICES: &'static [(Self, &'static str, &'static str)] = &[
        (
            Self::Compliant,
            "compliant",
            "A stiff one-sided spring and damper between two masses, as on a real rig",
        ),
        (
            Self::Rigid,
            "rigid",
            "The indentation is imposed exactly, or the push on the renderer's mass",
        ),
        (Self::Ideal, "ideal", "Nothing has a mass: the tissue alone"),
    ];
}

/// The number type of the loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Precision {
    /// Double, 53 bits.
    F64,
    /// Single, 24 bits, as on a microcontroller.
    F32,
}

impl Named for Precision {
    const CHOICES: &'static [(Self, &'static str, &'static str)] = &[
        (Self::F64, "f64", "Double, 53 bits"),
        (Self::F32, "f32", "Single, 24 bits, as on a microcontroller"),
    ];
}

/// The safety chain, and the mass, damping, delay and lag of a device at a port as far as its own keys and its device file say them.
fn guarded(table: &Table<'_>, real: bool) -> Result<(Safety, Option<Dynamics>), FileError> {
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
    Ok((safety, dynamics))
}

/// What `[relax]` and `[creep]` share, with the table of a controller that holds the indenter; `load` reads what they do not.
pub(super) fn rendering(
    table: &Table<'_>,
    held: Option<&Table<'_>>,
    contact: &Parameter,
    duration_s: f64,
    load: impl FnOnce(&TissuePiece) -> Result<RigDrive, FileError>,
) -> Result<Indentation, FileError> {
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
            loop_host = p::LOOP.set_to("host")
        );
        without(table, [&PRECISION], idle)?;
    }
    let (safety, dynamics) = guarded(table, remote.is_some())?;
    let sample_time_s = table.number(&p::SAMPLE_TIME)?;
    samples_fit(table, sample_time_s, duration_s, &SAMPLES)?;
    let piece = piece(table)?;
    let (model, order) = (piece.material.composed(), piece.material.order());
    let scheme = scheme(table, model, order, sample_time_s, duration_s)?;
    Ok(Indentation {
        load: load(&piece)?,
        duration_s,
        dynamics,
        piece,
        scheme,
        precision,
        sample_time_s,
        contact: match table.choice(contact)? {
            Contact::Ideal if !table.has(contact) && (remote.is_some() || held.is_some()) => {
                Contact::Compliant
            }
            given @ (Contact::Compliant | Contact::Rigid | Contact::Ideal) => given,
        },
        mass_kg: table.number(&RIG_MASS)?,
        damping_n_s_per_m: table.number(&RIG_DAMPING)?,
        drive: held.map(drive::drive).transpose()?,
        sensors,
        force_limit_n: table.number(&p::FORCE_LIMIT)?,
        force_rate_limit_n_per_s: table.number(&p::FORCE_RATE_LIMIT)?,
        safety,
        conduct: Conduct::on(remote),
    })
}
