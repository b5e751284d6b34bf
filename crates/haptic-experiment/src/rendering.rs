//! A tissue rendered on the simulated rig: everything that relaxation and creep share.

use super::kept::Samples;
use super::preflight::{Preflight, PreflightRequest};
use super::refused::parameter;
use super::remote::{
    Kept, RemoteDevice, RemoteLaw, RemoteRun, host_limits, indentation, no_operator, portable, push,
};
use super::run::{Ran, SAMPLES, Supervisor, run_logged};
use super::safety::{GuardedDevice, Safety};
use super::schedule::{Pace, Schedule};
use super::sensed::{Sensed, Sensors};
use super::track::{Track, operator};
use crate::failure::Failure;
use crate::folder::FolderRequest;
use crate::imperfections::Imperfections;
use crate::modelled::ModelledTissue;
use crate::named::Named;
use crate::parameters;
use crate::simulate::{Sink, simulate};
use fracdiff::full_memory::Kernel;
use fracdiff::{Operator, Real, Scheme, Seconds};
use haptic_link::LoopMode;
use haptic_loop::plant::{IndentationRig, RigConfig, RigContact, RigDrive};
use haptic_loop::units::{Metres, Newtons, NewtonsPerSecond, SquareMetres};
use haptic_loop::{Contact as OneSided, Controller, KelvinVoigt, Limits, SafetyChain, Specimen};
use serde::Serialize;
use std::collections::BTreeMap;

/// Parameters of a rig as metadata, each with its unit.
fn rig_values(rig: &RigConfig) -> impl Iterator<Item = (String, String)> + use<> {
    let servo = rig.servo;
    let mut values = vec![
        ("renderer_mass_kg", rig.renderer_mass.0),
        ("renderer_damping_n_s_per_m", rig.renderer_damping.0),
        ("indenter_mass_kg", rig.indenter_mass.0),
        ("indenter_damping_n_s_per_m", rig.indenter_damping.0),
    ];
    if let RigContact::Compliant { stiffness, damping } = rig.contact {
        values.push(("contact_stiffness_n_per_m", stiffness.0));
        values.push(("contact_damping_n_s_per_m", damping.0));
        // An imposed position needs no servo, nor does a force.
        if let RigDrive::Position(_) = rig.drive {
            values.push(("servo_stiffness_n_per_m", servo.stiffness.0));
            values.push(("servo_damping_n_s_per_m", servo.damping.0));
            values.push(("servo_integral_time_s", servo.integral_time.0));
        }
    }
    if let Some(saturation) = rig.saturation {
        values.push(("renderer_force_saturation_n", saturation.0));
    }
    let named = |(name, value): (&str, f64)| (format!("rig_{name}"), value.to_string());
    values.into_iter().map(named)
}

/// A one-sided virtual tissue that begins at 0.
type VirtualTissue<F> = OneSided<F, KelvinVoigt<F, Operator<F>>, 1>;

/// How the indenter touches the renderer.
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
            "A stiff, one-sided spring and damper between two masses, as on a real rig",
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
    /// Between position and loop.
    pub sensors: Sensors,
    /// Largest force, N.
    pub force_limit_n: f64,
    /// Largest rate of force, N/s.
    pub force_rate_limit_n_per_s: f64,
    /// What else the safety chain does.
    pub safety: Safety,
    /// How time passes.
    pub pace: Pace,
    /// The serial device; `None` for the simulated rig.
    pub remote: Option<RemoteDevice>,
    /// What the pre-flight is to do.
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
        let t = self.sample_time_s;
        let (least, most) = (Seconds::MIN_SAMPLE_TIME, Seconds::MAX_SAMPLE_TIME);
        if !(least..=most).contains(&t) {
            return Err(Failure::bad_input(format_args!(
                "sample time {t} s is not in [{least:e}, {most:e}] s: give `sample_time_s`, as in 0.001"
            )));
        }
        let samples = (duration_s / t).round() + 1.0;
        if duration_s > 0.0 && SAMPLES.contains(&samples) {
            Ok(samples as u64)
        } else {
            Err(Failure::bad_input(format_args!(
                "duration {duration_s} s at a sample time of {t} s is {samples} samples, which is not \
                 in [{}, {:e}]: change `duration_s` or `sample_time_s`",
                SAMPLES.start(),
                SAMPLES.end()
            )))
        }
    }

    /// How long the operator remembers, s; `None` if all of it. For the recursive forms the time that
    /// their slowest part takes to fade, about one period of the lower corner or N samples.
    #[must_use]
    pub fn memory_s(&self) -> Option<f64> {
        let t = self.sample_time_s;
        match self.scheme {
            Scheme::Grunwald { length } => Some(length as f64 * t),
            Scheme::Muir { degree } => Some((degree + 1) as f64 * t),
            Scheme::TustinMuir { degree } => Some(degree as f64 * t),
            Scheme::Oustaloup { band, .. } => Some(1.0 / band.low_hz),
            _ => None,
        }
    }

    /// The rig with this drive.
    fn rig(&self, drive: RigDrive) -> RigConfig {
        let contact = match self.contact {
            Contact::Compliant => RigContact::COMPLIANT,
            Contact::Rigid => RigContact::Rigid,
        };
        RigConfig::new(drive, contact, Seconds(self.sample_time_s))
    }

    /// Everything needed to make this rendering again.
    #[must_use]
    pub fn metadata(&self, experiment: &str, drive: RigDrive) -> BTreeMap<String, String> {
        let entries = [
            ("experiment", experiment.to_owned()),
            ("device", self.device_name()),
            ("tissue", self.material.name.clone()),
            (
                "elastic_modulus_pa",
                self.material.elastic_modulus_pa.to_string(),
            ),
            (
                "viscosity_pa_s_alpha",
                self.material.viscosity_pa_s_alpha.to_string(),
            ),
            ("order", self.material.order.to_string()),
            ("area_m2", self.specimen.area().0.to_string()),
            ("thickness_m", self.specimen.thickness().0.to_string()),
            ("scheme", self.scheme.to_string()),
            (
                "precision",
                format!("{:?}", self.precision_run()).to_lowercase(),
            ),
            ("sample_time_s", self.sample_time_s.to_string()),
            ("contact", format!("{:?}", self.contact).to_lowercase()),
            (
                "encoder_resolution_m",
                self.sensors.encoder_resolution_m.to_string(),
            ),
            ("sensor_noise_m", self.sensors.noise_m.to_string()),
            ("seed", self.sensors.seed.to_string()),
            ("force_limit_n", self.force_limit_n.to_string()),
            (
                "force_rate_limit_n_per_s",
                self.force_rate_limit_n_per_s.to_string(),
            ),
            ("pace", self.pace.to_string()),
        ];
        let mut metadata: BTreeMap<String, String> =
            entries.map(|(key, value)| (key.to_owned(), value)).into();
        // The rig and the servo as they are built in.
        if self.remote.is_none() {
            metadata.extend(rig_values(&self.rig(drive)));
        }
        metadata.insert(
            "tissue_source".to_owned(),
            self.material.source.citation.clone(),
        );
        metadata.insert(
            "tissue_checked".to_owned(),
            self.material.source.checked.to_string(),
        );
        self.safety.describe(&mut metadata);
        metadata
    }

    /// The kernel whose full history the force is compared with: the scheme's own, or Grünwald's.
    #[must_use]
    pub fn reference_kernel(&self) -> Kernel {
        match self.scheme {
            Scheme::Full { kernel, .. } => kernel,
            _ => Kernel::Grunwald,
        }
    }

    /// The force that the specimen opposes to an indentation, by the full history of it, N.
    ///
    /// ```text
    /// F = max(0, (A/ℓ)·(E₀·x + η·D^α x))        x ≥ 0
    /// ```
    ///
    /// # Errors
    /// If the record cannot be transformed.
    pub fn full_history_force(&self, position_m: &[f64]) -> anyhow::Result<Vec<f64>> {
        let tissue = self.material.tissue();
        // The virtual tissue begins at 0 and only pushes.
        let depth: Vec<f64> = position_m.iter().map(|x| x.max(0.0)).collect();
        let t = Seconds(self.sample_time_s);
        let kernel = self.reference_kernel();
        let derivative = super::judge::full_history(kernel, tissue.order(), t, &depth)?;
        let pushes = self.pushes();
        let forces = depth.iter().zip(derivative).map(|(&x, d)| pushes(x, d));
        Ok(forces.collect())
    }

    /// The same tick by tick, for a run too long to keep: from each position the force.
    ///
    /// # Errors
    /// A duration outside the range of [`samples`](Self::samples).
    pub(super) fn full_history_step(
        &self,
        duration_s: f64,
    ) -> Result<impl FnMut(f64) -> f64 + use<>, Failure> {
        let samples = self.samples(duration_s)?;
        let (kernel, t) = (self.reference_kernel(), Seconds(self.sample_time_s));
        let mut channel = operator(kernel, self.material.tissue().order(), t, samples)?;
        let pushes = self.pushes();
        Ok(move |x: f64| {
            let depth = x.max(0.0);
            pushes(depth, channel.step(depth))
        })
    }

    /// The force of [`full_history_force`](Self::full_history_force) for each sample of a run.
    ///
    /// # Errors
    /// If the record cannot be transformed.
    pub(super) fn full_history(
        &self,
        samples: Samples<'_>,
        duration_s: f64,
    ) -> Result<Track<'static>, Failure> {
        Track::new(
            samples,
            |x| self.full_history_force(x).map_err(Failure::Run),
            || {
                let mut force = self.full_history_step(duration_s)?;
                Ok(Box::new(move |_, x| force(x)))
            },
        )
    }

    /// The force at a depth of at least 0, m, and its derivative of order α, N.
    fn pushes(&self) -> impl Fn(f64, f64) -> f64 + use<> {
        let (stiffness, dissipation) = self.spring_and_damper();
        move |depth, derivative| {
            if depth > 0.0 {
                (stiffness * depth + dissipation * derivative).max(0.0)
            } else {
                0.0
            }
        }
    }

    /// Runs the loop on the rig and writes the log. Nothing is made in the folder before every
    /// parameter is known to be good.
    ///
    /// # Errors
    /// Bad parameters; a folder or log that cannot be written.
    pub fn run(
        &self,
        drive: RigDrive,
        samples: u64,
        request: &FolderRequest,
        metadata: BTreeMap<String, String>,
        supervisor: Supervisor<'_>,
    ) -> Result<Ran, Failure> {
        match self.precision {
            Precision::F64 => self.run_as::<f64>(drive, samples, request, metadata, supervisor),
            Precision::F32 => self.run_as::<f32>(drive, samples, request, metadata, supervisor),
        }
    }

    /// The same without folder, log or clock, on the simulated rig: each sample goes to the sink. `true` if it reached the end
    /// without a fault.
    ///
    /// # Errors
    /// Bad parameters.
    pub fn simulate(&self, drive: RigDrive, samples: u64, sink: Sink<'_>) -> Result<bool, Failure> {
        Ok(match self.precision {
            Precision::F64 => {
                let mut controller = self.controller::<f64>(drive, samples)?;
                simulate(
                    &mut controller,
                    &mut self.rig_behind_sensors(drive)?,
                    samples,
                    sink,
                )
            }
            Precision::F32 => {
                let mut controller = self.controller::<f32>(drive, samples)?;
                simulate(
                    &mut controller,
                    &mut self.rig_behind_sensors(drive)?,
                    samples,
                    sink,
                )
            }
        })
    }

    fn run_as<F: Real>(
        &self,
        drive: RigDrive,
        samples: u64,
        request: &FolderRequest,
        metadata: BTreeMap<String, String>,
        supervisor: Supervisor<'_>,
    ) -> Result<Ran, Failure> {
        let mut controller = self.controller::<F>(drive, samples)?;
        let schedule = Schedule {
            samples,
            sample_time_s: self.sample_time_s,
            pace: self.pace,
        };
        if let Some(device) = &self.remote {
            let reference = move |time_s: f64| match drive {
                RigDrive::Position(profile) => profile.position(time_s),
                RigDrive::Force(_) => f64::NAN,
            };
            let run = RemoteRun {
                device,
                law: self.law(drive, device, samples)?,
                schedule,
                reference: &reference,
                preflight: self.preflight(drive, samples),
                wanted: self.preflight,
                request,
                metadata,
            };
            return run.run(&mut controller, supervisor);
        }
        let mut device = self.rig_behind_sensors(drive)?;
        run_logged(
            &mut controller,
            &mut device,
            schedule,
            request,
            metadata,
            supervisor,
        )
    }

    /// The tissue behind the safety chain.
    fn controller<F: Real>(
        &self,
        drive: RigDrive,
        samples: u64,
    ) -> Result<Controller<F, 1, VirtualTissue<F>>, Failure> {
        let operator: Operator<F> = self.operator(samples)?;
        let tissue = KelvinVoigt::new(self.material.tissue(), &self.specimen, operator).map_err(
            |error| {
                Failure::input_with_advice(error, "change `area_m2`, `thickness_m` or `tissue`")
            },
        )?;
        let environment = OneSided::at(Metres(0.0), tissue).map_err(Failure::input)?;
        let limits = match &self.remote {
            None => {
                self.safety.acts()?;
                self.limits_on_rig(drive)?
            }
            Some(remote) if remote.loop_mode == LoopMode::Host => host_limits(&self.limits(true)),
            // The chain is the device's; this one runs only to be checked.
            Some(_) => self.limits(true),
        };
        let chain =
            SafetyChain::from_limits(&limits, Seconds(self.sample_time_s)).map_err(parameter)?;
        Ok(Controller::new(environment, chain))
    }

    /// The simulated rig.
    fn rig_behind_sensors(&self, drive: RigDrive) -> Result<Sensed<IndentationRig>, Failure> {
        let rig = IndentationRig::new(self.rig(drive)).map_err(Failure::input)?;
        Sensed::new(rig, self.sensors)
    }

    /// Limits of the safety chain, without a guard.
    fn limits(&self, starts_small: bool) -> Limits {
        let (force, rate) = (self.force_limit_n, self.force_rate_limit_n_per_s);
        let limits = Limits::bare(Newtons(force), NewtonsPerSecond(rate));
        self.safety.on(limits, starts_small)
    }

    /// The same on the simulated rig, with a guard made for its renderer.
    fn limits_on_rig(&self, drive: RigDrive) -> Result<Limits, Failure> {
        let rig = self.rig(drive);
        let known = self.safety.guarded(GuardedDevice {
            mass_kg: Some(rig.renderer_mass.0),
            damping_n_s_per_m: Some(rig.renderer_damping.0),
            delay_s: Some((0.0, 0.0)),
            lag_s: Some(0.0),
            noise_m: Some(self.sensors.deviation_m()),
        });
        Ok(Limits {
            guard: self.safety.guard.of(&known, rig.sample_time)?,
            ..(self.safety).braked(self.limits(false), rig.renderer_mass.0, 0)
        })
    }

    /// The loop for the analysis: the tissue as a wall that is felt all the time. An indentation that is imposed
    /// closes no loop.
    fn preflight(&self, drive: RigDrive, samples: u64) -> Option<Preflight> {
        let imposed = matches!(drive, RigDrive::Position(_)) && self.contact == Contact::Rigid;
        let (stiffness, dissipation) = self.spring_and_damper();
        (!imposed).then(|| Preflight {
            stiffness_n_per_m: stiffness,
            dissipation_n_s_mu_per_m: dissipation,
            order: self.material.tissue().order(),
            scheme: self.scheme,
            sample_time_s: self.sample_time_s,
            samples,
        })
    }

    /// The operator, for so many samples.
    fn operator<F: Real>(&self, samples: u64) -> Result<Operator<F>, Failure> {
        // A little more than needed, so that the last weights are not at the very edge.
        let horizon = crate::schedule::horizon(samples);
        self.scheme
            .build(
                self.material.tissue().order(),
                Seconds(self.sample_time_s),
                horizon,
            )
            .map_err(|error| Failure::input_with_advice(error, "change `scheme`"))
    }

    /// The same tissue and drive for a device.
    fn law(
        &self,
        drive: RigDrive,
        device: &RemoteDevice,
        samples: u64,
    ) -> Result<RemoteLaw, Failure> {
        let (stiffness, dissipation) = self.spring_and_damper();
        Ok(RemoteLaw {
            stiffness_n_per_m: stiffness,
            dissipation_n_s_mu_per_m: dissipation,
            order: self.material.order,
            one_sided: true,
            operator: match device.loop_mode {
                LoopMode::Device => portable(&self.operator(samples)?)?,
                LoopMode::Host => no_operator(),
            },
            limits: self.limits(true),
            kept: Kept {
                speed: self.safety.speed_limit_m_per_s.is_none(),
                ..Kept::default()
            },
            guard: (
                self.safety.guard,
                self.safety.guarded(GuardedDevice::default()),
            ),
            simulation: match drive {
                RigDrive::Position(profile) => indentation(
                    self.contact == Contact::Compliant,
                    profile.depth().0,
                    profile.ramp_time().0,
                ),
                RigDrive::Force(force) => push(force.0),
            },
        })
    }

    /// K in N/m and B in N·s^α/m of the specimen.
    fn spring_and_damper(&self) -> (f64, f64) {
        let tissue = self.material.tissue();
        let shape = self.specimen.area().0 / self.specimen.thickness().0;
        (
            shape * tissue.elastic_modulus().0,
            shape * tissue.viscosity_pa_s_alpha(),
        )
    }

    /// The number type that the force was computed in: that of the device, if the loop was closed there.
    #[must_use]
    pub fn precision_run(&self) -> Precision {
        match &self.remote {
            Some(remote) if remote.loop_mode == LoopMode::Device => Precision::F32,
            _ => self.precision,
        }
    }

    /// The device, as on the command line.
    #[must_use]
    pub fn device_name(&self) -> String {
        super::remote::device_name(self.remote.as_ref())
    }
}
