//! An experiment on a device at the other end of a link.
//!
//! ```text
//! device loop:  set parameters ─▶ arm ─▶ start ─▶ samples ─▶ log        the device ticks
//! host loop:    ... sample ─▶ controller of this program ─▶ force ...   the device only measures and applies
//! ```
//! Time is the device's, n·T. What the line loses is counted, never made up.

use super::flight::FaultSeen;
use super::preflight::{Dynamics, MEASURED, Preflight, PreflightRequest, Verdict, delay_samples};
use super::realtime::RealtimeOptions;
use super::recorder::{Recorded, Recorder};
use super::run::{Ended, Pace, Ran, Record, Schedule, Supervisor, log_stopped};
use super::safety::{GuardChoice, GuardedDevice};
use crate::device::{SerialName, at_port};
use crate::failure::Failure;
use crate::folder::{FolderRequest, OutputFolder};
use crate::output::note;
use crate::record::TickMessage;
use fracdiff::{Operator, Real};
use haptic_link::{
    Capabilities, Configuration, EventKind, Field, Limits, LoopMode, OperatorShape, Refusal,
    Report, Request, Sample, Simulation, SimulationKind, Start, State, Statistics,
};
use haptic_loop::realtime::{Fallback, RaisedThread};
use haptic_loop::remote::serial::{Heard, SerialError, SerialLink};
use haptic_loop::remote::{LinkError, wire_limits};
use haptic_loop::units::Seconds;
use haptic_loop::{Controller, Environment, Fault, Guard, StartRefused};
use std::collections::BTreeMap;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// What is still to be heard after a fault, when nothing comes for so long.
const AFTER_FAULT: Duration = Duration::from_millis(200);

/// A device and how the loop with it is closed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RemoteDevice {
    /// The port.
    pub name: SerialName,
    /// Where the loop is closed.
    pub loop_mode: LoopMode,
    /// Silence after which the device lets go, ms.
    pub watchdog_ms: u16,
    /// Late ticks in a row that latch a fault; 0 for never.
    pub late_ticks: u16,
    /// How long to wait for the device to be there.
    pub patience: Duration,
}

impl RemoteDevice {
    /// With the defaults: the device's loop, 20 ms of silence, 20 late ticks, no patience.
    #[must_use]
    pub fn new(name: SerialName) -> Self {
        Self {
            name,
            loop_mode: LoopMode::Device,
            watchdog_ms: Limits::DEFAULT.watchdog_ms,
            late_ticks: Limits::DEFAULT.late_ticks,
            patience: Duration::ZERO,
        }
    }
}

/// What the device renders, and what it simulates if it is simulated.
#[derive(Clone, Debug)]
pub struct RemoteLaw {
    /// K, N/m.
    pub stiffness_n_per_m: f64,
    /// B, N·s^μ/m.
    pub dissipation_n_s_mu_per_m: f64,
    /// μ.
    pub order: f64,
    /// Pushes but never pulls, from 0 on.
    pub one_sided: bool,
    /// Coefficients of the operator.
    pub operator: (OperatorShape, Vec<f32>),
    /// Limits of the safety chain, without a guard.
    pub limits: haptic_loop::Limits,
    /// The guard, and what is known of a real device.
    pub guard: (GuardChoice, GuardedDevice),
    /// The plant of a simulated device.
    pub simulation: Simulation,
}

/// What the link of a run counted.
#[derive(Clone, Debug, serde::Serialize)]
pub struct LinkSummary {
    /// Board.
    pub board: String,
    /// Firmware version.
    pub firmware: String,
    /// `device` or `host`.
    #[serde(rename = "loop")]
    pub loop_mode: &'static str,
    /// Samples of the run that did not come.
    pub samples_lost: u64,
    /// Samples that came but found no room here.
    pub samples_dropped: u64,
    /// Samples that found no room on the device.
    pub samples_dropped_on_device: u32,
    /// Ticks of a host loop without a new force.
    pub stale_forces: u32,
    /// Forces that found no room here.
    pub forces_dropped: u64,
    /// Ticks of the device that were late.
    pub overruns: u32,
    /// Longest tick of the device, processor cycles; 0 if it cannot count them.
    pub tick_cycles_max: u32,
    /// Frames, seen from here.
    pub from_device: FrameCounts,
    /// Frames, seen from the device.
    pub to_device: FrameCounts,
    /// Requests that were sent again.
    pub retries: u32,
    /// From a keep-alive to its answer, µs: median, 99 of 100, longest.
    pub round_trip_us: [u64; 3],
}

impl LinkSummary {
    /// Samples that were measured and did not get to the log because of the line.
    #[must_use]
    pub fn samples_missing(&self) -> u64 {
        self.samples_lost + self.samples_dropped
    }
}

/// Frames of one direction.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct FrameCounts {
    /// Sent.
    pub sent: u32,
    /// Received whole.
    pub received: u32,
    /// Damaged.
    pub corrupt: u32,
    /// Did not come.
    pub lost: u32,
    /// Came twice.
    pub duplicate: u32,
    /// Came after a later one.
    pub late: u32,
}

/// A device that is configured, armed by nobody yet, and the log of what is to come.
struct Session<'a> {
    link: SerialLink,
    before: Statistics,
    watchdog: Duration,
    loop_mode: LoopMode,
    schedule: Schedule,
    reference: &'a dyn Fn(f64) -> f64,
    folder: OutputFolder,
    recorder: Recorder,
    record: Record,
    samples_lost: u64,
    next_tick: u64,
    preflight: Option<Verdict>,
}

/// A run to be made on a device.
pub struct RemoteRun<'a> {
    /// The device.
    pub device: &'a RemoteDevice,
    /// What it renders.
    pub law: RemoteLaw,
    /// How many ticks, how long each.
    pub schedule: Schedule,
    /// Where the indenter is told to be, m, at a time in s; not a number if nobody knows.
    pub reference: &'a dyn Fn(f64) -> f64,
    /// The same loop for the analysis; `None` if it is not closed through the device's motion.
    pub preflight: Option<Preflight>,
    /// What the user wants of that.
    pub wanted: PreflightRequest,
    /// Where the files go.
    pub request: &'a FolderRequest,
    /// Everything needed to repeat the run.
    pub metadata: BTreeMap<String, String>,
}

impl std::fmt::Debug for RemoteRun<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RemoteRun")
            .field("device", self.device)
            .field("law", &self.law)
            .field("schedule", &self.schedule)
            .finish_non_exhaustive()
    }
}

impl<'a> RemoteRun<'a> {
    /// Runs where the device's loop mode says; `controller` closes a loop on the host.
    ///
    /// # Errors
    /// A device that cannot be used, parameters that it refuses; a folder or log that cannot be written.
    pub fn run<F: Real, E: Environment<F, 1>>(
        self,
        controller: &mut Controller<F, 1, E>,
        supervisor: Supervisor<'_>,
    ) -> Result<Ran, Failure> {
        let mode = self.device.loop_mode;
        let mut session = self.prepare(supervisor)?;
        let ended = match mode {
            LoopMode::Device => session.listen(supervisor),
            LoopMode::Host => session.control(controller, supervisor),
        };
        if let Err(error) = ended {
            session.give_up(&error);
        }
        session.after_fault();
        session.finish()
    }

    /// Connects, configures, and only then makes folder and log.
    fn prepare(mut self, supervisor: Supervisor<'_>) -> Result<Session<'a>, Failure> {
        let device = self.device;
        let mut link = device.name.connect(device.patience)?;
        let path = link.path().to_owned();
        let configuration = configuration(device, &self.law, self.schedule, link.capabilities())?;
        let problem = |error: SerialError| match error.is_refusal() {
            true if error.is_about(Field::SimulationKind) => Failure::input_with_advice(
                error,
                "this board simulates no compliant contact, take --contact rigid",
            ),
            true => Failure::bad_input(error),
            false => at_port(&path, &error),
        };
        link.set(configuration, &self.law.operator.1)
            .map_err(problem)?;
        let before = link.statistics().map_err(problem)?;
        describe(&link, device, &mut self.metadata);
        let preflight = self.preflight(&link)?;
        match &preflight {
            Some(verdict) => verdict.describe(&mut self.metadata),
            None => {
                (self.metadata).insert("preflight".to_owned(), "skipped".to_owned());
            }
        }

        let folder = self.request.prepare()?;
        let log = folder.file("mcap");
        let live = supervisor.live_streams();
        let started = Recorder::start(&log, self.metadata, false, folder.overwrite(), live);
        let recorder = started.inspect_err(|_| folder.discard())?;
        let mut record = Record::with_room_for(self.schedule.samples).map_err(Failure::Run)?;
        if let Some(priority) = options(self.schedule).priority {
            record.not_realtime = link.raise(priority).err().map(|refusal| {
                let fallback = Fallback {
                    priority: Some((priority, refusal)),
                    ..Fallback::default()
                };
                fallback.to_string()
            });
        }
        Ok(Session {
            link,
            before,
            watchdog: Duration::from_millis(u64::from(device.watchdog_ms)),
            loop_mode: device.loop_mode,
            schedule: self.schedule,
            reference: self.reference,
            folder,
            recorder,
            record,
            samples_lost: 0,
            next_tick: 0,
            preflight,
        })
    }
}

impl RemoteRun<'_> {
    /// Looks at the loop before it is closed; `None` if it cannot be judged.
    fn preflight(&self, link: &SerialLink) -> Result<Option<Verdict>, Failure> {
        let Some(subject) = self.preflight else {
            return Ok(None);
        };
        let simulation = &self.law.simulation;
        let dynamics = if link.capabilities().simulated {
            Some(Dynamics {
                mass_kg: f64::from(simulation.mass_kg),
                damping_n_s_per_m: f64::from(simulation.damping_n_s_per_m),
                hand_stiffness_n_per_m: f64::from(simulation.hand_stiffness_n_per_m),
            })
        } else {
            self.wanted.dynamics
        };
        let Some(dynamics) = dynamics else {
            note(
                "warning",
                "pre-flight: skipped, the mass and damping of the device are not known: give --device-mass \
                 and --device-damping",
            );
            return Ok(None);
        };
        let delay = match self.device.loop_mode {
            LoopMode::Device => 0,
            LoopMode::Host => {
                let round_trip_us = link.measure_round_trip(MEASURED).value_at_quantile(0.9);
                delay_samples(round_trip_us, self.schedule.sample_time_s)
            }
        };
        let verdict = subject.verdict(dynamics, delay)?;
        // Energy bounding promises passivity for the damping that the device was said to have.
        let guarded = self.law.guard.0 == GuardChoice::EnergyBounding;
        verdict.require_stable(self.wanted.force_unstable || guarded)?;
        if let Some(warning) = verdict.warning(guarded) {
            note("warning", warning);
        }
        Ok(Some(verdict))
    }
}

/// What is asked for the threads of a run.
const fn options(schedule: Schedule) -> RealtimeOptions {
    match schedule.pace {
        Pace::Realtime(options) => options,
        Pace::Virtual => RealtimeOptions::NORMAL,
    }
}

/// The configuration of the device.
pub(super) fn configuration(
    device: &RemoteDevice,
    law: &RemoteLaw,
    schedule: Schedule,
    capabilities: &Capabilities,
) -> Result<Configuration, Failure> {
    let us = schedule.sample_time_s * 1e6;
    if (us - us.round()).abs() > 1e-6 || !(1.0..=4e9).contains(&us) {
        return Err(Failure::bad_input(format_args!(
            "sample time {} s is not a whole number of microseconds, which a device needs: change \
             --sample-time",
            schedule.sample_time_s
        )));
    }
    let simulation = if capabilities.simulated {
        law.simulation
    } else {
        Simulation::REAL
    };
    let t = Seconds(schedule.sample_time_s);
    let guard = guard_of(law.guard.0, law.guard.1, &simulation, t)?;
    let limits = wire_limits(&haptic_loop::Limits {
        guard,
        ..law.limits
    });
    Ok(Configuration {
        loop_mode: device.loop_mode,
        tick_period_us: us.round() as u32,
        stiffness_n_per_m: law.stiffness_n_per_m as f32,
        dissipation_n_s_mu_per_m: law.dissipation_n_s_mu_per_m as f32,
        order: law.order as f32,
        one_sided: law.one_sided,
        surface_m: 0.0,
        operator: law.operator.0,
        limits: Limits {
            watchdog_ms: device.watchdog_ms,
            late_ticks: device.late_ticks,
            ..limits
        },
        simulation,
    })
}

/// Limits of the chain that closes a loop here: force, rate and start. The rest is up to the device, which
/// knows where it is without delay.
#[must_use]
pub const fn host_limits(limits: &haptic_loop::Limits) -> haptic_loop::Limits {
    haptic_loop::Limits {
        start_force: limits.start_force,
        ..haptic_loop::Limits::bare(limits.force, limits.rate)
    }
}

/// A guard for a device: what nobody has said of a simulated one is known from what it simulates. In a real
/// one a force takes a tick more than none, for what board and actuator need.
///
/// # Errors
/// As [`GuardChoice::of`].
pub fn guard_of(
    guard: GuardChoice,
    known: GuardedDevice,
    simulation: &Simulation,
    t: Seconds,
) -> Result<Option<Guard>, Failure> {
    let known = if simulation.kind == SimulationKind::Real {
        GuardedDevice {
            delay_samples: known.delay_samples.max(1),
            ..known
        }
    } else {
        let simulated = |value: f32| Some(f64::from(value));
        GuardedDevice {
            mass_kg: known.mass_kg.or(simulated(simulation.mass_kg)),
            damping_n_s_per_m: known
                .damping_n_s_per_m
                .or(simulated(simulation.damping_n_s_per_m)),
            ..known
        }
    };
    guard.of(&known, t)
}

/// Coefficients for a device that does not compute the force itself: one zero.
#[must_use]
pub fn no_operator() -> (OperatorShape, Vec<f32>) {
    (Configuration::PASSIVE.operator, vec![0.0])
}

/// The operator of a device, from the scheme.
///
/// # Errors
/// More coefficients than the wire can count.
pub fn portable(operator: &Operator<f32>) -> Result<(OperatorShape, Vec<f32>), Failure> {
    haptic_loop::remote::operator_shape(operator)
        .map_err(|error| Failure::input_with_advice(error, "change --scheme, or take --loop host"))
}

impl Session<'_> {
    /// Asks the device what it counted, lets it go, and closes the log.
    fn finish(self) -> Result<Ran, Failure> {
        let Session {
            link,
            before,
            loop_mode,
            folder,
            mut recorder,
            mut record,
            samples_lost,
            preflight,
            ..
        } = self;
        // Only a device that has let go answers so; its force falls at its own rate limit.
        let let_go = record.ended == Some(Ended::LogStopped) && waits_for_rest(&link);
        // A device that is gone cannot be asked.
        let after = link.statistics().unwrap_or(before);
        let summary = summarise(&link, loop_mode, before, after, samples_lost);
        drop(link);
        record.dropped = recorder.dropped() + summary.samples_dropped + samples_lost;
        record.missed_deadlines = u64::from(summary.overruns) + u64::from(summary.stale_forces);
        recorder.metadata("link", flat(&summary));
        record.link = Some(summary);
        let recorded = recorder.finish();
        let Recorded {
            log,
            fault_log,
            warnings,
        } = match recorded {
            Err(error) if record.ended == Some(Ended::LogStopped) => {
                return Err(log_stopped(error, let_go));
            }
            recorded => recorded?,
        };
        Ok(Ran {
            record,
            log,
            fault_log,
            preflight,
            live_warnings: warnings,
            folder,
        })
    }

    /// Arms and starts.
    fn start(&mut self, ticks: u32) -> Result<(), SerialError> {
        self.link.arm(self.watchdog)?;
        self.link.start(Start {
            run: 1,
            ticks,
            every: 1,
            batch: self.batch(),
        })
    }

    /// A run in the device's loop: everything is decided there.
    fn listen(&mut self, supervisor: Supervisor<'_>) -> Result<(), SerialError> {
        /// Nothing for so long in the middle of a run is the end of it.
        const SILENCE: Duration = Duration::from_secs(2);
        // A run of 2³² ticks and more is stopped from here.
        self.start(u32::try_from(self.schedule.samples).unwrap_or(0))?;
        let mut patience = SILENCE;
        loop {
            match self.link.hear(patience) {
                Some(Heard::Sample(sample)) => {
                    self.take_sample(&sample);
                    (supervisor.progress)(self.next_tick);
                }
                Some(Heard::Event(event)) => match event.kind {
                    EventKind::Finished | EventKind::Stopped | EventKind::Disarmed => break,
                    EventKind::Configured | EventKind::Armed | EventKind::Started => {}
                },
                Some(Heard::Fault(report)) => {
                    self.ends(Ended::DeviceFault(report), "fault");
                    // Until the ramp is over its samples come by themselves; for those behind it, ask.
                    self.stream_after_fault(1);
                    patience = AFTER_FAULT;
                }
                Some(Heard::Over(error)) => return Err(error.into()),
                None if self.record.ended.is_some_and(Ended::is_fault) => break,
                None => {
                    let waited_ms = SILENCE.as_millis() as u64;
                    return Err(LinkError::NoSamples { waited_ms }.into());
                }
            }
            if self.recorder.flight().is_full() {
                break;
            }
            let asked = supervisor.stop.load(Ordering::Relaxed);
            if self.record.ended.is_none() && asked {
                self.ends(Ended::Interrupted, "interrupted");
                self.link.ask(Request::Stop)?;
            }
            if self.record.ended == Some(Ended::LogStopped) {
                self.link.ask(Request::Stop)?;
                break;
            }
        }
        self.count_missing_end();
        self.link.disarm()
    }

    /// A run with the loop closed here, until the samples are done and the force is zero.
    fn control<F: Real, E: Environment<F, 1>>(
        &mut self,
        controller: &mut Controller<F, 1, E>,
        supervisor: Supervisor<'_>,
    ) -> Result<(), SerialError> {
        let thread = RaisedThread::new(options(self.schedule).thread());
        self.record.raised(&thread);
        self.start(0)?;
        loop {
            // Waiting for the sample is no part of the tick.
            let reading = haptic_loop::Device::<F, 1>::read(&mut self.link)?;
            if self.next_tick == 0 {
                controller.may_start(&reading).map_err(blow)?;
            }
            let began = Instant::now();
            let done = controller.tick_reading(&mut self.link, reading)?;
            let took = began.elapsed().as_nanos() as u64;
            self.record.tick_ns.saturating_record(took.max(1));
            let tick = reading.tick;
            let counted = tick < self.schedule.samples && self.record.ended.is_none();
            self.gap(tick);
            let message = TickMessage {
                tick,
                time_s: reading.time_s,
                position_m: reading.position_m[0].to_f64(),
                environment_force_n: done.environment_force_n[0].to_f64(),
                force_n: done.force.newtons()[0].to_f64(),
                // The device limits what it is sent once more.
                limiters: done.limiters.bits() | self.link.newest_limiters(),
                ..self.blank(reading.time_s)
            };
            self.keep(message, counted);
            (supervisor.progress)(self.next_tick);
            if self.record.ended.is_none() {
                if let Some(fault) = controller.safety().fault() {
                    self.ends(Ended::Fault(fault), "fault");
                } else if supervisor.stop.load(Ordering::Relaxed) {
                    self.ends(Ended::Interrupted, "interrupted");
                }
            }
            if self.record.ended.is_some() || tick + 1 >= self.schedule.samples {
                controller.stop();
                // Of a fault, what follows it is kept too.
                let flight = self.recorder.flight();
                let recorded = flight.fault().is_none() || flight.is_full();
                if controller.safety().is_at_rest() && recorded {
                    break;
                }
            }
        }
        self.link.disarm()
    }

    fn take_sample(&mut self, sample: &Sample) {
        let message = self.message(sample);
        let counted = message.tick < self.schedule.samples && self.record.ended.is_none();
        self.gap(message.tick);
        self.keep(message, counted);
    }

    /// A sample of the device as the log has it.
    fn message(&self, sample: &Sample) -> TickMessage {
        let tick = u64::from(sample.tick);
        let time_s = tick as f64 * self.schedule.sample_time_s;
        TickMessage {
            tick,
            time_s,
            position_m: f64::from(sample.position_m),
            environment_force_n: f64::from(sample.environment_force_n),
            force_n: f64::from(sample.force_n),
            limiters: sample.limiters,
            ..self.blank(time_s)
        }
    }

    /// What is known without the device; the rest is not a number.
    fn blank(&self, time_s: f64) -> TickMessage {
        TickMessage {
            reference_m: (self.reference)(time_s),
            indenter_position_m: f64::NAN,
            contact_force_n: f64::NAN,
            observed_energy_j: f64::NAN,
            ..TickMessage::default()
        }
    }

    /// Counts what is missing before this tick.
    fn gap(&mut self, tick: u64) {
        // What follows a fault is no part of the result.
        let faulted = self.record.ended.is_some_and(Ended::is_fault);
        if !faulted && tick > self.next_tick && self.next_tick < self.schedule.samples {
            let missing = tick.min(self.schedule.samples) - self.next_tick;
            self.samples_lost += missing;
            let time_s = tick as f64 * self.schedule.sample_time_s;
            let text = format!("{missing} samples before tick {tick} did not come");
            // A recorder that has ended is seen when it is closed.
            let _ = self.recorder.event(time_s, "lost", text);
        }
        self.next_tick = tick + 1;
    }

    /// A run that finished, but whose last samples did not come.
    fn count_missing_end(&mut self) {
        if self.record.ended.is_none() {
            self.gap(self.schedule.samples.max(self.next_tick));
        }
    }

    fn keep(&mut self, message: TickMessage, counted: bool) {
        let logged = self.recorder.tick(message);
        if counted {
            self.record.push(&message);
        }
        if logged.is_err() && self.record.ended.is_none() {
            self.record.ended = Some(Ended::LogStopped);
        }
    }

    fn ends(&mut self, ended: Ended, kind: &str) {
        if self.record.ended.is_none() {
            self.record.ended = Some(ended);
            let seen = match ended {
                Ended::Fault(fault) => Some((fault.code(), self.next_tick.saturating_sub(1))),
                Ended::DeviceFault(report) => Some((report.status.fault, u64::from(report.tick))),
                Ended::Interrupted | Ended::LinkLost(_) | Ended::LogStopped => None,
            };
            if let Some((code, tick)) = seen {
                let known = Fault::from_code(code).map(|fault| fault.to_string());
                self.recorder.fault(FaultSeen {
                    code,
                    text: known.unwrap_or_else(|| format!("fault {code}")),
                    tick,
                    time_s: tick as f64 * self.schedule.sample_time_s,
                });
            }
            let time_s = self.next_tick as f64 * self.schedule.sample_time_s;
            let _ = self.recorder.event(time_s, kind, ended.reason());
        }
    }

    /// Which ticks come while nothing runs: each how manyth, 0 none.
    fn stream_after_fault(&self, every: u16) {
        let batch = self.batch();
        // A device that does not answer has nothing more to tell.
        let _ = self.link.ask(Request::Stream { every, batch });
    }

    /// After a fault on the device: hears what follows it, and reads the device's own flight recorder, whose
    /// samples fill in for those that did not come.
    fn after_fault(&mut self) {
        if !matches!(self.record.ended, Some(Ended::DeviceFault(_))) {
            return;
        }
        if !self.recorder.flight().is_full() {
            self.stream_after_fault(1);
            while let (false, Some(heard)) = (
                self.recorder.flight().is_full(),
                self.link.hear(AFTER_FAULT),
            ) {
                match heard {
                    Heard::Sample(sample) => self.take_sample(&sample),
                    Heard::Over(_) => return,
                    Heard::Event(_) | Heard::Fault(_) => {}
                }
            }
        }
        self.stream_after_fault(0);
        let mut kept = Vec::new();
        let mut count = 1;
        while kept.len() < usize::from(count) {
            let index = kept.len() as u16;
            let Ok(Report::Flight(flight)) = self.link.ask(Request::ReadFlight { index }) else {
                break;
            };
            count = flight.count;
            if count > 0 {
                kept.push(self.message(&flight.sample));
            }
        }
        self.recorder.fill_flight(kept);
    }

    /// Samples in a frame.
    fn batch(&self) -> u8 {
        // Above 1 kHz samples go in batches, or the line would be too slow.
        if self.schedule.sample_time_s < 0.9e-3 && self.loop_mode == LoopMode::Device {
            8
        } else {
            1
        }
    }

    /// The line or the device is gone: the log keeps what there is.
    fn give_up(&mut self, error: &SerialError) {
        match error {
            SerialError::Link(LinkError::Faulted(report)) => {
                self.ends(Ended::DeviceFault(*report), "fault");
            }
            SerialError::Link(error) => self.ends(Ended::LinkLost(*error), "link"),
            // What opening can meet; this port was open.
            _ => self.ends(Ended::LinkLost(LinkError::Gone), "link"),
        }
    }
}

/// A start that this side of the link refuses, as the device would.
fn blow(refused: StartRefused) -> SerialError {
    SerialError::Link(LinkError::Refused {
        request: "start",
        refusal: Refusal::ForceNotSmall {
            wanted_n: refused.wanted_n as f32,
            allowed_n: refused.allowed_n as f32,
        },
    })
}

/// Waits until the device tells, by its keep-alives, that it is idle: its force has fallen to zero.
fn waits_for_rest(link: &SerialLink) -> bool {
    /// Longer than any ramp at a rate limit that is one.
    const PATIENCE: Duration = Duration::from_secs(2);
    let began = Instant::now();
    while link.status().state != State::Idle && began.elapsed() < PATIENCE {
        let _ = link.measure_round_trip(Duration::from_millis(20));
    }
    link.status().state == State::Idle
}

/// What only the connected device can tell.
fn describe(link: &SerialLink, device: &RemoteDevice, metadata: &mut BTreeMap<String, String>) {
    let [major, minor, patch] = link.hello().firmware;
    let mut add = |key: &str, value: String| metadata.insert(key.to_owned(), value);
    add("board", link.capabilities().board().to_owned());
    add("firmware", format!("{major}.{minor}.{patch}"));
    add("loop", loop_name(device.loop_mode).to_owned());
    add(
        "watchdog_s",
        (f64::from(device.watchdog_ms) * 1e-3).to_string(),
    );
}

const fn loop_name(loop_mode: LoopMode) -> &'static str {
    match loop_mode {
        LoopMode::Device => "device",
        LoopMode::Host => "host",
    }
}

fn summarise(
    link: &SerialLink,
    loop_mode: LoopMode,
    before: Statistics,
    after: Statistics,
    samples_lost: u64,
) -> LinkSummary {
    let [major, minor, patch] = link.hello().firmware;
    let report = link.report();
    let host = report.host;
    let round_trip = &report.round_trip_us;
    LinkSummary {
        board: link.capabilities().board().to_owned(),
        firmware: format!("{major}.{minor}.{patch}"),
        loop_mode: loop_name(loop_mode),
        samples_lost,
        samples_dropped: report.samples_dropped,
        samples_dropped_on_device: after.samples_dropped - before.samples_dropped,
        stale_forces: after.stale_forces - before.stale_forces,
        forces_dropped: report.forces_dropped,
        overruns: after.overruns - before.overruns,
        tick_cycles_max: after.tick_cycles_max,
        from_device: FrameCounts {
            sent: after.sent - before.sent,
            received: host.received,
            corrupt: host.corrupt + host.oversize + host.foreign,
            lost: host.lost,
            duplicate: host.duplicate,
            late: host.late,
        },
        to_device: FrameCounts {
            sent: host.sent,
            received: after.received - before.received,
            corrupt: after.corrupt + after.oversize + after.foreign
                - before.corrupt
                - before.oversize
                - before.foreign,
            lost: after.lost - before.lost,
            duplicate: after.duplicate - before.duplicate,
            late: after.late - before.late,
        },
        retries: host.retries,
        round_trip_us: [
            round_trip.value_at_quantile(0.5),
            round_trip.value_at_quantile(0.99),
            round_trip.max(),
        ],
    }
}

/// The summary as the metadata of a log.
fn flat(summary: &LinkSummary) -> BTreeMap<String, String> {
    // A structure of numbers and words always becomes JSON.
    let json = serde_json::to_value(summary).unwrap_or_default();
    let mut flat = BTreeMap::new();
    for (key, value) in json.as_object().into_iter().flatten() {
        match value.as_object() {
            Some(inner) => {
                for (name, value) in inner {
                    flat.insert(format!("{key}.{name}"), value.to_string());
                }
            }
            None => {
                let text = value
                    .as_str()
                    .map_or_else(|| value.to_string(), str::to_owned);
                flat.insert(key.clone(), text);
            }
        }
    }
    flat
}

/// The device, as on the command line.
#[must_use]
pub fn device_name(device: Option<&RemoteDevice>) -> String {
    device.map_or_else(|| "sim".to_owned(), |device| device.name.to_string())
}

/// A simulated device without a wall to be felt: what a drive of the rig becomes on a device.
#[must_use]
pub fn indentation(compliant: bool, depth_m: f64, ramp_time_s: f64) -> Simulation {
    Simulation {
        kind: if compliant {
            SimulationKind::CompliantIndentation
        } else {
            SimulationKind::RigidIndentation
        },
        depth_m: depth_m as f32,
        ramp_time_s: ramp_time_s as f32,
        ..Simulation::TESTBED
    }
}

/// A constant push on the testbed's mass.
#[must_use]
pub fn push(push_n: f64) -> Simulation {
    Simulation {
        push_n: push_n as f32,
        ..Simulation::TESTBED
    }
}
