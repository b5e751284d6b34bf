//! Warnings to the user about the numbers of a run.

use crate::drive::DriveReport;
use crate::kept::Record;
use crate::remote::{FrameCounts, LinkSummary};
use crate::run::Ran;

/// Sentences for the user.
#[derive(Debug, Default)]
pub struct Warnings(pub Vec<String>);

impl Warnings {
    /// The operator remembers less than the experiment lasts, or is off for another reason.
    pub fn operator(
        &mut self,
        memory_s: Option<f64>,
        duration_s: f64,
        over_theory: Option<f64>,
        what: &str,
    ) {
        /// A final value further than this from theory deserves a sentence.
        const NOTABLE: f64 = 0.02;
        let notable = over_theory.filter(|ratio| (ratio - 1.0).abs() > NOTABLE);
        let off = over_theory.map_or_else(String::new, |ratio| {
            format!("at the end the {what} is {ratio:.3} times the closed form; ")
        });
        if let Some(memory_s) = memory_s.filter(|memory_s| *memory_s < duration_s) {
            self.0.push(format!(
                "the scheme remembers {} s, the experiment lasts {duration_s} s: {off}`scheme` = full \
                 remembers everything",
                (memory_s * 1e6).round() / 1e6
            ));
        } else if notable.is_some() {
            self.0.push(format!(
                "{off}the lines \"operator\" and \"closed form\" of the summary say what that is due to"
            ));
        }
    }

    /// The safety chain acted, so the force is not the tissue's.
    pub fn limited(&mut self, samples: u64) {
        if samples > 0 {
            self.0.push(format!(
                "the safety chain limited the force in {samples} samples: raise `force_limit_n` or \
                 `force_rate_limit_n_per_s`, or on a serial device its own limits and rise time (`host-cli device set`), \
                 or render less stiffly"
            ));
        }
    }

    /// The drive was at its limit, or runs though the analysis calls it unstable.
    pub(super) fn drive(&mut self, drive: Option<&DriveReport>) {
        let Some(drive) = drive else {
            return;
        };
        if drive.saturated_samples > 0 {
            self.0.push(format!(
                "the drive was at its limit of {} N in {} samples: raise `drive_force_limit_n`, or take a slower ramp or \
                 another `controller`",
                drive.drive_force_limit_n, drive.saturated_samples
            ));
        }
        if !drive.preflight.stable() {
            self.0.push(
                "pre-flight: the loop of the drive is unstable by the analysis; run all the same"
                    .to_owned(),
            );
        }
    }

    /// Adds the warnings about a run, of any experiment.
    pub(super) fn run(&mut self, ran: &Ran) {
        let record = &ran.record;
        self.0.extend(record.not_realtime.clone());
        self.late(record);
        self.dropped(record.dropped_by_disk());
        self.link(record.link.as_ref());
        self.0.extend_from_slice(&ran.live_warnings);
    }

    /// The loop was late.
    fn late(&mut self, record: &Record) {
        let (missed, samples) = (record.missed_deadlines, record.samples);
        if missed == 0 {
            return;
        }
        if let Some(link) = &record.link {
            self.0.push(format!(
                "of {samples} ticks of the device {} were a whole period late, and {} had no new force from \
                 here: the device, the line or this machine was too slow for the sample time",
                link.overruns, link.stale_forces
            ));
            return;
        }
        let cause = match record.realtime {
            None => "this machine was busy, or the sample time is too short for it".to_owned(),
            Some(realtime) => {
                let causes = [
                    (
                        realtime.late_by_wake_up,
                        "woken late (`host-cli rt-check` says what helps)",
                    ),
                    (
                        realtime.late_by_compute,
                        "the tick before took too long (give a longer `sample_time_s`)",
                    ),
                ];
                let named = causes.into_iter().filter(|(count, _)| *count > 0);
                let named: Vec<String> = named
                    .map(|(count, cause)| format!("{count} {cause}"))
                    .collect();
                format!(
                    "{}; {} periods were skipped",
                    named.join(", "),
                    realtime.skipped_periods
                )
            }
        };
        self.0.push(format!(
            "{missed} of {samples} ticks were more than one sample time late: {cause}"
        ));
    }

    /// Adds the troubles of a link, if it had any.
    fn link(&mut self, link: Option<&LinkSummary>) {
        let Some(link) = link else {
            return;
        };
        let (from, to) = (link.from_device, link.to_device);
        let bad =
            |frames: FrameCounts| frames.corrupt + frames.lost + frames.duplicate + frames.late;
        if bad(from) + bad(to) > 0 {
            self.0.push(format!(
                "the line is not clean: of {} frames from the device {} did not come and {} were damaged, of \
                 {} to it {} and {}; {} requests were sent again",
                from.sent, from.lost, from.corrupt, to.sent, to.lost, to.corrupt, link.retries
            ));
        }
    }

    /// Samples did not reach the log.
    fn dropped(&mut self, samples: u64) {
        if samples > 0 {
            self.0.push(format!(
                "{samples} samples did not reach the log: the disk was slower than the loop"
            ));
        }
    }
}
