//! Runs of the device on the bench, followed by their samples.

use super::bench::{Bench, Broken, refusal};
use super::fall::Bounds;
use haptic_document::parameters::FORCE_LIMIT;
use haptic_link::{AXES_MAX, EventKind, FaultReport, Request, Sample};
use haptic_loop::realtime::Moment;
use haptic_loop::{Fault, Limiters};
use haptic_remote::serial::DeviceMessage;
use haptic_remote::{LinkError, Tick};
use std::time::Duration;

/// Largest force that is asked for, in limits.
pub(super) const ASKED: f32 = 3.0;
/// Time to wait for something to be heard, or to be asked for.
const LOOK: Duration = Duration::from_millis(20);
/// Messages that are taken at once before the newest sample is answered.
const AT_ONCE: usize = 1000;
/// Silence after which a run has ended.
const SILENCE: Duration = Duration::from_secs(2);
/// Faults of a host that was silent or late. No trial sends a stale force on purpose.
pub(super) const LATE: &[Fault] = &[Fault::HostSilent, Fault::StaleForce];
/// Ticks after a fault that a device sends unasked.
const AFTERMATH_TICKS: u32 = 100;

pub(super) struct Trial<S, U> {
    /// Silence of the host that is a fault, ms.
    pub(super) watchdog_ms: u16,
    /// Force that answers a sample, N, and how many were sent before; `None` for silence.
    pub(super) say: S,
    pub(super) until: U,
}

/// Remaining reports of a device about a run that is over.
enum Rest {
    Awaited,
    /// Complete once the device has made this many ticks.
    Until(u32),
    Came,
}

/// Force that changes its sign: `share` of the limit, and one in 10⁵ more with each that was sent before, so that each is
/// known by its number.
pub(super) fn alternating(bounds: &Bounds, tick: u32, sent: usize, share: f32) -> f32 {
    let sign = if (tick / bounds.half_period_ticks()).is_multiple_of(2) {
        1.0
    } else {
        -1.0
    };
    let more = 1.0 + 1e-5 * (sent % 5000) as f32;
    // Whatever share: never more than what a device without limits may make.
    sign * bounds.limits.force_n * (share * more).min(ASKED)
}

/// A sample as a trial of one axis sees it: the position of that axis, and the force on all, with the sign of its own. `None` for one of other
/// axes.
pub(super) fn seen(sample: &Sample, axis: usize) -> Option<Tick> {
    let mut driven = *sample.axes.get(axis)?;
    if sample.axes.len() > 1 {
        let squares = sample.axes.iter().map(|axis| axis.force_n * axis.force_n);
        driven.force_n = squares.sum::<f32>().sqrt().copysign(driven.force_n);
    }
    let axes = core::iter::once(driven).collect();
    Tick::reported(&Sample {
        axes,
        ..sample.clone()
    })
}

impl Bench<'_> {
    /// A trial with each axis driven in turn.
    pub(super) fn each_axis<T>(
        &mut self,
        mut trial: impl FnMut(&mut Self) -> Result<T, Broken>,
    ) -> Result<Vec<T>, Broken> {
        let mut lines = Vec::new();
        for axis in 0..usize::from(self.link()?.capabilities().axes) {
            self.axis = axis;
            let tried = trial(self);
            self.axis = 0;
            lines.push(tried?);
        }
        Ok(lines)
    }

    fn send_force(&self, tick: u32, force_n: f32) -> Result<(), Broken> {
        let link = self.link()?;
        let mut vector = [0.0; AXES_MAX];
        vector[self.axis] = force_n;
        let axes = usize::from(link.capabilities().axes);
        link.send_force(tick, &vector[..axes.min(AXES_MAX)]);
        Ok(())
    }

    pub(super) fn listen(&mut self, time: Duration) -> Result<Followed, Broken> {
        self.link()?.stream(1, 1)?;
        let began = Moment::now();
        let followed = self.follow(
            Followed::default(),
            |_, _| None,
            |_| began.elapsed() >= time,
        );
        self.link()?.stream(0, 1)?;
        followed
    }

    /// A run from limits to rest: arm, start, follow, stop, disarm. Where the device let go because this machine was silent or late
    /// against its will, by a fault of `spoiled`, or where a limit of it ended the run, the bench remembers that.
    pub(super) fn conduct<S, U>(
        &mut self,
        trial: &Trial<S, U>,
        spoiled: &[Fault],
    ) -> Result<Result<Followed, LinkError>, Broken>
    where
        S: Fn(&Tick, usize) -> Option<f32>,
        U: Fn(&Followed) -> bool,
    {
        self.limit(trial.watchdog_ms)?;
        self.arm_for_trial()?;
        if let Some(refused) = self.start()? {
            self.calm()?;
            self.is_well()?;
            // Silent between arm and start.
            if self.link()?.status().fault == Fault::HostSilent.code() {
                self.late = Some(Fault::HostSilent.to_string());
            }
            return Ok(Err(refused));
        }
        let followed = self
            .follow(Followed::default(), &trial.say, &trial.until)
            .and_then(|followed| self.end(followed));
        if followed.is_err() {
            // Best effort: whatever went wrong, no force stays.
            let _ = self.calm();
        }
        let followed = followed?;
        self.is_well()?;
        self.left = followed.left_limits().or(self.left.take());
        if followed.ended_by(spoiled) {
            self.late = followed.fault_in_words();
        }
        Ok(Ok(followed))
    }

    /// Answers samples of a run that was followed up to now, until `until` is met or a fault or end has come with all that
    /// follows it.
    fn follow(
        &mut self,
        mut followed: Followed,
        say: impl Fn(&Tick, usize) -> Option<f32>,
        until: impl Fn(&Followed) -> bool,
    ) -> Result<Followed, Broken> {
        let mut patience = self.link()?.patience(SILENCE);
        let (mut rest, mut asked) = (Rest::Awaited, Moment::now());
        loop {
            self.goes_on()?;
            if let Some(heard) = self.link_mut()?.hear(LOOK) {
                let axis = self.axis;
                let mut newest = followed.take(heard, axis)?;
                for _ in 0..AT_ONCE {
                    let Some(heard) = self.link_mut()?.try_hear() else {
                        break;
                    };
                    newest = followed.take(heard, axis)?.or(newest);
                }
                if newest.is_some() {
                    patience = self.link()?.patience(SILENCE);
                }
                if let Some(sample) = newest.filter(|_| !followed.is_over())
                    && let Some(force_n) = say(&sample, followed.sent.len())
                {
                    self.send_force(sample.tick, force_n)?;
                    followed.sent.push((sample.tick, force_n));
                }
            }
            if self.link_mut()?.is_silent(&mut patience) && !followed.is_over() {
                let waited_ms = SILENCE.as_millis() as u64;
                if !self.answers_on()? {
                    return Err(Broken::Link(LinkError::NoSamples { waited_ms }.into()));
                }
                self.late = Some(LinkError::HeldUp { waited_ms }.to_string());
                followed.held_up = true;
                return Ok(followed);
            }
            if followed.is_over() {
                if matches!(rest, Rest::Came) {
                    return Ok(followed);
                }
                if asked.elapsed() >= LOOK {
                    (rest, asked) = (self.rest(rest)?, Moment::now());
                }
            } else if until(&followed) {
                return Ok(followed);
            }
        }
    }

    /// Asks a device whose run is over how far it is. Its answer comes behind all that it had said before, however late.
    fn rest(&self, rest: Rest) -> Result<Rest, Broken> {
        let ticks = self.link()?.statistics()?.ticks;
        let more = self.bounds().stop_ticks() + AFTERMATH_TICKS;
        Ok(match rest {
            Rest::Until(until) if ticks.wrapping_sub(until).cast_signed() >= 0 => Rest::Came,
            Rest::Until(_) | Rest::Came => rest,
            Rest::Awaited => Rest::Until(ticks.wrapping_add(more)),
        })
    }

    /// Stops a running run, receives the rest of it, and disarms.
    fn end(&mut self, mut followed: Followed) -> Result<Followed, Broken> {
        if !followed.is_over() {
            // Behind the stop samples go on: its last one may be lost, and so may the news of its end.
            self.stream(1)?;
            let stopped = self.link()?.ask(Request::Stop);
            followed.stop_asked = followed.samples.last().map(|sample| sample.tick);
            followed.ended = match refusal(stopped.map(drop))? {
                None => true,
                // A fault was sooner: it is heard of when nothing else comes.
                Some(_) => {
                    self.stream(0)?;
                    false
                }
            };
            followed = self.follow(followed, |_, _| None, |_| false)?;
            self.stream(0)?;
        }
        self.calm()?;
        Ok(followed)
    }

    /// Asks for each n-th tick without a run; 0 for none. The company that is kept stays as it is.
    fn stream(&self, every: u16) -> Result<(), Broken> {
        self.link()?.ask(Request::Stream { every, batch: 1 })?;
        Ok(())
    }
}

/// Samples of a run, forces that were sent, and the fault that ended it.
#[derive(Clone, Debug, Default)]
pub(super) struct Followed {
    pub(super) samples: Vec<Tick>,
    /// Positions of all axes in each of them, m; 0 where there is no axis.
    pub(super) places_m: Vec<[f32; AXES_MAX]>,
    /// Tick that a force answered, and the force, N.
    pub(super) sent: Vec<(u32, f32)>,
    pub(super) fault: Option<FaultReport>,
    /// The run has begun; earlier samples belong to another.
    pub(super) begun: bool,
    pub(super) ended: bool,
    /// No sample came for long, though the device answers: this machine or the line was held up, and the run was given up.
    pub(super) held_up: bool,
    /// Tick of the newest sample when the device had taken a stop.
    pub(super) stop_asked: Option<u32>,
}

impl Followed {
    /// Tick at which the fault latched: as reported, or, where the report was lost, that of the first sample of a chain
    /// in a fault.
    pub(super) fn fault_tick(&self) -> Option<u32> {
        let report = self.fault?;
        if report.time_us != 0 {
            return Some(report.tick);
        }
        // A report that the host made of a keep-alive knows no time.
        let mut samples = self.samples.iter();
        let shown = samples.find(|sample| sample.limiters & Limiters::FAULT.bits() != 0);
        shown.map(|sample| sample.tick)
    }

    /// The last force that the device took over before the fault: the tick that it answered, and the first sample that
    /// shows it.
    pub(super) fn last_taken(&self, fault_tick: u32) -> Option<(u32, Tick)> {
        let same = |a: f32, b: f32| a.to_bits() == b.to_bits();
        let before = self.samples.iter().rev();
        let wanted = (before.clone())
            .find(|sample| sample.tick <= fault_tick)?
            .environment_force_n[0];
        let (answered, _) = (self.sent.iter()).rfind(|(_, force)| same(*force, wanted))?;
        let shown = (self.samples.iter()).find(|sample| {
            sample.tick > *answered && same(sample.environment_force_n[0], wanted)
        })?;
        Some((*answered, *shown))
    }

    pub(super) fn fault_in_words(&self) -> Option<String> {
        let code = self.fault?.status.fault;
        let name = Fault::from_code(code).map(|fault| format!(", {fault}"));
        Some(format!("fault {code}{}", name.unwrap_or_default()))
    }

    pub(super) fn largest_n(&self) -> f32 {
        let forces = self.samples.iter().map(|sample| sample.force_n[0].abs());
        // A force that is no number is the largest of all.
        forces.fold(0.0, |most, force| {
            if force <= most || most.is_nan() {
                most
            } else {
                force
            }
        })
    }

    fn take(&mut self, heard: DeviceMessage, axis: usize) -> Result<Option<Tick>, Broken> {
        match heard {
            DeviceMessage::Sample(sample) => {
                let tick = seen(&sample, axis);
                self.begun |= tick.is_some();
                self.samples.extend(tick);
                let place = |axis: usize| sample.axes.get(axis).map_or(0.0, |axis| axis.position_m);
                (self.places_m).extend(tick.map(|_| core::array::from_fn(place)));
                return Ok(tick);
            }
            DeviceMessage::Event(event) => {
                self.begun |= event.kind == EventKind::Started;
                // An end before the beginning is that of the run before.
                self.ended |= self.begun
                    && matches!(
                        event.kind,
                        EventKind::Finished | EventKind::Stopped | EventKind::Disarmed
                    );
            }
            DeviceMessage::Fault(report) => self.fault = Some(report),
            DeviceMessage::Over(error) => return Err(Broken::Link(error.into())),
        }
        Ok(None)
    }

    fn is_over(&self) -> bool {
        self.ended || self.held_up || self.fault.is_some()
    }

    pub(super) fn ended_by(&self, faults: &[Fault]) -> bool {
        let code = self.fault.map(|report| report.status.fault);
        faults.iter().any(|fault| code == Some(fault.code()))
    }

    pub(super) fn left_limits(&self) -> Option<String> {
        let fault = Fault::from_code(self.fault?.status.fault)?;
        let advice = if fault == Fault::Workspace {
            "set a wider workspace (`host-cli device set`)"
        } else if fault == Fault::Velocity {
            "set a higher speed limit (`host-cli device set`)"
        } else {
            return None;
        };
        Some(format!(
            "a limit of the device ended the trial ({fault}): {advice}, or test with a smaller {FORCE_LIMIT}"
        ))
    }
}
