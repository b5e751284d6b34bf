//! Requests whose answers are lost, and stops that the device does not hear.

use super::middle::Middle;
use super::{Emulated, at};
use crate::faults::metadata;
use crate::process::{Ended, PATIENCE, column, holds, signal};
use haptic_link::{DeviceReport, EventKind, FaultReport, Request, Sample, Start, State, Status};
use haptic_loop::{Fault, Limiters};
use std::collections::BTreeMap;
use std::process::Child;
use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex};
use std::time::Duration;
use testkit::assert_says;

/// A wall that the device is pushed through, out of its workspace.
pub(super) const LEAVES: &str = "[wall]
mass_kg = 0.065
damping_n_s_per_m = 3.5
sample_time_s = 0.001
order = 0.5
stiffness_n_per_m = 20
dissipation_n_s_mu_per_m = 1
push_n = 1
force_limit_n = 5
duration_s = 4
workspace_low_m = -0.01
workspace_high_m = 0.01
";

/// A relaxation that has some hundred samples.
pub(super) fn under_way(device: &Emulated, line: &str) -> Child {
    let mut child = device.place.start(line);
    let log = "run/relax.mcap.part";
    let grew = device.place.grows(log, 40_000, &mut child);
    assert!(grew, "ended before the signal");
    child
}

pub(super) fn ended(line: &str, child: Child) -> Ended {
    Ended::new(line.to_owned(), &child.wait_with_output().expect("ends"))
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_sample_that_is_asked_for_after_a_silence_is_none_of_the_run() {
    let device = Emulated::new("");
    device.loosen();
    let (message, faults) = channel();
    let _line = Middle::before(&device, move |report| {
        if matches!(report, DeviceReport::Fault(_)) {
            // Nobody waits for the second.
            let _ = message.send(());
        }
        false
    });
    let line = "relax --device serial:line watchdog=300ms --contact rigid --ramp-time 100ms --duration 60s --out run --quiet --json";
    let child = under_way(&device, line);
    signal(&child, "STOP");
    faults.recv_timeout(PATIENCE).expect("the device lets go");
    // It tells a hundred ticks after its fault, then none.
    std::thread::sleep(Duration::from_millis(600));
    signal(&child, "CONT");
    let ended = ended(line, child).failed(1);
    assert!(ended.error().contains("heard nothing"), "{ended}");
    assert!(!ended.error().contains("lacks"), "{ended}");
    assert_eq!(at(&ended.json(), "/dropped_samples"), 0.0, "{ended}");
    let check = device.place.run("log check run/relax.mcap --json").json();
    assert_eq!(at(&check, "/missing_samples"), 0.0, "{check}");
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_stop_that_the_device_does_not_hear_is_told_as_it_was() {
    std::thread::scope(|scope| {
        for options in ["", "--loop host max_age_ticks=500"] {
            scope.spawn(move || stop_unheard(options));
        }
    });
}

fn stop_unheard(options: &str) {
    let device = Emulated::new("");
    device.loosen();
    let (middle, reported) = witnessed(&device, |_| false);
    let line = format!(
        "relax --device serial:line {options} watchdog=500ms late_ticks=0 --contact rigid --ramp-time 100ms \
         --duration 60s --out run --quiet --json"
    );
    // Ctrl-C when nothing reaches the device any more.
    let child = under_way(&device, &line);
    middle.deafen();
    signal(&child, "INT");
    let ended = ended(&line, child).failed(1);

    assert_says(
        ended.error(),
        "interrupted, but & heard nothing from the host & the device pushed on until",
    );
    let last = (1e3 * at(&ended.json(), "/duration_s")).round();
    holds(device.place.path("run/relax-fault.mcap").exists(), &ended);
    // Those behind the samples that count.
    let behind = logged_as_reported(&device, &reported, last as u32);
    assert!(behind.iter().any(|(_, force_n)| *force_n < -0.01));
    let (_, last_n) = behind.last().expect("samples");
    assert!(last_n.abs() < 1e-12, "{last_n} N at the end");
    let check = device.place.run("log check run/relax.mcap --json").json();
    assert_eq!(check["end"]["ended"], "fault", "{check}");
    assert_eq!(at(&check, "/missing_samples"), 0.0, "{check}");
}

/// Samples that a device reported, by tick.
pub(super) type Reported = Arc<Mutex<BTreeMap<u32, Sample>>>;

/// A line that keeps what the device tells, and loses the messages for which this is true.
pub(super) fn witnessed(device: &Emulated, loses: fn(&DeviceReport) -> bool) -> (Middle, Reported) {
    let reported = Reported::default();
    let telling = Arc::clone(&reported);
    let start = Request::Start(Start::ENDLESS).number();
    let line = Middle::before(device, move |report| {
        let mut reported = telling.lock().expect("nobody panicked");
        if let DeviceReport::Sample(sample) = report {
            reported.insert(sample.tick, sample.clone());
        }
        // Samples of an earlier run do not count.
        if matches!(report, DeviceReport::Ack(ack) if ack.request == start) {
            reported.clear();
        }
        loses(report)
    });
    (line, reported)
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_fault_whose_frame_is_lost_has_its_own_tick() {
    for options in ["", "--loop host max_age_ticks=500"] {
        let device = Emulated::new("");
        let (_line, reported) =
            witnessed(&device, |report| matches!(report, DeviceReport::Fault(_)));
        device.place.write("wall.toml", LEAVES);
        let line = format!("run wall.toml --device serial:line {options} --out run --json");
        let ended = device.place.run(&line).failed(1);
        assert!(ended.error().contains("left its workspace"), "{ended}");
        let reported = reported.lock().expect("nobody panicked");
        let faulted = |sample: &&Sample| sample.axes[0].limiters & Limiters::FAULT.bits() != 0;
        let first = reported.values().find(faulted).expect("a fault").tick;
        let report = ended.json();
        assert_eq!(at(&report, "/dropped_samples"), 0.0, "{report}");
        // The tick of the fault is none of the result.
        let last = (1e3 * at(&report, "/duration_s")).round();
        assert_eq!(last, f64::from(first) - 1.0, "{report}");
        let info = device.json("log info run/wall-fault.mcap");
        let fault = metadata(&info, "fault");
        assert_eq!(fault["tick"], first.to_string(), "{fault}");
        assert_eq!(fault["code"], "6", "{fault}");
    }
}

/// A board that fails while its force falls, and tells samples for as long as it is asked to.
#[test]
fn a_fault_on_the_way_to_zero_ends_a_run_that_was_interrupted() {
    let device = Emulated::new("");
    device.loosen();
    let mut failed = false;
    let _line = Middle::changing(&device, move |report| {
        if matches!(&report, DeviceReport::Event(event) if event.kind == EventKind::Stopped) {
            return None;
        }
        if let DeviceReport::Sample(sample) = &report
            && !failed
            && sample.axes[0].limiters & Limiters::STOPPING.bits() != 0
        {
            failed = true;
            return Some(DeviceReport::Fault(FaultReport {
                status: Status {
                    state: State::Fault,
                    fault: Fault::Workspace.code(),
                    ..Status::default()
                },
                tick: sample.tick,
                time_us: sample.time_us.into(),
            }));
        }
        Some(report)
    });
    let line = "relax --device serial:line watchdog=1s late_ticks=0 --contact rigid --ramp-time 100ms --duration 300s --out run --quiet";
    let child = under_way(&device, line);
    signal(&child, "INT");

    assert_says(
        ended(line, child).failed(1).error(),
        "interrupted, but the device did not say that it stopped & the device left its workspace",
    );
    device.json("log info run/relax.mcap");
}

/// The log of `run/relax` behind this tick, some hundred ticks and forces, N. Each tick of all has the force that the device itself reported.
pub(super) fn logged_as_reported(
    device: &Emulated,
    reported: &Reported,
    after: u32,
) -> Vec<(u32, f64)> {
    let export = device.place.run("log export run/relax.mcap -").succeeded();
    let reported = reported.lock().expect("nobody panicked");
    let ticks = column(&export.stdout, "tick")
        .into_iter()
        .map(|tick| tick as u32);
    let mut rows: Vec<_> = ticks
        .zip(column(&export.stdout, "applied_force_n"))
        .collect();
    let other = |(tick, force_n): &&(u32, f64)| {
        (force_n - f64::from(reported[tick].axes[0].force_n)).abs() > 1e-9
    };
    let other = rows.iter().find(other);
    assert_eq!(other, None, "{:?}", other.map(|(tick, _)| &reported[tick]));
    rows.retain(|(tick, _)| *tick > after);
    assert!(rows.len() > 400, "{}", rows.len());
    rows
}

/// Each of its samples can be, and together they cannot.
#[test]
fn a_force_that_does_not_follow_the_places_that_came_is_said() {
    let lies: [fn(&mut Sample, f32); 3] = [
        |sample, first_m| sample.axes[0].position_m = first_m,
        |sample, _| sample.axes[0].position_m *= 1.2,
        |sample, _| sample.axes[0].force_n *= 0.8,
    ];
    let line = "relax --device serial:line watchdog=1s late_ticks=0 --contact rigid --ramp-time 100ms --duration 300ms --out run --quiet --json";
    let ran = |lie: Option<fn(&mut Sample, f32)>| {
        let device = Emulated::new("");
        device.loosen();
        let mut first_m = None;
        let _line = Middle::changing(&device, move |mut report| {
            if let (DeviceReport::Sample(sample), Some(lie)) = (&mut report, lie) {
                let first_m = *first_m.get_or_insert(sample.axes[0].position_m);
                lie(sample, first_m);
            }
            Some(report)
        });
        device.place.run(line)
    };
    assert!(!ran(None).succeeded().stdout.contains("off the law"));
    for lie in lies {
        let ended = ran(Some(lie)).failed(1);
        assert_says(
            ended.error(),
            "the force does not follow the law: check the sensor",
        );
        let warnings = ended.json()["warnings"].to_string();
        assert!(
            warnings.contains("is off the law of the positions"),
            "{warnings}"
        );
    }
}

#[test]
fn abilities_that_are_no_numbers_are_refused_before_anything_moves() {
    let device = Emulated::new("");
    let _line = Middle::changing(&device, move |mut report| {
        if let DeviceReport::Capabilities(capabilities) = &mut report {
            capabilities.force_max_n = f32::NAN;
        }
        Some(report)
    });
    let ended = device.place.run("device info --device serial:line");
    ended.refused(3, &["largest force, N, of NaN", "flash its firmware again"]);
}
