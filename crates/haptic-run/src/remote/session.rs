//! A configured device: arm, start, listen or control, let go, and close the log.

use crate::{
    conduct::{close, tell_end},
    fault_recorder::AFTER,
    folder::OutputFolder,
    link_summary::LinkSummary,
    ran::Ran,
    record::RunRecord,
    recorder::{Recorded, Recorder},
    remote::{
        RemoteDevice,
        partner::{Partner, Side},
        summary::summarise,
    },
    schedule::Schedule,
    supervisor::Supervisor,
};
use fracdiff::Real;
use haptic_document::Failure;
use haptic_link::{
    EventKind, FaultReport, LoopMode, Refusal, Request, Sample, Start, State, Statistics,
};
use haptic_log::record::{RecordError, StartTime};
use haptic_loop::{
    Controller, Device, Environment, LoopSample as Tick, Reading, SafeForce, StartRefused, Tap,
    realtime::{Moment, RaisedThread},
};
use haptic_message::{DRIVE_END, END, EventMessage, TickMessage, flaw::LATE_FORCE};
use haptic_remote::{
    LinkError, Patience,
    serial::{DeviceMessage, SerialError, SerialLink},
};
use haptic_trial::{
    ending::{Ending, MotorPush},
    flat::flat,
    preflight::Findings,
    sensor_offset::{OFFSET_SAMPLES, SensorOffset},
    tick::{TickRecord, by_device, by_loop, per_axis, sensed_by_device},
};
use nalgebra::SVector;
use std::{
    collections::BTreeMap,
    sync::atomic::{AtomicBool, Ordering},
    time::{Duration, SystemTime},
};

/// Nothing for so long in the middle of a run is the end of it.
const SILENCE: Duration = Duration::from_secs(2);
/// Longest silence after a fault in which the rest is still waited for.
const AFTER_FAULT: Duration = Duration::from_millis(200);

/// A device that is configured and judged, and has no log yet.
pub(super) struct Ready<'a, M> {
    pub link: SerialLink,
    pub before: Statistics,
    pub device: &'a RemoteDevice,
    pub schedule: Schedule,
    pub start: haptic_trial::samples::RunStart,
    /// Ticks in which its force rises.
    pub rise_ticks: u64,
    /// Log values at a time, s, that are known without the device.
    pub blank: &'a (dyn Fn(f64) -> M + Sync),
    pub metadata: BTreeMap<String, String>,
    pub found: Option<Findings>,
    /// Push of a motor into its law.
    pub push: Option<MotorPush>,
    /// Taps of its motor; `None` without them.
    pub tap: Option<Tap<f64>>,
    pub force_limit_n: f64,
    /// The offset of its force sensor is measured before it is armed.
    pub tares: bool,
    /// Set to stop the run.
    pub stop: &'a AtomicBool,
}

/// A device that is configured, armed by nobody yet, and the log of what is to come.
pub(super) struct HostSession<'a, M, const D: usize> {
    pub ready: Ready<'a, M>,
    pub recorder: Recorder,
    pub record: RunRecord,
    pub samples_lost: u64,
    pub next_tick: u64,
    /// The device has said that the run is over, or its newest sample that there is no force any more.
    pub over: bool,
    /// The device does not answer.
    pub deaf: bool,
    /// The law that a motor pushes into has swung.
    pub swung: bool,
    /// The device at the other side of a contact, if there is one.
    pub partner: Option<Partner<'a>>,
    /// Samples before the time is known from which a run with a partner counts.
    pub pending: Vec<M>,
}

impl<M: TickRecord, const D: usize> HostSession<'_, M, D> {
    /// Runs to its end, whatever that is.
    pub(super) fn conduct<F: Real, E: Environment<F, D>>(
        &mut self,
        controller: &mut Controller<F, D, E>,
        steers: &mut impl Steers<F, E, D>,
        supervisor: Supervisor<'_>,
    ) {
        let ended = match self.ready.device.loop_mode {
            LoopMode::Device => self.listen(supervisor),
            LoopMode::Host => self.control(controller, steers, supervisor),
        };
        // Before this one is heard out.
        self.partner.iter().for_each(Partner::leaves);
        if let Err(error) = &ended {
            self.give_up(error);
        }
        if ended.is_err() && self.partner.is_some() {
            // Its keep-alives would go on until both sides are over. One that does not hear this lets go without them.
            let _ = self.ready.link.disarm();
        }
        self.after_fault();
        self.record.board_lost = self.ready.link.lost_board();
        if let (None, Some(trouble)) = (&self.record.board_lost, self.ready.link.trouble()) {
            (supervisor.warn)(&trouble.words);
        }
    }

    /// Asks the device what it counted, lets it go, and closes the log.
    pub(super) fn finish(self, folder: OutputFolder) -> Result<Ran, Failure> {
        let found = self.ready.found;
        let (record, recorder, let_go) = self.let_go();
        let recorded = close(recorder, &record, let_go)?;
        let mut ran = Ran::of(record, recorded, folder);
        match found {
            Some(Findings::Loop(verdict)) => ran.preflight = Some(verdict),
            Some(Findings::Drive(verdict)) => ran.drive = Some(verdict),
            None => {}
        }
        Ok(ran)
    }

    /// Keeps a report in the log.
    pub(super) fn note(&mut self, name: &str, report: &impl serde::Serialize) {
        self.recorder.metadata(name, flat(report, "", "."));
    }

    /// Finishes a drive, whose samples are in the log of the tissue's device.
    pub(super) fn finish_drive(self) -> (RunRecord, Result<Recorded, RecordError>) {
        let (record, recorder, _) = self.let_go();
        (record, recorder.finish())
    }

    /// The record, the log that is still to be closed, and true if the force is known to be zero.
    fn let_go(mut self) -> (RunRecord, Recorder, bool) {
        self.count_missing_fault();
        // Only a device that has let go answers so; its force falls within its own stop time.
        let let_go =
            self.record.ended == Some(Ending::LogStopped) && waits_for_rest(&self.ready.link);
        // A device that is gone cannot be asked.
        let asked = (!self.deaf)
            .then(|| self.ready.link.statistics().ok())
            .flatten();
        let counted = asked.map(|after| after.since(&self.ready.before));
        let lost = self.samples_lost;
        let mut summary = summarise(&self.ready.link, self.ready.device, counted, lost);
        // A sample without room here is missing by its number too.
        summary.samples_lost = lost.saturating_sub(summary.samples_dropped);
        summary.tap = self.ready.tap;
        drop(self.ready.link);
        let (record, recorder) = (&mut self.record, &mut self.recorder);
        record.dropped = recorder.dropped() + lost;
        record.missed_deadlines = u64::from(summary.overruns) + u64::from(summary.stale_forces);
        let is_drive = self.partner.as_ref().is_some_and(Partner::is_drive);
        let (link, end) = if is_drive {
            (LinkSummary::OF_DRIVE, DRIVE_END)
        } else {
            ("link", END)
        };
        recorder.metadata(link, flat(&summary, "", "."));
        record.link = Some(summary);
        let planned = match &self.partner {
            Some(partner)
                if self.ready.schedule.samples == u64::MAX
                    || is_drive && record.ended.is_some() =>
            {
                partner.samples
            }
            Some(_) | None => self.ready.schedule.samples,
        };
        let ended = record.end(planned, self.next_tick);
        recorder.metadata(end, ended.metadata());
        (self.record, self.recorder, let_go)
    }

    /// The offset of the force sensor of a device by what it shows idle; false if its handle is not still for so long.
    fn sense_offset(&mut self) -> Result<bool, SerialError> {
        /// Samples in which a handle has to be still for a while.
        const PATIENCE: u32 = 10 * OFFSET_SAMPLES;
        let link = &mut self.ready.link;
        if !self.ready.tares || link.capabilities().sensed_force_max_n <= 0.0 {
            return Ok(true);
        }
        link.stream(1, 1)?;
        let (sensor, mut samples) = (&mut self.record.sensor, 0);
        let mut patience = link.patience(SILENCE);
        while sensor.offset == SensorOffset::Measuring
            && samples < PATIENCE
            && !link.is_silent(&mut patience)
            && !link.is_stopped()
        {
            match link.hear(AFTER_FAULT) {
                Some(DeviceMessage::Sample(sample)) => {
                    samples += 1;
                    sensor.take_off(&mut by_device(TickMessage::at_rest(D), &sample, 0.0));
                }
                Some(DeviceMessage::Event(_)) => {}
                // A device that is silent, or gone, says so when it is armed.
                Some(DeviceMessage::Fault(_) | DeviceMessage::Over(_)) | None => break,
            }
        }
        link.stream(0, 1)?;
        Ok(samples < PATIENCE || sensor.offset != SensorOffset::Measuring)
    }

    /// Arms and starts; false if the partner left before, or somebody asked to stop.
    fn start(&mut self, ticks: u32, supervisor: Supervisor<'_>) -> Result<bool, SerialError> {
        if !self.sense_offset()? {
            self.ends(Ending::Untared);
            return Ok(false);
        }
        self.ready.link.arm(self.ready.device.watchdog())?;
        if let Some(partner) = &self.partner
            && !partner.waits(&self.ready.link, supervisor.stop)
        {
            self.ends(if supervisor.stop.load(Ordering::Relaxed) {
                Ending::Interrupted
            } else {
                Ending::OtherLeft
            });
            return Ok(false);
        }
        let asked = SystemTime::now();
        self.ready.link.start(Start {
            run: 1,
            ticks,
            every: 1,
            batch: self.batch(),
        })?;
        let started = StartTime::between(asked, SystemTime::now());
        // A recorder that has ended is seen at the first sample.
        let _ = self.recorder.starts_at(started);
        Ok(true)
    }

    /// A run in the device's loop: everything is decided there.
    fn listen(&mut self, supervisor: Supervisor<'_>) -> Result<(), SerialError> {
        // A run of 2³² ticks and more is stopped from here, and so is that of a tissue whose drive sends its start.
        let ticks = u32::try_from(self.ready.schedule.samples).unwrap_or(0);
        if !self.start(ticks, supervisor)? {
            return self.ready.link.disarm();
        }
        let mut most = SILENCE;
        let mut patience = self.ready.link.patience(most);
        loop {
            let before = self.next_tick;
            let heard = self.hear_or_stop(&mut patience, supervisor)?;
            let mut is_silent = heard.is_none();
            match heard {
                Some(DeviceMessage::Sample(sample)) => {
                    if !self.take_sample(&sample) {
                        break;
                    }
                    (supervisor.progress)(self.counted());
                }
                Some(DeviceMessage::Event(event)) => match event.kind {
                    EventKind::Finished | EventKind::Stopped | EventKind::Disarmed => {
                        self.over = true;
                        // Any other end is one that nobody here has asked for.
                        if let Some(partner) = &self.partner
                            && partner.is_drive()
                            && event.kind == EventKind::Finished
                        {
                            partner.done();
                        }
                        let asked = self.partner.as_ref().is_some_and(Partner::is_done);
                        if event.kind != EventKind::Finished
                            && self.record.ended.is_none()
                            && !asked
                        {
                            return Err(LinkError::Disarmed.into());
                        }
                        break;
                    }
                    EventKind::Configured
                    | EventKind::Armed
                    | EventKind::Started
                    | EventKind::Withdrawn => {}
                },
                Some(DeviceMessage::Fault(report)) => {
                    // Also of one that was to stop, and was on its way to zero: nothing else would end it.
                    self.ends_unasked(Ending::DeviceFault(report));
                    // Until the ramp is over its samples come by themselves; for those behind it, ask.
                    self.stream_after_fault(1);
                    most = AFTER_FAULT;
                    patience = self.ready.link.patience(most);
                }
                Some(DeviceMessage::Over(error)) => return Err(error.into()),
                None => {}
            }
            // Only the next sample of the run begins a patience anew, whatever else comes.
            if self.next_tick > before {
                patience = self.ready.link.patience(most);
            } else {
                is_silent |= self.ready.link.is_silent(&mut patience);
            }
            match self.record.ended {
                Some(ended) if is_silent && ended.is_fault() => break,
                _ if is_silent => return Err(self.ready.link.silent(SILENCE).into()),
                _ => {}
            }
            if self.has_all_after_fault() {
                break;
            }
            if self.record.ended == Some(Ending::LogStopped) {
                self.ready.link.stop()?;
                break;
            }
        }
        self.count_missing_end();
        self.ready.link.disarm()
    }

    /// The device's next message; `None` once that patience is over. A stop of the run is noticed at once, whatever arrives.
    fn hear_or_stop(
        &mut self,
        patience: &mut Patience,
        supervisor: Supervisor<'_>,
    ) -> Result<Option<DeviceMessage>, SerialError> {
        /// A pause in which a stop is looked for.
        const PAUSE: Duration = Duration::from_millis(20);
        loop {
            if self.record.ended.is_none() && supervisor.stop.load(Ordering::Relaxed) {
                self.ends(Ending::Interrupted);
                self.ready.link.stop()?;
            }
            if let (None, Some(left)) = (self.record.ended, self.unfit_to_go_on()) {
                self.ends(left);
                self.ready.link.stop()?;
            }
            let pause = patience.left().min(PAUSE);
            if self.lets_go() {
                self.ready.link.stop()?;
                self.partner.iter().for_each(Partner::done);
            }
            if let Some(heard) = self.ready.link.hear(pause) {
                self.partner.iter().for_each(Partner::hears);
                return Ok(Some(heard));
            }
            if self.ready.link.is_silent(patience) {
                return Ok(None);
            }
        }
    }

    /// A run with the loop closed here, until the samples are done and the force is zero.
    pub(super) fn control<F: Real, E: Environment<F, D>>(
        &mut self,
        controller: &mut Controller<F, D, E>,
        steers: &mut impl Steers<F, E, D>,
        supervisor: Supervisor<'_>,
    ) -> Result<(), SerialError> {
        let thread = RaisedThread::new(self.ready.schedule.thread_options());
        self.record.raised(&thread);
        if !self.start(0, supervisor)? {
            return self.ready.link.disarm();
        }
        let mut engaged = controller.engage(&mut *self);
        let (mut stops, mut resting) = (false, 0);
        loop {
            // Waiting for the sample is no part of the tick.
            let reading = engaged.read()?;
            if engaged.device().next_tick == 0 {
                // The way from zero to where the device stands is no motion of it.
                engaged.controller_mut().settle(&reading);
                engaged.controller().may_start(&reading).map_err(blow)?;
            }
            let began = Moment::now();
            let done = engaged.tick_reading(reading)?;
            let took = began.elapsed().as_nanos() as u64;
            let session = engaged.device_mut();
            session.record.tick_ns.record(took);
            session.partner.iter().for_each(Partner::hears);
            let tick = reading.tick;
            session.dated(tick, session.ready.link.newest().time_us);
            let counted = session.counts(tick);
            session.gap(tick);
            let message = session.controlled(&done);
            session.keep(message, counted);
            let steered = steers.steer(engaged.controller_mut(), &done);
            let session = engaged.device_mut();
            session.steered(steered, tick);
            (supervisor.progress)(session.counted());
            let waits = !session.lets_go() && session.is_pushed();
            if session.record.ended.is_none() {
                if let Some(fault) = done.fault {
                    session.ends(Ending::Fault(fault));
                } else if supervisor.stop.load(Ordering::Relaxed) {
                    session.ends(Ending::Interrupted);
                } else if let Some(left) = session.unfit_to_go_on() {
                    session.ends(left);
                }
            }
            let planned = session.ready.schedule.samples;
            stops |= session.record.ended.is_some() || tick + 1 >= planned && !waits;
            if stops {
                engaged.controller_mut().stop();
                let session = engaged.device_mut();
                session.partner.iter().for_each(Partner::done);
                resting += u64::from(engaged.controller().safety().is_at_rest());
                let session = engaged.device_mut();
                session.over = resting > 0 && session.applies_none();
                let late = resting > AFTER;
                if (session.over || late) && session.recorder.has_aftermath() {
                    break;
                }
            }
        }
        drop(engaged);
        self.ready.link.disarm()
    }

    /// A tick of the loop here, with what the device reports of it.
    fn controlled<F: Real>(&self, done: &Tick<F, D>) -> M {
        let link = &self.ready.link;
        let newest = link.newest().axes.first();
        let (newest_limiters, newest_flaws) =
            newest.map_or((0, 0), |axis| (axis.limiters, axis.flaws));
        let mut message = (self.ready.blank)(done.reading.time_s - self.start_s());
        let logged = message.logged_mut();
        *logged = TickMessage {
            applied_force_n: per_axis(&applied_n::<D>(link.newest())),
            sensed_force_n: sensed_by_device(link.newest()),
            // The device limits what it is sent once more.
            limiters: done.limiters.bits() | newest_limiters,
            flaws: newest_flaws | if link.follows() { 0 } else { LATE_FORCE },
            ..by_loop(*logged, done, None)
        };
        logged.time_s += self.shift_s();
        message
    }

    /// True if there was no force in the newest sample.
    fn applies_none(&self) -> bool {
        let applied_n: SVector<f64, D> = applied_n(self.ready.link.newest());
        applied_n.iter().all(|&force_n| force_n == 0.0)
    }

    /// Does what whoever steers wants after this tick.
    fn steered(&mut self, steered: Steered, tick: u64) {
        match steered {
            // A recorder that has ended is seen at the next tick.
            Steered::On(event) => drop(event.map(|event| self.recorder.tell(event))),
            Steered::Over => {
                let planned = &mut self.ready.schedule.samples;
                *planned = (*planned).min(tick + 1);
            }
        }
    }

    /// Asks for every n-th tick while nothing runs; 0 for none.
    fn stream_after_fault(&mut self, every: u16) {
        let batch = self.batch();
        // A device that does not answer has nothing more to send.
        self.deaf |= !self.deaf
            && self
                .ready
                .link
                .ask(Request::Stream { every, batch })
                .is_err();
    }

    /// After a fault on the device: hears what follows it, and reads the device's own flight recorder, whose
    /// samples fill in for those that did not come.
    fn after_fault(&mut self) {
        if !matches!(self.record.ended, Some(Ending::DeviceFault(_))) {
            return;
        }
        if !self.has_all_after_fault() {
            self.stream_after_fault(1);
            let mut patience = self.ready.link.patience(SILENCE);
            while !self.has_all_after_fault() && !self.ready.link.is_silent(&mut patience) {
                let goes_on = match self.ready.link.hear(AFTER_FAULT) {
                    Some(DeviceMessage::Sample(sample)) => self.take_sample(&sample),
                    Some(DeviceMessage::Over(_)) => return,
                    Some(DeviceMessage::Event(_) | DeviceMessage::Fault(_)) => true,
                    None => false,
                };
                if !goes_on {
                    break;
                }
            }
        }
        self.stream_after_fault(0);
        if self.deaf {
            return;
        }
        let kept = self.ready.link.flight().map_while(|sample| {
            let mut logged = *self.message(&sample.ok()?)?.logged();
            let sensed = logged.sensed_force_n.take();
            logged.sensed_force_n = sensed.and_then(|sensed| self.record.sensor.less(sensed));
            Some(logged)
        });
        self.recorder.fill_fault_recorder(kept.collect::<Vec<_>>());
    }

    fn batch(&self) -> u8 {
        // Above 1 kHz samples go in batches, or the line would be too slow.
        if self.ready.schedule.sample_time_s < 0.9e-3
            && self.ready.device.loop_mode == LoopMode::Device
        {
            8
        } else {
            1
        }
    }
}

/// Wish of whoever steers a loop, after a tick.
#[derive(Debug)]
pub enum Steered {
    /// It goes on; the log says this.
    On(Option<EventMessage>),
    /// This was the last tick of the run.
    Over,
}

/// Whoever may change the law of a loop here between its ticks.
pub trait Steers<F: Real, E: Environment<F, D>, const D: usize> {
    /// Sees a tick that is done, and may change the law before the next.
    fn steer(&mut self, controller: &mut Controller<F, D, E>, sample: &Tick<F, D>) -> Steered;
}

/// Nobody: the law stays as it is.
impl<F: Real, E: Environment<F, D>, const D: usize> Steers<F, E, D> for () {
    fn steer(&mut self, _: &mut Controller<F, D, E>, _: &Tick<F, D>) -> Steered {
        Steered::On(None)
    }
}

/// A loop here reads and writes the link.
impl<F: Real, M, const D: usize> Device<F, D> for HostSession<'_, M, D> {
    type Error = SerialError;

    fn read(&mut self) -> Result<Reading<F, D>, SerialError> {
        self.ready.link.read_or_stop(self.ready.stop)
    }

    fn write(&mut self, force: SafeForce<F, D>) -> Result<(), SerialError> {
        self.ready.link.write(force)
    }

    fn let_go(&mut self) {
        Device::<F, D>::let_go(&mut self.ready.link);
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

/// Waits until the device's keep-alives report that it is idle: its force has fallen to zero.
fn waits_for_rest(link: &SerialLink) -> bool {
    link.wait_for_rest() && link.status().state == State::Idle
}

/// Force that the device made in a sample, N.
fn applied_n<const D: usize>(sample: &Sample) -> SVector<f64, D> {
    let force_n = |axis: usize| sample.axes.get(axis).map_or(0.0, |axis| axis.force_n);
    SVector::from_fn(|axis, _| f64::from(force_n(axis)))
}

/// Sample of what is known without the device: where the indenter is to be, m; the rest is not a number.
pub fn blank(reference_m: f64) -> TickMessage {
    TickMessage {
        reference_m: reference_m.into(),
        ..TickMessage::unknown(1)
    }
}

impl<M: TickRecord, const D: usize> HostSession<'_, M, D> {
    /// Processes a sample of the device. One with another number of axes is dropped, and its tick counts as missing. False for a sample after
    /// all those that a device sends of a run that its fault has ended: it came only on request.
    pub(super) fn take_sample(&mut self, sample: &Sample) -> bool {
        let tick = u64::from(sample.tick);
        if self.next_tick <= tick {
            self.dated(tick, sample.time_us);
        }
        let Some(message) = self.message(sample) else {
            return true;
        };
        if let Some(last) = self.last_after_fault() {
            let falls = !self.record.has_fallen() && message.kept().applied_force_n != 0.0;
            // The next tick leaves no gap in which the device was not asked.
            if tick > last && tick != self.next_tick && !falls {
                self.came_until(last);
                return false;
            }
        }
        let counted = self.counts(tick);
        self.gap(tick);
        self.keep(message, counted);
        true
    }

    /// Why there is no partner any more, if it has left.
    fn partner_left(&mut self) -> Option<Ending> {
        self.partner.as_mut().and_then(Partner::left)
    }

    /// Gives a partner the time of this tick by the device's own clock, and gets from it the start of the run.
    fn dated(&mut self, tick: u64, time_us: u32) {
        /// Ticks from one look at the clocks to the next.
        const LOOK: u64 = 1024;
        let Some(partner) = &mut self.partner else {
            return;
        };
        let time_s = tick as f64 * self.ready.schedule.sample_time_s;
        let is_first = !partner.has_begun();
        if is_first {
            partner.began(time_us, 1e6 * time_s);
        }
        match partner.side {
            Side::Drive if is_first || tick.is_multiple_of(LOOK) => partner.align(time_s),
            Side::Drive => {}
            Side::Tissue if tick >= partner.rise_ticks => partner.risen(),
            Side::Tissue => {}
        }
    }

    /// The drive has begun: what came before that is its approach, and the rest counts.
    fn begin(&mut self) {
        let begun = self.partner.as_ref().and_then(|partner| {
            let is_tissue = !partner.is_drive();
            partner
                .begun_s()
                .filter(|_| is_tissue)
                .map(|begun_s| (begun_s, partner.samples))
        });
        if let (Some((begun_s, samples)), false) = (begun, self.has_begun()) {
            self.record.start =
                haptic_trial::samples::RunStart::from(begun_s, self.ready.schedule.sample_time_s);
            self.ready.schedule.samples = self.record.start.tick + samples;
            for message in std::mem::take(&mut self.pending) {
                self.place(&message);
            }
        }
    }

    /// Puts a sample where its tick belongs, however late it came: before the beginning of a run with a partner, in the run, or behind it.
    fn place(&mut self, message: &M) {
        let sample = message.kept();
        if sample.tick < self.record.start.tick && self.partner.is_some() {
            self.record.approach.push(sample);
        } else if sample.tick < self.ready.schedule.samples {
            self.record.push(message);
        } else {
            self.record.falls(message);
        }
    }

    /// False as long as nobody knows when a run with a partner begins to count.
    const fn has_begun(&self) -> bool {
        self.ready.schedule.samples < u64::MAX
    }

    /// True if a partner pushes it, which is to let go first.
    fn is_pushed(&self) -> bool {
        let partner = self.partner.as_ref();
        partner.is_some_and(|partner| !partner.is_drive())
    }

    /// Reports to a partner what is made, and ends a drive that may let go; true if this device may: neither is pushed by the other then.
    fn lets_go(&mut self) -> bool {
        let (made, samples) = (self.next_tick, &mut self.ready.schedule.samples);
        let Some(partner) = self
            .partner
            .as_ref()
            .filter(|_| self.record.ended.is_none())
        else {
            return false;
        };
        partner.makes(made, *samples);
        let may = partner.may_let_go(made);
        if may && partner.is_drive() {
            *samples = made;
        }
        may
    }

    /// True if this tick may be part of the result: none from a fault of the device on, though nobody knows which yet.
    fn counts(&self, tick: u64) -> bool {
        self.record.ended.is_none() && !has_faulted(self.ready.link.fault_tick(), tick)
    }

    /// Last tick after a fault of the device that the log needs. The device sends those before it unasked.
    fn last_after_fault(&self) -> Option<u64> {
        match self.record.ended {
            Some(Ending::DeviceFault(report)) => Some(u64::from(report.tick) + AFTER),
            _ => None,
        }
    }

    /// True if all is there that follows a fault of the device.
    fn has_all_after_fault(&self) -> bool {
        self.recorder.flight().is_full() && self.record.has_fallen()
    }

    /// A sample of the device as the log has it.
    fn message(&self, sample: &Sample) -> Option<M> {
        if sample.axes.len() != D {
            return None;
        }
        let own_s = f64::from(sample.tick) * self.ready.schedule.sample_time_s;
        let time_s = own_s + self.shift_s();
        let mut message = (self.ready.blank)(own_s - self.start_s());
        let logged = message.logged_mut();
        *logged = by_device(*logged, sample, time_s);
        Some(message)
    }

    /// Seconds from the device's own time to that of the log.
    fn shift_s(&self) -> f64 {
        self.partner.as_ref().map_or(0.0, |partner| partner.shift_s)
    }

    /// Ticks so far that count.
    const fn counted(&self) -> u64 {
        self.next_tick.saturating_sub(self.record.start.tick)
    }

    /// When the run begins to count, s.
    fn start_s(&self) -> f64 {
        self.record.start.time_s()
    }

    /// Counts what is missing before this tick.
    fn gap(&mut self, tick: u64) {
        self.came_until(tick);
        self.next_tick = tick + 1;
    }

    /// Counts what did not come of the ticks before this one.
    fn came_until(&mut self, tick: u64) {
        // Samples after a fault or the last tick are no part of the result, but of the log: those that are missing
        // there are lost.
        if tick > self.next_tick {
            let missing = tick - self.next_tick;
            self.samples_lost += missing;
            let time_s = tick as f64 * self.ready.schedule.sample_time_s + self.shift_s();
            let text = format!("{missing} samples before tick {tick} are missing");
            // A recorder that has ended is seen when it is closed.
            let _ = self.recorder.event(time_s, "lost", text);
            self.next_tick = tick;
        }
    }

    /// A run that finished, but whose last samples did not come.
    fn count_missing_end(&mut self) {
        if self.record.ended.is_none() && self.has_begun() {
            self.came_until(self.ready.schedule.samples);
        }
    }

    /// A fault on the device whose tick did not come, nor any later one.
    fn count_missing_fault(&mut self) {
        if let Some(Ending::DeviceFault(report)) = self.record.ended {
            let made = u64::from(report.tick) + 1;
            self.came_until(made.min(self.ready.schedule.samples));
        }
    }

    fn keep(&mut self, mut message: M, counted: bool) {
        self.record.sensor.take_off(message.logged_mut());
        let (force_n, limit_n) = (message.kept().applied_force_n, self.ready.force_limit_n);
        let swings = |push: MotorPush| push.swings(force_n, limit_n, self.ready.tap.is_some());
        self.swung |= self.ready.push.is_some_and(swings);
        let logged = self.recorder.tick(message.logged());
        if let Some(partner) = &self.partner {
            partner.opposes(message.kept().reaction_n());
            self.begin();
        }
        if counted && !self.has_begun() {
            self.pending.push(message);
        } else if counted {
            self.place(&message);
        } else {
            self.record.push_after(&message);
        }
        if logged.is_err() && self.record.ended.is_none() {
            self.record.ended = Some(Ending::LogStopped);
            self.partner.iter().for_each(Partner::ends);
        }
    }

    /// Reason to end a run that could go on.
    fn unfit_to_go_on(&mut self) -> Option<Ending> {
        self.swung
            .then_some(Ending::Swing)
            .or_else(|| self.partner_left())
    }

    fn ends(&mut self, ended: Ending) {
        if self.record.ended.is_none() {
            self.record.ended = Some(ended);
            self.partner.iter().for_each(Partner::ends);
            let tick = if let Ending::DeviceFault(report) = ended {
                u64::from(report.tick)
            } else if let Ending::Impossible(what) = ended {
                u64::from(what.tick())
            } else {
                self.next_tick.saturating_sub(1)
            };
            let time_s =
                |tick: u64| tick as f64 * self.ready.schedule.sample_time_s + self.shift_s();
            let (at, event_s) = ((tick, time_s(tick)), time_s(self.next_tick));
            tell_end(&mut self.recorder, ended, self.record.lateness, at, event_s);
        }
    }
}

/// True from the first tick on that a fault affected.
fn has_faulted(fault_tick: Option<u32>, tick: u64) -> bool {
    fault_tick.is_some_and(|first| tick >= u64::from(first))
}

/// Time behind the watchdog time in which a device that hears nothing has let go.
const FALLEN: Duration = Duration::from_secs(2);

/// Last report of a device about a run.
enum Last {
    /// That the run is over, and its force zero.
    Over,
    Fault(FaultReport),
    Nothing,
}

impl<M: TickRecord, const D: usize> HostSession<'_, M, D> {
    /// The line or the device is gone, or does not answer: the log keeps what there is, and what still comes.
    fn give_up(&mut self, error: &SerialError) {
        let error = if let SerialError::Link(error) = error {
            *error
        } else {
            // Errors that only opening can meet; this port was open.
            LinkError::Gone
        };
        if let LinkError::Impossible(what) = error {
            self.keep_impossible();
            self.ends(Ending::Impossible(what));
            // The device was commanded to let go: record how the force falls.
            let _ = self.hear_out();
            return;
        }
        if matches!(error, LinkError::Withdrawn | LinkError::Disarmed) {
            self.over = true;
            self.ends(Ending::Stopped(error));
            return;
        }
        if let LinkError::NoAnswer { .. } = error {
            self.deaf = true;
            self.ready.link.give_up();
        }
        let unheard = matches!(
            error,
            LinkError::NoAnswer { .. }
                | LinkError::Gone
                | LinkError::Refused {
                    request: "stop" | "disarm",
                    ..
                }
        );
        let last = if let LinkError::Faulted(report) = error {
            Last::Fault(report)
        } else if unheard && self.may_run_on() {
            self.hear_out()
        } else {
            Last::Nothing
        };
        match last {
            Last::Over => {}
            Last::Fault(report) => self.ends_unasked(Ending::DeviceFault(report)),
            Last::Nothing => self.ends_unasked(Ending::LinkLost(error)),
        }
    }

    /// The sample that cannot be is in the log, as what it is, and no part of the result.
    fn keep_impossible(&mut self) {
        let sample = self.ready.link.impossible();
        let message = sample.and_then(|sample| self.message(sample));
        if let Some(message) = message {
            self.gap(message.logged().tick);
            // A recorder that has ended is seen when it is closed.
            let _ = self.recorder.tick(message.logged());
        }
    }

    /// True if a run began whose end is not known.
    fn may_run_on(&self) -> bool {
        let ended = self.record.ended;
        let asked = matches!(
            ended,
            None | Some(Ending::Interrupted | Ending::OtherLeft | Ending::Swing)
        );
        !self.over && self.next_tick > 0 && asked
    }

    /// The run ended so. One that was to be stopped, and was not known to be over, did not end because somebody asked for it.
    fn ends_unasked(&mut self, ended: Ending) {
        if let Some(asked @ (Ending::Interrupted | Ending::OtherLeft | Ending::Swing)) =
            self.record.ended
            && !self.over
        {
            self.record.stop_unheard = asked == Ending::Interrupted;
            self.record.ended = None;
        }
        self.ends(ended);
    }

    /// Takes what the device says of a run until that is over, or it is silent.
    fn hear_out(&mut self) -> Last {
        let most = self.ready.device.watchdog() + FALLEN;
        let mut patience = self.ready.link.patience(most);
        let mut pause = self.ready.link.patience(AFTER_FAULT);
        while !self.ready.link.is_silent(&mut patience) {
            let before = self.next_tick;
            match self.ready.link.hear(AFTER_FAULT) {
                Some(DeviceMessage::Sample(sample)) => {
                    self.take_sample(&sample);
                }
                Some(DeviceMessage::Event(event)) => match event.kind {
                    EventKind::Finished
                    | EventKind::Stopped
                    | EventKind::Disarmed
                    | EventKind::Withdrawn => return Last::Over,
                    EventKind::Configured | EventKind::Armed | EventKind::Started => {}
                },
                Some(DeviceMessage::Fault(report)) => return Last::Fault(report),
                Some(DeviceMessage::Over(_)) | None => break,
            }
            if self.next_tick > before {
                pause = self.ready.link.patience(AFTER_FAULT);
            } else if self.ready.link.is_silent(&mut pause) {
                break;
            }
        }
        Last::Nothing
    }
}

#[cfg(test)]
mod mad_line_tests;
#[cfg(test)]
mod tests;
