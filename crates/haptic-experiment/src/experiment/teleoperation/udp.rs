//! One side of a teleoperation in this process, the other in another one, and real datagrams between them.
//!
//! Both devices are simulated and paced by the clock. A port is served by one socket; nothing blocks the tick.

mod line;
mod record;
mod report;

use super::body::Body;
use super::curves::SideCurves;
use super::specification::TeleoperationExperiment;
use crate::document::failure::Failure;
use crate::judge::curves::Published;
use crate::run::ending::Ending;
use crate::run::folder::FolderRequest;
use crate::run::realtime::RealtimeOptions;
use crate::run::schedule::{Pace, Schedule};
use crate::run::{Supervisor, told};
use fracdiff::Operator;
use haptic_link::{Architecture, HandSide, hand_digest};
use haptic_log::record::TickMessage;
use haptic_log::record::flaw::LATE_FORCE;
use haptic_loop::realtime::Periodic;
use haptic_loop::{Limiters, SafeForce};
use haptic_teleoperation::{Heard, Introduction, Port};
pub use line::End;
use line::{Line, unusable};
use record::SideRecord;
pub use report::{FarEnd, FarReport, Terms};
use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, Ordering};

impl TeleoperationExperiment {
    /// Runs a side for `duration_s` of its device, once the other is there; log and table go into the folder. `opened` hears the address of
    /// this side.
    ///
    /// # Errors
    /// A parameter outside its range; an address that cannot be had; nobody at the other end, or somebody who does not fit; a log that
    /// cannot be written.
    pub fn run_side(
        &self,
        end: End,
        terms: Terms,
        opened: &dyn Fn(SocketAddr),
        (request, supervisor): (&FolderRequest, Supervisor<'_>),
    ) -> Result<Published<FarReport, SideCurves>, Failure> {
        let terms = terms.checked()?;
        let side = end.side();
        self.check_side(side)?;
        let (port, body) = (self.port(side)?, self.body(side)?);
        let schedule = self.schedule_by_the_clock();
        let Some(clock) = schedule.clock().map_err(Failure::input)? else {
            return Err(Failure::bad_input("two processes need a clock"));
        };
        // A folder that takes no files is seen before anybody waits.
        let folder = request.prepare()?;
        let line = self.met(end, terms, opened, supervisor);
        let line = line.inspect_err(|_| folder.discard())?;
        let peer = line.peer.map_or_else(String::new, |peer| peer.to_string());
        let kept = (folder, request);
        let mut kept = self.kept(end, &peer, kept, (schedule, supervisor))?;
        let mut side = Side {
            port,
            body,
            line,
            sent: 0,
            acted_on: 0,
            heard_tick: 0,
            at_limit: 0,
            left: false,
        };
        let mut periodic = Periodic::new(clock).map_err(Failure::input)?;
        let times = (schedule.samples, self.sample_time().0);
        let run = side.all(&mut periodic, times, (&mut kept, supervisor))?;
        told(periodic, &mut kept.record, &mut kept.recorder);
        side.line.farewell();
        let (ended, ticks, skipped, silent_to_zero) = run;
        let ended = terms.judge(ended, skipped, ticks);
        if skipped > 0 {
            (supervisor.warn)(&format!(
                "this machine was late: {skipped} of {ticks} ticks were skipped"
            ));
        }
        let peak_force_n = kept.record.peak_force_n();
        let report = self.told(&side, (ended, ticks, skipped, silent_to_zero), peak_force_n);
        if report.is_saturated() {
            (supervisor.warn)(&self.saturated());
        }
        let whole = matches!(ended, FarEnd::Done | FarEnd::Late | FarEnd::OtherLeft);
        kept.finish(report, (whole, side.port.safety().is_at_rest()))
    }

    /// The line to the other side, once that is there.
    fn met(
        &self,
        end: End,
        terms: Terms,
        opened: &dyn Fn(SocketAddr),
        supervisor: Supervisor<'_>,
    ) -> Result<Line, Failure> {
        let mut line = Line::open(end, self.introduction(end.side()))?;
        let address = line.socket.local_addr();
        opened(address.map_err(|error| unusable(end, &error))?);
        if line.meet(end, terms.patience, supervisor.stop)? {
            return Ok(line);
        }
        Err(Failure::Run(anyhow::anyhow!(
            "interrupted before the other side was there; no force was made"
        )))
    }

    /// In real time, whatever the pace of a simulation is.
    fn schedule_by_the_clock(&self) -> Schedule {
        Schedule {
            samples: self.samples(),
            sample_time_s: self.sample_time().0,
            pace: match self.pace {
                Pace::Virtual => Pace::Realtime(RealtimeOptions::NORMAL),
                pace @ Pace::Realtime(_) => pace,
            },
        }
    }

    fn check_side(&self, side: HandSide) -> Result<(), Failure> {
        self.check_duration()?;
        self.check_waves()?;
        if side == HandSide::Slave {
            self.require_stable()?;
        }
        Ok(())
    }

    fn introduction(&self, side: HandSide) -> Introduction {
        Introduction {
            side,
            architecture: self.architecture,
            sample_time_s: self.sample_time().0,
            wave_impedance_n_s_per_m: match self.architecture {
                Architecture::Wave => self.wave_impedance_n_s_per_m,
                _ => 0.0,
            },
            coupler_digest: match self.architecture {
                Architecture::Wave => 0,
                _ => hand_digest(
                    &[
                        self.coupler.stiffness_n_per_m,
                        self.coupler.dissipation_n_s_mu_per_m,
                        self.order.get(),
                    ],
                    &self.scheme.to_string(),
                ),
            },
        }
    }

    fn told(
        &self,
        side: &Side,
        (ended, ticks, skipped, silent_to_zero_s): (FarEnd, u64, u64, Option<f64>),
        peak_force_n: f64,
    ) -> FarReport {
        let t = self.sample_time().0;
        let (counts, line) = (side.port.counts(), side.line.state.counters());
        let stop_time_s = self.safety.stop_time_s;
        let stop_time_s = stop_time_s.unwrap_or(haptic_loop::Limits::default().stop_time.0);
        FarReport {
            side: side.line.state.side().to_string(),
            architecture: self.architecture.name().to_owned(),
            peer: side
                .line
                .peer
                .map_or_else(String::new, |peer| peer.to_string()),
            ended,
            ticks,
            duration_s: ticks as f64 * t,
            skipped,
            sent: side.sent,
            acted_on: side.acted_on,
            missing: counts.missing,
            stale: counts.stale,
            duplicate: counts.duplicate,
            corrupt: line.corrupt.saturating_add(line.oversize),
            foreign: side.line.strangers + u64::from(side.line.state.other_connections()),
            ticks_at_limit: side.at_limit,
            peak_force_n,
            final_force_n: side.port.force_n(),
            given_j: side.port.given_j(),
            silent_to_zero_s,
            silent_to_zero_most_s: self.silence_s + stop_time_s + 2.0 * t,
            log: String::new(),
            logs: Vec::new(),
            csv: None,
            figure: None,
            fault_log: None,
            dropped_samples: 0,
            unwritten: None,
        }
    }
}

/// A side at work.
struct Side {
    port: Port<Operator<f64>>,
    body: Body,
    line: Line,
    sent: u64,
    acted_on: u64,
    /// The tick of the newest message.
    heard_tick: u64,
    /// Ticks whose force was at its limit.
    at_limit: u64,
    left: bool,
}

impl Side {
    /// All ticks, until the force is zero again: why it ended, ticks, skipped ones, and the time from the last message to zero.
    fn all<W: haptic_loop::realtime::Waiter>(
        &mut self,
        periodic: &mut Periodic<W>,
        (samples, sample_time_s): (u64, f64),
        (kept, supervisor): (&mut SideRecord, Supervisor<'_>),
    ) -> Result<(FarEnd, u64, u64, Option<f64>), Failure> {
        let (mut tick, mut skipped) = (0_u64, 0_u64);
        let (mut ended, mut silent_s) = (None, None);
        let mut force = SafeForce::zero();
        loop {
            let late = periodic.wait().skipped;
            skipped += late;
            // The device moves on meanwhile, under the last force, which a real one would hold too.
            for _ in 0..late {
                let message = self.skipped(tick, force, kept);
                kept.take(&message);
                self.body.advance(tick as f64 * sample_time_s, force);
                tick += 1;
            }
            self.listen(tick)?;
            force = self.tick(tick, kept)?;
            self.body.advance(tick as f64 * sample_time_s, force);
            tick += 1;
            if ended.is_none() {
                ended = self.ended(tick >= samples, supervisor.stop, kept);
                if let Some((_, why)) = ended {
                    if let Some(why) = why {
                        kept.ends(why, tick - 1);
                    }
                    self.port.stop();
                }
            }
            let at_rest = self.port.safety().is_at_rest();
            if let Some((ended, _)) = ended.filter(|_| at_rest) {
                let silent = (tick - self.heard_tick) as f64 * sample_time_s;
                silent_s.get_or_insert(silent);
                if kept.recorder.has_aftermath() {
                    let silent_s = silent_s.filter(|_| ended == FarEnd::Silent);
                    return Ok((ended, tick, skipped, silent_s));
                }
            }
        }
    }

    /// Takes in what has come.
    fn listen(&mut self, tick: u64) -> Result<(), Failure> {
        while let Some(heard) = self.line.next()? {
            match heard {
                Heard::Sample(sample) => {
                    if self.port.receive(&sample) {
                        self.acted_on += 1;
                        self.heard_tick = tick;
                    }
                }
                Heard::Hello => self.line.greet(),
                Heard::Bye => self.left = true,
                Heard::Met | Heard::Nothing => {}
            }
        }
        Ok(())
    }

    fn tick(&mut self, tick: u64, kept: &mut SideRecord) -> Result<SafeForce<f64, 1>, Failure> {
        let observed = self.observed(tick, kept);
        let begun = self.port.begin(self.body.reading(tick));
        let force = begun.force();
        let done = begun.finish();
        let message = done.message;
        self.at_limit += u64::from(done.sample.limiters.contains(Limiters::MAGNITUDE));
        kept.take(&TickMessage {
            environment_force_n: done.sample.environment_force_n[0].into(),
            commanded_force_n: force.newtons()[0].into(),
            applied_force_n: force.newtons()[0].into(),
            limiters: done.sample.limiters.bits(),
            observed_energy_j: 0.0 - self.port.given_j(),
            ..observed
        });
        let Line { state, buffer, .. } = &mut self.line;
        let length = (state.sample(message, buffer)).map_err(|error| Failure::Run(error.into()))?;
        self.line.send(length);
        self.sent += 1;
        Ok(force)
    }

    /// A tick as the log has it, without what the port does in it.
    fn observed(&self, tick: u64, kept: &SideRecord) -> TickMessage {
        let reading = self.body.reading(tick);
        TickMessage {
            tick,
            time_s: reading.time_s,
            reference_m: kept.reference_m(reading.time_s).into(),
            indenter_position_m: reading.position_m[0].into(),
            position_m: reading.position_m[0].into(),
            contact_force_n: (0.0 - self.body.outside_n(reading.time_s)).into(),
            ..TickMessage::default()
        }
    }

    /// One that this machine was too late for.
    fn skipped(&self, tick: u64, held: SafeForce<f64, 1>, kept: &SideRecord) -> TickMessage {
        TickMessage {
            environment_force_n: f64::NAN.into(),
            commanded_force_n: held.newtons()[0].into(),
            applied_force_n: held.newtons()[0].into(),
            flaws: LATE_FORCE,
            observed_energy_j: 0.0 - self.port.given_j(),
            ..self.observed(tick, kept)
        }
    }

    /// Why it is to end, for the report and for the log; the latter has none for a run that has reached its end.
    fn ended(
        &self,
        over: bool,
        stop: &AtomicBool,
        kept: &SideRecord,
    ) -> Option<(FarEnd, Option<Ending>)> {
        if let Some(fault) = self.port.safety().fault() {
            Some((FarEnd::Fault, Some(Ending::Fault(fault))))
        } else if kept.record.ended == Some(Ending::LogStopped) {
            Some((FarEnd::Interrupted, None))
        } else if stop.load(Ordering::Relaxed) {
            Some((FarEnd::Interrupted, Some(Ending::Interrupted)))
        } else if self.left {
            Some((FarEnd::OtherLeft, Some(Ending::OtherLeft)))
        } else if self.port.is_silent() {
            Some((FarEnd::Silent, Some(Ending::Silent)))
        } else {
            over.then_some((FarEnd::Done, None))
        }
    }
}
