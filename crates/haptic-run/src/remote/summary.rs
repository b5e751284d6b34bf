//! Counts of a link, asked for at the end of a run.

use crate::{
    device::firmware_version,
    link_summary::{FrameCounts, LinkSummary, RoundTrip, cycles},
    remote::RemoteDevice,
};
use haptic_document::Named;
use haptic_link::Statistics;
use haptic_remote::serial::SerialLink;

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
    use crate::remote::bad_line_tests::{quiet, remote};
    use haptic_loop::realtime::Durations;

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
