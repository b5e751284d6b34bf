//! Counts of a link over a run, for the report and for the log.

use haptic_loop::{Tap, realtime::Durations};

/// Counts of the link of a run.
#[derive(Clone, Debug, Default, serde::Serialize)]
pub struct LinkSummary {
    /// Name that the board gives itself.
    pub board: String,
    /// Version of its firmware, as the board states it.
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
    /// Why the longest tick is unknown.
    pub tick_cycles_max_reason: Option<&'static str>,
    /// Counts of frames from the device.
    pub from_device: FrameCounts,
    /// Counts of frames to the device, as the device reports them.
    pub to_device: FrameCounts,
    /// Why its counts are unknown.
    pub to_device_reason: Option<&'static str>,
    /// Requests that were sent again.
    pub retries: u32,
    /// Time from a keep-alive to its answer; null if none came.
    pub round_trip_us: Option<RoundTrip>,
    /// Why the round trip is unknown.
    pub round_trip_reason: Option<&'static str>,
}

impl LinkSummary {
    /// Name of the record in a log with the counts of a drive.
    pub(crate) const OF_DRIVE: &str = "drive.link";

    /// Samples of the device that did not get to the log because of the line.
    pub fn samples_missing(&self) -> u64 {
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

/// Frames of one direction of a link, counted at its receiving end.
#[derive(Clone, Copy, Debug, Default, serde::Serialize)]
pub struct FrameCounts {
    /// Number that were sent.
    pub sent: u32,
    /// Number that arrived whole, with a right check sum.
    pub received: u32,
    /// Number whose check sum was wrong.
    pub corrupt: u32,
    /// Number missing from the sequence.
    pub lost: u32,
    /// Number that repeated one received before.
    pub duplicate: u32,
    /// Came after a later one.
    pub late: u32,
}
