//! A device as a testing machine: its own position loop presses a real specimen, and the log says with which force.
//!
//! ```text
//! sensor       F = sensed, its offset taken off, later by its lag
//! motor        F = u − m·x'' − b·x' − F_c·s       s = sign(r') on the move, anything in [−1, 1] where the handle is held
//! depth        δ = x − F/k                        k the stiffness of the frame, if it is given
//! ```
//! - *Symbols*: u the force of the motor, N; x the position and r the wanted path, m; m, b, `F_c` mass, damping and friction of the device.
//! - *Zero*: a sensor is tared while the handle is still in the air, and looked at once more in the air behind the press.
//! - *Guards*: a force beyond `force_limit_n` is never commanded; beyond `depth_limit_m` a fault ends the run. Both hold before any force.
//! - *Simulated*: a tissue of the library, integrated apart from what renders it, see [`PressedDevice`].

mod doubts;
mod position_loop;
mod record;
mod report;
#[cfg(test)]
mod tests;

use super::{
    drive::{self, Drive, HostDrive, PressPath, Section},
    kind::{Conduct, Experiment, conducts},
    reading::{metadata, remote},
    trial::no_law_there,
};
use crate::judge::{Published, Report};
use doubts::Open;
use fracdiff::{Scheme, parameter::Shown};
use fractional_control::Term;
use haptic_analysis::Dynamics;
use haptic_document::{
    Failure, FileError, Table, named, parameters, parameters as p,
    parameters::{
        CONTROLLER, CONTROLLER_IN_LOG, DEVICE, FORCE_LIMIT, FORCE_RATE_LIMIT, LOOP, Parameter,
        SAMPLE_TIME, TISSUE_IN_LOG, joined,
        range::{DURATIONS, FREQUENCIES_HZ, REACHES_ABOVE_0, STIFFNESSES_ABOVE_0},
    },
};
use haptic_judge::{
    modelled_tissue::TissuePiece,
    rendering::DEPTH,
    tissue_table::{fits, piece},
    trial::force_and_rate,
};
use haptic_link::LoopMode;
use haptic_loop::{
    Controller, SafetyLimits,
    plant::{
        ForceSensorConfig, MassDamperConfig, PressedDevice, PressedSpecimen, RampHold, Sensed,
        SpecimenMatter,
    },
    units::{Metres, NewtonsPerMetre, Seconds},
};
use haptic_run::{
    Ran, Watched,
    remote::{RemoteDevice, RemoteLaw, RemoteRun, blank},
    run_logged,
};
use haptic_trial::{
    Sensors,
    advice::parameter,
    device_table::{device, dynamics, force_sensor, samples_fit, without},
    drive_verdict::DriveVerdict,
    keys::drive::DRIVE_FORCE_LIMIT,
    preflight::{Findings, note_findings},
    safe_chain::safe_chain,
    safety::{Safety, safety},
    samples::WHOLE_MOST,
    sensor_offset::OFFSET_SAMPLES,
    simulate::SimulatedLoop,
};
pub use record::PressRecord;
use std::{collections::BTreeMap, sync::Arc};

parameters! {
    pub(crate) mod keys;
    PROTOCOL = text("protocol", "ramp", "How it is pressed");
    /// Largest depth, m, from where the handle begins.
    PRESS_DEPTH = number(DEPTH.key, 2e-3, "2mm", REACHES_ABOVE_0, "Depth to hold, from where the handle begins: in front of the specimen");
    PRESS_DEPTHS = list("depths_m", REACHES_ABOVE_0, "Steps: their depths, deeper each [default: a third, two thirds and all of the depth]");
    /// Time of a ramp, s.
    PRESS_RAMP = number("ramp_time_s", 0.1, "100ms", DURATIONS, "Time to go to a depth");
    /// Time of a hold, s.
    PRESS_HOLD = number("hold_time_s", 10.0, "10s", DURATIONS, "Time to stay there");
    PRESS_AMPLITUDE = optional("amplitude_m", REACHES_ABOVE_0, "Sine: its amplitude, below the depth by twice as much [default: a tenth of the depth]");
    PRESS_FREQUENCIES = list("frequencies_hz", FREQUENCIES_HZ, "Sine: its frequencies, five periods each [default: 0.2, 0.5, 1, 2 and 5 Hz]");
    /// Guard of the depth, m.
    DEPTH_LIMIT = optional("depth_limit_m", REACHES_ABOVE_0, "Depth beyond which a fault ends the run [default: 1.5 times the depth]");
    /// Stiffness of the frame, N/m.
    FRAME_STIFFNESS = optional("frame_stiffness_n_per_m", STIFFNESSES_ABOVE_0, "Stiffness of frame and handle, whose deflection is taken off the depth");
}

/// Keys of `[press]`.
pub(crate) const PRESS: &[Parameter] = &joined::<34>(&[
    &[PROTOCOL, PRESS_DEPTH, PRESS_DEPTHS, PRESS_RAMP, PRESS_HOLD],
    &[PRESS_AMPLITUDE, PRESS_FREQUENCIES],
    &[DEPTH_LIMIT, FRAME_STIFFNESS],
    p::PIECE,
    &[p::MASS, p::DAMPING],
    p::LESS_THAN_IDEAL,
    p::FORCE_SENSOR,
    &[SAMPLE_TIME, FORCE_LIMIT, FORCE_RATE_LIMIT, p::DEVICE_MODEL],
]);

/// Periods for which a sine of one frequency lasts.
const PERIODS: f64 = 5.0;
/// Samples by which a force from here is later than one of the device's own loop.
const LINE_SAMPLES: f64 = 2.0;
/// Longest lag of a force sensor of which nothing is known, s.
const LAG_MOST_S: f64 = 5e-3;
/// Rest in front of the specimen, in which the offset of a sensor is measured: twice the samples that it needs.
const REST_SAMPLES: f64 = 2.0 * OFFSET_SAMPLES as f64;

/// The path of a press.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Protocol {
    Ramp,
    Steps,
    Sine,
}

named! { Protocol:
    Ramp = "ramp", "A ramp to the depth, which is held";
    Steps = "steps", "A ramp to each depth, which is held";
    Sine = "sine", "A ramp to the depth, then a sine of each frequency";
}

/// A specimen that a device presses.
#[derive(Clone, Debug)]
pub(crate) struct Press {
    protocol: Protocol,
    path: Arc<PressPath>,
    /// The specimen: its shape, and the tissue of a simulated one.
    pub piece: TissuePiece,
    device: MassDamperConfig,
    /// Its parameters as far as its file leaves them open.
    open: Open,
    sensors: Sensors,
    force_sensor: Option<ForceSensorConfig>,
    /// Between which times it lags, s.
    lag_s: [f64; 2],
    drive: Drive,
    limits: SafetyLimits,
    frame_n_per_m: Option<f64>,
    safety: Safety,
    conduct: Conduct,
}

impl Experiment for Press {
    fn check(&self) -> Result<u64, Failure> {
        let allowed = 10.0..=WHOLE_MOST as f64;
        haptic_trial::samples::count(self.path.duration_s(), self.sample_time_s(), &allowed)
    }

    fn sample_time_s(&self) -> f64 {
        self.device.sample_time.0
    }

    fn metadata(&self) -> BTreeMap<String, String> {
        let mut metadata = metadata("press", &self.conduct, Scheme::Exact, &self.safety);
        let files = [
            (CONTROLLER_IN_LOG, self.drive.controller.to_toml()),
            (TISSUE_IN_LOG, self.piece.material.to_toml()),
        ];
        metadata.extend(files.map(|(key, text)| (key.to_owned(), text)));
        metadata
    }

    conducts!();

    fn run(&self, watched: Watched<'_>) -> Result<Published<Report>, Failure> {
        let ran = match &self.conduct.remote {
            Some(remote) => self.run_on(remote, watched)?,
            None => self.simulate(watched)?,
        };
        let (report, curves) = self.report(&ran)?;
        Ok(Published::new(report, curves, ran))
    }

    fn may_be_refused(&self) -> bool {
        true
    }
}

impl Press {
    /// The position loop behind the safety chain.
    fn controller(&self) -> Result<Controller<f64, 1, HostDrive>, Failure> {
        let chain = safe_chain(
            self.limits,
            &self.device,
            self.sensors,
            &self.safety,
            self.conduct.at_port(),
        )?;
        let law = self
            .drive
            .along(Arc::clone(&self.path), self.sample_time_s())?;
        Ok(Controller::new(law, chain))
    }

    fn pressed(&self) -> Result<Sensed<PressedDevice>, Failure> {
        let device = PressedDevice::new(self.device, specimen(&self.piece)).map_err(parameter)?;
        let t = self.device.sample_time;
        (self.sensors).and_force_before(device, self.force_sensor, t)
    }

    fn simulate(&self, watched: Watched<'_>) -> Result<Ran, Failure> {
        let samples = self.check()?;
        let mut controller = self.controller()?;
        let mut device = self.pressed()?;
        let verdict = self.judged(&dynamics(&self.device))?;
        verdict.require_stable(self.conduct.force_unstable)?;
        let mut metadata = self.metadata();
        note_findings(&mut metadata, DriveVerdict::KEY, &verdict);
        let mut world = SimulatedLoop::new(&mut controller, &mut device);
        let ran = run_logged(
            &mut world,
            self.schedule(samples),
            (watched.request, metadata),
            watched.supervisor,
        )?;
        Ok(Ran {
            drive: Some(verdict),
            ..ran
        })
    }

    /// The loop of the handle: alone, and before the specimen of a simulation, if that is a spring beside a spring-pot.
    fn judged(&self, device: &Dynamics) -> Result<DriveVerdict, Failure> {
        let material = &self.piece.material;
        let known = self.conduct.remote.is_none() && material.composed().is_none();
        let tissue = (known && self.piece.is_linear()).then(|| {
            let (stiffness, dissipation) = self.piece.spring_and_damper();
            [
                Term::new(stiffness, 0.0),
                Term::new(dissipation, material.order().get()),
            ]
        });
        self.drive.on_device(device, tissue)
    }

    fn run_on(&self, remote: &RemoteDevice, watched: Watched<'_>) -> Result<Ran, Failure> {
        let samples = self.check()?;
        let mut controller = self.controller()?;
        let t = self.sample_time_s();
        let look = |dynamics: Dynamics, line: usize| {
            let later = Dynamics {
                delay_s: dynamics.delay_s + line as f64 * t,
                ..dynamics
            };
            self.judged(&later).map(Findings::Drive)
        };
        let blank = |time_s| blank(self.path.at(time_s).position_m);
        let (law, schedule) = (self.law(remote)?, self.schedule(samples));
        let run = RemoteRun {
            preflight: Some(&look),
            force_unstable: self.conduct.force_unstable,
            tares: true,
            dynamics: Some(dynamics(&self.device)),
            metadata: self.metadata(),
            ..RemoteRun::new(remote, law, schedule, &blank, watched.request)
        };
        run.run(&mut controller, watched.supervisor)
    }

    /// Settings of the device: its limits, and its controller if it closes the loop itself.
    fn law(&self, remote: &RemoteDevice) -> Result<RemoteLaw, Failure> {
        let rate = Some(self.limits.rate.0);
        let bare = no_law_there(self.limits, rate, &self.safety, &self.device, 0.0);
        let (LoopMode::Device, [ramp, _]) = (remote.loop_mode, self.path.sections.as_slice())
        else {
            return Ok(bare);
        };
        let way = RampHold::new(Metres(ramp.to_m), Seconds(ramp.duration_s)).map_err(parameter)?;
        let (shape, values, controller) = self.drive.portable(way, self.sample_time_s())?;
        Ok(RemoteLaw {
            operator: (shape, values),
            controller: Some(controller),
            ..bare
        })
    }
}

/// A piece of tissue as a physical specimen.
#[must_use]
pub fn specimen(piece: &TissuePiece) -> PressedSpecimen {
    PressedSpecimen {
        matter: piece.material.model.joined(
            |size, order| SpecimenMatter::SpringPot { size, order },
            |a, b| SpecimenMatter::Parallel(vec![a, b]),
            |a, b| SpecimenMatter::Series(vec![a, b]),
        ),
        shape_m: piece.shape_m(),
        map: piece.specimen.depth_map(),
    }
}

/// `[press]`, with the table of the controller that holds the handle.
pub(crate) fn press(table: &Table<'_>, held: Option<&Table<'_>>) -> Result<Press, FileError> {
    let given = |key: &Parameter| held.filter(|held| held.has(key));
    if let Some(held) = given(&p::DRIVE_DEVICE) {
        let reason =
            "drive_device is of [relax] and [creep], and [press] moves its own device: omit it";
        return Err(held.fail_at(p::DRIVE_DEVICE.key, reason));
    }
    let remote = remote(table)?;
    let t = table.number(&SAMPLE_TIME)?;
    let (device, sensors) = device(table, t)?;
    let force_limit_n = table.number(&FORCE_LIMIT)?;
    let of_drive = held.map(|held| held.number_if(&DRIVE_FORCE_LIMIT));
    let of_drive = of_drive.transpose()?.flatten().unwrap_or(force_limit_n);
    let drive = match given(&CONTROLLER) {
        Some(held) => drive::drive(held, None, None, force_limit_n)?,
        None => own_loop(table, &device, remote.as_ref(), force_limit_n)?,
    };
    let drive = Drive {
        force_limit_n: of_drive,
        force_limit_reason: None,
        ..drive
    };
    let protocol = table.choice(&PROTOCOL)?;
    let in_device = (remote.as_ref()).is_some_and(|remote| remote.loop_mode == LoopMode::Device);
    if in_device && protocol != Protocol::Ramp {
        return Err(table.fail_at(
            PROTOCOL.key,
            format_args!(
                "a device's own loop follows protocol = \"ramp\" alone: give {}",
                LOOP.set_to("host")
            ),
        ));
    }
    let path = PressPath {
        // The loop of a device holds its handle from its first tick on.
        rest_s: if in_device { 0.0 } else { REST_SAMPLES * t },
        sections: sections(table, protocol)?,
        back_s: if in_device || remote.is_none() && !table.has(&p::SENSED_RANGE) {
            None
        } else {
            Some(table.number(&PRESS_RAMP)?)
        },
    };
    let deepest_m = path.deepest_m();
    let limit_m = table.number_if(&DEPTH_LIMIT)?.unwrap_or(1.5 * deepest_m);
    if limit_m <= deepest_m {
        return Err(table.fail_at(
            DEPTH_LIMIT.key,
            format_args!(
                "depth_limit_m = {} is not above the depth of {} m: change it, or omit it",
                Shown(limit_m),
                Shown(deepest_m)
            ),
        ));
    }
    samples_fit(table, t, path.duration_s(), &(10.0..=WHOLE_MOST as f64))?;
    let piece = piece(table)?;
    fits(table, &piece, deepest_m)?;
    let force_sensor = if remote.is_some() {
        let idle = format!("with a device, which has its own: omit {DEVICE}");
        let simulated = [&p::TISSUE, &p::SENSED_RANGE, &p::SENSED_NOISE];
        let simulated = simulated
            .into_iter()
            .chain([&p::SENSED_OFFSET, &p::SENSED_SEED]);
        without(table, simulated, &idle)?;
        None
    } else {
        force_sensor(table)?
    };
    let mut safety = safety(table)?;
    // As far in front of the specimen as the guard is behind its surface.
    safety.workspace_m.get_or_insert((0.0 - limit_m, limit_m));
    let rate = table.number(&FORCE_RATE_LIMIT)?;
    Ok(Press {
        protocol,
        path: Arc::new(path),
        piece,
        open: Open::of(&device, &table.intervals),
        device: MassDamperConfig {
            stiffness: NewtonsPerMetre(0.0),
            ..device
        },
        sensors,
        force_sensor,
        lag_s: lag(table)?,
        drive,
        limits: force_and_rate(force_limit_n, Some(rate), Seconds(t)),
        frame_n_per_m: table.number_if(&FRAME_STIFFNESS)?,
        safety,
        conduct: Conduct::on(remote),
    })
}

/// Between which times the force sensor lags, s: as somebody or a device file says, or up to what a load cell may.
fn lag(table: &Table<'_>) -> Result<[f64; 2], FileError> {
    let lag_s = table.number(&p::SENSED_LAG)?;
    let known = table
        .intervals
        .iter()
        .find(|ends| ends.key == p::SENSED_LAG.key);
    Ok(match known {
        Some(ends) if (ends.low..=ends.high).contains(&lag_s) => [ends.low, ends.high],
        Some(_) | None if table.has(&p::SENSED_LAG) => [lag_s; 2],
        Some(_) | None => [0.0, LAG_MOST_S],
    })
}

/// A position loop for this device, if its mass is known.
fn own_loop(
    table: &Table<'_>,
    device: &MassDamperConfig,
    remote: Option<&RemoteDevice>,
    force_limit_n: f64,
) -> Result<Drive, FileError> {
    let known = [&p::MASS, &p::DEVICE_MODEL]
        .iter()
        .any(|key| table.has(key));
    let line = match remote {
        Some(_) if !known => {
            return Err(table.fail(format_args!(
                "[press] makes its position loop from the mass of the device, which nobody gave: give {}, or {} and {}, or {CONTROLLER} in [drive]",
                p::DEVICE_MODEL,
                p::MASS,
                p::DAMPING
            )));
        }
        Some(remote) if remote.loop_mode == LoopMode::Host => LINE_SAMPLES,
        Some(_) | None => 0.0,
    };
    Ok(Drive {
        name: "made from mass and damping".to_owned(),
        controller: position_loop::position_loop(device, line),
        force_limit_n,
        force_limit_reason: None,
        device: None,
    })
}

/// The sections of a protocol.
fn sections(table: &Table<'_>, protocol: Protocol) -> Result<Vec<Section>, FileError> {
    let depth_m = table.number(&PRESS_DEPTH)?;
    let (ramp_s, hold_s) = (table.number(&PRESS_RAMP)?, table.number(&PRESS_HOLD)?);
    let of_sine = [&PRESS_AMPLITUDE, &PRESS_FREQUENCIES];
    let idle: &[&Parameter] = match protocol {
        Protocol::Ramp => &[&PRESS_DEPTHS, of_sine[0], of_sine[1]],
        Protocol::Steps => &of_sine,
        Protocol::Sine => &[&PRESS_DEPTHS],
    };
    if let Some(key) = idle.iter().find(|key| table.has(key)) {
        let key = key.key;
        return Err(table.fail_at(
            key,
            format_args!("{key} has no effect with this {PROTOCOL}: change that, or omit {key}"),
        ));
    }
    let to = |from_m, to_m| {
        [
            Section::straight(ramp_s, from_m, to_m),
            Section::straight(hold_s, to_m, to_m),
        ]
    };
    Ok(match protocol {
        Protocol::Ramp => to(0.0, depth_m).into(),
        Protocol::Steps => {
            let depths = table.numbers_if(&PRESS_DEPTHS)?;
            let depths =
                depths.unwrap_or_else(|| [1.0, 2.0, 3.0].map(|n| n * depth_m / 3.0).into());
            let before = std::iter::once(0.0).chain(depths.iter().copied());
            if before
                .clone()
                .zip(&depths)
                .any(|(before, depth)| *depth <= before)
            {
                return Err(table.fail_at(
                    PRESS_DEPTHS.key,
                    "depths_m do not grow: give them in rising order, as in [0.5e-3, 1e-3]",
                ));
            }
            before
                .zip(&depths)
                .flat_map(|(from_m, to_m)| to(from_m, *to_m))
                .collect()
        }
        Protocol::Sine => {
            let amplitude_m = table.number_if(&PRESS_AMPLITUDE)?.unwrap_or(0.1 * depth_m);
            if 2.0 * amplitude_m >= depth_m {
                return Err(table.fail_at(
                    PRESS_AMPLITUDE.key,
                    format_args!(
                        "amplitude_m = {} is not below half of the depth of {} m, so the handle would leave the specimen: change it",
                        Shown(amplitude_m),
                        Shown(depth_m)
                    ),
                ));
            }
            let frequencies = table.numbers_if(&PRESS_FREQUENCIES)?;
            let frequencies = frequencies.unwrap_or_else(|| vec![0.2, 0.5, 1.0, 2.0, 5.0]);
            let sines = frequencies.into_iter().map(|hz| Section {
                sine: [hz, amplitude_m],
                ..Section::straight(PERIODS / hz, depth_m, depth_m)
            });
            to(0.0, depth_m).into_iter().chain(sines).collect()
        }
    })
}
