//! Faults and what is kept of them, and the pre-flight that is to prevent some.

use crate::devices::Emulated;
use crate::process::{Place, holds, number, signal};
use serde_json::Value;
use std::process::Stdio;
use std::time::Duration;
use testkit::{assert_close, assert_says, skip};

/// The metadata record of this name in what `log info` or `log check` tells.
pub(crate) fn metadata<'a>(summary: &'a Value, name: &str) -> &'a Value {
    let records = summary["metadata"].as_array().expect("a list");
    let record = records.iter().find(|record| record["name"] == name);
    &record.unwrap_or_else(|| panic!("no {name} in {summary}"))["values"]
}

/// A specimen that is pressed beyond the workspace, 1 mm in 4 s.
const TOO_DEEP: &str = "relax --duration 20s --ramp-time 4s --contact rigid precision=f32 --scheme full \
                        workspace_low=-10mm workspace_high=0.6mm --out run";

#[test]
fn a_fault_is_kept_with_a_thousand_samples_before_it_and_a_hundred_after() {
    let place = Place::new();
    let ended = place.run(&format!("{TOO_DEEP} --json")).failed(1);
    assert_says(
        ended.error(),
        "fault & the device left its workspace & run/relax.mcap",
    );
    let files = ["run/", "run/relax-fault.mcap", "run/relax.mcap"];
    assert_eq!(place.files(), files);
    let run = place.json("log check run/relax.mcap");
    assert_eq!(run["events"][0]["kind"], "fault");
    let report = ended.json();
    let log = report["fault_log"].as_str().expect("a fault log");
    assert!(log.ends_with("run/relax-fault.mcap"), "{report}");
    let check = place
        .run("log check run/relax-fault.mcap --json")
        .succeeded();
    let check = check.json();
    assert_eq!(number(&check, "samples"), 1100.0, "{check}");
    let fault = metadata(&check, "fault");
    for (key, value) in [
        ("code", "6"),
        ("text", "the device left its workspace"),
        ("samples_before", "1000"),
        ("samples_after", "100"),
        ("run", "relax.mcap"),
    ] {
        assert_eq!(fault[key], value, "{key}");
    }
    let tick: f64 = fault["tick"]
        .as_str()
        .and_then(|t| t.parse().ok())
        .expect("a tick");
    assert_close(
        "start",
        number(&check, "first_s"),
        1e-3 * (tick - 999.0),
        1e-9,
    );
    assert_eq!(check["events"][0]["kind"], "fault");
    // Everything needed to repeat the run is there too.
    assert_eq!(metadata(&check, "experiment")["experiment"], "relax");

    // Neither is overwritten unasked, not even if the log alone is gone.
    let kept = place.read("run/relax-fault.mcap");
    std::fs::remove_file(place.path("run/relax.mcap")).expect("removes");
    let words = ["relax-fault.mcap", "already exists", "--overwrite"];
    place.run(TOO_DEEP).refused(2, &words);
    assert_eq!(place.read("run/relax-fault.mcap"), kept);
    // A run without a fault that takes its place takes it away.
    place
        .run("relax --duration 2s --ramp-time 1s --out run --overwrite --quiet")
        .succeeded();
    assert!(!place.path("run/relax-fault.mcap").exists());
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

/// A wall on the testbed; 100 N/mm at 500 Hz is far beyond what is stable.
fn wall(stiffness: f64, dissipation: f64) -> String {
    format!(
        "[wall]\ndevice = \"serial:device\"\nwatchdog_s = 1\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\n\
         sample_time_s = 2e-3\norder = 0.5\nstiffness_n_per_m = {stiffness}\n\
         dissipation_n_s_mu_per_m = {dissipation}\nduration_s = 2\n"
    )
}

#[test]
fn an_unstable_wall_is_refused_on_a_device_and_noted_on_the_simulated_one() {
    let device = Emulated::new("--speed 10");
    let place = device.place();
    place.write("wall.toml", wall(1e5, 100.0));
    let words = [
        "pre-flight | unstable | alpha 6.1538 | beta | delta | delay 0 samples",
        "margin 0. | softer K | less B | --force-unstable",
    ];
    let words: Vec<&str> = words.iter().flat_map(|words| words.split(" | ")).collect();
    place.run("run wall.toml --out wall").refused(2, &words);
    assert!(!place.path("wall").exists());
    // The device was not armed for it.
    let info = device.json("device info --device serial:device");
    assert_eq!(info["state"], "idle", "{info}");

    let forced = place.run("run wall.toml --out wall --force-unstable --json");
    holds(forced.stderr.contains("unstable by the analysis"), &forced);
    let report = forced.json();
    assert_eq!(report["preflight"]["stable"], false, "{report}");
    assert_eq!(report["stable"], false, "{report}");

    let simulated = place.run("run wall.toml --device sim --out simulated --json");
    let report = simulated.succeeded_with_warnings().json();
    assert_eq!(report["preflight"]["stable"], false, "{report}");
    assert!(number(&report["preflight"], "margin") < 0.5, "{report}");
    let info = device.json("log info simulated/wall.mcap");
    let experiment = metadata(&info, "experiment");
    assert_eq!(experiment["preflight.stable"], "false", "{info}");
    assert_eq!(experiment["preflight.delay_samples"], "0", "{info}");
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_delay_of_a_host_loop_is_measured_and_counts() {
    let device = Emulated::new("");
    let place = device.place();
    // Stable in the device's loop, not with two samples of delay and more.
    place.write("wall.toml", wall(3000.0, 100.0));
    let report = device.json("run wall.toml --out looped --quiet");
    assert_eq!(report["preflight"]["stable"], true, "{report}");
    assert_eq!(number(&report["preflight"], "delay_samples"), 0.0);
    let refused = place.run("run wall.toml --loop host --out host");
    let refused = refused.refused(2, &["pre-flight", "unstable", "delay"]);
    assert!(!refused.error().contains("delay 0 samples"), "{refused}");
    // A soft one is let through, and its verdict is in the report.
    place.write("wall.toml", wall(20.0, 0.5));
    // A machine that is busy answers late.
    let report = device.json("run wall.toml --loop host max_age_ticks=1000 --out host --quiet");
    let preflight = &report["preflight"];
    assert_eq!(preflight["stable"], true, "{report}");
    assert!(number(preflight, "delay_samples") >= 2.0, "{report}");
    for key in ["margin", "required_delta", "delta"] {
        assert!(preflight[key].is_number(), "{key}: {report}");
    }
    assert!(preflight["passive"].is_boolean(), "{report}");
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_full_disk_under_a_run_on_a_device_lets_the_device_go() {
    let device = Emulated::new("");
    let ended = device.place().shell(
        "ulimit -f 100 && exec \"$0\" relax --device serial:device watchdog=1s --contact rigid \
         --out run --quiet",
    );
    if ended.stderr.contains("ulimit") {
        return skip("the shell cannot limit the file size");
    }
    let words = [
        "run/relax.mcap.part",
        "log recover",
        "the force fell to zero",
    ];
    ended.refused(4, &words);
    let info = device.json("device info --device serial:device");
    assert_eq!(info["state"], "idle", "{info}");
    let saved = device
        .place()
        .run("log recover run/relax.mcap.part saved.mcap --json");
    let saved = saved.failed(4).json();
    assert!(number(&saved, "samples") >= 300.0, "{saved}");
    device.place().run("log check saved.mcap").succeeded();
}
