//! Counts of a link over a run, for the report and for the log.

use crate::run::device::firmware_version;
use crate::run::remote::RemoteDevice;
use haptic_document::Named;
use haptic_link::Statistics;
use haptic_loop::Tap;
use haptic_loop::realtime::Durations;
use haptic_remote::serial::SerialLink;

/// Counts of the link of a run.
#[derive(Clone, Debug, Default, serde::Serialize)]
pub(crate) struct LinkSummary {
    pub board: String,
    pub firmware: String,
    /// Number that the device told.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub serial_number: Option<String>,
    /// The device simulates its plant: no actuator, no sensor.
    pub simulated: bool,
    /// Its newtons were checked on this day, or never.
    pub calibration: String,
    /// Step of its encoder, m; 0 if it does not say.
    #[serde(skip)]
    pub position_resolution_m: f64,
    /// Taps of the motor that renders the law.
    #[serde(skip)]
    pub tap: Option<Tap<f64>>,
    /// `device` or `host`.
    #[serde(rename = "loop")]
    pub loop_mode: &'static str,
    /// Samples of the run that did not come.
    pub samples_lost: u64,
    /// Samples that came but found no room here.
    pub samples_dropped: u64,
    /// Samples that the device dropped because its queue was full.
    pub samples_dropped_on_device: u32,
    /// Ticks of a host loop without a new force.
    pub stale_forces: u32,
    /// Ticks in which a board of another maker did not answer: their positions come from earlier
    /// ticks.
    pub unanswered: u32,
    /// Forces that such a board did not confirm.
    pub forces_not_taken: u32,
    /// Forces that this program dropped because its queue was full.
    pub forces_dropped: u64,
    /// Forces that were not sent because a newer sample had come already.
    pub forces_skipped: u64,
    /// False where the device could not be asked at the end: its counts are then unknown, and given
    /// as 0.
    pub device_answered: bool,
    /// Ticks of the device since it was asked before the run: those between arming and start, and of the fall of the force, too.
    pub ticks: u32,
    /// Number of those that were late.
    pub overruns: u32,
    /// Longest tick of the device, processor cycles; null if it cannot count them.
    pub tick_cycles_max: Option<u32>,
    pub tick_cycles_max_reason: Option<&'static str>,
    pub from_device: FrameCounts,
    /// Counts of frames to the device, as the device reports them.
    pub to_device: FrameCounts,
    /// Why its counts are unknown.
    pub to_device_reason: Option<&'static str>,
    /// Requests that were sent again.
    pub retries: u32,
    /// Time from a keep-alive to its answer; null if none came.
    pub round_trip_us: Option<RoundTrip>,
    pub round_trip_reason: Option<&'static str>,
}

impl LinkSummary {
    /// Name of the record in a log with the counts of a drive.
    pub(crate) const OF_DRIVE: &str = "drive.link";

    /// Samples of the device that did not get to the log because of the line.
    pub(crate) fn samples_missing(&self) -> u64 {
        self.samples_lost + self.samples_dropped
    }
}

/// Times from a request to its answer, µs.
#[derive(Clone, Copy, Debug, Default, serde::Serialize)]
pub struct RoundTrip {
    /// Half of the questions were answered in this time.
    pub p50: u64,
    /// 99 of 100.
    pub p99: u64,
    /// The time of the slowest answer.
    pub max: u64,
}

impl RoundTrip {
    /// Quantiles of these times, or the reason why there are no times.
    #[must_use]
    pub fn of(measured: &Durations) -> (Option<Self>, Option<&'static str>) {
        if measured.is_empty() {
            return (None, Some("no answer came"));
        }
        let round_trip = Self {
            p50: measured.quantile(0.5),
            p99: measured.quantile(0.99),
            max: measured.max(),
        };
        (Some(round_trip), None)
    }
}

/// Processor cycles counted by the device, and why they are missing.
#[must_use]
pub fn cycles(counted: u32) -> (Option<u32>, Option<&'static str>) {
    match counted {
        0 => (None, Some("not measured")),
        cycles => (Some(cycles), None),
    }
}

#[derive(Clone, Copy, Debug, Default, serde::Serialize)]
pub(crate) struct FrameCounts {
    pub sent: u32,
    pub received: u32,
    pub corrupt: u32,
    pub lost: u32,
    pub duplicate: u32,
    /// Came after a later one.
    pub late: u32,
}

/// `counted` is what the device counted over the run; `None` if it could not be asked.
pub(super) fn summarise(
    link: &SerialLink,
    device: &RemoteDevice,
    counted: Option<Statistics>,
    samples_lost: u64,
) -> LinkSummary {
    let device_answered = counted.is_some();
    let counted = counted.unwrap_or_default();
    let report = link.report();
    let host = report.host;
    let (round_trip_us, round_trip_reason) = RoundTrip::of(&report.round_trip_us);
    let (tick_cycles_max, tick_cycles_max_reason) = cycles(counted.tick_cycles_max);
    let damaged = |kinds: [u32; 3]| kinds.into_iter().fold(0, u32::wrapping_add);
    LinkSummary {
        board: link.capabilities().board().to_owned(),
        firmware: firmware_version(link.hello()),
        serial_number: (link.hello().serial_number().text()).map(ToOwned::to_owned),
        simulated: link.capabilities().simulated,
        position_resolution_m: link.capabilities().position_resolution_m.into(),
        calibration: device.calibration_in_words(),
        tap: None,
        loop_mode: device.loop_mode.name(),
        samples_lost,
        samples_dropped: report.samples_dropped,
        samples_dropped_on_device: counted.samples_dropped,
        stale_forces: counted.stale_forces,
        unanswered: counted.unanswered,
        forces_not_taken: counted.forces_not_taken,
        forces_dropped: report.forces_dropped,
        forces_skipped: report.forces_skipped,
        device_answered,
        ticks: counted.ticks,
        overruns: counted.overruns,
        tick_cycles_max,
        tick_cycles_max_reason,
        from_device: FrameCounts {
            sent: counted.sent,
            received: host.line.received,
            corrupt: damaged([host.line.corrupt, host.line.oversize, host.line.foreign]),
            lost: host.order.lost,
            duplicate: host.order.duplicate,
            late: host.order.late,
        },
        to_device: FrameCounts {
            sent: host.sent,
            received: counted.received,
            corrupt: damaged([counted.corrupt, counted.oversize, counted.foreign]),
            lost: counted.lost,
            duplicate: counted.duplicate,
            late: counted.late,
        },
        to_device_reason: (!device_answered)
            .then_some("the device did not answer at the end: what it received stands as 0"),
        retries: host.retries,
        round_trip_us,
        round_trip_reason,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::remote::bad_line_tests::{quiet, remote};

    #[test]
    fn what_was_not_measured_has_a_reason_instead() {
        let mut times = Durations::default();
        let none = RoundTrip::of(&times);
        assert!(none.0.is_none() && none.1.is_some());
        (1..=100).for_each(|time_us| times.record(time_us));
        let (some, reason) = RoundTrip::of(&times);
        let some = some.expect("a hundred answers");
        assert_eq!((some.p50, some.p99, some.max, reason), (50, 99, 100, None));
        assert_eq!(cycles(7), (Some(7), None));
        assert!(cycles(0).0.is_none() && cycles(0).1.is_some());
        for counted in [None, Some(Statistics::default())] {
            let mut summary = summarise(&quiet().0, &remote(), counted, 3);
            assert_eq!(summary.to_device_reason.is_none(), counted.is_some());
            summary.samples_dropped = 2;
            assert_eq!(summary.samples_missing(), 5);
        }
    }
}
