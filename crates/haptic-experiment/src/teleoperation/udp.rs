//! One side of a teleoperation in this process, the other in another one, and real datagrams between them.
//!
//! Both devices are simulated and paced by the clock. A port is served by one socket; nothing blocks the tick.

mod line;
mod report;

use super::body::Body;
use super::specification::TeleoperationExperiment;
use crate::device::Warn;
use crate::failure::Failure;
use crate::realtime::RealtimeOptions;
use crate::schedule::{Pace, Schedule};
use fracdiff::Operator;
use haptic_link::{Architecture, HandSide, hand_digest};
use haptic_loop::realtime::Periodic;
use haptic_loop::{Limiters, SafeForce};
use haptic_teleoperation::{Heard, Introduction, Port};
pub use line::End;
use line::{Line, unusable};
pub use report::{FarEnd, FarReport, SKIPPED_MOST, Terms};
use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, Ordering};

impl TeleoperationExperiment {
    /// Runs a side for `duration_s` of its device, once the other is there. `opened` hears the address of this side.
    ///
    /// # Errors
    /// A parameter outside its range; an address that cannot be had; nobody at the other end, or somebody who does not fit.
    pub fn run_side(
        &self,
        end: End,
        terms: Terms,
        opened: &dyn Fn(SocketAddr),
        (stop, warn): (&AtomicBool, Warn<'_>),
    ) -> Result<FarReport, Failure> {
        let terms = terms.checked()?;
        let side = end.side();
        self.check_side(side)?;
        let (port, body) = (self.port(side)?, self.body(side)?);
        let schedule = self.schedule_by_the_clock();
        let Some(clock) = schedule.clock().map_err(Failure::input)? else {
            return Err(Failure::bad_input("two processes need a clock"));
        };
        let mut line = Line::open(end, self.introduction(side))?;
        opened(
            line.socket
                .local_addr()
                .map_err(|error| unusable(end, &error))?,
        );
        if !line.meet(end, terms.patience, stop)? {
            return Err(Failure::Run(anyhow::anyhow!(
                "interrupted before the other side was there; no force was made"
            )));
        }
        let mut side = Side {
            port,
            body,
            line,
            sent: 0,
            acted_on: 0,
            heard_tick: 0,
            at_limit: 0,
            peak_force_n: 0.0,
            left: false,
        };
        let mut periodic = Periodic::new(clock).map_err(Failure::input)?;
        let (ended, ticks, skipped, silent_to_zero) = side.all(
            &mut periodic,
            (schedule.samples, self.sample_time().0),
            stop,
        )?;
        let (_, thread) = periodic.finish();
        drop(thread);
        side.line.farewell();
        let ended = terms.judge(ended, skipped, ticks);
        if skipped > 0 {
            warn(&format!(
                "this machine was late: {skipped} of {ticks} ticks were skipped"
            ));
        }
        let report = self.told(&side, (ended, ticks, skipped, silent_to_zero));
        if report.is_saturated() {
            warn(&self.saturated());
        }
        Ok(report)
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
            peak_force_n: side.peak_force_n,
            final_force_n: side.port.force_n(),
            given_j: side.port.given_j(),
            silent_to_zero_s,
            silent_to_zero_most_s: self.silence_s + stop_time_s + 2.0 * t,
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
    peak_force_n: f64,
    left: bool,
}

impl Side {
    /// All ticks, until the force is zero again: why it ended, ticks, skipped ones, and the time from the last message to zero.
    fn all<W: haptic_loop::realtime::Waiter>(
        &mut self,
        periodic: &mut Periodic<W>,
        (samples, sample_time_s): (u64, f64),
        stop: &AtomicBool,
    ) -> Result<(FarEnd, u64, u64, Option<f64>), Failure> {
        let (mut tick, mut skipped, mut ended) = (0_u64, 0_u64, None);
        let mut force = SafeForce::zero();
        loop {
            let late = periodic.wait().skipped;
            skipped += late;
            // The device moves on meanwhile, under the last force, which a real one would hold too.
            for _ in 0..late {
                self.body.advance(tick as f64 * sample_time_s, force);
                tick += 1;
            }
            self.listen(tick)?;
            force = self.tick(tick)?;
            self.body.advance(tick as f64 * sample_time_s, force);
            tick += 1;
            if ended.is_none() {
                ended = self.ended(tick >= samples, stop);
                if ended.is_some() {
                    self.port.stop();
                }
            }
            if let Some(ended) = ended.filter(|_| self.port.safety().is_at_rest()) {
                let silent = (tick - self.heard_tick) as f64 * sample_time_s;
                let silent = (ended == FarEnd::Silent).then_some(silent);
                return Ok((ended, tick, skipped, silent));
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

    fn tick(&mut self, tick: u64) -> Result<SafeForce<f64, 1>, Failure> {
        let begun = self.port.begin(self.body.reading(tick));
        let force = begun.force();
        let done = begun.finish();
        let message = done.message;
        self.at_limit += u64::from(done.sample.limiters.contains(Limiters::MAGNITUDE));
        self.peak_force_n = self.peak_force_n.max(force.newtons()[0].abs());
        let Line { state, buffer, .. } = &mut self.line;
        let length = (state.sample(message, buffer)).map_err(|error| Failure::Run(error.into()))?;
        self.line.send(length);
        self.sent += 1;
        Ok(force)
    }

    fn ended(&self, over: bool, stop: &AtomicBool) -> Option<FarEnd> {
        if self.port.safety().fault().is_some() {
            Some(FarEnd::Fault)
        } else if stop.load(Ordering::Relaxed) {
            Some(FarEnd::Interrupted)
        } else if self.left {
            Some(FarEnd::OtherLeft)
        } else if self.port.is_silent() {
            Some(FarEnd::Silent)
        } else {
            over.then_some(FarEnd::Done)
        }
    }
}
