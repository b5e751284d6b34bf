//! A tissue under an indenter: stress relaxation, and creep.
//!
//! - *Relaxation*: the indenter follows a ramp to the depth δ₀ in T₀ and holds it; the force that the virtual tissue opposes
//!   to it is the result. Source: O. Tokatlı, *Fractional Order Control in Haptics*, figure 7.2.
//! - *Creep*: the indenter pushes with F₀ from t = 0, and both sink in. The closed form is that of the tissue alone. On the
//!   ideal rig nothing has a mass, and each depth is the root of γ·(c₀·e(x\[n\]) + past) = F₀; the masses and the damping of
//!   another rig slow the start down, and the report says from when on the tissue is seen.

#[cfg(all(test, feature = "bad-lines"))]
mod pair_tests;
mod report;
#[cfg(test)]
mod tests;

use super::{
    kind::{Conduct, Experiment, conducts},
    reading::{metadata, remote},
};
use crate::{
    experiment::drive::{self, Drive, DriveDevice, TissueLaw},
    judge::{Published, Report, against::Measured},
};
use fracdiff::Real;
use fractional_control::Term;
use haptic_document::{
    Failure, FileError, Named as _, Table, bad_input, parameters as p,
    parameters::{CONTACT, CONTROLLER, CONTROLLER_IN_LOG, DEVICE, DRIVE_LOOP, LOOP, TISSUE_IN_LOG},
};
use haptic_judge::{
    indentation::{self, IndentationTrial, VirtualTissue},
    preflight::{Preflight, WallContact},
    rendering::{IndenterContact, Precision},
    simulated_rig::SimulatedRig,
};
use haptic_link::{LoopMode, Simulation};
use haptic_loop::{
    Controller, Limit, SafetyChain, SafetyLimits,
    plant::{FacingConfig, HeldRig, RigDrive, Sensed},
    units::{Newtons, NewtonsPerSecond},
};
use haptic_run::{
    Ran, Watched,
    remote::{
        PairRun, RemoteDevice, RemoteLaw, RemoteRun, UnchangedLimits, blank, fits_two_devices,
        indentation as indented, no_operator, portable, push,
    },
    run_logged,
};
use haptic_trial::{
    advice::parameter,
    device_table::device_model,
    drive_verdict::DriveVerdict,
    preflight::{Findings, note_findings},
    safe_chain::{chain, limits_here},
    safety::{GuardChoice, GuardedDevice},
    simulate::{SimulatedLoop, Sink, simulate},
    tick::KeptSample,
};
use std::{
    collections::BTreeMap,
    ops::{Deref, DerefMut},
    sync::{Arc, atomic::AtomicU64},
};

/// A piece of tissue under an indenter, the operator that renders it, and the rig it is rendered on.
#[derive(Clone, Debug)]
pub struct Indentation {
    pub(crate) trial: IndentationTrial,
    /// The controller that holds the indenter; `None` for the rig's own servo or a constant push.
    pub(crate) drive: Option<Drive>,
    pub(crate) conduct: Conduct,
    /// Measured record of a real piece.
    pub(crate) against: Option<Measured>,
}

impl Deref for Indentation {
    type Target = IndentationTrial;

    fn deref(&self) -> &IndentationTrial {
        &self.trial
    }
}

impl DerefMut for Indentation {
    fn deref_mut(&mut self) -> &mut IndentationTrial {
        &mut self.trial
    }
}

impl Experiment for Indentation {
    fn check(&self) -> Result<u64, Failure> {
        self.trial.samples()
    }

    fn sample_time_s(&self) -> f64 {
        self.actuator.sample_time.0
    }

    fn metadata(&self) -> BTreeMap<String, String> {
        let kind = match self.load {
            RigDrive::Position(_) => "relax",
            RigDrive::Force(_) => "creep",
        };
        let mut metadata = metadata(kind, &self.conduct, self.scheme, &self.safety);
        let material = &self.piece.material;
        let (stiffness, dissipation) = material.spring_and_damper(1.0);
        let ran = [
            ("precision", self.precision_run().name().to_owned()),
            ("rendered_modulus_pa", stiffness.to_string()),
            ("rendered_viscosity_pa_s_mu", dissipation.to_string()),
            ("rendered_order", material.order().to_string()),
        ];
        metadata.extend(ran.map(|(key, value)| (key.to_owned(), value)));
        metadata.insert(TISSUE_IN_LOG.to_owned(), material.to_toml());
        if let Some(drive) = &self.drive {
            metadata.insert(CONTROLLER_IN_LOG.to_owned(), drive.controller.to_toml());
        }
        metadata
    }

    conducts!();

    fn run(&self, watched: Watched<'_>) -> Result<Published<Report>, Failure> {
        let ran = self.record(watched)?;
        let (report, curves) = self.report(&ran)?;
        Ok(Published::new(report, curves, ran))
    }

    /// The controller of a drive is looked at wherever it runs.
    fn may_be_refused(&self) -> bool {
        self.drive.is_some()
    }
}

impl Indentation {
    /// The number type that the force was computed in: that of the device, if the loop was closed there.
    fn precision_run(&self) -> Precision {
        match &self.conduct.remote {
            Some(remote) if remote.loop_mode == LoopMode::Device => Precision::F32,
            Some(_) | None => self.precision,
        }
    }

    /// Runs the loop and writes the log.
    pub(crate) fn record(&self, watched: Watched<'_>) -> Result<Ran, Failure> {
        match self.precision {
            Precision::F64 => self.record_as::<f64>(watched),
            Precision::F32 => self.record_as::<f32>(watched),
        }
    }

    /// Runs on the simulated rig in virtual time, without folder, log or clock: each sample goes to the sink. `true` if it reached the
    /// end without a fault.
    ///
    /// # Errors
    /// Bad parameters.
    pub fn simulate(&self, sink: Sink<'_>) -> Result<bool, Failure> {
        match self.precision {
            Precision::F64 => self.simulate_as::<f64>(sink),
            Precision::F32 => self.simulate_as::<f32>(sink),
        }
    }

    /// The verdict on the controller that holds the indenter over so many samples; `None` without one.
    pub(super) fn drive_verdict(&self, samples: u64) -> Result<Option<DriveVerdict>, Failure> {
        let Some(drive) = &self.drive else {
            return Ok(None);
        };
        let devices = self.rig().facing().map_err(parameter)?;
        let verdict = drive.facing(&devices, self.load, self.tissue_law(samples)?);
        verdict.map(Some)
    }

    fn simulate_as<F: Real>(&self, sink: Sink<'_>) -> Result<bool, Failure> {
        let samples = self.check()?;
        let mut controller = self.controller::<F>(samples)?;
        let mut rig = self.rig_behind_sensors(samples)?;
        Ok(simulate(&mut controller, &mut rig, samples, sink))
    }

    /// Nothing is made in the folder before every parameter is known to be good.
    fn record_as<F: Real>(&self, watched: Watched<'_>) -> Result<Ran, Failure> {
        let (request, supervisor) = (watched.request, watched.supervisor);
        let samples = self.check()?;
        let mut metadata = self.metadata();
        let mut controller = self.controller::<F>(samples)?;
        let schedule = self.schedule(samples);
        self.drive_acts()?;
        if let Some(device) = &self.conduct.remote {
            let reference = |time_s: f64| match self.load {
                RigDrive::Position(profile) => profile.position(time_s),
                RigDrive::Force(_) => f64::NAN,
            };
            let second = self.second();
            let look = |dynamics, line| match &self.drive {
                Some(drive) if drive.device.is_none() => {
                    let verdict = drive.on_device(&dynamics, self.tissue_terms());
                    verdict.map(Findings::Drive)
                }
                Some(_) | None => self
                    .look(samples)
                    .proved(dynamics, line)
                    .map(Findings::Loop),
            };
            let followed = |time_s| blank(reference(time_s));
            // Of two devices it is the drive that follows.
            let known = |time_s| match second {
                None => followed(time_s),
                Some(_) => blank(f64::NAN),
            };
            let law = self.law(device, samples)?;
            let run = RemoteRun {
                preflight: Some(&look),
                force_unstable: self.conduct.force_unstable,
                dynamics: self.dynamics,
                metadata,
                ..RemoteRun::new(device, law, schedule, &known, request)
            };
            if let Some((drive, second)) = second {
                let opposed_n = Arc::new(AtomicU64::new(0));
                let mut holding = self.drive_controller(drive, second, Arc::clone(&opposed_n))?;
                let drive_device = RemoteDevice {
                    patience: device.patience,
                    ..second.remote.clone()
                };
                let pair = PairRun {
                    opposed_n,
                    may_rise_s: match self.load {
                        RigDrive::Position(profile) => profile.ramp_time().0,
                        RigDrive::Force(_) => 0.0,
                    },
                    drive: RemoteRun::new(
                        &drive_device,
                        self.drive_law(drive)?,
                        schedule,
                        &followed,
                        request,
                    ),
                    tissue: run,
                    judged: Some(&|delays_s| self.faced(drive, second, delays_s, samples)),
                };
                return pair.run(&mut controller, &mut holding, supervisor);
            }
            return run.run(&mut controller, supervisor);
        }
        let mut device = self.rig_behind_sensors(samples)?;
        let verdict = self.drive_verdict(samples)?;
        if let Some(verdict) = &verdict {
            verdict.require_stable(self.conduct.force_unstable)?;
            note_findings(&mut metadata, DriveVerdict::KEY, verdict);
        }
        let mut world = SimulatedLoop::new(&mut controller, &mut device);
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

    /// True if a device is the indenter, and its motor holds it before a real piece.
    fn holds_device(&self) -> bool {
        self.drive.is_some() && self.conduct.remote.is_some() && self.second().is_none()
    }

    /// The drive and its device, if it has one of its own.
    fn second(&self) -> Option<(&Drive, &DriveDevice)> {
        let drive = self.drive.as_ref()?;
        Some((drive, drive.device.as_ref()?))
    }

    /// The verdict on a drive whose device meets that of the tissue, both loops so many seconds later than their devices are; `None` if one
    /// of them is not known.
    fn faced(
        &self,
        drive: &Drive,
        second: &DriveDevice,
        delays_s: [f64; 2],
        samples: u64,
    ) -> Result<Option<DriveVerdict>, Failure> {
        let Some(devices) = self.dynamics.zip(second.dynamics) else {
            return Ok(None);
        };
        let mut devices = [devices.0, devices.1]
            .map(|dynamics| drive::device(&dynamics, self.actuator.sample_time));
        for (device, delay_s) in devices.iter_mut().zip(delays_s) {
            device.delay.0 += delay_s;
        }
        let contact = second.contact;
        let devices = FacingConfig { devices, contact };
        let verdict = drive.facing(&devices, self.load, self.tissue_law(samples)?)?;
        verdict.require_stable(self.conduct.force_unstable)?;
        Ok(Some(verdict))
    }

    /// The tissue as the analysis of a drive sees it.
    fn tissue_law(&self, samples: u64) -> Result<TissueLaw, Failure> {
        let look = self.look(samples);
        let (stiffness, dissipation) = (look.stiffness_n_per_m, look.dissipation_n_s_mu_per_m);
        let operator = look.loop_operator()?;
        Ok(TissueLaw::new(
            stiffness,
            dissipation,
            operator,
            look.sample_time_s,
        ))
    }

    /// The law of the device of a drive: its controller, within its own force.
    fn drive_law(&self, drive: &Drive) -> Result<RemoteLaw, Failure> {
        let safety = &self.safety;
        let bare = RemoteLaw {
            unchanged: UnchangedLimits {
                speed: safety.number(Limit::Speed).is_none(),
                ..UnchangedLimits::default()
            },
            ..RemoteLaw::bare(self.limits_of(drive), push(0.0))
        };
        self.moved(drive, bare)
    }

    /// The controller of a drive behind the safety chain, for a loop here.
    fn drive_controller(
        &self,
        drive: &Drive,
        second: &DriveDevice,
        opposed_n: Arc<AtomicU64>,
    ) -> Result<Controller<f64, 1, drive::HostDrive>, Failure> {
        let limits = limits_here(second.remote.loop_mode, self.limits_of(drive));
        let chain = SafetyChain::from_limits(&limits, self.actuator.sample_time);
        let environment = drive.on_host(self.load, self.sample_time_s(), opposed_n)?;
        Ok(Controller::new(environment, chain.map_err(parameter)?))
    }

    fn limits_of(&self, drive: &Drive) -> SafetyLimits {
        let rate = NewtonsPerSecond(self.force_rate_limit_n_per_s);
        self.safety
            .on(SafetyLimits::bare(Newtons(drive.force_limit_n), rate), true)
    }

    /// Force that the tissue opposes, N: on a device that a drive moves, the force that this takes.
    fn opposed_n(&self, sample: &KeptSample) -> f64 {
        if self.holds_device() {
            sample.force_n
        } else {
            sample.reaction_n()
        }
    }

    /// The tissue behind the safety chain.
    fn controller<F: Real>(
        &self,
        samples: u64,
    ) -> Result<Controller<F, 1, VirtualTissue<F>>, Failure> {
        let Some(remote) = &self.conduct.remote else {
            return self.trial.controller(samples);
        };
        let tissue = self.tissue(samples)?;
        let limits = limits_here(remote.loop_mode, self.limits_there());
        let (t, at_port) = (self.actuator.sample_time, self.conduct.at_port());
        Ok(Controller::new(
            tissue,
            chain(&limits, t, &self.safety, at_port)?,
        ))
    }

    fn rig_behind_sensors(&self, samples: u64) -> Result<Sensed<SimulatedRig>, Failure> {
        let rig = match &self.drive {
            None => self.free_rig(samples)?,
            Some(drive) => {
                self.drive_acts()?;
                let holder = drive.holder(self.sample_time_s())?;
                let rig = HeldRig::new(self.rig(), holder).map_err(Failure::input)?;
                SimulatedRig::Held(Box::new(rig))
            }
        };
        self.behind_sensors(rig)
    }

    /// Refuses a drive where nothing could be held by one.
    fn drive_acts(&self) -> Result<(), Failure> {
        if self.drive.is_none() {
            return Ok(());
        }
        if let Some((_, second)) = self.second() {
            if matches!(self.load, RigDrive::Force(_))
                && second.remote.loop_mode == LoopMode::Device
            {
                return Err(bad_input!(
                    "the force that the {CONTROLLER} of a drive holds in a creep test is that of the other device: use {}",
                    DRIVE_LOOP.set_to("host")
                ));
            }
            fits_two_devices(self.check()?)?;
        } else if let Some(remote) = &self.conduct.remote {
            if matches!(self.load, RigDrive::Force(_)) {
                return Err(bad_input!(
                    "no device measures the force that the {CONTROLLER} of a drive holds in a creep test: use [relax], or omit {DEVICE}"
                ));
            }
            if remote.loop_mode == LoopMode::Host {
                return Err(bad_input!(
                    "the {CONTROLLER} of a drive runs on the device: use {loop_device}",
                    loop_device = LOOP.set_to("device")
                ));
            }
        }
        match self.contact {
            IndenterContact::Compliant => Ok(()),
            IndenterContact::Rigid | IndenterContact::Ideal => Err(bad_input!(
                "the {CONTROLLER} of a drive moves a mass, and this contact has none: use {contact_compliant}",
                contact_compliant = CONTACT.set_to("compliant")
            )),
        }
    }

    /// Limits of the chain of a device, without its guard.
    fn limits_there(&self) -> SafetyLimits {
        self.safety.on(self.force_and_rate(), true)
    }

    /// The loop for the analysis: the tissue as a wall that is felt all the time.
    fn look(&self, samples: u64) -> Preflight<'_> {
        let piece = &self.piece;
        let (stiffness_n_per_m, dissipation_n_s_mu_per_m) = piece.spring_and_damper();
        let look = Preflight {
            stiffness_n_per_m,
            dissipation_n_s_mu_per_m,
            order: piece.material.order(),
            model: piece.material.composed(),
            scheme: self.scheme,
            sample_time_s: self.sample_time_s(),
            samples,
            map: None,
            contact: WallContact::OneSided,
            guarded: self.safety.guard == GuardChoice::EnergyBounding,
        };
        // As steep as it becomes where the run ends.
        look.at_depth(piece.specimen.depth_map(), self.deepest())
    }

    /// The depth at the end of the run, m, that of the tissue alone; on a device, which a hand presses, that of the largest force.
    fn deepest(&self) -> f64 {
        let crept = |force_n| self.piece.crept(force_n, &[self.duration_s])[0];
        if self.conduct.remote.is_some() {
            return crept(self.force_limit_n);
        }
        match self.load {
            RigDrive::Position(profile) => profile.depth().0,
            RigDrive::Force(push) => crept(push.0),
        }
    }

    /// Tissue and drive for a device.
    fn law(&self, device: &RemoteDevice, samples: u64) -> Result<RemoteLaw, Failure> {
        let (stiffness, dissipation) = self.piece.spring_and_damper();
        let simulation = match self.load {
            RigDrive::Position(profile) => indented(
                self.contact == IndenterContact::Compliant,
                profile.depth().0,
                profile.ramp_time().0,
            ),
            RigDrive::Force(force) => push(force.0),
        };
        // Nothing of the rig is there beside the device that the drive moves.
        let simulation = if self.holds_device() {
            push(0.0)
        } else {
            simulation
        };
        let safety = &self.safety;
        let bare = RemoteLaw {
            unchanged: UnchangedLimits {
                speed: safety.number(Limit::Speed).is_none(),
                ..UnchangedLimits::default()
            },
            guard: (safety.guard, safety.guarded(GuardedDevice::default())),
            ..RemoteLaw::bare(
                self.limits_there(),
                // The device of which the pre-flight speaks, if it knows one.
                match self.dynamics {
                    Some(known) => Simulation {
                        mass_kg: known.mass_kg as f32,
                        damping_n_s_per_m: known.damping_n_s_per_m as f32,
                        ..simulation
                    },
                    None => simulation,
                },
            )
        };
        if let Some(drive) = self.drive.as_ref().filter(|drive| drive.device.is_none()) {
            return self.moved(drive, bare);
        }
        Ok(RemoteLaw {
            stiffness_n_per_m: stiffness,
            dissipation_n_s_mu_per_m: dissipation,
            order: self.piece.material.order().get(),
            one_sided: true,
            depth_map: self.piece.specimen.depth_map(),
            operator: match device.loop_mode {
                LoopMode::Device => portable(&self.operator(samples)?)?,
                LoopMode::Host => no_operator(),
            },
            after_rise: true,
            ..bare
        })
    }

    /// The law of a device that this drive moves.
    fn moved(&self, drive: &Drive, bare: RemoteLaw) -> Result<RemoteLaw, Failure> {
        let in_device = |device: &DriveDevice| device.remote.loop_mode == LoopMode::Device;
        let RigDrive::Position(profile) = self.load else {
            return Ok(bare);
        };
        if !drive.device.as_ref().is_none_or(in_device) {
            return Ok(bare);
        }
        let portable = drive.portable(profile, self.sample_time_s());
        let (shape, values, controller) = match &drive.device {
            None => portable?,
            Some(_) => portable
                .map_err(|failure| failure.and(&format!("or use {}", DRIVE_LOOP.set_to("host"))))?,
        };
        Ok(RemoteLaw {
            operator: (shape, values),
            controller: Some(controller),
            ..bare
        })
    }
}

/// A trial, run as its table and that of a controller that holds the indenter say.
fn conducted(
    table: &Table<'_>,
    held: Option<&Table<'_>>,
    read: impl FnOnce(Option<LoopMode>) -> Result<IndentationTrial, FileError>,
) -> Result<Indentation, FileError> {
    let conduct = Conduct::on(remote(table)?);
    let trial = read(conduct.at_port())?;
    let drive = held.map(|held| {
        let model = device_model(table)?;
        drive::drive(held, conduct.remote.as_ref(), model, trial.peak_n())
    });
    let against = table.file(&p::AGAINST)?.map(|record| {
        let read = Measured::read(&record, &trial.piece, trial.load, trial.duration_s);
        read.map_err(|reason| table.fail_at(p::AGAINST.key, reason))
    });
    Ok(Indentation {
        drive: drive.transpose()?,
        against: against.transpose()?,
        trial,
        conduct,
    })
}

/// `[relax]`, with the table of a controller that holds the indenter.
pub(crate) fn relax(
    table: &Table<'_>,
    drive: Option<&Table<'_>>,
) -> Result<Indentation, FileError> {
    conducted(table, drive, |at_port| {
        indentation::relax(table, at_port, drive.is_some())
    })
}

/// `[creep]`, likewise.
pub(crate) fn creep(
    table: &Table<'_>,
    drive: Option<&Table<'_>>,
) -> Result<Indentation, FileError> {
    conducted(table, drive, |at_port| {
        indentation::creep(table, at_port, drive.is_some())
    })
}
