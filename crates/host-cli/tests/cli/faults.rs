//! Faults and what is kept of them, and the pre-flight that is to prevent some.

use crate::devices::Emulated;
use crate::process::{number, signal};
use serde_json::Value;
use std::process::Stdio;
use std::time::Duration;
use testkit::assert_says;

/// The metadata record of this name in what `log info` or `log check` tells.
pub(crate) fn metadata<'a>(summary: &'a Value, name: &str) -> &'a Value {
    let records = summary["metadata"].as_array().expect("a list");
    let record = records.iter().find(|record| record["name"] == name);
    &record.unwrap_or_else(|| panic!("no {name} in {summary}"))["values"]
}

/// A run on a device that is stopped for longer than the watchdog waits: the report of its end.
fn run_with_a_silent_host(device: &Emulated, options: &str) -> Value {
    // A machine that is busy for longer than the watchdog waits is silent too soon: then once more.
    for attempt in 1..=10 {
        if let Some(report) = stop_in_the_middle(device, options) {
            return report;
        }
        println!("attempt {attempt}: this machine was silent before it was stopped");
    }
    panic!("this machine is too busy for a watchdog of 190 ms");
}

/// The same; `None` if the run ended before the host was stopped.
fn stop_in_the_middle(device: &Emulated, options: &str) -> Option<Value> {
    let line = "relax --device serial:device watchdog=190ms --contact rigid --duration 60s --out run --overwrite \
                --json";
    let mut command = device.place().command(&format!("{line} {options}"));
    command.stdout(Stdio::piped()).stderr(Stdio::null());
    let mut child = command.spawn().expect("runs");
    let log = "run/relax.mcap.part";
    if !device.place().grows(log, 40_000, &mut child) {
        return None;
    }
    signal(&child, "STOP");
    std::thread::sleep(Duration::from_millis(600));
    signal(&child, "CONT");
    let output = child.wait_with_output().expect("ends");
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    Some(serde_json::from_slice(&output.stdout).expect("JSON"))
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_fault_on_a_device_is_kept_with_what_the_device_recorded() {
    for (options, emulated) in [
        ("", "drop=8% line_seed=5"),
        ("--loop host max_age_ticks=1000", ""),
    ] {
        let device = Emulated::new(emulated);
        let report = run_with_a_silent_host(&device, options);
        assert!(report["fault_log"].is_string(), "{report}");
        // 190 ms were set: more is proposed.
        let reason = report["ended_early"].as_str().expect("a reason");
        assert_says(&reason, "`watchdog_s` = 0.95");
        // The log lacks what the report says, and is not judged by what was planned behind the fault.
        let info = device.json("log info run/relax.mcap");
        assert_eq!(info["missing_samples"], report["dropped_samples"], "{info}");
        assert_eq!(info["end"]["ended"], "fault", "{info}");
        assert_eq!(info["end"]["reason"], reason, "{info}");
        assert!(number(&info["end"], "made_samples") < 60_001.0, "{info}");
        let info = device.json("log info run/relax-fault.mcap");
        let fault = metadata(&info, "fault");
        let missing = info["missing_samples"].to_string();
        assert_eq!(fault["ticks_missing"], missing.as_str(), "{info}");
        assert_eq!(fault["code"], "2", "{options}: {fault}");
        let parsed = |key: &str| fault[key].as_str().and_then(|n| n.parse::<f64>().ok());
        // The device tells 99 ticks after the one of the fault; a host that is silent for longer asks too late for more.
        let least = if emulated.is_empty() { 99.0 } else { 80.0 };
        let after = parsed("samples_after").expect("a number");
        assert!((least..=100.0).contains(&after), "{options}: {fault}");
        let tick = parsed("tick").expect("a tick");
        assert!(
            tick > 400.0 && parsed("samples_before").is_some(),
            "{fault}"
        );
        if options.is_empty() {
            // A line that loses 8 of 100 frames loses some near the fault, wherever that is: the 96 samples of
            // the device's own recorder around the fault are whole.
            let filled = fault["ticks_from_device_recorder"]
                .as_str()
                .expect("a list");
            assert!(!filled.is_empty(), "{fault}");
            let gaps = info["gaps"].as_array().expect("a list");
            for gap in gaps {
                let before = number(gap, "before_tick") - 1.0;
                let after = number(gap, "after_tick") + 1.0;
                let outside = before < tick - 60.0 || after > tick + 23.0;
                assert!(outside, "{gap} near {tick}");
            }
        }
        // The device tells the same fault, and lets go.
        let info = device.json("device info --device serial:device");
        assert_eq!(info["state"], "in a fault", "{info}");
    }
}

#[test]
fn every_fault_has_its_place_in_the_users_guide() {
    let guide = include_str!("../../../../docs/guide/src/faults.md");
    for fault in haptic_loop::Fault::ALL {
        let heading = format!("\n## {} · {fault:?}: {fault}\n", fault.code());
        let section = guide.split_once(&heading);
        let (_, section) = section.unwrap_or_else(|| panic!("no section {heading:?}"));
        let section = section.split("\n## ").next().unwrap_or_default();
        assert_says(section, "*Means* & *Check*");
    }
}
