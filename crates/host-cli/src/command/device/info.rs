//! `device info`.

use super::port::PortArguments;
use crate::output::Output;
use clap::Args;
use haptic_experiment::Failure;
use haptic_experiment::run::device::{at_port, firmware_version, trouble};
use haptic_link::{Statistics, Status};
use haptic_loop::Fault;
use haptic_remote::serial::SerialLink;
use serde::Serialize;
use std::io::{self, Write};
use std::time::Duration;

/// Arguments of `device info`.
#[derive(Debug, Args)]
#[command(after_help = "Example: host-cli device info --device serial:/dev/ttyACM0")]
pub struct Arguments {
    #[command(flatten)]
    port: PortArguments,
}

/// Facts about a device.
#[derive(Serialize)]
struct Info {
    device: String,
    board: String,
    firmware: String,
    simulated: bool,
    axes: u8,
    sample_time_min_s: f64,
    sample_time_max_s: f64,
    force_max_n: f32,
    force_rate_max_n_per_s: f32,
    position_resolution_m: f32,
    coefficients_max: u16,
    modes_max: u16,
    degree_max: u16,
    flight_samples: u16,
    state: String,
    fault: Option<String>,
    /// Words of a board of another maker about its fault.
    fault_reason: Option<String>,
    faults: u16,
    latency_ms: Option<u32>,
    round_trip_us: RoundTrip,
    statistics: Counted,
}

/// From a request to its answer.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct RoundTrip {
    /// Median.
    pub p50: u64,
    /// 99 of 100.
    pub p99: u64,
    /// The longest.
    pub max: u64,
}

/// The device's counters.
#[derive(Serialize)]
struct Counted {
    ticks: u32,
    overruns: u32,
    tick_cycles_max: u32,
    tick_cycles_last: u32,
    stale_forces: u32,
    samples_dropped: u32,
    frames_sent: u32,
    frames_received: u32,
    frames_corrupt: u32,
    frames_oversize: u32,
    frames_foreign: u32,
    frames_lost: u32,
    frames_duplicate: u32,
    frames_late: u32,
    bytes_overrun: u32,
    frames_of_strangers: u32,
    unanswered: u32,
    forces_not_taken: u32,
}

impl From<Statistics> for Counted {
    fn from(s: Statistics) -> Self {
        Self {
            ticks: s.ticks,
            overruns: s.overruns,
            tick_cycles_max: s.tick_cycles_max,
            tick_cycles_last: s.tick_cycles_last,
            stale_forces: s.stale_forces,
            samples_dropped: s.samples_dropped,
            frames_sent: s.sent,
            frames_received: s.received,
            frames_corrupt: s.corrupt,
            frames_oversize: s.oversize,
            frames_foreign: s.foreign,
            frames_lost: s.lost,
            frames_duplicate: s.duplicate,
            frames_late: s.late,
            bytes_overrun: s.bytes_overrun,
            frames_of_strangers: s.strangers,
            unanswered: s.unanswered,
            forces_not_taken: s.forces_not_taken,
        }
    }
}

impl Arguments {
    /// Runs the command.
    ///
    /// # Errors
    /// Exit code 3: no port, no device, no answer.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let link = self.port.connect_any()?;
        let info = info(&link)?;
        output.print(&info, |out| print(out, &info))
    }
}

/// Whole words for a latched fault; `None` if there is none.
pub fn fault_in_words(status: Status) -> Option<String> {
    (status.fault > 0).then(|| {
        Fault::from_code(status.fault).map_or_else(
            || format!("fault {}, which this program does not know", status.fault),
            |fault| fault.to_string(),
        )
    })
}

fn info(link: &SerialLink) -> Result<Info, Failure> {
    let problem = |error| at_port(link.path(), &error);
    let round_trip = link.measure_round_trip(Duration::from_millis(250));
    let statistics = link.statistics().map_err(problem)?;
    let status = link.status();
    let can = link.capabilities();
    Ok(Info {
        device: link.name(),
        board: can.board().to_owned(),
        firmware: firmware_version(link.hello()),
        simulated: can.simulated,
        axes: can.axes,
        sample_time_min_s: f64::from(can.tick_period_min_us) * 1e-6,
        sample_time_max_s: f64::from(can.tick_period_max_us) * 1e-6,
        force_max_n: can.force_max_n,
        force_rate_max_n_per_s: can.force_rate_max_n_per_s,
        position_resolution_m: can.position_resolution_m,
        coefficients_max: can.coefficients_max,
        modes_max: can.modes_max,
        degree_max: can.degree_max,
        flight_samples: can.flight_samples,
        state: status.state.to_string(),
        fault: fault_in_words(status),
        fault_reason: trouble(link).filter(|_| status.fault > 0),
        faults: status.faults,
        latency_ms: link.latency_ms(),
        round_trip_us: RoundTrip {
            p50: round_trip.value_at_quantile(0.5),
            p99: round_trip.value_at_quantile(0.99),
            max: round_trip.max(),
        },
        statistics: statistics.into(),
    })
}

fn print(out: &mut dyn Write, info: &Info) -> io::Result<()> {
    writeln!(
        out,
        "{} · board {}{} · firmware {}",
        info.device,
        info.board,
        if info.simulated { " (simulated)" } else { "" },
        info.firmware
    )?;
    write!(out, "  state             {}", info.state)?;
    match (&info.fault, &info.fault_reason) {
        (Some(fault), Some(reason)) => writeln!(out, ": {fault}: {reason}")?,
        (Some(fault), None) => writeln!(out, ": {fault}")?,
        (None, _) => writeln!(out, ", {} faults since power-up", info.faults)?,
    }
    writeln!(
        out,
        "  tick              {} µs to {} µs",
        (1e6 * info.sample_time_min_s).round(),
        (1e6 * info.sample_time_max_s).round()
    )?;
    writeln!(
        out,
        "  force             at most {} N, {} N/s",
        info.force_max_n, info.force_rate_max_n_per_s
    )?;
    writeln!(
        out,
        "  operator          {} coefficients, {} modes, degree {}",
        info.coefficients_max, info.modes_max, info.degree_max
    )?;
    writeln!(
        out,
        "  round trip        {}",
        haptic_experiment::run::round_trip([
            info.round_trip_us.p50,
            info.round_trip_us.p99,
            info.round_trip_us.max
        ])
    )?;
    let counted = &info.statistics;
    writeln!(
        out,
        "  ticks             {}, {} late, longest {} cycles",
        counted.ticks, counted.overruns, counted.tick_cycles_max
    )?;
    writeln!(
        out,
        "  frames            {} sent, {} received, {} damaged, {} lost, {} repeated, {} late",
        counted.frames_sent,
        counted.frames_received,
        counted.frames_corrupt + counted.frames_oversize + counted.frames_foreign,
        counted.frames_lost,
        counted.frames_duplicate,
        counted.frames_late
    )
}
