//! What a side keeps of its run: log, table, curves.

use super::line::End;
use crate::document::failure::Failure;
use crate::experiment::teleoperation::curves::SideCurves;
use crate::experiment::teleoperation::specification::{HandMotion, TeleoperationExperiment};
use crate::experiment::teleoperation::udp::report::FarReport;
use crate::judge::curves::Published;
use crate::judge::decimated::Decimated;
use crate::judge::report::Files;
use crate::run::ending::Ending;
use crate::run::folder::{FolderRequest, OutputFolder, Table};
use crate::run::record::Record;
use crate::run::recorder::Recorder;
use crate::run::schedule::Schedule;
use crate::run::{Ran, Supervisor, close, recorder, tell_end};
use haptic_link::HandSide;
use haptic_log::record::{END, StartTime, TickMessage};
use serde::Serialize;
use std::time::SystemTime;

/// A row of the table.
#[derive(Serialize)]
struct Row {
    time_s: f64,
    reference_m: f64,
    position_m: f64,
    force_n: f64,
    outside_force_n: f64,
    taken_j: f64,
}

/// Log, table and curves of a side.
pub(super) struct SideRecord {
    pub(super) recorder: Recorder,
    pub(super) record: Record,
    folder: OutputFolder,
    table: Table,
    curves: Decimated<4>,
    /// Of the hand, on the side of the master.
    motion: Option<HandMotion>,
    schedule: Schedule,
}

impl TeleoperationExperiment {
    /// Begins what a side keeps.
    pub(super) fn kept(
        &self,
        end: End,
        peer: &str,
        (folder, request): (OutputFolder, &FolderRequest),
        (schedule, supervisor): (Schedule, Supervisor<'_>),
    ) -> Result<SideRecord, Failure> {
        let side = end.side();
        let mut metadata = self.metadata();
        metadata.insert("side".to_owned(), side.to_string());
        metadata.insert("peer".to_owned(), peer.to_owned());
        metadata.insert("pace".to_owned(), schedule.pace.to_string());
        let mut recorder = recorder(request, &folder, metadata, false, supervisor)?;
        // A recorder that has ended is seen at the tick.
        let _ = recorder.starts_at(StartTime::at(SystemTime::now()));
        let record = Record::with_room_for(schedule.samples).map_err(Failure::Run)?;
        Ok(SideRecord {
            recorder,
            table: folder.table_beside_log("csv"),
            curves: Decimated::of(&record),
            record,
            folder,
            motion: (side == HandSide::Master).then(|| self.motion.clone()),
            schedule,
        })
    }
}

impl SideRecord {
    /// Where the hand wants to be, m; not a number on the side without one.
    pub(super) fn reference_m(&self, time_s: f64) -> f64 {
        let motion = self.motion.as_ref();
        motion.map_or(f64::NAN, |motion| motion.at(time_s).0)
    }

    /// Takes a tick in.
    pub(super) fn take(&mut self, message: &TickMessage) {
        let logged = self.recorder.tick(message);
        if self.record.ended.is_some() {
            self.record.push_after(message);
            return;
        }
        self.record.push(message);
        let (time_s, taken_j) = (message.time_s, message.observed_energy_j);
        let [reference_m, position_m, force_n] = [
            message.reference_m[0],
            message.position_m[0],
            message.applied_force_n[0],
        ];
        let outside_force_n = 0.0 - message.contact_force_n[0];
        self.table.row(Row {
            time_s,
            reference_m,
            position_m,
            force_n,
            outside_force_n,
            taken_j,
        });
        let values = [reference_m, position_m, force_n, outside_force_n];
        self.curves.add(time_s, values);
        if logged.is_err() {
            self.record.ended = Some(Ending::LogStopped);
        }
    }

    /// The run ends so; the log says it.
    pub(super) fn ends(&mut self, ended: Ending, tick: u64) {
        let at = (tick, self.record.duration_s());
        tell_end(&mut self.recorder, ended, None, at, at.1);
        self.record.ended = Some(ended);
    }

    /// Closes the log, and names log and table in the report. `whole` if the run was not cut short: then there are a table and curves.
    pub(super) fn finish(
        mut self,
        mut report: FarReport,
        (whole, at_rest): (bool, bool),
    ) -> Result<Published<FarReport, SideCurves>, Failure> {
        self.record.dropped = self.recorder.dropped();
        let end = self.record.end(self.schedule.samples, report.ticks);
        self.recorder.metadata(END, end.metadata());
        let recorded = close(self.recorder, &self.record, at_rest)?;
        let ran = Ran::of(self.record, recorded, self.folder);
        let files = Files::of_run(&ran, whole.then_some(self.table));
        let shown = |path: &std::path::PathBuf| path.display().to_string();
        report.logs = ran.log.paths.iter().map(shown).collect();
        report.log = report.logs.first().cloned().unwrap_or_default();
        report.fault_log = ran.fault_log.as_ref().map(shown);
        report.dropped_samples = ran.record.dropped;
        (report.csv, report.unwritten) = (files.csv, files.unwritten);
        self.curves.finish();
        let [reference_m, position_m, force_n, outside_n] = self.curves.curves;
        let curves = whole.then(|| SideCurves {
            title: format!("A teleoperation, the {}", report.side),
            subtitle: format!("{} · with {}", report.architecture, report.peer),
            time_s: self.curves.time_s,
            reference_m,
            position_m,
            force_n,
            outside_n,
        });
        Ok(Published::new((report, curves), ran.folder))
    }
}
