//! A tissue under an indenter: stress relaxation, and creep.
//!
//! - *Relaxation*: the indenter follows a ramp to the depth δ₀ in T₀ and holds it; the force that the virtual tissue opposes
//!   to it is the result. Source: O. Tokatlı, *Fractional Order Control in Haptics*, figure 7.2.
//! - *Creep*: the indenter pushes with F₀ from t = 0, and both sink in. The closed form is that of the tissue alone. On the
//!   ideal rig nothing has a mass, and each depth is the root of γ·(c₀·e(x\[n\]) + past) = F₀; the masses and the damping of
//!   another rig slow the start down, and the report says from when on the tissue is seen.
//!
//! A slab is held at a strain or under a stress, δ₀ = ε₀·h and F₀ = σ₀·A; any other piece at a depth or under a force.

mod report;
#[cfg(test)]
mod tests;

use super::reading::metadata;
use super::rendering::{
    CREEP_CONTACT, CREEP_DURATION, Contact, DEPTH, FORCE, Precision, RAMP_TIME, RELAX_DURATION,
    Rendering, STRAIN, STRESS, rendering,
};
use crate::document::error::FileError;
use crate::document::failure::Failure;
use crate::document::named::Named as _;
use crate::document::parameters as p;
use crate::document::parameters::{CONTACT, CONTROLLER, DEVICE, LOOP, Parameter, TISSUE};
use crate::document::reader::Table;
use crate::document::{CONTROLLER_IN_LOG, TISSUE_IN_LOG};
use crate::experiment::drive::{Drive, SimulatedRig, TissueLaw};
use crate::judge::preflight::{Preflight, WallContact};
use crate::run::advice::parameter;
use crate::run::drive_verdict::DriveVerdict;
use crate::run::folder::FolderRequest;
use crate::run::preflight::{Findings as _, PreflightSubject, note_findings};
use crate::run::remote::{
    RemoteDevice, RemoteLaw, RemoteRun, UnchangedLimits, blank, indentation, no_operator, portable,
    push,
};
use crate::run::safety::keys::SPEED_LIMIT;
use crate::run::safety::{GuardChoice, GuardedDevice};
use crate::run::schedule::{Schedule, samples};
use crate::run::simulate::{Simulated, Sink, simulate};
use crate::run::tick::KeptSample;
use crate::run::{Ran, SAMPLES, Supervisor, run_logged};
use fracdiff::parameter::Shown;
use fracdiff::{Operator, Real, Seconds};
use fractional_control::Term;
use haptic_analysis::Dynamics;
use haptic_link::{LoopMode, Simulation};
use haptic_loop::plant::{
    HeldRig, IndentationRig, RampHold, RigConfig, RigContact, RigDrive, RigServo, Sensed,
};
use haptic_loop::units::{Kilograms, Metres, NewtonSecondsPerMetre, Newtons, NewtonsPerSecond};
use haptic_loop::{Contact as OneSided, Controller, Limits, SafetyChain, Specimen, SpringDamper};
pub use report::IndentationReport;
use std::collections::BTreeMap;

/// A one-sided virtual tissue that begins at 0.
type VirtualTissue<F> = OneSided<F, SpringDamper<F, Operator<F>>, 1>;

/// A tissue under an indenter.
#[derive(Clone, Debug)]
pub struct Indentation {
    /// The tissue, and how it is rendered.
    pub(crate) rendering: Rendering,
    pub(crate) load: Load,
    /// Until when, s.
    pub duration_s: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Load {
    /// It holds a depth: a relaxation.
    Depth {
        /// δ₀, m, above 0.
        depth_m: f64,
        ramp_time_s: f64,
    },
    /// It pushes from t = 0 on: creep.
    Force {
        /// F₀, N, above 0.
        force_n: f64,
    },
}

impl Indentation {
    /// Runs the loop and writes the log.
    pub(crate) fn record(
        &self,
        request: &FolderRequest,
        supervisor: Supervisor<'_>,
    ) -> Result<Ran, Failure> {
        match self.rendering.precision {
            Precision::F64 => self.record_as::<f64>(request, supervisor),
            Precision::F32 => self.record_as::<f32>(request, supervisor),
        }
    }

    /// The same on the simulated rig in virtual time, without folder, log or clock: each sample goes to the sink. `true` if it
    /// reached the end without a fault.
    ///
    /// # Errors
    /// Bad parameters.
    pub fn simulate(&self, sink: Sink<'_>) -> Result<bool, Failure> {
        match self.rendering.precision {
            Precision::F64 => self.simulate_as::<f64>(sink),
            Precision::F32 => self.simulate_as::<f32>(sink),
        }
    }

    /// The number of samples, if all parameters are good.
    pub(crate) fn check(&self) -> Result<u64, Failure> {
        let samples = samples(self.duration_s, self.rendering.sample_time_s, &SAMPLES)?;
        match self.load {
            Load::Depth { ramp_time_s, .. }
                if !(ramp_time_s > 0.0 && ramp_time_s < self.duration_s) =>
            {
                Err(Failure::bad_input(format_args!(
                    "ramp time {} s is not above 0 s and below the duration of {} s: give {RAMP_TIME}",
                    Shown(ramp_time_s),
                    Shown(self.duration_s)
                )))
            }
            _ => Ok(samples),
        }
    }

    /// The verdict on the controller that holds the indenter over so many samples; `None` without one.
    pub(super) fn drive_verdict(&self, samples: u64) -> Result<Option<DriveVerdict>, Failure> {
        let rendering = &self.rendering;
        let Some(own) = &rendering.drive else {
            return Ok(None);
        };
        let look = self.look(samples);
        let (stiffness, dissipation) = (look.stiffness_n_per_m, look.dissipation_n_s_mu_per_m);
        let operator = look.loop_operator()?;
        let tissue = TissueLaw::new(stiffness, dissipation, operator, look.sample_time_s);
        own.verdict(&self.rig()?, tissue).map(Some)
    }

    /// The way of the indenter, or its push.
    fn drive(&self) -> Result<RigDrive, Failure> {
        match self.load {
            Load::Depth {
                depth_m,
                ramp_time_s,
            } => RampHold::new(Metres(depth_m), Seconds(ramp_time_s))
                .map(RigDrive::Position)
                .map_err(Failure::input),
            Load::Force { force_n } => Ok(RigDrive::Force(Newtons(force_n))),
        }
    }

    fn rig(&self) -> Result<RigConfig, Failure> {
        let contact = match self.rendering.contact {
            Contact::Compliant => RigContact::COMPLIANT,
            Contact::Rigid | Contact::Ideal => RigContact::Rigid,
        };
        let t = Seconds(self.rendering.sample_time_s);
        let (mass, damping) = (
            Kilograms(self.rendering.mass_kg),
            NewtonSecondsPerMetre(self.rendering.damping_n_s_per_m),
        );
        Ok(RigConfig {
            renderer_mass: mass,
            renderer_damping: damping,
            indenter_mass: mass,
            indenter_damping: damping,
            servo: RigServo::of(mass, damping),
            ..RigConfig::new(self.drive()?, contact, t)
        })
    }

    fn simulate_as<F: Real>(&self, sink: Sink<'_>) -> Result<bool, Failure> {
        let samples = self.check()?;
        let mut controller = self.controller::<F>(samples)?;
        let mut rig = self.rig_behind_sensors()?;
        Ok(simulate(&mut controller, &mut rig, samples, sink))
    }

    /// What the log of a run says of it, over its document.
    pub(crate) fn metadata(&self) -> BTreeMap<String, String> {
        let rendering = &self.rendering;
        let kind = match self.load {
            Load::Depth { .. } => "relax",
            Load::Force { .. } => "creep",
        };
        let mut metadata = metadata(
            kind,
            (rendering.pace, rendering.scheme),
            rendering.remote.as_ref(),
            &rendering.safety,
        );
        let material = &rendering.piece.material;
        let (stiffness, dissipation) = material.spring_and_damper(1.0);
        let ran = [
            ("precision", rendering.precision_run().name().to_owned()),
            ("rendered_modulus_pa", stiffness.to_string()),
            ("rendered_viscosity_pa_s_mu", dissipation.to_string()),
            ("rendered_order", material.order().to_string()),
        ];
        metadata.extend(ran.map(|(key, value)| (key.to_owned(), value)));
        metadata.insert(TISSUE_IN_LOG.to_owned(), material.to_toml());
        if let Some(own) = &rendering.drive {
            metadata.insert(CONTROLLER_IN_LOG.to_owned(), own.controller.to_toml());
        }
        metadata
    }

    /// Nothing is made in the folder before every parameter is known to be good.
    fn record_as<F: Real>(
        &self,
        request: &FolderRequest,
        supervisor: Supervisor<'_>,
    ) -> Result<Ran, Failure> {
        let (rendering, samples, drive) = (&self.rendering, self.check()?, self.drive()?);
        let mut metadata = self.metadata();
        let mut controller = self.controller::<F>(samples)?;
        let schedule = Schedule {
            samples,
            sample_time_s: rendering.sample_time_s,
            pace: rendering.pace,
        };
        self.drive_acts()?;
        if let Some(device) = &rendering.remote {
            let reference = move |time_s: f64| match drive {
                RigDrive::Position(profile) => profile.position(time_s),
                RigDrive::Force(_) => f64::NAN,
            };
            let run = RemoteRun {
                device,
                law: self.law(drive, device, samples)?,
                schedule,
                blank: &|time_s| blank(reference(time_s)),
                preflight: None,
                wanted: rendering.preflight,
                request,
                metadata,
            };
            return match &rendering.drive {
                None => {
                    let run = run.looked_at_by(self.preflight(samples));
                    run.run(&mut controller, supervisor)
                }
                Some(own) => {
                    let tissue = self.tissue_terms();
                    let run = run.looked_at_by(Some(DriveLook { own, tissue }));
                    run.run(&mut controller, supervisor)
                }
            };
        }
        let mut device = self.rig_behind_sensors()?;
        let verdict = self.drive_verdict(samples)?;
        if let Some(verdict) = &verdict {
            verdict.require_stable(rendering.preflight.force_unstable)?;
            note_findings(&mut metadata, DriveVerdict::KEY, verdict);
        }
        let mut world = Simulated::new(&mut controller, &mut device);
        let ran = run_logged(&mut world, schedule, (request, metadata), supervisor)?;
        Ok(Ran {
            drive: verdict,
            ..ran
        })
    }

    /// K and B·s^α of the tissue at the depth to be held; `None` of a chain of parts.
    fn tissue_terms(&self) -> Option<[Term; 2]> {
        let look = self.look(0);
        look.model.is_none().then(|| {
            [
                Term::new(look.stiffness_n_per_m, 0.0),
                Term::new(look.dissipation_n_s_mu_per_m, look.order.get()),
            ]
        })
    }

    /// True if a device is the indenter, and its motor holds it.
    fn holds_device(&self) -> bool {
        self.rendering.drive.is_some() && self.rendering.remote.is_some()
    }

    /// Force that the tissue opposes, N: on a device that a drive moves, the force that this takes.
    fn opposed_n(&self, sample: &KeptSample) -> f64 {
        match self.holds_device() {
            true => sample.force_n,
            false => sample.reaction_n(),
        }
    }

    /// The tissue behind the safety chain.
    fn controller<F: Real>(
        &self,
        samples: u64,
    ) -> Result<Controller<F, 1, VirtualTissue<F>>, Failure> {
        let Rendering {
            piece,
            safety,
            remote,
            ..
        } = &self.rendering;
        let operator: Operator<F> = self.operator(samples)?;
        let (stiffness, dissipation) = piece.spring_and_damper();
        let too_much = |error| {
            let advice = format_args!("change the sizes of the piece or {TISSUE}");
            Failure::input_with_advice(error, advice)
        };
        let tissue = SpringDamper::new(stiffness, dissipation, operator).map_err(too_much)?;
        let map = piece.specimen.depth_map();
        let map = map.map(|map| map.rounded()).transpose().map_err(too_much)?;
        let environment = OneSided::at(Metres(0.0), tissue).map_err(Failure::input)?;
        let environment = environment.with_depth_map(map);
        let limits = match remote {
            None => self.limits_on_rig()?,
            Some(remote) => remote.limits_here(self.limits(true)),
        };
        let t = Seconds(self.rendering.sample_time_s);
        let chain = SafetyChain::from_limits(&limits, t).map_err(parameter)?;
        match remote {
            None => safety.acts()?,
            Some(_) => safety.acts_on_device()?,
        }
        Ok(Controller::new(environment, chain))
    }

    fn rig_behind_sensors(&self) -> Result<Sensed<SimulatedRig>, Failure> {
        let config = self.rig()?;
        let rig = match &self.rendering.drive {
            None if self.is_ideal() => SimulatedRig::Ideal(Box::new(self.massless()?)),
            None => {
                let rig = IndentationRig::new(config).map_err(Failure::input)?;
                SimulatedRig::Plain(Box::new(rig))
            }
            Some(own) => {
                self.drive_acts()?;
                let holder = own.holder(self.rendering.sample_time_s)?;
                let rig = HeldRig::new(config, holder).map_err(Failure::input)?;
                SimulatedRig::Held(Box::new(rig))
            }
        };
        self.rendering.sensors.before(rig)
    }

    /// True for a push on the tissue alone.
    fn is_ideal(&self) -> bool {
        let pushes = matches!(self.load, Load::Force { .. });
        pushes && self.rendering.contact == Contact::Ideal && self.rendering.remote.is_none()
    }

    /// Refuses a drive where nothing could be held by one.
    fn drive_acts(&self) -> Result<(), Failure> {
        if self.rendering.drive.is_none() {
            return Ok(());
        }
        if let Some(remote) = &self.rendering.remote {
            if matches!(self.load, Load::Force { .. }) {
                return Err(Failure::bad_input(format_args!(
                    "no device measures the force that the {CONTROLLER} of a drive holds in a creep test: take [relax], or omit {DEVICE}"
                )));
            }
            if remote.loop_mode == LoopMode::Host {
                return Err(Failure::bad_input(format_args!(
                    "the {CONTROLLER} of a drive runs on the device: take {loop_device}",
                    loop_device = LOOP.set_to("device")
                )));
            }
        }
        match self.rendering.contact {
            Contact::Compliant => Ok(()),
            Contact::Rigid | Contact::Ideal => Err(Failure::bad_input(format_args!(
                "the {CONTROLLER} of a drive moves a mass, and this contact has none: take {contact_compliant}",
                contact_compliant = CONTACT.set_to("compliant")
            ))),
        }
    }

    /// Limits of the safety chain, without a guard.
    fn limits(&self, starts_small: bool) -> Limits {
        let (force, rate) = (
            self.rendering.force_limit_n,
            self.rendering.force_rate_limit_n_per_s,
        );
        let limits = Limits::bare(Newtons(force), NewtonsPerSecond(rate));
        self.rendering.safety.on(limits, starts_small)
    }

    /// The same on the simulated rig, with a guard made for its renderer.
    fn limits_on_rig(&self) -> Result<Limits, Failure> {
        let (rig, safety) = (self.rig()?, &self.rendering.safety);
        let known = safety.guarded(GuardedDevice {
            mass_kg: Some(rig.renderer_mass.0),
            damping_n_s_per_m: Some(rig.renderer_damping.0),
            delay_s: Some((0.0, 0.0)),
            lag_s: Some(0.0),
            noise_m: Some(self.rendering.sensors.deviation_m()),
        });
        Ok(Limits {
            guard: safety.guard.of(&known, rig.sample_time)?,
            ..safety.braked(self.limits(false), rig.renderer_mass.0, 0)
        })
    }

    /// The loop for the analysis: the tissue as a wall that is felt all the time. An indentation that is imposed
    /// closes no loop.
    fn preflight(&self, samples: u64) -> Option<Preflight<'_>> {
        let rigid = self.rendering.contact != Contact::Compliant;
        let imposed = matches!(self.load, Load::Depth { .. }) && rigid;
        // Nothing is imposed on a device: a hand presses it.
        (!imposed || self.rendering.remote.is_some()).then(|| self.look(samples))
    }

    /// The tissue as a wall.
    fn look(&self, samples: u64) -> Preflight<'_> {
        let rendering = &self.rendering;
        let piece = &rendering.piece;
        let (stiffness_n_per_m, dissipation_n_s_mu_per_m) = piece.spring_and_damper();
        let look = Preflight {
            stiffness_n_per_m,
            dissipation_n_s_mu_per_m,
            order: piece.material.order(),
            model: piece.material.composed(),
            scheme: rendering.scheme,
            sample_time_s: rendering.sample_time_s,
            samples,
            map: None,
            contact: WallContact::OneSided,
            guarded: rendering.safety.guard == GuardChoice::EnergyBounding,
        };
        // As steep as it becomes where the run ends.
        look.at_depth(piece.specimen.depth_map(), self.deepest())
    }

    /// The depth at the end of the run, m, that of the tissue alone; on a device, which a hand presses, that of the largest force.
    fn deepest(&self) -> f64 {
        let rendering = &self.rendering;
        match self.load {
            _ if rendering.remote.is_some() => rendering
                .piece
                .crept(rendering.force_limit_n, &[self.duration_s])[0],
            Load::Depth { depth_m, .. } => depth_m,
            Load::Force { force_n } => self.rendering.piece.crept(force_n, &[self.duration_s])[0],
        }
    }

    /// The operator, for so many samples.
    fn operator<F: Real>(&self, samples: u64) -> Result<Operator<F>, Failure> {
        let Rendering { piece, scheme, .. } = &self.rendering;
        piece
            .material
            .operator(*scheme, Seconds(self.rendering.sample_time_s), samples)
    }

    /// The same tissue and drive for a device.
    fn law(
        &self,
        drive: RigDrive,
        device: &RemoteDevice,
        samples: u64,
    ) -> Result<RemoteLaw, Failure> {
        let rendering = &self.rendering;
        let (stiffness, dissipation) = rendering.piece.spring_and_damper();
        let simulation = match drive {
            RigDrive::Position(profile) => indentation(
                rendering.contact == Contact::Compliant,
                profile.depth().0,
                profile.ramp_time().0,
            ),
            RigDrive::Force(force) => push(force.0),
        };
        // Nothing of the rig is there beside the device that the drive moves.
        let simulation = match self.holds_device() {
            true => push(0.0),
            false => simulation,
        };
        let safety = &rendering.safety;
        let bare = RemoteLaw {
            unchanged: UnchangedLimits {
                speed: safety.number(SPEED_LIMIT).is_none(),
                ..UnchangedLimits::default()
            },
            guard: (safety.guard, safety.guarded(GuardedDevice::default())),
            ..RemoteLaw::bare(
                self.limits(true),
                // The device of which the pre-flight speaks, if it knows one.
                match rendering.preflight.dynamics {
                    Some(known) => Simulation {
                        mass_kg: known.mass_kg as f32,
                        damping_n_s_per_m: known.damping_n_s_per_m as f32,
                        ..simulation
                    },
                    None => simulation,
                },
            )
        };
        if let (Some(own), RigDrive::Position(profile)) = (&rendering.drive, drive) {
            let t = rendering.sample_time_s;
            let ramp_ticks = (profile.ramp_time().0 / t).round() as u32;
            let way = (profile.depth().0, ramp_ticks);
            let (shape, values, controller) = own.portable(way, t)?;
            return Ok(RemoteLaw {
                operator: (shape, values),
                controller: Some(controller),
                ..bare
            });
        }
        Ok(RemoteLaw {
            stiffness_n_per_m: stiffness,
            dissipation_n_s_mu_per_m: dissipation,
            order: rendering.piece.material.order().get(),
            one_sided: true,
            depth_map: rendering.piece.specimen.depth_map(),
            operator: match device.loop_mode {
                LoopMode::Device => portable(&self.operator(samples)?)?,
                LoopMode::Host => no_operator(),
            },
            after_rise: true,
            ..bare
        })
    }
}

/// A drive that moves a device, to be looked at.
struct DriveLook<'a> {
    own: &'a Drive,
    tissue: Option<[Term; 2]>,
}

impl PreflightSubject for DriveLook<'_> {
    type Findings = DriveVerdict;

    fn verdict(&self, dynamics: Dynamics, _: usize) -> Result<DriveVerdict, Failure> {
        self.own.on_device(&dynamics, self.tissue)
    }
}

/// `[relax]`, with the table of a controller that holds the indenter.
pub(crate) fn relax(
    table: &Table<'_>,
    drive: Option<&Table<'_>>,
) -> Result<Indentation, FileError> {
    let duration_s = table.number(&RELAX_DURATION)?;
    let ramp_time_s = table.number(&RAMP_TIME)?;
    if ramp_time_s >= duration_s {
        let reason = format!(
            "ramp_time_s = {ramp_time_s} is not below duration_s = {duration_s}: change {RAMP_TIME} too"
        );
        return Err(table.fail_at("ramp_time_s", reason));
    }
    let rendering = rendering(table, drive, (&CONTACT, duration_s))?;
    let size = |piece: &Specimen| piece.slab_sizes().map(|(_, thickness)| thickness.0);
    let depth_m = either(table, &rendering, (&STRAIN, size), &DEPTH)?;
    let thickness_m = rendering.piece.specimen.loading().thickness_m;
    if let Some(thickness_m) = thickness_m.filter(|thickness_m| depth_m > *thickness_m) {
        let reason = format!(
            "depth_m = {depth_m} is beyond thickness_m = {thickness_m}: change one of them",
            depth_m = Shown(depth_m),
            thickness_m = Shown(thickness_m)
        );
        return Err(table.fail_at(DEPTH.key, reason));
    }
    Ok(Indentation {
        load: Load::Depth {
            depth_m,
            ramp_time_s,
        },
        duration_s,
        rendering,
    })
}

/// `[creep]`, likewise.
pub(crate) fn creep(
    table: &Table<'_>,
    drive: Option<&Table<'_>>,
) -> Result<Indentation, FileError> {
    let duration_s = table.number(&CREEP_DURATION)?;
    let rendering = rendering(table, drive, (&CREEP_CONTACT, duration_s))?;
    let size = |piece: &Specimen| piece.slab_sizes().map(|(area, _)| area.0);
    Ok(Indentation {
        load: Load::Force {
            force_n: either(table, &rendering, (&STRESS, size), &FORCE)?,
        },
        duration_s,
        rendering,
    })
}

/// A strain or stress times a size of the slab, or the depth or force itself, which any other piece needs.
fn either(
    table: &Table<'_>,
    rendering: &Rendering,
    (share, size): (&Parameter, impl Fn(&Specimen) -> Option<f64>),
    whole: &Parameter,
) -> Result<f64, FileError> {
    let specimen = &rendering.piece.specimen;
    let given = table.number_if(whole)?;
    if given.is_some() && table.has(share) {
        let reason = format!(
            "{} and {} are one and the same: omit one",
            share.key, whole.key
        );
        return Err(table.fail_at(share.key, reason));
    }
    if let Some(given) = given {
        return Ok(given);
    }
    match size(specimen) {
        Some(size) => Ok(table.number(share)? * size),
        None => {
            let kind = specimen.loading().kind.name();
            let reason = format!("a {kind} has no {}: give {whole}", share.key);
            Err(table.fail_at(p::LOADING.key, reason))
        }
    }
}
