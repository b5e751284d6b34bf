//! A tissue, the operator that renders it, and the rig it is rendered on: what relaxation and creep share, and their keys.

use super::reading::{device_model, piece, remote, samples_fit, scheme, sensors, without};
use crate::document::error::FileError;
use crate::document::named::Named;
use crate::document::parameters as p;
use crate::document::parameters::kind::{Parameter, joined, parameters};
use crate::document::parameters::range::{
    DAMPINGS, DURATIONS, FORCES_ABOVE_0, MASSES, REACHES_ABOVE_0, STRAINS, STRESSES,
};
use crate::document::reader::Table;
use crate::experiment::drive::{self, Drive};
use crate::judge::Reference;
use crate::judge::modelled_tissue::TissuePiece;
use crate::run::SAMPLES;
use crate::run::preflight::PreflightRequest;
use crate::run::remote::{RemoteDevice, device_name};
use crate::run::safety::safety;
use crate::run::safety::{GuardedDevice, Safety};
use crate::run::schedule::Pace;
use crate::run::sensors::Sensors;
use fracdiff::{Scheme, Seconds};
use haptic_analysis::Dynamics;
use haptic_link::LoopMode;
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

/// A specimen of tissue, the operator that renders it, and the rig it is rendered on.
#[derive(Clone, Debug)]
pub(crate) struct Rendering {
    pub(crate) piece: TissuePiece,
    pub scheme: Scheme,
    /// Number type of the loop.
    pub(crate) precision: Precision,
    pub sample_time_s: f64,
    pub(crate) contact: Contact,
    /// Mass of each of the two actuators, kg.
    pub(crate) mass_kg: f64,
    /// Viscous damping of each, N·s/m.
    pub(crate) damping_n_s_per_m: f64,
    /// The controller that holds the indenter; `None` for the rig's own servo or a constant push.
    pub(crate) drive: Option<Drive>,
    pub(crate) sensors: Sensors,
    pub(crate) force_limit_n: f64,
    /// Largest rate of force, N/s.
    pub(crate) force_rate_limit_n_per_s: f64,
    /// Further settings of the safety chain.
    pub(crate) safety: Safety,
    pub(crate) pace: Pace,
    /// The serial device; `None` for the simulated rig.
    pub(crate) remote: Option<RemoteDevice>,
    pub(crate) preflight: PreflightRequest,
}

impl Rendering {
    /// Memory of the operator, s; `None` for all of the past.
    pub(super) fn memory_s(&self) -> Option<f64> {
        self.scheme.memory_s(Seconds(self.sample_time_s))
    }

    /// The kernel whose full history the force is compared with: the scheme's own, or Grünwald's.
    pub(super) fn reference_kernel(&self) -> Reference {
        Reference::of(self.scheme)
    }

    /// The number type that the force was computed in: that of the device, if the loop was closed there.
    pub(super) fn precision_run(&self) -> Precision {
        match &self.remote {
            Some(remote) if remote.loop_mode == LoopMode::Device => Precision::F32,
            _ => self.precision,
        }
    }

    /// The device, as on the command line.
    pub(super) fn device_name(&self) -> String {
        device_name(self.remote.as_ref())
    }
}

/// The safety chain and the pre-flight of a device, whose mass, damping, delay and lag its own keys say, and its device file.
fn guarded(table: &Table<'_>, real: bool) -> Result<(Safety, PreflightRequest), FileError> {
    let mut safety = safety(table)?;
    let model = device_model(table)?;
    if let Some(model) = &model {
        let on_rig = safety.on_rig(&model.guarded(), real);
        safety = on_rig.map_err(|error| table.fail_at(p::DEVICE_MODEL.key, error.to_string()))?;
    }
    let known = safety.guarded(GuardedDevice::default());
    let known = known.mass_kg.zip(known.damping_n_s_per_m);
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

/// The rendering of `[relax]` or `[creep]`, with the table of a controller that holds the indenter.
pub(super) fn rendering(
    table: &Table<'_>,
    held: Option<&Table<'_>>,
    (contact, duration_s): (&Parameter, f64),
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
            loop_host = p::LOOP.set_to("host")
        );
        without(table, [&PRECISION], idle)?;
    }
    let (safety, preflight) = guarded(table, remote.is_some())?;
    let sample_time_s = table.number(&p::SAMPLE_TIME)?;
    samples_fit(table, sample_time_s, duration_s, &SAMPLES)?;
    let piece = piece(table)?;
    let (model, order) = (piece.material.composed(), piece.material.order());
    let scheme = scheme(table, model, order, sample_time_s, duration_s)?;
    Ok(Rendering {
        preflight,
        piece,
        scheme,
        precision,
        sample_time_s,
        contact: match table.choice(contact)? {
            Contact::Ideal if !table.has(contact) && (remote.is_some() || held.is_some()) => {
                Contact::Compliant
            }
            contact => contact,
        },
        mass_kg: table.number(&RIG_MASS)?,
        damping_n_s_per_m: table.number(&RIG_DAMPING)?,
        drive: held.map(drive::drive).transpose()?,
        sensors,
        force_limit_n: table.number(&p::FORCE_LIMIT)?,
        force_rate_limit_n_per_s: table.number(&p::FORCE_RATE_LIMIT)?,
        safety,
        pace: Pace::Virtual,
        remote,
    })
}
