//! One side of a teleoperation in this process, the other in another one, and real datagrams between them.
//!
//! Both devices are simulated and paced by the clock. A port is served by one socket; nothing blocks the tick.

use super::{
    HandMotion, TeleoperationExperiment,
    line::{End, Line, unusable},
    pair::Body,
    report::TeleoperationVerdict,
};
use crate::{
    experiment::kind::Experiment as _,
    judge::{Published, report::Files},
};
use fracdiff::Operator;
use haptic_document::{
    Failure, Rows,
    parameters::{SAMPLE_TIME, SKIPPED_SHARE},
    rows,
};
use haptic_judge::{curves::Drawing, decimated::Decimated, settling::SATURATED_S};
use haptic_link::{Architecture, HandSide, hand_digest};
use haptic_log::record::StartTime;
use haptic_loop::{Limit, Limiters, SafeForce, realtime::Periodic};
use haptic_message::{END, TickMessage, flaw::LATE_FORCE};
use haptic_quantity::{digits, written};
use haptic_run::{
    Ran, Supervisor,
    conduct::{close, note_periodic, tell_end},
    folder::{FolderRequest, OutputFolder, RunTable},
    realtime::RealtimeOptions,
    record::RunRecord,
    recorder,
    recorder::Recorder,
    schedule::{Pace, Schedule},
};
use haptic_teleoperation::{Introduction, PeerMessage, Port};
use haptic_trial::{ending::Ending, keys::teleoperation::MUST_BE_PASSIVE, tick::by_loop};
use serde::Serialize;
use serde_json::json;
use std::{
    net::SocketAddr,
    sync::atomic::{AtomicBool, Ordering},
    time::{Duration, SystemTime},
};

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
enum FarEnd {
    Done,
    /// Its time was over, but the clock had skipped more ticks than a result may miss.
    Late,
    /// The other side said goodbye.
    OtherLeft,
    /// The other side was silent for too long.
    Silent,
    Interrupted,
    /// The safety chain latched a fault.
    Fault,
}

/// Terms on which a side connects to the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Terms {
    /// Time to wait for the other side.
    pub patience: Duration,
    /// Largest share of the ticks that may be skipped, 0 to 1; a run that skips more has no valid
    /// result.
    pub skipped_most: f64,
}

impl Terms {
    /// Changes the end to late if more ticks were skipped than a result may miss.
    fn judge(self, ended: FarEnd, skipped: u64, ticks: u64) -> FarEnd {
        let whole = matches!(ended, FarEnd::Done | FarEnd::OtherLeft);
        let late = skipped as f64 > self.skipped_most * ticks as f64;
        if whole && late { FarEnd::Late } else { ended }
    }
}

/// The report of a side.
#[derive(Clone, Debug, Serialize)]
pub struct FarReport {
    /// Counts of its device and its messages.
    #[serde(flatten)]
    seen: Rows,
    /// The log, or the first of its files.
    pub log: String,
    logs: Vec<String>,
    csv: Option<String>,
    /// The picture, entered by the code that saves it, unless the run was cut short.
    pub figure: Option<String>,
    fault_log: Option<String>,
    /// Number of samples and events that did not reach the log.
    pub dropped_samples: u64,
    /// Why a run that reached its end has no table.
    #[serde(skip)]
    pub unwritten: Option<String>,
    #[serde(skip)]
    refused: Option<String>,
}

impl FarReport {
    /// Refuses a side that did not reach its end, skipped too many ticks, or does not meet the
    /// requirements in its document.
    ///
    /// # Errors
    /// Exit code 1.
    pub fn require(&self) -> Result<(), Failure> {
        match &self.refused {
            Some(why) => Err(Failure::run(format_args!("{why}; the force is zero"))),
            None => Ok(()),
        }
    }
}

impl TeleoperationExperiment {
    /// Runs a side for `duration_s` of its device, once the other is there; log and table go into the folder. `opened` hears the address of
    /// this side.
    pub(crate) fn run_side(
        &self,
        end: End,
        terms: Terms,
        opened: &dyn Fn(SocketAddr),
        request: &FolderRequest,
        supervisor: Supervisor<'_>,
    ) -> Result<Published<FarReport>, Failure> {
        let hand_side = end.side();
        if hand_side == HandSide::Slave {
            self.require_stable()?;
        }
        let (port, body) = (self.port(hand_side)?, self.body(hand_side)?);
        let t = self.sample_time().0;
        // In real time, whatever the pace of a simulation is.
        let schedule = Schedule {
            samples: self.samples(),
            sample_time_s: t,
            pace: match self.conduct.pace {
                Pace::Virtual => Pace::Realtime(RealtimeOptions::default()),
                pace @ Pace::Realtime(_) => pace,
            },
        };
        let Some(clock) = schedule.clock().map_err(Failure::input)? else {
            return Err(Failure::bad_input(
                "two processes cannot run in virtual time",
            ));
        };
        // A folder that takes no files is seen before anybody waits.
        let folder = request.prepare()?;
        let line = self.met(end, terms, opened, supervisor);
        let line = line.inspect_err(|_| folder.discard())?;
        let peer = line.peer.map_or_else(String::new, |peer| peer.to_string());
        let mut metadata = self.metadata();
        metadata.insert("pace".to_owned(), schedule.pace.to_string());
        metadata.insert("side".to_owned(), hand_side.to_string());
        metadata.insert("peer".to_owned(), peer.clone());
        let mut recorder = recorder(request, &folder, metadata, false, supervisor)?;
        // A recorder that has ended is seen at the tick.
        let _ = recorder.starts_at(StartTime::at(SystemTime::now()));
        let record = RunRecord::with_room_for(schedule.samples);
        let mut side = Side {
            port,
            body,
            line,
            motion: (hand_side == HandSide::Master).then_some(&self.motion),
            kept: Kept {
                table: folder.named_table_beside_log("csv", &COLUMNS),
                curves: Decimated::kept(record.whole.is_some()),
                recorder,
                record,
            },
            sample_time_s: t,
            tick: 0,
            skipped: 0,
            sent: 0,
            acted_on: 0,
            heard_tick: 0,
            at_limit: 0,
            left: false,
        };
        let mut periodic = Periodic::new(clock).map_err(Failure::input)?;
        let (ended, silent_to_zero_s) =
            side.all(&mut periodic, schedule.samples, supervisor.stop)?;
        note_periodic(periodic, &mut side.kept.record, &mut side.kept.recorder);
        side.line.farewell();
        let ended = terms.judge(ended, side.skipped, side.tick);
        if side.skipped > 0 {
            (supervisor.warn)(&format!(
                "this machine was late: {} of {} ticks were skipped",
                side.skipped, side.tick
            ));
        }
        if side.is_saturated() {
            (supervisor.warn)(&self.saturated());
        }
        let refused = self.refused(&side, ended, terms);
        let mut published = self.reported(side, ended, silent_to_zero_s, &peer, folder)?;
        published.report.refused = refused;
        Ok(published)
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
        Err(Failure::run(format_args!(
            "interrupted before the other side connected; no force was applied"
        )))
    }

    fn introduction(&self, side: HandSide) -> Introduction {
        let gains = [
            self.coupler.stiffness_n_per_m,
            self.coupler.dissipation_n_s_mu_per_m,
            self.order.get(),
        ];
        let waves = self.architecture == Architecture::Wave;
        Introduction {
            side,
            architecture: self.architecture,
            sample_time_s: self.sample_time().0,
            wave_impedance_n_s_per_m: if waves {
                self.wave_impedance_n_s_per_m
            } else {
                0.0
            },
            coupler_digest: if waves {
                0
            } else {
                hand_digest(&gains, &self.scheme.to_string())
            },
        }
    }

    /// Why a side is no result. Of a run that must be passive one side sees its own force at the limit, or that the other left longer before
    /// the end than it may be silent; the energy of the line is that of both together, the sum of their `given_j`.
    fn refused(&self, side: &Side<'_>, ended: FarEnd, terms: Terms) -> Option<String> {
        let duration_s = side.duration_s();
        let after = format!("after {}", written("duration_s", duration_s));
        Some(match ended {
            FarEnd::Done | FarEnd::OtherLeft => {
                let left = ended == FarEnd::OtherLeft;
                let verdict = if !self.must_be_passive {
                    return None;
                } else if side.is_saturated() {
                    TeleoperationVerdict::Saturated
                } else if left && self.duration_s - duration_s > self.silence_s {
                    TeleoperationVerdict::Unfinished
                } else {
                    return None;
                };
                format!(
                    "{key}: {} {after}; take {key} out of the file to allow it",
                    verdict.words(),
                    key = MUST_BE_PASSIVE.key
                )
            }
            FarEnd::Late => format!(
                "{} of {} ticks were skipped, more than {} %: the result is not valid; free this machine, use a longer {SAMPLE_TIME}, or allow it \
                 with {SKIPPED_SHARE}",
                side.skipped,
                side.tick,
                digits(100.0 * terms.skipped_most, 4)
            ),
            FarEnd::Silent => format!("the other side fell silent {after}"),
            FarEnd::Interrupted => format!("interrupted {after}"),
            FarEnd::Fault => format!("a fault {after}"),
        })
    }

    /// Closes the log and reports. Unless the run was cut short there are a table and curves.
    fn reported(
        &self,
        side: Side<'_>,
        ended: FarEnd,
        silent_to_zero_s: Option<f64>,
        peer: &str,
        folder: OutputFolder,
    ) -> Result<Published<FarReport>, Failure> {
        let duration_s = side.duration_s();
        let Kept {
            mut recorder,
            mut record,
            table,
            curves,
        } = side.kept;
        let whole = matches!(ended, FarEnd::Done | FarEnd::Late | FarEnd::OtherLeft);
        let peak_force_n = record.peak_force_n();
        record.dropped = recorder.dropped();
        let end = record.end(self.samples(), side.tick);
        recorder.metadata(END, end.metadata());
        let recorded = close(recorder, &record, side.port.safety().is_at_rest())?;
        let ran = Ran::of(record, recorded, folder);
        let files = Files::of_run(&ran, whole.then_some(table));
        let shown = |path: &std::path::PathBuf| path.display().to_string();
        let logs: Vec<String> = ran.log.paths.iter().map(shown).collect();
        let t = self.sample_time().0;
        let (counts, line) = (side.port.counts(), side.line.state.counters());
        let stop_time_s = self.safety.number(Limit::StopTime);
        let stop_time_s = stop_time_s.unwrap_or(Limit::StopTime.default_number());
        let (name, architecture) = (side.line.state.side(), self.architecture.name());
        let seen = json!({
            "side": name.to_string(),
            "architecture": architecture,
            "peer": peer,
            "ended": ended,
            "ticks": side.tick,
            "duration_s": duration_s,
            "skipped": side.skipped,
            "sent": side.sent,
            "acted_on": side.acted_on,
            // Numbers that were passed over, because they were lost or late; the next two came and were refused.
            "missing": counts.missing,
            "stale": counts.stale,
            "duplicate": counts.duplicate,
            "corrupt": line.corrupt.saturating_add(line.oversize),
            // From elsewhere, or of another connection.
            "foreign": side.line.strangers + u64::from(side.line.state.other_connections()),
            "ticks_at_limit": side.at_limit,
            "peak_force_n": peak_force_n,
            "final_force_n": side.port.force_n(),
            // By the line; below 0 it took some.
            "given_j": side.port.given_j(),
            // Device time from the last message to a force of zero, and the most of it: silence, stop time and two samples.
            "silent_to_zero_s": silent_to_zero_s,
            "silent_to_zero_most_s": self.silence_s + stop_time_s + 2.0 * t,
        });
        let report = FarReport {
            seen: rows([seen]),
            log: logs.first().cloned().unwrap_or_default(),
            logs,
            csv: files.csv,
            figure: None,
            fault_log: ran.fault_log.as_ref().map(shown),
            dropped_samples: ran.record.dropped,
            unwritten: files.unwritten,
            refused: None,
        };
        let curves = whole.then(|| {
            let title = format!("A teleoperation, the {name}");
            let subtitle = format!("{architecture} · with {peer}");
            let names = ["reference_m", "position_m", "force_n", "outside_n"];
            curves.named(names, "simulated", title, subtitle, Drawing::Side)
        });
        Ok(Published::new(report, curves, ran))
    }
}

/// Columns of the table of a side.
const COLUMNS: [&str; 6] = [
    "time_s",
    "reference_m",
    "position_m",
    "force_n",
    "outside_force_n",
    "taken_j",
];

/// Log, table and curves of a side.
struct Kept {
    recorder: Recorder,
    record: RunRecord,
    table: RunTable,
    curves: Decimated<4>,
}

impl Kept {
    fn take(&mut self, mut message: TickMessage) {
        self.record.sensor.take_off(&mut message);
        let message = &message;
        let logged = self.recorder.tick(message);
        if self.record.ended.is_some() {
            self.record.push_after(message);
            return;
        }
        self.record.push(message);
        let values = [
            message.reference_m[0],
            message.position_m[0],
            message.applied_force_n[0],
            0.0 - message.contact_force_n[0],
        ];
        let [reference_m, position_m, force_n, outside_n] = values;
        let (time_s, taken_j) = (message.time_s, message.observed_energy_j);
        let row = [time_s, reference_m, position_m, force_n, outside_n, taken_j];
        self.table.row(row);
        self.curves.add(time_s, values);
        if logged.is_err() {
            self.record.ended = Some(Ending::LogStopped);
        }
    }
}

struct Side<'a> {
    port: Port<Operator<f64>>,
    body: Body,
    line: Line,
    /// Motion of the hand, on the side of the master.
    motion: Option<&'a HandMotion>,
    kept: Kept,
    sample_time_s: f64,
    tick: u64,
    /// Ticks that this machine was too late for.
    skipped: u64,
    sent: u64,
    acted_on: u64,
    /// The tick of the newest message.
    heard_tick: u64,
    /// Ticks whose force was at its limit.
    at_limit: u64,
    left: bool,
}

impl Side<'_> {
    fn duration_s(&self) -> f64 {
        self.tick as f64 * self.sample_time_s
    }

    /// True if a force was at its limit for longer than a passive run may have.
    fn is_saturated(&self) -> bool {
        self.at_limit as f64 * self.sample_time_s > SATURATED_S
    }

    /// All ticks, until the force is zero again: why it ended, and the time from the last message to zero, if that was silence.
    fn all<W: haptic_loop::realtime::Waiter>(
        &mut self,
        periodic: &mut Periodic<W>,
        samples: u64,
        stop: &AtomicBool,
    ) -> Result<(FarEnd, Option<f64>), Failure> {
        let (mut ended, mut silent_s) = (None, None);
        let mut force = SafeForce::<f64, 1>::zero();
        loop {
            let late = periodic.wait().skipped;
            self.skipped += late;
            // The device moves on meanwhile, under the last force, which a real one would hold too.
            for _ in 0..late {
                let message = TickMessage {
                    environment_force_n: f64::NAN.into(),
                    commanded_force_n: force.newtons()[0].into(),
                    applied_force_n: force.newtons()[0].into(),
                    flaws: LATE_FORCE,
                    observed_energy_j: 0.0 - self.port.given_j(),
                    ..self.observed()
                };
                self.kept.take(message);
                self.advance(force);
            }
            self.listen()?;
            force = self.tick()?;
            self.advance(force);
            if ended.is_none() {
                ended = self.ended(self.tick >= samples, stop);
                if let Some((_, why)) = ended {
                    if let Some(why) = why {
                        self.ends(why);
                    }
                    self.port.stop();
                }
            }
            let at_rest = self.port.safety().is_at_rest();
            if let Some((ended, _)) = ended.filter(|_| at_rest) {
                let silent = (self.tick - self.heard_tick) as f64 * self.sample_time_s;
                silent_s.get_or_insert(silent);
                if self.kept.recorder.has_aftermath() {
                    return Ok((ended, silent_s.filter(|_| ended == FarEnd::Silent)));
                }
            }
        }
    }

    /// The device moves on under a force.
    fn advance(&mut self, force: SafeForce<f64, 1>) {
        self.body.advance(self.duration_s(), force);
        self.tick += 1;
    }

    /// Takes in what has come.
    fn listen(&mut self) -> Result<(), Failure> {
        while let Some(heard) = self.line.next()? {
            match heard {
                PeerMessage::Sample(sample) => {
                    if self.port.receive(&sample) {
                        self.acted_on += 1;
                        self.heard_tick = self.tick;
                    }
                }
                PeerMessage::Hello => self.line.greet(),
                PeerMessage::Bye => {
                    self.left = true;
                    self.port.stop();
                }
                PeerMessage::Met | PeerMessage::Nothing => {}
            }
        }
        Ok(())
    }

    fn tick(&mut self) -> Result<SafeForce<f64, 1>, Failure> {
        let observed = self.observed();
        let begun = self.port.begin(self.body.reading(self.tick));
        let force = begun.force();
        let done = begun.finish();
        let message = done.message;
        self.at_limit += u64::from(done.sample.limiters.contains(Limiters::MAGNITUDE));
        let taken_j = 0.0 - self.port.given_j();
        self.kept
            .take(by_loop(observed, &done.sample, Some(taken_j)));
        let Line { state, buffer, .. } = &mut self.line;
        let length = state.sample(message, buffer).map_err(Failure::run)?;
        self.line.send(length);
        self.sent += 1;
        Ok(force)
    }

    /// This tick as the log has it, without what the port does in it.
    fn observed(&mut self) -> TickMessage {
        let reading = self.body.reading(self.tick);
        let time_s = reading.time_s;
        let contact_force_n = 0.0 - self.body.outside_n(time_s);
        TickMessage {
            tick: self.tick,
            time_s,
            reference_m: (self.motion.map_or(f64::NAN, |motion| motion.at(time_s).0)).into(),
            indenter_position_m: reading.position_m[0].into(),
            position_m: reading.position_m[0].into(),
            contact_force_n: contact_force_n.into(),
            sensed_force_n: self.body.sensed_n(contact_force_n),
            ..TickMessage::unknown(1)
        }
    }

    /// The run ends so; the log says it.
    fn ends(&mut self, ended: Ending) {
        let Kept {
            recorder, record, ..
        } = &mut self.kept;
        let time_s = record.duration_s();
        tell_end(recorder, ended, None, (self.tick - 1, time_s), time_s);
        record.ended = Some(ended);
    }

    /// Why it is to end, for the report and for the log; the latter has none for a run that has reached its end.
    fn ended(&self, over: bool, stop: &AtomicBool) -> Option<(FarEnd, Option<Ending>)> {
        if let Some(fault) = self.port.safety().fault() {
            Some((FarEnd::Fault, Some(Ending::Fault(fault))))
        } else if self.kept.record.ended == Some(Ending::LogStopped) {
            Some((FarEnd::Interrupted, None))
        } else if stop.load(Ordering::Relaxed) {
            Some((FarEnd::Interrupted, Some(Ending::Interrupted)))
        } else if self.port.is_silent() {
            Some((FarEnd::Silent, Some(Ending::Silent)))
        } else if self.left {
            Some((FarEnd::OtherLeft, Some(Ending::OtherLeft)))
        } else {
            over.then_some((FarEnd::Done, None))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_that_skipped_too_many_ticks_is_no_result() {
        let terms = Terms {
            patience: Duration::from_secs(1),
            skipped_most: 0.1,
        };
        for (ended, skipped, want) in [
            (FarEnd::Done, 100, FarEnd::Done),
            (FarEnd::Done, 101, FarEnd::Late),
            (FarEnd::OtherLeft, 550, FarEnd::Late),
            // Why it ended early says more.
            (FarEnd::Silent, 550, FarEnd::Silent),
            (FarEnd::Interrupted, 550, FarEnd::Interrupted),
        ] {
            assert_eq!(terms.judge(ended, skipped, 1000), want, "{skipped}");
        }
        let any = Terms {
            skipped_most: 1.0,
            ..terms
        };
        assert_eq!(any.judge(FarEnd::Done, 999, 1000), FarEnd::Done);
    }
}
