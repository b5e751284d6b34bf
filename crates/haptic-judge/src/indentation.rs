//! A tissue under an indenter, tried in virtual time: stress relaxation, and creep.
//!
//! ```text
//! relaxation   the indenter follows a ramp to the depth δ₀ in T₀ and holds it
//! creep        the indenter pushes with F₀ from t = 0
//! ```
//! A slab is held at a strain or under a stress, δ₀ = ε₀·h and F₀ = σ₀·A; any other piece at a depth or under a force.

use crate::{
    modelled_tissue::{ModelledTissue, Sampled, TissuePiece},
    reference::ReferenceWeights,
    rendering::{
        CHANGES, CREEP_CONTACT, CREEP_DURATION, DEPTH, FORCE, IndenterContact, PIECE_DISSIPATION,
        PIECE_ORDER, PIECE_STIFFNESS, PRECISION, Precision, RAMP_TIME, RELAX_DURATION, RIG_DAMPING,
        RIG_MASS, STRAIN, STRESS,
    },
    simulated_rig::{Massless, SimulatedRig},
    tissue_table::{fits, piece, scheme},
};
use fracdiff::{Operator, Real, Scheme, Seconds};
use haptic_analysis::Dynamics;
use haptic_document::{
    Failure, FileError, Table, parameters as p,
    parameters::{CONTACT, Parameter, TISSUE},
};
use haptic_link::LoopMode;
use haptic_loop::{
    Contact as OneSided, Controller, SafetyLimits, SpringDamper,
    plant::{
        ForceSensorConfig, IndentationRig, MassDamperConfig, RampHold, RigConfig, RigContact,
        RigDrive, RigServo, Sensed,
    },
    units::{Kilograms, Metres, NewtonSecondsPerMetre, Newtons, NewtonsPerSecond},
};
use haptic_tissue::{Library, MaterialError};
use haptic_trial::{
    Sensors,
    device_table::{device_model, force_sensor, samples_fit, sensors, without},
    ending::Ending,
    safe_chain::safe_chain,
    safety::{GuardedDevice, Safety, safety},
    samples::{SAMPLES, count},
    simulate::{SimulatedLoop, Sink, to_the_end},
};

/// A one-sided virtual tissue that begins at 0.
pub type VirtualTissue<F> = OneSided<F, SpringDamper<F, Operator<F>>, 1>;

/// A piece of tissue under an indenter, the operator that renders it, and the rig it is rendered on.
#[derive(Clone, Debug)]
pub struct IndentationTrial {
    /// Its way is a relaxation, its push from t = 0 on is creep.
    pub load: RigDrive,
    /// End of the test, s.
    pub duration_s: f64,
    /// The piece of tissue that is pressed.
    pub piece: TissuePiece,
    /// Scheme of the tissue's operator.
    pub scheme: Scheme,
    /// Number type of the loop.
    pub precision: Precision,
    /// Contact of the indenter with the renderer.
    pub contact: IndenterContact,
    /// Each of the two actuators, with the sample time of the loop.
    pub actuator: MassDamperConfig,
    /// Sensors of the simulated rig.
    pub sensors: Sensors,
    /// Force sensor of the simulated rig, if it has one.
    pub force_sensor: Option<ForceSensorConfig>,
    /// Largest force of the renderer, N.
    pub force_limit_n: f64,
    /// Largest rate of the force, N/s.
    pub force_rate_limit_n_per_s: f64,
    /// Settings of the safety chain.
    pub safety: Safety,
    /// Place of the loop of a device at a port; `None` for the simulated rig.
    pub at_port: Option<LoopMode>,
    /// Dynamics of a device at a port, if known.
    pub dynamics: Option<Dynamics>,
}

impl IndentationTrial {
    /// The number of samples.
    ///
    /// # Errors
    /// A duration of too few samples, or too many.
    pub fn samples(&self) -> Result<u64, Failure> {
        count(self.duration_s, self.actuator.sample_time.0, &SAMPLES)
    }

    /// The largest force of the piece, N: it relaxes from the end of the ramp on.
    pub fn peak_n(&self) -> f64 {
        match self.load {
            RigDrive::Position(way) => {
                let ramp_s = way.ramp_time().0;
                self.piece.relaxed(way.depth().0, ramp_s, &[ramp_s])[0]
            }
            RigDrive::Force(push) => push.0,
        }
    }

    /// The tissue for so many samples.
    ///
    /// # Errors
    /// Sizes or an operator of which none can be made.
    pub fn tissue<F: Real>(&self, samples: u64) -> Result<VirtualTissue<F>, Failure> {
        let (stiffness, dissipation) = self.piece.spring_and_damper();
        let too_much = |error| {
            let advice = format_args!("change the sizes of the piece or {TISSUE}");
            Failure::input_with_advice(error, advice)
        };
        let operator: Operator<F> = self.operator(samples)?;
        let tissue = SpringDamper::new(stiffness, dissipation, operator).map_err(too_much)?;
        let map = self.piece.specimen.depth_map();
        let map = map.map(|map| map.rounded()).transpose().map_err(too_much)?;
        let environment = OneSided::at(Metres(0.0), tissue).map_err(Failure::input)?;
        Ok(environment.with_depth_map(map))
    }

    /// The rig without a controller, for so many samples.
    ///
    /// # Errors
    /// A rig of which none can be made.
    pub fn free_rig(&self, samples: u64) -> Result<SimulatedRig, Failure> {
        Ok(match self.load {
            RigDrive::Force(push) if self.is_ideal() => {
                SimulatedRig::Ideal(Box::new(self.massless(push, samples)?))
            }
            RigDrive::Position(_) | RigDrive::Force(_) => {
                let rig = IndentationRig::new(self.rig()).map_err(Failure::input)?;
                SimulatedRig::Plain(Box::new(rig))
            }
        })
    }

    /// Runs it on the simulated rig without a controller, to its end or until the force of one that ended early is zero: why it did.
    ///
    /// # Errors
    /// Parameters of which no loop can be made.
    pub fn run(&self, see: Sink<'_>) -> Result<Option<Ending>, Failure> {
        match self.precision {
            Precision::F64 => self.run_as::<f64>(see),
            Precision::F32 => self.run_as::<f32>(see),
        }
    }

    /// The tissue behind the safety chain of the simulated rig, for so many samples.
    ///
    /// # Errors
    /// Parameters of which none can be made.
    pub fn controller<F: Real>(
        &self,
        samples: u64,
    ) -> Result<Controller<F, 1, VirtualTissue<F>>, Failure> {
        let limits = self.force_and_rate();
        let chain = safe_chain(limits, &self.actuator, self.sensors, &self.safety, None)?;
        Ok(Controller::new(self.tissue(samples)?, chain))
    }

    /// A rig behind the sensors of this one.
    ///
    /// # Errors
    /// Sensors of which none can be made.
    pub fn behind_sensors(&self, rig: SimulatedRig) -> Result<Sensed<SimulatedRig>, Failure> {
        (self.sensors).and_force_before(rig, self.force_sensor, self.actuator.sample_time)
    }

    fn run_as<F: Real>(&self, see: Sink<'_>) -> Result<Option<Ending>, Failure> {
        let samples = self.samples()?;
        let mut controller = self.controller::<F>(samples)?;
        let mut rig = self.behind_sensors(self.free_rig(samples)?)?;
        let mut world = SimulatedLoop::new(&mut controller, &mut rig);
        Ok(to_the_end(&mut world, samples, see))
    }

    /// The two actuators and their contact.
    pub fn rig(&self) -> RigConfig {
        let contact = match self.contact {
            IndenterContact::Compliant => RigContact::COMPLIANT,
            IndenterContact::Rigid | IndenterContact::Ideal => RigContact::Rigid,
        };
        let MassDamperConfig {
            mass,
            damping,
            sample_time,
            ..
        } = self.actuator;
        RigConfig {
            renderer_mass: mass,
            renderer_damping: damping,
            indenter_mass: mass,
            indenter_damping: damping,
            servo: RigServo::of(mass, damping),
            ..RigConfig::new(self.load, contact, sample_time)
        }
    }

    /// True for a push on the tissue alone.
    pub fn is_ideal(&self) -> bool {
        let pushes = matches!(self.load, RigDrive::Force(_));
        pushes && self.contact == IndenterContact::Ideal && self.at_port.is_none()
    }

    /// Limits of force and rate.
    pub fn force_and_rate(&self) -> SafetyLimits {
        let rate = NewtonsPerSecond(self.force_rate_limit_n_per_s);
        SafetyLimits::bare(Newtons(self.force_limit_n), rate)
    }

    /// The operator for this number of samples.
    ///
    /// # Errors
    /// An operator that the scheme cannot make.
    pub fn operator<F: Real>(&self, samples: u64) -> Result<Operator<F>, Failure> {
        let t = self.actuator.sample_time;
        self.piece.material.operator(self.scheme, t, samples)
    }

    /// The tissue alone under a push, for `samples` samples.
    ///
    /// # Errors
    /// Weights that cannot be made.
    pub fn massless(&self, push: Newtons, samples: u64) -> Result<Massless, Failure> {
        Ok(Massless::new(
            self.sampled(samples)?,
            self.piece.specimen.depth_map(),
            push.0,
            self.actuator.sample_time,
        ))
    }

    /// The piece tick by tick with all of its past, from e(δ) to force.
    ///
    /// # Errors
    /// Weights that cannot be made.
    pub fn sampled(&self, samples: u64) -> Result<Sampled, Failure> {
        let piece = &self.piece;
        let t = self.actuator.sample_time;
        let reference = ReferenceWeights::of(self.scheme);
        (piece.material).sampled(piece.shape_m(), reference, t, samples)
    }
}

/// The safety chain, and the mass, damping, delay and lag of a device at a port as far as its own keys and its device file say them.
fn guarded(table: &Table<'_>, real: bool) -> Result<(Safety, Option<Dynamics>), FileError> {
    let mut safety = safety(table)?;
    let model = device_model(table)?;
    if let Some(model) = &model {
        let on_rig = safety.on_rig(&model.guarded(), real);
        safety = on_rig.map_err(|error| table.fail_at(p::DEVICE_MODEL.key, error))?;
    }
    let known = safety.guarded(GuardedDevice::default());
    let known = known.mass_kg.zip(known.damping_n_s_per_m);
    let dynamics = known.map(|(mass_kg, damping_n_s_per_m)| Dynamics {
        mass_kg,
        damping_n_s_per_m,
        ..model.map_or(Dynamics::ideal(mass_kg, damping_n_s_per_m), |model| {
            model.values.dynamics()
        })
    });
    Ok((safety, dynamics))
}

/// Reads the keys that `[relax]` and `[creep]` share; `load` reads the others.
fn rendering(
    table: &Table<'_>,
    (at_port, is_held): (Option<LoopMode>, bool),
    contact: &Parameter,
    duration_s: f64,
    load: impl FnOnce(&TissuePiece) -> Result<RigDrive, FileError>,
) -> Result<IndentationTrial, FileError> {
    let is_real = at_port.is_some();
    let sensors = sensors(table)?;
    let force_sensor = force_sensor(table)?;
    if is_real && force_sensor.is_some() {
        let reason = format!(
            "{} is of the simulated rig: omit it with a device, which has its own sensor or none",
            p::SENSED_RANGE.key
        );
        return Err(table.fail_at(p::SENSED_RANGE.key, reason));
    }
    if is_real && !sensors.are_ideal() {
        let reason = "encoder_resolution_m and sensor_noise_m are of the simulated rig: omit them with a serial device, which has its own";
        return Err(table.fail_at(p::ENCODER_RESOLUTION.key, reason));
    }
    let precision = table.choice(&PRECISION)?;
    if at_port == Some(LoopMode::Device) && precision == Precision::F64 {
        let idle = &format!(
            "in a loop on the device, which computes in f32: give {loop_host}",
            loop_host = p::LOOP.set_to("host")
        );
        without(table, [&PRECISION], idle)?;
    }
    let (safety, dynamics) = guarded(table, is_real)?;
    let sample_time_s = table.number(&p::SAMPLE_TIME)?;
    samples_fit(table, sample_time_s, duration_s, &SAMPLES)?;
    let piece = changed(table, piece(table)?)?;
    let (model, order) = (piece.material.composed(), piece.material.order());
    let scheme = scheme(table, model, order, sample_time_s, duration_s)?;
    let load = load(&piece)?;
    Ok(IndentationTrial {
        load,
        at_port,
        duration_s,
        dynamics,
        piece,
        scheme,
        precision,
        contact: match table.choice(contact)? {
            IndenterContact::Ideal if !table.has(contact) && (is_real || is_held) => {
                IndenterContact::Compliant
            }
            given @ (IndenterContact::Compliant
            | IndenterContact::Rigid
            | IndenterContact::Ideal) => given,
        },
        actuator: MassDamperConfig::ideal(
            Kilograms(table.number(&RIG_MASS)?),
            NewtonSecondsPerMetre(table.number(&RIG_DAMPING)?),
            Seconds(sample_time_s),
        ),
        sensors,
        force_sensor,
        force_limit_n: table.number(&p::FORCE_LIMIT)?,
        force_rate_limit_n_per_s: table.number(&p::FORCE_RATE_LIMIT)?,
        safety,
    })
}

/// The piece with K, B and μ as far as they are given, instead of those of its tissue: E₀ = K/γ, η = B/γ.
fn changed(table: &Table<'_>, piece: TissuePiece) -> Result<TissuePiece, FileError> {
    let mut given = [None; 3];
    for (number, parameter) in given.iter_mut().zip(CHANGES) {
        *number = table.number_if(parameter)?;
    }
    let [stiffness, dissipation, order] = given;
    let per_shape = |number: Option<f64>| number.map(|number| number / piece.shape_m());
    let [is_given, is_sized] = [&given[..], &given[..2]].map(|of| of.iter().any(Option::is_some));
    let refuse = |reason: String| {
        let key = CHANGES.iter().rev().find(|key| table.has(key));
        table.fail_at(key.map_or("", |key| key.key), reason)
    };
    if !is_given {
        return Ok(piece);
    }
    if is_sized && !piece.is_linear() {
        return Err(refuse(TissuePiece::NOT_LINEAR.to_owned()));
    }
    let elements = [per_shape(stiffness), per_shape(dissipation), order];
    let tissue = piece.material.with_elements(elements).map_err(|error| {
        let remedy = if matches!(error, MaterialError::Elements(..)) {
            with_one_order(table)
        } else if matches!(error, MaterialError::NoSpringPot(_)) {
            format!(
                "give {PIECE_DISSIPATION} and {PIECE_ORDER} together, or use the tissue spring-pot"
            )
        } else {
            format!("change {PIECE_STIFFNESS} or {PIECE_DISSIPATION}")
        };
        refuse(format!("{error}: {remedy}"))
    })?;
    let material = ModelledTissue::new(tissue).map_err(|error| refuse(error.to_string()))?;
    Ok(TissuePiece {
        material: Box::new(material),
        ..piece
    })
}

/// The tissues of the library whose model has one order.
fn with_one_order(table: &Table<'_>) -> String {
    let folder = table.file(&p::LIBRARY).ok().flatten();
    let library = Library::load(folder.as_deref());
    let all = library.iter().flat_map(Library::materials);
    let names = all.filter(|one| one.with_elements([None, None, Some(0.5)]).is_ok());
    let names: Vec<&str> = names.map(|one| one.name.as_str()).collect();
    format!("{} have one", names.join(", "))
}

/// `[relax]`, on a device at a port or the simulated rig, whose indenter a controller may hold.
///
/// # Errors
/// A value that is wrong, with its place.
pub fn relax(
    table: &Table<'_>,
    at_port: Option<LoopMode>,
    is_held: bool,
) -> Result<IndentationTrial, FileError> {
    let duration_s = table.number(&RELAX_DURATION)?;
    let ramp_time_s = table.number(&RAMP_TIME)?;
    if ramp_time_s >= duration_s {
        return Err(table.fail_at("ramp_time_s", format_args!(
            "ramp_time_s = {ramp_time_s} is not below duration_s = {duration_s}: change {RAMP_TIME} too"
        )));
    }
    rendering(table, (at_port, is_held), &CONTACT, duration_s, |piece| {
        let thickness_m = piece.specimen.slab_sizes().map(|sizes| sizes.1.0);
        let depth_m = either(table, piece, &STRAIN, thickness_m, &DEPTH)?;
        fits(table, piece, depth_m)?;
        let ramp = RampHold::new(Metres(depth_m), Seconds(ramp_time_s));
        Ok(RigDrive::Position(ramp.map_err(|error| table.fail(error))?))
    })
}

/// `[creep]`, likewise.
///
/// # Errors
/// A value that is wrong, with its place.
pub fn creep(
    table: &Table<'_>,
    at_port: Option<LoopMode>,
    is_held: bool,
) -> Result<IndentationTrial, FileError> {
    let duration_s = table.number(&CREEP_DURATION)?;
    rendering(
        table,
        (at_port, is_held),
        &CREEP_CONTACT,
        duration_s,
        |piece| {
            let area_m2 = piece.specimen.slab_sizes().map(|sizes| sizes.0.0);
            let push_n = either(table, piece, &STRESS, area_m2, &FORCE)?;
            Ok(RigDrive::Force(Newtons(push_n)))
        },
    )
}

/// A strain or stress times a size of the slab, or the depth or force itself, which any other piece needs.
fn either(
    table: &Table<'_>,
    piece: &TissuePiece,
    share: &Parameter,
    size: Option<f64>,
    whole: &Parameter,
) -> Result<f64, FileError> {
    let given = table.number_if(whole)?;
    if given.is_some() && table.has(share) {
        return Err(table.fail_at(
            share.key,
            format_args!("{share} and {whole} are one and the same: omit one"),
        ));
    }
    if let Some(given) = given {
        return Ok(given);
    }
    match size {
        Some(size) => Ok(table.number(share)? * size),
        None => {
            let kind = piece.specimen.loading().kind.name();
            Err(table.fail_at(
                p::LOADING.key,
                format_args!("a {kind} has no {}: give {whole}", share.key),
            ))
        }
    }
}
