//! A run to be made on a connected device: judged, configured, then handed to its session.

use super::session::{HostSession, Ready, Steers};
use crate::{
    device::{firmware_version, refused_at_port},
    folder::FolderRequest,
    ran::Ran,
    record::RunRecord,
    recorder,
    recorder::Recorder,
    remote::{RemoteDevice, RemoteLaw, agreed, partner::Partner},
    schedule::Schedule,
    supervisor::Supervisor,
};
use fracdiff::Real;
use haptic_analysis::Dynamics;
use haptic_document::{
    Failure, Named, Warn,
    parameters::{CONTACT, CONTROLLER, LOOP, MEMORY, SAMPLE_TIME},
};
use haptic_link::{AxisWorkspace, Field, Limits, LoopMode, Refusal, WorkspaceBox};
use haptic_loop::{Controller, Environment, GuardRefused, Tap, Workspace, realtime::Fallback};
use haptic_message::TickMessage;
use haptic_remote::{
    LinkError,
    serial::{Companions, SerialError, SerialLink},
};
use haptic_trial::{
    GuardChoice,
    drive_verdict::DriveVerdict,
    ending::ForceKeeper,
    preflight::{Findings, LoopJudge, MEASURED, delay_samples, note_findings},
    robot::RobotModel,
    safety::keys::{DEVICE_DAMPING, DEVICE_MASS},
    samples::RunStart,
    tick::TickRecord,
};
use std::collections::BTreeMap;

/// A run to be made on a device.
pub struct RemoteRun<'a, M = TickMessage> {
    /// The device and how its link is watched.
    pub device: &'a RemoteDevice,
    /// The law that it gets before it is armed.
    pub law: RemoteLaw,
    /// Number of ticks, and the length of each.
    pub schedule: Schedule,
    /// The values at a time, s, that are known without the device, as the log needs them.
    pub blank: &'a (dyn Fn(f64) -> M + Sync),
    /// This loop for the analysis; `None` if it is not closed through the device's motion.
    pub preflight: Option<&'a LoopJudge<'a>>,
    /// True to run even an unstable loop.
    pub force_unstable: bool,
    /// True to tare its force sensor while it is idle; a device that holds its handle from its first tick on is tared anyway.
    pub tares: bool,
    /// The robot at a port, if the device moves: without it none is armed.
    pub robot: Option<&'a RobotModel>,
    /// Known dynamics of a device at a port.
    pub dynamics: Option<Dynamics>,
    /// Folder and names of the files of the run.
    pub request: &'a FolderRequest,
    /// Everything needed to repeat the run.
    pub metadata: BTreeMap<String, String>,
}

impl<M> std::fmt::Debug for RemoteRun<'_, M> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RemoteRun")
            .field("device", self.device)
            .field("law", &self.law)
            .finish_non_exhaustive()
    }
}

impl<'a, M> RemoteRun<'a, M> {
    /// A run that nothing looks at before, as that of a second device, which is judged and described with that of the first.
    pub fn new(
        device: &'a RemoteDevice,
        law: RemoteLaw,
        schedule: Schedule,
        blank: &'a (dyn Fn(f64) -> M + Sync),
        request: &'a FolderRequest,
    ) -> Self {
        Self {
            device,
            law,
            schedule,
            blank,
            request,
            preflight: None,
            force_unstable: false,
            tares: false,
            robot: None,
            dynamics: None,
            metadata: BTreeMap::new(),
        }
    }

    /// Runs where the device's loop mode says; `controller` closes a loop on the host.
    ///
    /// # Errors
    /// As [`steered`](Self::steered).
    pub fn run<F: Real, E: Environment<F, D>, const D: usize>(
        self,
        controller: &mut Controller<F, D, E>,
        supervisor: Supervisor<'a>,
    ) -> Result<Ran, Failure>
    where
        M: TickRecord,
    {
        self.steered(controller, &mut (), |_, _| Ok(()), supervisor)
    }

    /// Runs as [`run`](Self::run) does, but somebody may change the law between ticks, and hears of the device before it is armed: how many samples
    /// its loop here is late, and in how many ticks its force rises.
    ///
    /// # Errors
    /// If the device is not there, refuses the law or the pre-flight does, or a file cannot be written; after the start of a run only the last.
    pub fn steered<F: Real, E: Environment<F, D>, const D: usize>(
        self,
        controller: &mut Controller<F, D, E>,
        steers: &mut impl Steers<F, E, D>,
        connected: impl FnOnce(&SerialLink, u64) -> Result<(), Failure>,
        supervisor: Supervisor<'a>,
    ) -> Result<Ran, Failure>
    where
        M: TickRecord,
    {
        let request = self.request;
        let ready = self.ready::<D>(supervisor)?;
        connected(&ready.link, ready.rise_ticks)?;
        let folder = request.prepare()?;
        let metadata = ready.metadata.clone();
        let recorder = recorder(request, &folder, metadata, false, supervisor)?;
        let mut session = ready.session(recorder, None)?;
        session.conduct(controller, steers, supervisor);
        session.finish(folder)
    }

    /// Connects, configures, and looks at the loop: before any file is made, and any force.
    pub(super) fn ready<const D: usize>(
        mut self,
        supervisor: Supervisor<'a>,
    ) -> Result<Ready<'a, M>, Failure> {
        let device = self.device;
        let (patience, stop) = (device.patience, Some(supervisor.stop));
        let mut link = (device.name).connect_with(D, patience, supervisor.warn, stop)?;
        device.calibrate(&mut link)?;
        let conduct = link.capabilities().lets_go_alone;
        let moves = conduct.moves;
        if conduct.to_measure {
            return Err(Failure::input(LinkError::UnmeasuredRobot));
        }
        fits_motion(moves, self.robot.is_some(), self.law.guard.0)?;
        if moves {
            link.knows_robot();
        }
        let path = link.path().to_owned();
        let holds = self.law.controller.is_some();
        let problem = |error: SerialError| match error.is_refusal() {
            true if error.is_about(Field::SimulationKind) => Failure::input_with_advice(
                error,
                format_args!(
                    "this board cannot simulate a compliant contact: use {contact_rigid}",
                    contact_rigid = CONTACT.set_to("rigid")
                ),
            ),
            true if holds && is_too_long(&error) => Failure::input_with_advice(
                error,
                format_args!(
                    "give the {CONTROLLER} fewer numbers, for instance with a shorter `{}` or scheme = \"full:1e-4\", or a longer {SAMPLE_TIME}",
                    MEMORY.key
                ),
            ),
            _ if matches!(error, SerialError::Link(LinkError::NoSurfaces)) => {
                let loop_host = LOOP.set_to("host");
                Failure::input_with_advice(error, format_args!("give {loop_host}"))
            }
            _ => refused_at_port(&path, error),
        };
        let (set, _) = link.configuration().map_err(problem)?;
        let schedule = self.schedule;
        let mut configuration = agreed(device, &self.law, schedule, &link, &set, supervisor.warn)?;
        let (t, rise_s) = (
            self.schedule.sample_time_s,
            configuration.limits.rise_time_s,
        );
        let start_ticks = if self.law.after_rise && link.capabilities().simulated && rise_s > 0.0 {
            risen_after((t / f64::from(rise_s)) as f32)
        } else {
            0
        };
        configuration.simulation.start_ticks = start_ticks as f32;
        self.schedule.samples += start_ticks;
        if start_ticks > 0 {
            (self.metadata).insert("start_s".to_owned(), (start_ticks as f64 * t).to_string());
        }
        let tap = self.law.tap.map(|_| Tap {
            force_n: f64::from(configuration.tap_n),
            ticks: configuration.tap_ticks,
        });
        if let Some(Tap { force_n, ticks }) = tap {
            (self.metadata).insert("tap_n".to_owned(), force_n.to_string());
            (self.metadata).insert("tap_ticks".to_owned(), ticks.to_string());
        }
        describe_limits(&configuration.limits, &mut self.metadata);
        let workspace = self.law.limits.workspace_box.map(wire_box::<D>);
        let companions = Companions {
            workspace: workspace.as_ref(),
            surface: self.law.surface.as_ref(),
            controller: self.law.controller.as_ref(),
        };
        let set = link.set_run(configuration, &self.law.operator.1, companions);
        set.map_err(problem)?;
        let before = link.statistics().map_err(problem)?;
        describe(&link, device, &mut self.metadata);
        let found = self.preflight(&link, supervisor.warn)?;

        Ok(Ready {
            link,
            before,
            device,
            schedule: self.schedule,
            start: RunStart::at(start_ticks, t),
            // The device sums it in single precision.
            rise_ticks: (f64::from(rise_s) / t).ceil() as u64 + 10,
            blank: self.blank,
            metadata: self.metadata,
            found,
            push: self.law.push,
            tap,
            force_limit_n: configuration.limits.force_n.into(),
            tares: holds || self.tares,
            stop: supervisor.stop,
        })
    }
}

impl<M> Ready<'_, M> {
    /// Sends keep-alives for a while: how much later than in the device its loop is closed, s.
    pub(super) fn measured_delay_s(&self) -> f64 {
        let samples = delay_of(&self.link, self.device, self.schedule);
        samples as f64 * self.schedule.sample_time_s
    }
}

/// A device that moves needs its robot, and no passivity guard; no other has a robot.
fn fits_motion(moves: bool, is_known: bool, guard: GuardChoice) -> Result<(), Failure> {
    match (moves, is_known) {
        (false, false) => Ok(()),
        (false, true) => {
            let reason =
                "[admittance] is of a robot that takes a velocity, and this device takes a force";
            let advice = "give the device file of this one";
            Err(Failure::input_with_advice(reason, advice))
        }
        (true, _) if guard != GuardChoice::Off => Err(Failure::input(GuardRefused)),
        (true, false) => Err(Failure::input(LinkError::UnknownRobot)),
        (true, true) => Ok(()),
    }
}

/// Keep-alives for a while, and by them whole samples from a device to a loop here and back; 0 for a loop in the device.
pub fn delay_of(link: &SerialLink, device: &RemoteDevice, schedule: Schedule) -> usize {
    let measured = link.measure_round_trip(MEASURED);
    // Without any answer in that time it is as long at least.
    let round_trip_us = if measured.is_empty() {
        MEASURED.as_micros() as u64
    } else {
        measured.quantile(0.9)
    };
    match device.loop_mode {
        LoopMode::Device => 0,
        LoopMode::Host => delay_samples(round_trip_us, schedule.sample_time_s),
    }
}

impl<'a, M: TickRecord> Ready<'a, M> {
    pub(super) fn session<const D: usize>(
        mut self,
        recorder: Recorder,
        partner: Option<Partner<'a>>,
    ) -> Result<HostSession<'a, M, D>, Failure> {
        let mut record = RunRecord::with_room_for(self.schedule.samples);
        record.start = self.start;
        record.lateness = Some(self.device.lateness());
        record.keeper = ForceKeeper {
            served: self.link.is_served(),
            alone: self.link.capabilities().lets_go_alone.lets_go,
        };
        record.not_realtime = raised(&self.link, self.schedule);
        if partner.as_ref().is_some_and(|partner| !partner.is_drive()) {
            // Until its drive has sent its start.
            self.schedule.samples = u64::MAX;
        }
        Ok(HostSession {
            ready: self,
            recorder,
            record,
            samples_lost: 0,
            next_tick: 0,
            over: false,
            deaf: false,
            swung: false,
            partner,
            pending: Vec::new(),
        })
    }
}

/// True if the device refused a controller for its many coefficients.
const fn is_too_long(error: &SerialError) -> bool {
    let SerialError::Link(LinkError::Refused { refusal, .. }) = error else {
        return false;
    };
    matches!(
        refusal,
        Refusal::Range {
            field: Field::TickPeriod | Field::CoefficientCount,
            ..
        }
    )
}

/// Ticks until a force that rises by this share each is whole, summed as the device does.
fn risen_after(share: f32) -> u64 {
    let (mut risen, mut ticks) = (0.0, 0);
    while risen < 1.0 {
        risen += share;
        ticks += 1;
    }
    ticks
}

/// The first ranges of a box, as they go over the wire.
fn wire_box<const D: usize>(ranges: [Workspace; 3]) -> WorkspaceBox {
    let range = |range: &Workspace| AxisWorkspace {
        low_m: range.low.0 as f32,
        high_m: range.high.0 as f32,
        soft_m: range.soft.0 as f32,
    };
    WorkspaceBox {
        axes: ranges.iter().take(D).map(range).collect(),
    }
}

/// Raises the threads of the link, if that is asked for; the refusal.
fn raised(link: &SerialLink, schedule: Schedule) -> Option<String> {
    let priority = schedule.thread_options().priority?;
    let refusal = link.raise(priority).err()?;
    let fallback = Fallback {
        priority: Some((priority, refusal)),
        ..Fallback::default()
    };
    Some(fallback.to_string())
}

impl<M> RemoteRun<'_, M> {
    /// Looks at the loop before it is closed, and notes what it saw; `None` if it cannot be judged.
    fn preflight(
        &mut self,
        link: &SerialLink,
        warn: Warn<'_>,
    ) -> Result<Option<Findings>, Failure> {
        let key = match self.law.controller {
            Some(_) => DriveVerdict::KEY,
            None => "preflight",
        };
        let found = self.judged(link, warn)?;
        match &found {
            Some(found) => note_findings(&mut self.metadata, key, found),
            None => drop((self.metadata).insert(key.to_owned(), "skipped".to_owned())),
        }
        Ok(found)
    }

    fn judged(&self, link: &SerialLink, warn: Warn<'_>) -> Result<Option<Findings>, Failure> {
        let Some(look) = self.preflight else {
            return Ok(None);
        };
        // A simulated board of which nobody says anything is the mass that it is asked to be.
        let simulation = &self.law.simulation;
        let asked = || Dynamics {
            hand_stiffness_n_per_m: f64::from(simulation.hand_stiffness_n_per_m),
            ..Dynamics::ideal(
                f64::from(simulation.mass_kg),
                f64::from(simulation.damping_n_s_per_m),
            )
        };
        let simulated = link.capabilities().simulated;
        let dynamics = self.dynamics.or_else(|| simulated.then(asked));
        let Some(dynamics) = dynamics else {
            warn(&format!(
                "pre-flight: skipped, the device is unknown: give {DEVICE_MASS} and {DEVICE_DAMPING}"
            ));
            return Ok(None);
        };
        let delay = match self.device.loop_mode {
            LoopMode::Device => 0,
            LoopMode::Host => delay_of(link, self.device, self.schedule),
        };
        let verdict = look(dynamics, delay)?;
        // Energy bounding promises passivity for the damping that the device was said to have.
        let guarded = self.law.guard.0 == GuardChoice::EnergyBounding;
        verdict.require_stable(self.force_unstable || guarded)?;
        if let Some(warning) = verdict.warning(guarded) {
            warn(&warning);
        }
        Ok(Some(verdict))
    }
}

/// The limits that really hold, for the log.
fn describe_limits(limits: &Limits, metadata: &mut BTreeMap<String, String>) {
    let numbers = [
        ("device_force_limit_n", limits.force_n),
        ("device_force_rate_limit_n_per_s", limits.force_rate_n_per_s),
        ("device_rise_time_s", limits.rise_time_s),
        ("device_speed_limit_m_per_s", limits.speed_hard_m_per_s),
    ];
    metadata.extend(numbers.map(|(key, value)| (key.to_owned(), value.to_string())));
}

/// Adds the facts that only the connected device knows.
fn describe(link: &SerialLink, device: &RemoteDevice, metadata: &mut BTreeMap<String, String>) {
    let mut add = |key: &str, value: String| metadata.insert(key.to_owned(), value);
    add("board", link.capabilities().board().to_owned());
    add("firmware", firmware_version(link.hello()));
    add("identity", device.name.identity(link).to_string());
    add("loop", device.loop_mode.name().to_owned());
    add(
        "watchdog_s",
        (f64::from(device.watchdog_ms()) * 1e-3).to_string(),
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robot_runs_with_its_file_and_without_a_guard_and_nothing_else_with_one() {
        let off = GuardChoice::Off;
        for (moves, is_known, guard, words) in [
            (true, false, off, "device_model=robot.toml"),
            (true, true, GuardChoice::Observer, "passivity guard"),
            (true, true, GuardChoice::EnergyBounding, "passivity guard"),
            (false, true, off, "takes a force"),
        ] {
            let refused = fits_motion(moves, is_known, guard).expect_err(words);
            assert!(refused.to_string().contains(words), "{refused}");
        }
        for guard in [off, GuardChoice::Observer, GuardChoice::EnergyBounding] {
            assert!(fits_motion(false, false, guard).is_ok());
        }
        assert!(fits_motion(true, true, off).is_ok());
    }
}
