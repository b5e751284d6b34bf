//! `device info` and `device list`.

use super::port::PortArguments;
use super::settings::number;
use crate::command::conduct::stop_on_interrupt;
use crate::output::{Output, joined, note};
use crate::parse::whole;
use clap::Args;
use haptic_experiment::Failure;
use haptic_link::{Statistics, Status};
use haptic_loop::Fault;
use haptic_remote::serial::{ConnectOptions, SerialLink, ports};
use haptic_run::RoundTrip;
use haptic_run::{at_port, cycles, firmware_digest, firmware_version, trouble};
use serde_json::{Value, json};
use std::time::Duration;

/// Arguments of `device list`.
#[derive(Debug, Args)]
#[command(after_help = "Example: host-cli device list --probe")]
pub(crate) struct List {
    /// Ask what is at each port; opening a port resets some foreign boards
    #[arg(long)]
    probe: bool,
    /// Baud rate to ask at [default: 460800, then 921600]
    #[arg(long, value_name = "BAUD", value_parser = whole::<u32>(1200..=12_000_000))]
    baud: Option<u32>,
}

impl List {
    pub(super) fn run(self, output: Output) -> Result<(), Failure> {
        let options = ConnectOptions {
            baud: self.baud,
            stop: Some(stop_on_interrupt()?),
            ..ConnectOptions::default()
        };
        let listed = ports().into_iter().map(|port| {
            let link = self.probe.then(|| SerialLink::connect(&port.path, options));
            let link = link.transpose();
            let answer = link.as_ref().ok().and_then(Option::as_ref);
            json!({
                "path": port.path,
                "description": port.description,
                // Vendor and product, as `lsusb` writes them.
                "usb": port.usb.map(|(vendor, product)| format!("{vendor:04x}:{product:04x}")),
                "usb_vendor_id": port.usb.map(|(vendor, _)| vendor),
                "usb_product_id": port.usb.map(|(_, product)| product),
                // As in `serial:usb:NUMBER`.
                "usb_serial_number": port.serial_number,
                "latency_ms": port.latency_ms,
                // Of the device there; null without `--probe`.
                "board": answer.map(|link| link.capabilities().board()),
                "firmware": answer.map(|link| firmware_version(link.hello())),
                "serial_number": answer.and_then(|link| link.hello().serial_number().text().map(ToOwned::to_owned)),
                // Why no device answered.
                "problem": link.as_ref().err().map(ToString::to_string),
            })
        });
        let listed: Vec<_> = listed.collect();
        if listed.is_empty() {
            note(
                "ports",
                "none: plug in a device, or use host-cli device emulate",
            );
        }
        output.report(&json!({"ports": listed}))
    }
}

pub(super) fn info(port: &PortArguments, output: Output) -> Result<(), Failure> {
    let link = port.connect_any()?;
    let problem = |error| at_port(link.path(), &error);
    let measured = link.measure_round_trip(Duration::from_millis(250));
    let (round_trip_us, round_trip_reason) = RoundTrip::of(&measured);
    let statistics = link.statistics().map_err(problem)?;
    let set = link.configuration().map_err(problem)?.0.limits;
    let (status, can) = (link.status(), link.capabilities());
    let identity = port.device.identity(&link)?;
    let is = json!({
        "device": link.name(),
        "board": can.board(),
        "firmware": firmware_version(link.hello()),
        // Its limits and its calibration belong to it.
        "identity": identity.to_string(),
        "serial_number": identity.serial_number(),
        "serial_number_reason": identity.serial_number().is_none().then_some("neither the device nor its USB port has one of its own"),
    });
    let digest = firmware_digest(can).map(|digest| json!({"firmware_digest": digest}));
    // Of a device that runs them.
    let controllers = link.controller_cost().ok().map(|cost| {
        json!({
            "controller_sample_time_min_s": f64::from(cost.tick_us) * 1e-6,
            "controller_coefficient_s": f64::from(cost.coefficient_ns) * 1e-9,
        })
    });
    // Of a program that is a device: its own time between ticks.
    let paced = (statistics.period_ns > 0).then(|| {
        json!({
            "sample_time_declared_s": f64::from(can.tick_period_min_us) * 1e-6,
            "sample_time_measured_s": f64::from(statistics.period_ns) * 1e-9,
        })
    });
    let does = json!({
        "simulated": can.simulated,
        "axes": can.axes,
        "sample_time_min_s": f64::from(can.tick_period_min_us) * 1e-6,
        "sample_time_max_s": f64::from(can.tick_period_max_us) * 1e-6,
        // As set, see `device set`; of what the device can do `force_max_n`.
        "force_limit_n": number(set.force_n),
        "force_rate_limit_n_per_s": number(set.force_rate_n_per_s),
        "force_max_n": number(can.force_max_n),
        "force_rate_max_n_per_s": number(can.force_rate_max_n_per_s),
        "position_resolution_m": number(can.position_resolution_m),
        // Range of the force sensor; null of a device without one.
        "sensed_force_max_n": (can.sensed_force_max_n > 0.0).then(|| number(can.sensed_force_max_n)),
        "coefficients_max": can.coefficients_max,
        "modes_max": can.modes_max,
        "degree_max": can.degree_max,
        "flight_samples": can.flight_samples,
        // False where a driver may hold the last force.
        "lets_go_alone": can.lets_go_alone.lets_go,
        // True of a robot that takes a velocity.
        "moves": can.lets_go_alone.moves,
        "state": status.state.to_string(),
        "fault": fault_in_words(status),
        // Words of a board of another maker, or of a program that is a device.
        "fault_reason": trouble(&link).filter(|_| status.fault > 0),
        "faults": status.faults,
        "latency_ms": link.latency_ms(),
        "round_trip_us": round_trip_us,
        "round_trip_reason": round_trip_reason,
        "statistics": counted(&statistics),
    });
    output.report(&joined([
        is,
        digest.unwrap_or_default(),
        does,
        paced.unwrap_or_default(),
        controllers.unwrap_or_default(),
    ]))
}

fn counted(counters: &Statistics) -> Value {
    let (longest, unmeasured) = cycles(counters.tick_cycles_max);
    json!({
        "ticks": counters.ticks,
        "overruns": counters.overruns,
        "tick_cycles_max": longest,
        "tick_cycles_max_reason": unmeasured,
        "tick_cycles_last": cycles(counters.tick_cycles_last).0,
        "tick_cycles_last_reason": unmeasured,
        "stale_forces": counters.stale_forces,
        "samples_dropped": counters.samples_dropped,
        "frames_sent": counters.sent,
        "frames_received": counters.received,
        "frames_corrupt": counters.corrupt,
        "frames_oversize": counters.oversize,
        "frames_foreign": counters.foreign,
        "frames_lost": counters.lost,
        "frames_duplicate": counters.duplicate,
        "frames_late": counters.late,
        "bytes_overrun": counters.bytes_overrun,
        "frames_of_strangers": counters.strangers,
        "unanswered": counters.unanswered,
        "forces_not_taken": counters.forces_not_taken,
    })
}

pub(super) fn fault_in_words(status: Status) -> Option<String> {
    (status.fault > 0).then(|| {
        Fault::from_code(status.fault).map_or_else(
            || format!("unknown fault {}", status.fault),
            |fault| fault.to_string(),
        )
    })
}
