//! The report of an experiment: one JSON object, or a summary for a person. Every kind has the same skeleton, and fills it with rows.

use crate::judge::warnings::Warnings;
use fracdiff::Scheme;
use haptic_document::{Failure, Named as _, Rows, parameters::Parameter};
use haptic_judge::compared::Compared;
use haptic_link::LoopMode;
use haptic_run::{
    Ran, folder::RunTable, link_summary::LinkSummary, realtime::RealtimeSummary, record::RunRecord,
};
use haptic_trial::{preflight::PreflightVerdict, tick::KeptSample};
use serde::Serialize;
use serde_json::{Value, json};

/// The report of an experiment of any kind: JSON and people read it in this order. Its keys are a
/// contract of the command line; the keys of different kinds are equal where they mean the same.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// The law that was rendered, and by which operator.
    #[serde(flatten)]
    pub(crate) law: Rows,
    /// Facts that every kind of experiment reports.
    #[serde(flatten)]
    pub run: RunReport,
    /// Results by the measure of the kind.
    #[serde(flatten)]
    pub(crate) results: Rows,
    /// The result in words; `None` for a relaxation or creep test whose error has no meaning.
    #[serde(skip)]
    pub verdict: Option<String>,
    /// Why the run is not what its document demands; `None` if it is, or demands nothing.
    #[serde(skip)]
    pub(crate) unmet: Option<String>,
}

impl Report {
    /// Refuses a run that does not meet what its document requires with `must_be_stable` or
    /// `must_be_passive`.
    ///
    /// # Errors
    /// Exit code 1.
    pub fn require(&self) -> Result<(), Failure> {
        match &self.unmet {
            Some(unmet) => Err(Failure::run(unmet)),
            None => Ok(()),
        }
    }
}

/// A demand of a document that a run does not meet: by which key, why, and what to do.
pub(crate) fn unmet(demand: &Parameter, why: &str, remedy: &str) -> String {
    let key = demand.key;
    format!("{key}: {why}: {remedy}, or remove {key} from the file to run it anyway")
}

/// Percentiles of the time that a tick took, ns, the simulated rig included.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct TickTimes {
    pub p50: u64,
    /// 99 of 100 ticks took no longer.
    pub p99: u64,
    pub max: u64,
}

/// Report of a run, the same in every experiment. The keys are a contract of the command line.
#[derive(Clone, Debug, Serialize)]
pub struct RunReport {
    /// The device as on the command line; `sim` for the simulated one.
    pub device: String,
    /// Time from one tick of the loop to the next, s.
    pub sample_time_s: f64,
    /// Ticks that the log has: fewer than planned if the run ended early.
    pub samples: u64,
    /// Time of the last sample that counts, s: the end of the log, or when the run was cut short.
    pub duration_s: f64,
    /// Largest magnitude of the commanded force, N; for a run that ended early, up to the end of
    /// its log, including braking.
    pub peak_force_n: f64,
    /// Force that opposes the device's motion in the last sample that counts, the one at
    /// `duration_s`, N: before it falls to zero, whether the run finished, was interrupted or ended
    /// by a fault.
    pub final_force_n: f64,
    /// Number of samples in which the safety chain limited the force.
    pub limited_samples: u64,
    /// Number of samples and events that did not reach the log.
    pub dropped_samples: u64,
    /// Why the run ended early; null if it did not.
    pub ended_early: Option<String>,
    /// Number of ticks more than one sample time late; 0 in virtual time.
    pub missed_deadlines: u64,
    /// Time of a tick; null in a loop on a device, which does not report it.
    tick_ns: Option<TickTimes>,
    /// Timing of a run by the clock of this machine; null in another.
    pub(crate) realtime: Option<RealtimeSummary>,
    /// Counts of the link to the device; null without one.
    pub(crate) link: Option<LinkSummary>,
    /// Verdict of the analysis before the run; null if it was not made.
    pub preflight: Option<PreflightVerdict>,
    /// The log, or the first of its files.
    pub log: String,
    /// All files of the log, in order.
    pub logs: Vec<String>,
    /// The picture (PNG; an SVG lies beside it), unless the run was cut short.
    pub figure: Option<String>,
    /// The samples, unless the run was cut short.
    pub csv: Option<String>,
    /// The log of the fault, 1000 samples before it and 100 after; null without a fault.
    pub fault_log: Option<String>,
    /// Why a run that reached its end has no table.
    #[serde(skip)]
    pub unwritten: Option<String>,
    /// Release of the force, if the run ended early.
    #[serde(skip)]
    pub let_go: Option<String>,
    /// True if the device can no longer be used: its link was lost, or its board is silent.
    #[serde(skip)]
    pub device_lost: bool,
    /// Warnings to the user about these numbers, a sentence each.
    pub warnings: Vec<String>,
}

/// Files of a run beside its log, unless it was cut short.
pub(crate) struct Files {
    pub csv: Option<String>,
    /// Why the run has no table.
    pub unwritten: Option<String>,
}

impl Files {
    /// The table of a run that reached its end, or the reason why it is missing; `None` for a run that was cut short. Without a new table, the
    /// results of an earlier run are removed.
    pub(crate) fn of_run(ran: &Ran, table: Option<RunTable>) -> Self {
        let files = Self::finished(table);
        if files.csv.is_none() {
            ran.folder.remove_stale_results();
        }
        files
    }

    /// A table with its name, or why it has none.
    pub(super) fn finished(table: Option<RunTable>) -> Self {
        let (csv, unwritten) = match table.map(RunTable::finish) {
            Some(Ok(path)) => (Some(path), None),
            Some(Err(failure)) => (None, Some(failure.to_string())),
            None => (None, None),
        };
        Self { csv, unwritten }
    }
}

/// A relative error, dimensionless, and the samples that it is the largest of: a number and, with ends to its name, `_from_s`, `_to_s`,
/// `_samples` and `_reason`. An error without meaning is null, its times too, and its reason says why.
pub(super) fn compared(name: &str, error: &Compared) -> Value {
    json!({
        name: error.largest,
        format!("{name}_from_s"): error.from_s,
        format!("{name}_to_s"): error.to_s,
        format!("{name}_samples"): error.samples,
        format!("{name}_reason"): error.reason,
    })
}

/// Commanded force against the full history of the position really recorded: the memory and the precision of the operator. In a relaxation
/// or creep test of each sample from 10 ms on; else as a share of the largest force.
pub(crate) fn full_history_error(error: &Compared) -> Value {
    compared("max_relative_error", error)
}

/// Force in a relaxation, from 0.1 s after the ramp on; strain in a creep test, from 1 s on; mean deflection of a wall over the window at
/// the end.
pub(crate) fn closed_form_error(error: &Compared) -> Value {
    compared("closed_form_error", error)
}

impl RunReport {
    /// Report of a run on this device; what happened to it is added to the warnings.
    pub(crate) fn new(
        ran: &Ran,
        device: String,
        sample_time_s: f64,
        files: Files,
        mut warnings: Warnings,
    ) -> Self {
        let record = &ran.record;
        warnings.run(ran);
        Self {
            device,
            samples: ran.log.samples,
            duration_s: record.duration_s(),
            peak_force_n: record.peak_force_n(),
            final_force_n: record.last.as_ref().map_or(0.0, KeptSample::reaction_n),
            tick_ns: TickTimes::of(record),
            missed_deadlines: record.missed_deadlines,
            realtime: record.realtime,
            log: ran.log.path.display().to_string(),
            logs: (ran.log.paths.iter())
                .map(|path| path.display().to_string())
                .collect(),
            figure: None,
            csv: files.csv,
            unwritten: files.unwritten,
            sample_time_s,
            limited_samples: record.limited,
            dropped_samples: record.dropped,
            ended_early: record.reason(),
            link: record.link.clone(),
            preflight: ran.preflight,
            fault_log: (ran.fault_log.as_ref()).map(|path| path.display().to_string()),
            let_go: record.let_go().map(|let_go| let_go.words()),
            device_lost: record.device_lost(),
            warnings: warnings.0,
        }
    }

    /// Holds the force of a law that a device renders, which is `off` by this share of its largest, against the positions that came: says
    /// so where nothing that a sound device does explains it, and then why the run is none that counts. `scheme` remembers everything, or
    /// is off by itself.
    #[must_use]
    pub(crate) fn hold_to_law(&mut self, off: Option<f64>, scheme: Scheme) -> Option<String> {
        /// Rounding in single precision and the tolerance of a memory stay below a thousandth.
        const WITHIN: f64 = 0.05;
        /// Lost samples are taken from a straight line, which a motion leaves.
        const WITHIN_LOST: f64 = 0.5;
        let link = self.link.as_ref();
        let link = link.filter(|link| link.loop_mode == LoopMode::Device.name())?;
        let within = if link.samples_missing() > 0 {
            WITHIN_LOST
        } else {
            WITHIN
        };
        let is_whole = matches!(scheme, Scheme::Full { .. } | Scheme::FullBdf2 { .. });
        let off = off.filter(|off| is_whole && *off > within)?;
        self.warnings.push(format!(
            "the force is off the law of the positions that came, by up to {:.0} % of the largest: the device did not measure the one, or did not make the other",
            1e2 * off
        ));
        Some(
            "the force does not follow the law: check the sensor and the firmware of the device"
                .to_owned(),
        )
    }

    /// Why a table could not be written, to be reported after everything else; `None` if it was
    /// written.
    #[must_use]
    pub fn lost_table(&self) -> Option<Failure> {
        let lost = self.unwritten.as_ref()?;
        Some(Failure::data_lost(format_args!("{lost}")))
    }
}

impl TickTimes {
    pub(crate) fn of(record: &RunRecord) -> Option<Self> {
        (!record.tick_ns.is_empty()).then(|| Self {
            p50: record.tick_ns.quantile(0.5),
            p99: record.tick_ns.quantile(0.99),
            max: record.tick_ns.max(),
        })
    }
}
