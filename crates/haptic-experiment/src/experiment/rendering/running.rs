//! The loop on the rig: simulated alone, or run with a log, here or on a device.

use super::specification::{Contact, Precision, Rendering};
use crate::document::advice::parameter;
use crate::document::failure::Failure;
use crate::document::parameters::{AREA, CONTACT, CONTROLLER, THICKNESS, TISSUE};
use crate::experiment::drive::{DriveJudge, DriveVerdict, SimulatedRig, TissueLaw};
use crate::judge::modelled_tissue::loop_operator;
use crate::judge::preflight::Preflight;
use crate::run::folder::FolderRequest;
use crate::run::record::Record;
use crate::run::remote::{RemoteRun, blank, host_limits};
use crate::run::safety::GuardedDevice;
use crate::run::schedule::Schedule;
use crate::run::simulate::{Simulated, Sink, simulate};
use crate::run::{Ran, Supervisor, run_logged};
use fracdiff::{Operator, Real, Seconds};
use haptic_link::LoopMode;
use haptic_loop::plant::{HeldRig, IndentationRig, RigDrive, Sensed};
use haptic_loop::units::{Metres, Newtons, NewtonsPerSecond, Pascals};
use haptic_loop::{Contact as OneSided, Controller, Limits, SafetyChain, SpringDamper};
use std::collections::BTreeMap;

/// A one-sided virtual tissue that begins at 0.
type VirtualTissue<F> = OneSided<F, SpringDamper<F, Operator<F>>, 1>;

impl Rendering {
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
        match self.precision {
            Precision::F64 => self.simulate_as::<f64>(drive, samples, sink),
            Precision::F32 => self.simulate_as::<f32>(drive, samples, sink),
        }
    }

    fn simulate_as<F: Real>(
        &self,
        drive: RigDrive,
        samples: u64,
        sink: Sink<'_>,
    ) -> Result<bool, Failure> {
        let mut controller = self.controller::<F>(drive, samples)?;
        let mut rig = self.rig_behind_sensors(drive)?;
        Ok(simulate(&mut controller, &mut rig, samples, sink))
    }

    fn run_as<F: Real>(
        &self,
        drive: RigDrive,
        samples: u64,
        request: &FolderRequest,
        mut metadata: BTreeMap<String, String>,
        supervisor: Supervisor<'_>,
    ) -> Result<Ran, Failure> {
        let mut controller = self.controller::<F>(drive, samples)?;
        let schedule = Schedule {
            samples,
            sample_time_s: self.sample_time_s,
            pace: self.pace,
        };
        self.drive_acts()?;
        if let Some(device) = &self.remote {
            let reference = move |time_s: f64| match drive {
                RigDrive::Position(profile) => profile.position(time_s),
                RigDrive::Force(_) => f64::NAN,
            };
            let run = RemoteRun {
                device,
                law: self.law(drive, device, samples)?,
                schedule,
                blank: &|time_s| blank(reference(time_s)),
                preflight: self.preflight(drive, samples),
                wanted: self.preflight,
                request,
                metadata,
            };
            return run.run(&mut controller, supervisor);
        }
        let mut device = self.rig_behind_sensors(drive)?;
        if let Some(verdict) = self.drive_verdict(drive, samples)? {
            verdict.require_stable(self.preflight.force_unstable)?;
            verdict.describe(&mut metadata);
        }
        let mut world = Simulated::new(&mut controller, &mut device);
        run_logged(&mut world, schedule, (request, metadata), supervisor)
    }

    /// The tissue behind the safety chain.
    fn controller<F: Real>(
        &self,
        drive: RigDrive,
        samples: u64,
    ) -> Result<Controller<F, 1, VirtualTissue<F>>, Failure> {
        let operator: Operator<F> = self.operator(samples)?;
        let (modulus, viscosity) = (
            Pascals(self.material.rest_modulus_pa()),
            self.material.viscosity_pa_s_mu(),
        );
        let tissue = SpringDamper::of_specimen(modulus, viscosity, &self.specimen, operator);
        let tissue = tissue.map_err(|error| {
            Failure::input_with_advice(
                error,
                format_args!("change {AREA}, {THICKNESS} or {TISSUE}"),
            )
        })?;
        let environment = OneSided::at(Metres(0.0), tissue).map_err(Failure::input)?;
        let limits = match &self.remote {
            None => self.limits_on_rig(drive)?,
            Some(remote) if remote.loop_mode == LoopMode::Host => host_limits(&self.limits(true)),
            // The chain is the device's; this one runs only to be checked.
            Some(_) => self.limits(true),
        };
        let chain =
            SafetyChain::from_limits(&limits, Seconds(self.sample_time_s)).map_err(parameter)?;
        match &self.remote {
            None => self.safety.acts()?,
            Some(_) => self.safety.acts_on_device()?,
        }
        Ok(Controller::new(environment, chain))
    }

    /// The simulated rig.
    fn rig_behind_sensors(&self, drive: RigDrive) -> Result<Sensed<SimulatedRig>, Failure> {
        let config = self.rig(drive);
        let rig = match &self.drive {
            None => {
                let rig = IndentationRig::new(config).map_err(Failure::input)?;
                SimulatedRig::Plain(Box::new(rig))
            }
            Some(own) => {
                self.drive_acts()?;
                let holder = own.holder(self.sample_time_s)?;
                let rig = HeldRig::new(config, holder).map_err(Failure::input)?;
                SimulatedRig::Held(Box::new(rig))
            }
        };
        self.sensors.before(rig)
    }

    /// Refuses a drive where nothing could be held by one.
    fn drive_acts(&self) -> Result<(), Failure> {
        if self.drive.is_none() {
            return Ok(());
        }
        if self.remote.is_some() {
            return Err(Failure::bad_input(format_args!(
                "a {CONTROLLER} of a drive holds the indenter of the simulated rig: leave it away with a serial device"
            )));
        }
        match self.contact {
            Contact::Compliant => Ok(()),
            Contact::Rigid => Err(Failure::bad_input(format_args!(
                "the {CONTROLLER} of a drive moves a mass, and a rigid contact has none: take {contact_compliant}",
                contact_compliant = CONTACT.set_to("compliant")
            ))),
        }
    }

    /// The loop of the drive before it runs; `None` without one.
    pub(crate) fn drive_verdict(
        &self,
        drive: RigDrive,
        samples: u64,
    ) -> Result<Option<DriveVerdict>, Failure> {
        let Some(own) = &self.drive else {
            return Ok(None);
        };
        let (stiffness, dissipation) = self.spring_and_damper();
        let t = self.sample_time_s;
        let horizon = crate::run::schedule::horizon(samples);
        let (model, order) = (self.material.composed(), self.material.order());
        let operator = loop_operator(model, self.scheme, order, Seconds(t), horizon)?;
        let tissue = TissueLaw::new(stiffness, dissipation, operator, t);
        own.verdict(&self.rig(drive), tissue).map(Some)
    }

    /// Limits of the safety chain, without a guard.
    pub(super) fn limits(&self, starts_small: bool) -> Limits {
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
    fn preflight(&self, drive: RigDrive, samples: u64) -> Option<Preflight<'_>> {
        let imposed = matches!(drive, RigDrive::Position(_)) && self.contact == Contact::Rigid;
        let (stiffness, dissipation) = self.spring_and_damper();
        (!imposed).then(|| Preflight {
            stiffness_n_per_m: stiffness,
            dissipation_n_s_mu_per_m: dissipation,
            order: self.material.order(),
            model: self.material.composed(),
            scheme: self.scheme,
            sample_time_s: self.sample_time_s,
            samples,
        })
    }

    /// The judge of the drive over this record; `None` without one.
    pub(crate) fn drive_judge(
        &self,
        drive: RigDrive,
        record: &Record,
    ) -> Result<Option<DriveJudge>, Failure> {
        let verdict = self.drive_verdict(drive, record.samples)?;
        let judge =
            self.drive.as_ref().zip(verdict).map(|(own, verdict)| {
                DriveJudge::new(own, drive, self.sample_time_s, verdict, record)
            });
        judge.transpose()
    }

    /// The operator, for so many samples.
    pub(super) fn operator<F: Real>(&self, samples: u64) -> Result<Operator<F>, Failure> {
        let t = Seconds(self.sample_time_s);
        self.material.operator(self.scheme, t, samples)
    }
}
