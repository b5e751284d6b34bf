//! A run that is over: of one device, or of two beside each other.

use crate::{folder::OutputFolder, record::RunRecord, recorder::Recorded};
use haptic_document::Failure;
use haptic_log::record::{Entry, FinishedLog, LogReader};
use haptic_message::TickMessage;
use haptic_trial::{
    drive_verdict::DriveVerdict,
    preflight::PreflightVerdict,
    samples::{RunStart, Samples},
};
use serde::Serialize;
use std::path::PathBuf;

/// A run that is over: its record, its log and where they are.
#[derive(Debug)]
pub struct Ran {
    /// Samples that counted, and how the run ended.
    pub record: RunRecord,
    /// Files of its log, closed.
    pub log: FinishedLog,
    /// Folder of log, table and pictures.
    pub folder: OutputFolder,
    /// The log of a fault, if one latched.
    pub fault_log: Option<PathBuf>,
    /// Findings of the pre-flight; `None` if it was skipped.
    pub preflight: Option<PreflightVerdict>,
    /// Findings of the pre-flight of a drive.
    pub drive: Option<DriveVerdict>,
    /// Result of a drive on a device of its own.
    pub second: Option<DriveRan>,
    /// Losses of live streams, a sentence each.
    pub live_warnings: Vec<String>,
}

/// The drive's clock beside that of the tissue's device.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Aligned {
    /// Tick 0 of the drive on the tissue's device, s from its own tick 0.
    #[serde(rename = "clock_offset_s")]
    pub offset_s: f64,
    /// Seconds that the clock of the tissue's device gains in one of the drive's.
    #[serde(rename = "clock_drift")]
    pub drift: f64,
    /// Largest error of a time of one on the other, s.
    #[serde(rename = "clock_residual_s")]
    pub residual_s: f64,
    /// Tick 0 of the tissue's device by its own clock, s.
    #[serde(rename = "clock_tick_0_s")]
    pub tissue_tick_0_s: f64,
    /// Tick 0 of the drive by its own clock, s.
    #[serde(rename = "clock_drive_tick_0_s")]
    pub drive_tick_0_s: f64,
}

impl Aligned {
    /// The time of the tissue's device, s from its tick 0, when the drive's time is this, from its own.
    pub fn first_s(&self, second_s: f64) -> f64 {
        self.offset_s + second_s * (1.0 + self.drift)
    }
}

/// Result of a drive on a device of its own.
#[derive(Debug)]
pub struct DriveRan {
    /// The device, as on the command line.
    pub device: String,
    /// Its samples, in the time of the log.
    pub record: RunRecord,
    /// `None` if a device did not send its time.
    pub aligned: Option<Aligned>,
    /// Log of a fault of the drive, if one latched.
    pub fault_log: Option<PathBuf>,
    /// Time in which its force may rise, s: until the motion that it follows is over, or its push is judged.
    pub may_rise_s: f64,
}

impl DriveRan {
    /// Largest error of this start of the first device's run, as far as the clocks know, s; infinite of a device that did not send its time.
    pub fn within_s(&self, start: RunStart) -> f64 {
        self.aligned.map_or(f64::INFINITY, |aligned| {
            aligned.residual_s + (start.begun_s() - aligned.offset_s).abs()
        })
    }
}

/// Hands over the ticks of a log in these files.
fn read_ticks(
    files: &[PathBuf],
    take: &mut dyn FnMut(&TickMessage) -> Result<(), Failure>,
) -> Result<(), Failure> {
    for file in files {
        for entry in LogReader::open(file)? {
            if let Entry::Tick(message) = entry? {
                take(&message)?;
            }
        }
    }
    Ok(())
}

impl Ran {
    /// The samples that count, in memory or in the log.
    pub fn samples(&self) -> Samples<'_> {
        let RunRecord {
            whole, last, start, ..
        } = &self.record;
        match (whole, last) {
            (Some(whole), _) => Samples::Whole(whole),
            (None, Some(last)) => Samples::Logged(&self.log.paths, read_ticks, *start, last.tick),
            (None, None) => Samples::Whole(&[]),
        }
    }

    /// True if neither of its devices cut it short.
    pub fn is_whole(&self) -> bool {
        let second = self.second.as_ref().and_then(|second| second.record.ended);
        self.record.ended.or(second).is_none()
    }

    /// A run of one device without pre-flight: what its recorder left.
    #[must_use]
    pub fn of(record: RunRecord, recorded: Recorded, folder: OutputFolder) -> Self {
        Self {
            record,
            log: recorded.log,
            folder,
            fault_log: recorded.fault_log,
            preflight: None,
            drive: None,
            second: None,
            live_warnings: recorded.warnings,
        }
    }
}
