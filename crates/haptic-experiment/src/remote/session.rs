//! A run on a connected device: set, arm, start, listen or control, let go, and close the log.

use super::{
    RemoteDevice, RemoteLaw, configuration, keep_within, loop_name,
    summary::{flat, summarise},
};
use crate::device::{Warn, at_port, firmware_version};
use crate::failure::Failure;
use crate::flight::FaultSeen;
use crate::folder::{FolderRequest, OutputFolder};
use crate::kept::Record;
use crate::preflight::{Dynamics, MEASURED, Preflight, PreflightRequest, Verdict, delay_samples};
use crate::realtime::RealtimeOptions;
use crate::recorder::{Recorded, Recorder};
use crate::run::{Ended, Ran, Supervisor, log_stopped};
use crate::safety::GuardChoice;
use crate::schedule::{Pace, Schedule};
use fracdiff::Real;
use haptic_link::{
    EventKind, Field, Limits, LoopMode, Refusal, Report, Request, Sample, Scope, Start, State,
    Statistics,
};
use haptic_log::record::{END, StartTime, TickMessage};
use haptic_loop::realtime::{Fallback, RaisedThread};
use haptic_loop::{Controller, Environment, Fault, StartRefused};
use haptic_remote::LinkError;
use haptic_remote::serial::{Heard, SerialError, SerialLink};
use std::collections::BTreeMap;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant, SystemTime};

/// What is still to be heard after a fault, when nothing comes for so long.
const AFTER_FAULT: Duration = Duration::from_millis(200);

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
    fn prepare(mut self, supervisor: Supervisor<'_>) -> Result<HostSession<'a>, Failure> {
        let device = self.device;
        let mut link = device.name.connect(device.patience, supervisor.warn)?;
        let path = link.path().to_owned();
        let problem = |error: SerialError| match error.is_refusal() {
            true if error.is_about(Field::SimulationKind) => Failure::input_with_advice(
                error,
                "this board simulates no compliant contact, take `contact` = rigid",
            ),
            true => Failure::bad_input(error),
            false => at_port(&path, &error),
        };
        let (set, _) = link.configuration().map_err(problem)?;
        let can = link.capabilities();
        let mut configuration = configuration(device, &self.law, self.schedule, can, &set.limits)?;
        if let Some(text) = keep_within(&mut configuration, &set) {
            (supervisor.warn)(&text);
        }
        describe_limits(&configuration.limits, &mut self.metadata);
        link.set_for(configuration, &self.law.operator.1, Scope::Run)
            .map_err(problem)?;
        let before = link.statistics().map_err(problem)?;
        describe(&link, device, &mut self.metadata);
        let preflight = self.preflight(&link, supervisor.warn)?;
        match &preflight {
            Some(verdict) => verdict.describe(&mut self.metadata),
            None => {
                (self.metadata).insert("preflight".to_owned(), "skipped".to_owned());
            }
        }

        let folder = self.request.prepare()?;
        let log = folder.file("mcap");
        let live = supervisor.live_streams();
        self.metadata.extend(self.request.provenance.clone());
        let started = Recorder::start(&log, self.metadata, false, folder.overwrite(), live);
        let mut recorder = started.inspect_err(|_| folder.discard())?;
        recorder.roll_at(folder.roll_bytes());
        let mut record = Record::with_room_for(self.schedule.samples).map_err(Failure::Run)?;
        record.watchdog_ms = Some(device.watchdog_ms());
        if let Some(priority) = options(self.schedule).priority {
            record.not_realtime = link.raise(priority).err().map(|refusal| {
                let fallback = Fallback {
                    priority: Some((priority, refusal)),
                    ..Fallback::default()
                };
                fallback.to_string()
            });
        }
        Ok(HostSession {
            link,
            before,
            watchdog: Duration::from_millis(u64::from(device.watchdog_ms())),
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
    fn preflight(&self, link: &SerialLink, warn: Warn<'_>) -> Result<Option<Verdict>, Failure> {
        let Some(subject) = self.preflight else {
            return Ok(None);
        };
        let simulation = &self.law.simulation;
        let dynamics = if link.capabilities().simulated {
            Some(Dynamics {
                mass_kg: f64::from(simulation.mass_kg),
                damping_n_s_per_m: f64::from(simulation.damping_n_s_per_m),
                hand_stiffness_n_per_m: f64::from(simulation.hand_stiffness_n_per_m),
                delay_s: 0.0,
                current_lag_s: 0.0,
            })
        } else {
            self.wanted.dynamics
        };
        let Some(dynamics) = dynamics else {
            warn(
                "pre-flight: skipped, the mass and damping of the device are not known: give `device_mass_kg` \
                 and `device_damping_n_s_per_m`",
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
            warn(&warning);
        }
        Ok(Some(verdict))
    }
}

/// A device that is configured, armed by nobody yet, and the log of what is to come.
struct HostSession<'a> {
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

impl HostSession<'_> {
    /// Asks the device what it counted, lets it go, and closes the log.
    fn finish(mut self) -> Result<Ran, Failure> {
        self.count_missing_fault();
        let HostSession {
            link,
            before,
            loop_mode,
            folder,
            mut recorder,
            mut record,
            samples_lost,
            next_tick,
            schedule,
            preflight,
            ..
        } = self;
        // Only a device that has let go answers so; its force falls within its own stop time.
        let let_go = record.ended == Some(Ended::LogStopped) && waits_for_rest(&link);
        // A device that is gone cannot be asked.
        let after = link.statistics().unwrap_or(before);
        let mut summary = summarise(&link, loop_mode, after.since(&before), samples_lost);
        // A sample without room here is missing by its number too.
        summary.samples_lost = samples_lost.saturating_sub(summary.samples_dropped);
        drop(link);
        record.dropped = recorder.dropped() + samples_lost;
        record.missed_deadlines = u64::from(summary.overruns) + u64::from(summary.stale_forces);
        recorder.metadata("link", flat(&summary));
        record.link = Some(summary);
        recorder.metadata(END, record.end(schedule.samples, next_tick).metadata());
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
        let asked = SystemTime::now();
        self.link.start(Start {
            run: 1,
            ticks,
            every: 1,
            batch: self.batch(),
        })?;
        let started = StartTime::between(asked, SystemTime::now());
        // A recorder that has ended is seen at the first sample.
        let _ = self.recorder.starts_at(started);
        Ok(())
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
        self.came_until(tick);
        self.next_tick = tick + 1;
    }

    /// Counts what did not come of the ticks before this one.
    fn came_until(&mut self, tick: u64) {
        // What follows a fault or the last tick is no part of the result, but of the log: what is missing there
        // is lost.
        if tick > self.next_tick {
            let missing = tick - self.next_tick;
            self.samples_lost += missing;
            let time_s = tick as f64 * self.schedule.sample_time_s;
            let text = format!("{missing} samples before tick {tick} did not come");
            // A recorder that has ended is seen when it is closed.
            let _ = self.recorder.event(time_s, "lost", text);
            self.next_tick = tick;
        }
    }

    /// A run that finished, but whose last samples did not come.
    fn count_missing_end(&mut self) {
        if self.record.ended.is_none() {
            self.came_until(self.schedule.samples);
        }
    }

    /// A fault on the device whose tick did not come, nor any later one.
    fn count_missing_fault(&mut self) {
        if let Some(Ended::DeviceFault(report)) = self.record.ended {
            let made = u64::from(report.tick) + 1;
            self.came_until(made.min(self.schedule.samples));
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
            let _ = self
                .recorder
                .event(time_s, kind, ended.reason(self.record.watchdog_ms));
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

/// What is asked for the threads of a run.
const fn options(schedule: Schedule) -> RealtimeOptions {
    match schedule.pace {
        Pace::Realtime(options) => options,
        Pace::Virtual => RealtimeOptions::NORMAL,
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
    link.wait_for_rest() && link.status().state == State::Idle
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

/// What only the connected device can tell.
fn describe(link: &SerialLink, device: &RemoteDevice, metadata: &mut BTreeMap<String, String>) {
    let mut add = |key: &str, value: String| metadata.insert(key.to_owned(), value);
    add("board", link.capabilities().board().to_owned());
    add("firmware", firmware_version(link.hello()));
    add("loop", loop_name(device.loop_mode).to_owned());
    add(
        "watchdog_s",
        (f64::from(device.watchdog_ms()) * 1e-3).to_string(),
    );
}
