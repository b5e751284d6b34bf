//! A tissue, the operator that renders it, and the rig it is rendered on.

use crate::document::failure::Failure;
use crate::document::named::Named;
use crate::document::parameters;
use crate::experiment::drive::Drive;
use crate::judge::Reference;
use crate::judge::modelled_tissue::ModelledTissue;
use crate::run::SAMPLES;
use crate::run::preflight::PreflightRequest;
use crate::run::remote::RemoteDevice;
use crate::run::safety::Safety;
use crate::run::schedule::Pace;
use crate::run::sensors::Imperfections;
use crate::run::sensors::Sensors;
use fracdiff::{Scheme, Seconds};
use haptic_link::LoopMode;
use haptic_loop::Specimen;
use haptic_loop::plant::{RigConfig, RigContact, RigDrive};
use haptic_loop::units::{Metres, SquareMetres};
use serde::Serialize;

/// Contact of the indenter with the renderer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Contact {
    /// A stiff, one-sided spring and damper between two masses, as on a real rig.
    Compliant,
    /// The indentation is imposed exactly.
    Rigid,
}

impl Named for Contact {
    const CHOICES: &'static [(Self, &'static str, &'static str)] = &[
        (
            Self::Compliant,
            "compliant",
            "A stiff one-sided spring and damper between two masses, as on a real rig",
        ),
        (Self::Rigid, "rigid", "The indentation is imposed exactly"),
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
pub struct Rendering {
    /// The tissue.
    pub material: ModelledTissue,
    /// The piece of it.
    pub specimen: Specimen,
    /// The operator.
    pub scheme: Scheme,
    /// Number type of the loop.
    pub precision: Precision,
    /// T, s.
    pub sample_time_s: f64,
    /// Between indenter and renderer.
    pub contact: Contact,
    /// The controller that holds the indenter; `None` for the rig's own servo or a constant push.
    pub drive: Option<Drive>,
    /// Between position and loop.
    pub sensors: Sensors,
    /// Largest force, N.
    pub force_limit_n: f64,
    /// Largest rate of force, N/s.
    pub force_rate_limit_n_per_s: f64,
    /// Further settings of the safety chain.
    pub safety: Safety,
    /// Pace of time.
    pub pace: Pace,
    /// The serial device; `None` for the simulated rig.
    pub remote: Option<RemoteDevice>,
    /// Request for the pre-flight.
    pub preflight: PreflightRequest,
}

impl Rendering {
    /// A tissue with the defaults of the parameters, on the simulated rig in virtual time.
    ///
    /// # Errors
    /// None: the defaults are within their ranges.
    pub fn new(material: ModelledTissue) -> Result<Self, Failure> {
        let area = SquareMetres(parameters::AREA.default_number());
        let thickness = Metres(parameters::THICKNESS.default_number());
        let scheme = parameters::SCHEME.shown.parse::<Scheme>();
        Ok(Self {
            material,
            specimen: Specimen::new(area, thickness).map_err(Failure::input)?,
            scheme: scheme.map_err(Failure::input)?,
            precision: Precision::F64,
            sample_time_s: parameters::SAMPLE_TIME.default_number(),
            contact: Contact::Compliant,
            drive: None,
            sensors: Imperfections::NONE.sensors,
            force_limit_n: parameters::FORCE_LIMIT.default_number(),
            force_rate_limit_n_per_s: parameters::FORCE_RATE_LIMIT.default_number(),
            safety: Safety::default(),
            pace: Pace::Virtual,
            remote: None,
            preflight: PreflightRequest::default(),
        })
    }

    /// Number of samples from time 0 to `duration_s`, both included.
    ///
    /// # Errors
    /// If that is too few or too many, or one of the two is not a number above 0.
    pub fn samples(&self, duration_s: f64) -> Result<u64, Failure> {
        crate::run::schedule::samples(duration_s, self.sample_time_s, &SAMPLES)
    }

    /// Memory of the operator, s; `None` for all of the past.
    #[must_use]
    pub(crate) fn memory_s(&self) -> Option<f64> {
        self.scheme.memory_s(Seconds(self.sample_time_s))
    }

    /// The rig with this drive.
    pub(super) fn rig(&self, drive: RigDrive) -> RigConfig {
        let contact = match self.contact {
            Contact::Compliant => RigContact::COMPLIANT,
            Contact::Rigid => RigContact::Rigid,
        };
        RigConfig::new(drive, contact, Seconds(self.sample_time_s))
    }

    /// The kernel whose full history the force is compared with: the scheme's own, or Grünwald's.
    #[must_use]
    pub(crate) fn reference_kernel(&self) -> Reference {
        Reference::of(self.scheme)
    }

    /// A/ℓ, m.
    pub(super) fn shape(&self) -> f64 {
        self.specimen.area().0 / self.specimen.thickness().0
    }

    /// K in N/m and B in N·s^μ/m of the specimen.
    pub(super) fn spring_and_damper(&self) -> (f64, f64) {
        self.material.spring_and_damper(self.shape())
    }

    /// The number type that the force was computed in: that of the device, if the loop was closed there.
    #[must_use]
    pub(crate) fn precision_run(&self) -> Precision {
        match &self.remote {
            Some(remote) if remote.loop_mode == LoopMode::Device => Precision::F32,
            _ => self.precision,
        }
    }

    /// The device, as on the command line.
    #[must_use]
    pub(crate) fn device_name(&self) -> String {
        crate::run::remote::device_name(self.remote.as_ref())
    }
}
