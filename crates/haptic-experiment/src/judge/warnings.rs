//! Warnings to the user about the numbers of a run.

use haptic_document::parameters::{FORCE_LIMIT, FORCE_RATE_LIMIT, SAMPLE_TIME, SCHEME};
use haptic_loop::Limiters;
use haptic_run::{
    Ran,
    link_summary::{FrameCounts, LinkSummary},
    record::RunRecord,
};
use haptic_trial::{
    safety::keys::{GUARD, RISE_TIME, SPEED_LIMIT, WORKSPACE_HIGH, WORKSPACE_LOW},
    tick::KeptSample,
};

/// Limiters in the order in which warnings name them.
const LIMITERS: [Limiters; 8] = [
    Limiters::MAGNITUDE,
    Limiters::RATE,
    Limiters::STARTUP,
    Limiters::WORKSPACE,
    Limiters::VELOCITY,
    Limiters::GUARD,
    Limiters::FAULT,
    Limiters::STOPPING,
];

/// Remedy for a limiter. A device has limits of its own, which a run can only tighten.
fn remedy(limiter: Limiters, on_device: bool) -> String {
    let here = if on_device {
        ", here and on the device (`host-cli device set`)"
    } else {
        ""
    };
    match limiter {
        Limiters::MAGNITUDE => {
            format!("it reached its limit: raise {FORCE_LIMIT}{here}, or render something softer")
        }
        Limiters::RATE => {
            format!(
                "its rate reached the limit: raise {FORCE_RATE_LIMIT}{here}, or touch more slowly"
            )
        }
        Limiters::STARTUP if on_device => format!(
            "it ramped up over the device's rise time, which a run cannot shorten: set a shorter {RISE_TIME} there (`host-cli device set`), or begin outside"
        ),
        Limiters::STARTUP => {
            format!("it ramped up at the start: use a shorter {RISE_TIME}, or begin outside")
        }
        Limiters::WORKSPACE => format!(
            "it braked near the end of the workspace: stay inside, or widen {WORKSPACE_LOW} to {WORKSPACE_HIGH}{here}"
        ),
        Limiters::VELOCITY => format!(
            "it braked near the largest speed: move more slowly, or raise {SPEED_LIMIT}{here}"
        ),
        Limiters::GUARD => format!(
            "the guard held back energy: render something softer, or leave {GUARD} off if the analysis says passive"
        ),
        Limiters::FAULT => "a fault held it at zero: see the fault in the log".to_owned(),
        _ => "it fell to zero at the end".to_owned(),
    }
}

#[derive(Debug, Default)]
pub(crate) struct Warnings(pub Vec<String>);

impl Warnings {
    /// The operator remembers less than the experiment lasts, or is off for another reason.
    pub(crate) fn operator(
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
                "the scheme remembers {} s, the experiment lasts {duration_s} s: {off}{} \
                 remembers everything",
                (memory_s * 1e6).round() / 1e6,
                SCHEME.set_to("full")
            ));
        } else if notable.is_some() {
            self.0.push(format!(
                "{off}`max_relative_error` is the operator's part of that, `rig_error` the rig's"
            ));
        }
    }

    /// The safety chain acted, so the force is not the tissue's.
    pub(crate) fn limited(&mut self, record: &RunRecord) {
        self.limited_after(record, 0.0);
    }

    /// [`limited`](Self::limited), but for samples of this time in which nothing but the start ramp of a device acted, s.
    pub(crate) fn limited_after(&mut self, record: &RunRecord, may_rise_s: f64) {
        let samples = || record.whole.iter().flatten();
        let from_s = samples().next().map_or(0.0, |first| first.time_s);
        let rises = |sample: &&KeptSample| {
            sample.limiters == Limiters::STARTUP.bits() && sample.time_s - from_s < may_rise_s
        };
        let rising = samples().filter(rises).count() as u64;
        let others = samples().filter(|sample| !rises(sample));
        let limiters = match rising {
            0 => record.limiters,
            _ => others.fold(0, |all, sample| all | sample.limiters),
        };
        let (samples, on_device) = (record.limited - rising, record.link.is_some());
        let acted = |limiter: Limiters| limiters & limiter.bits() != 0;
        let acted = LIMITERS.into_iter().filter(|limiter| acted(*limiter));
        let remedies: Vec<String> = acted.map(|limiter| remedy(limiter, on_device)).collect();
        if samples > 0 {
            self.0.push(format!(
                "the safety chain limited the force in {samples} samples: {}",
                remedies.join("; ")
            ));
        }
    }

    /// Adds the warnings about a run, of any experiment.
    pub(crate) fn run(&mut self, ran: &Ran) {
        let record = &ran.record;
        self.0.extend(record.not_realtime.clone());
        self.late(record);
        self.dropped(record.dropped_by_disk());
        self.link(record.link.as_ref());
        self.0.extend_from_slice(&ran.live_warnings);
        if let Some(second) = &ran.second {
            let mut of_drive = Self::default();
            of_drive.0.extend(second.record.not_realtime.clone());
            of_drive.limited_after(&second.record, second.may_rise_s);
            of_drive.late(&second.record);
            of_drive.dropped(second.record.dropped_by_disk());
            of_drive.link(second.record.link.as_ref());
            let missing = second.record.link.as_ref();
            let missing = missing.map_or(0, LinkSummary::samples_missing);
            if missing > 0 {
                of_drive.0.push(format!("{missing} samples did not come"));
            }
            let lines = of_drive.0.into_iter();
            self.0.extend(lines.map(|words| format!("drive: {words}")));
        }
    }

    fn late(&mut self, record: &RunRecord) {
        let (missed, samples) = (record.missed_deadlines, record.samples);
        if missed == 0 {
            return;
        }
        if let Some(link) = &record.link {
            self.0.push(format!(
                "of {} ticks of the device {} were a whole period late, and {} had no new force: use a longer sample time",
                link.ticks, link.overruns, link.stale_forces
            ));
            return;
        }
        let cause = match record.realtime {
            None => "this machine was busy, or the sample time is too short for it".to_owned(),
            Some(realtime) => {
                let causes = [
                    (
                        realtime.late_by_wake_up,
                        "woken late (`host-cli rt-check` says what helps)".to_owned(),
                    ),
                    (
                        realtime.late_by_compute,
                        format!("the tick before took too long (give a longer {SAMPLE_TIME})"),
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
        if link.unanswered + link.forces_not_taken > 0 {
            self.0.push(format!(
                "of {} ticks of the device {} had no answer from its board, {} forces were not confirmed: lengthen {SAMPLE_TIME}, or change the cable",
                link.ticks, link.unanswered, link.forces_not_taken
            ));
        }
        let (from, to) = (link.from_device, link.to_device);
        let bad =
            |frames: FrameCounts| frames.corrupt + frames.lost + frames.duplicate + frames.late;
        if bad(from) + bad(to) > 0 {
            self.0.push(format!(
                "the line is not clean: of {} frames from the device {} are lost and {} damaged, of {} to it {} and {}; {} requests were repeated",
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

#[cfg(test)]
mod tests {
    use super::*;
    use haptic_message::TickMessage;

    #[test]
    fn late_ticks_are_counted_among_all_ticks_of_the_device_and_not_those_of_the_run() {
        let mut record = RunRecord::with_room_for(0);
        (record.samples, record.missed_deadlines) = (11, 28);
        record.link = Some(LinkSummary {
            ticks: 1300,
            overruns: 28,
            ..LinkSummary::default()
        });
        let mut warnings = Warnings::default();
        warnings.late(&record);
        let warning = warnings.0.concat();
        assert!(
            warning.starts_with("of 1300 ticks of the device 28 were"),
            "{warning}"
        );
    }

    #[test]
    fn a_start_ramp_within_the_time_that_was_asked_for_is_no_warning() {
        let mut record = RunRecord::with_room_for(1000);
        for tick in 0..1000 {
            let time_s = 2.0 + tick as f64 * 1e-3;
            let limiters = Limiters::STARTUP.bits() * u8::from(tick < 500);
            record.push(&TickMessage {
                tick,
                time_s,
                limiters,
                ..TickMessage::at_rest(1)
            });
        }
        for (may_rise_s, samples) in [(1.0, None), (0.1995, Some("300"))] {
            let mut warnings = Warnings::default();
            warnings.limited_after(&record, may_rise_s);
            let said = warnings.0.concat();
            let want = samples.map_or(String::new(), |samples| {
                format!("in {samples} samples: it ramped")
            });
            assert!(
                said.contains(&want) && said.is_empty() == want.is_empty(),
                "{said}"
            );
        }
    }

    #[test]
    fn each_limiter_that_acted_has_a_remedy_of_its_own_and_no_other_is_told() {
        for (limiter, named) in [
            (Limiters::MAGNITUDE, "`force_limit_n`"),
            (Limiters::RATE, "`force_rate_limit_n_per_s`"),
            (Limiters::STARTUP, "`rise_time_s`"),
            (Limiters::WORKSPACE, "`workspace_low_m`"),
            (Limiters::VELOCITY, "`speed_limit_m_per_s`"),
            (Limiters::GUARD, "`guard`"),
        ] {
            let mut record = RunRecord::with_room_for(0);
            (record.limited, record.limiters) = (7, limiter.bits());
            let mut warnings = Warnings::default();
            warnings.limited(&record);
            let [warning] = &warnings.0[..] else {
                panic!("{warnings:?}")
            };
            let warning = warning.clone();
            assert!(
                warning.contains("in 7 samples") && warning.contains(named),
                "{warning}"
            );
            record.link = Some(LinkSummary::default());
            let mut warnings = Warnings::default();
            warnings.limited(&record);
            let said_of_device = warnings.0.concat();
            let set_there = limiter != Limiters::GUARD;
            assert!(said_of_device.contains(named), "{said_of_device}");
            assert_eq!(
                (
                    warning.contains("device set"),
                    said_of_device.contains("device set")
                ),
                (false, set_there),
                "{said_of_device}"
            );
            for other in LIMITERS.into_iter().filter(|other| *other != limiter) {
                assert!(!warning.contains(&remedy(other, false)), "{warning}");
            }
        }
        let bits: Vec<u8> = LIMITERS.iter().map(|limiter| limiter.bits()).collect();
        assert_eq!(
            bits.iter().fold(0, |all, bit| all | bit),
            u8::MAX,
            "one is missing"
        );
    }
}
