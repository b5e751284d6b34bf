//! The side of a drive that has a device of its own: its samples at the times of the tissue's device, and its report.

use crate::judge::RunReport;
use haptic_run::{Aligned, DriveRan, link_summary::LinkSummary, record::RunRecord};
use haptic_trial::{ending::Ending, tick::KeptSample};
use serde::Serialize;

/// Report of the device of a drive, besides the drive's results.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct SecondReport {
    /// The device as on the command line.
    device: String,
    /// Samples of it that count.
    samples: u64,
    dropped_samples: u64,
    /// Null if one of the devices did not send its time.
    #[serde(flatten)]
    aligned: Option<Aligned>,
    /// Why it ended early; null if it did not.
    ended_early: Option<String>,
    link: Option<LinkSummary>,
    /// The log of its fault; null without one.
    fault_log: Option<String>,
}

/// The samples of a drive at the times of a run: error, and the values of the columns.
pub(crate) struct DriveSamples {
    /// Samples with the time of the run, s.
    points: Vec<(f64, [f64; 3])>,
    /// The sample before the time that was asked for last.
    at: usize,
}

impl SecondReport {
    pub(crate) fn of(second: &DriveRan) -> Self {
        let record = &second.record;
        Self {
            device: second.device.clone(),
            samples: record.samples,
            dropped_samples: record.dropped,
            aligned: second.aligned,
            ended_early: record.reason(),
            link: record.link.clone(),
            fault_log: (second.fault_log.as_ref()).map(|path| path.display().to_string()),
        }
    }
}

impl DriveSamples {
    /// Judged in its own time, and put beside a run of this sample time that counts as this record does.
    pub(crate) fn new(
        second: &DriveRan,
        first: &RunRecord,
        sample_time_s: f64,
        mut judged: impl FnMut(&KeptSample) -> (f64, [f64; 2]),
    ) -> Self {
        let begun_s = first.start.begun_s();
        let samples = second.record.whole.as_deref().unwrap_or_default();
        let mut points = Vec::new();
        let of_tissue = first.whole.as_deref().unwrap_or_default();
        for sample in samples {
            let own_s = sample.tick as f64 * sample_time_s;
            let of_first = |aligned: Aligned| aligned.first_s(own_s);
            let now_s = second.aligned.map_or(sample.time_s, of_first) - begun_s;
            // The force between both is what the other device opposes, as of its newest tick.
            let newest = of_tissue.partition_point(|of_tissue| of_tissue.time_s <= now_s);
            let newest = newest
                .checked_sub(1)
                .and_then(|newest| of_tissue.get(newest));
            let kept = KeptSample {
                time_s: own_s,
                contact_force_n: newest.map_or(0.0, KeptSample::reaction_n),
                sensed_force_n: None,
                ..*sample
            };
            let (error, [measured, force_n]) = judged(&kept);
            points.push((now_s, [error, measured, force_n]));
        }
        Self { points, at: 0 }
    }

    /// Error and values of the columns at a time of the run, on the straight line between its neighbours, or those of the nearest. Times must
    /// not fall.
    pub(crate) fn at(&mut self, time_s: f64) -> (f64, [f64; 2]) {
        let point = |n: usize| self.points.get(n);
        while point(self.at + 1).is_some_and(|next| next.0 <= time_s) {
            self.at += 1;
        }
        let Some(&(before_s, before)) = point(self.at) else {
            return (f64::NAN, [f64::NAN; 2]);
        };
        let [error, measured, force_n] = match point(self.at + 1) {
            Some((after_s, after)) => {
                let share = ((time_s - before_s) / (after_s - before_s)).clamp(0.0, 1.0);
                std::array::from_fn(|n| before[n] + share * (after[n] - before[n]))
            }
            None => before,
        };
        (error, [measured, force_n])
    }
}

/// Adds the device of the drive to the report of a run.
pub(crate) fn tell(run: &mut RunReport, first: &RunRecord, second: &DriveRan) {
    let record = &second.record;
    run.dropped_samples += record.dropped;
    run.device_lost |= record.device_lost();
    let of_drive = |words: String| format!("drive {}: {words}", second.device);
    // A side that only followed the other does not know the cause.
    let follows = |ended| matches!(ended, None | Some(Ending::OtherLeft | Ending::Silent));
    if follows(first.ended) && (first.ended.is_none() || !follows(record.ended)) {
        run.ended_early = record.reason().map(of_drive);
    }
    let let_go = record.let_go().map(|let_go| of_drive(let_go.words()));
    let words = run.let_go.iter().chain(let_go.iter());
    let words: Vec<&str> = words.map(String::as_str).collect();
    run.let_go = (!words.is_empty()).then(|| words.join("; "));
}
